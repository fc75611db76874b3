"""What `ulna dynamics` asks of a limb that jerks: again for a moment, and then it says so."""

from types import TracebackType
from typing import TypeVar

import msgspec
import numpy as np
import pytest

from services.cli import dynamics as verbs
from services.cli.dynamics_client import REST_PATIENCE_S, DynamicsClient
from services.cli.main import main
from services.cli.stack_client import PATIENCE_S
from services.config import load_robot
from services.core.clock import NS_PER_MS, NS_PER_S
from services.core.errors import ServiceError
from services.core.stream import Call, ReplyT, RequestT, Stream
from services.wholebody.dynamics_messages import DynamicsRequest
from tests.services.whole_body import Stand

MessageT = TypeVar("MessageT", bound=msgspec.Struct)

JERK_N = np.array([0.0, 10.0, 0.0])
JERK_NS = 300 * NS_PER_MS
SENSOR = "r_arm_ft"
REFUSAL = "something touches the limb; free it"


class StandClock:
    """The time of a stand, which goes on while somebody sleeps; a touch ends at its time."""

    def __init__(self, stand: Stand, touch_ends_ns: int | None) -> None:
        self._stand = stand
        self._touch_ends_ns = touch_ends_ns

    def now_ns(self) -> int:
        return self._stand.now_ns

    def sleep_until(self, deadline_ns: int) -> None:
        while self._stand.now_ns < deadline_ns:
            if self._touch_ends_ns is not None and self._stand.now_ns >= self._touch_ends_ns:
                self._stand.push_n = np.zeros(3)
            self._stand.run(1)


class StandClient(DynamicsClient):
    """A client whose stack is a stand instead of a hub and its processes."""

    def __init__(self, stand: Stand, touch_ends_ns: int | None = None) -> None:
        self.clock = StandClock(stand, touch_ends_ns)
        self.stand = stand
        self.calls = 0

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        pass

    def call(self, call: Call[RequestT, ReplyT], request: RequestT) -> ReplyT:
        assert isinstance(request, DynamicsRequest)
        self.calls += 1
        return msgspec.convert(self.stand.request(request), call.reply)

    def wait_for(self, stream: Stream[MessageT], patience_s: float = PATIENCE_S) -> MessageT:
        self.clock.sleep_until(self.clock.now_ns() + round(min(0.1, patience_s) * NS_PER_S))
        return self.stand.bench.last(stream)


@pytest.fixture
def jerked() -> Stand:
    """Calibrated, and its sensor shows more than the model explains."""
    stand = Stand(load_robot("icub:arms"), pushed="r_hand_dh_frame")
    stand.calibrate()
    stand.push_n = JERK_N
    stand.run(200)
    return stand


@pytest.fixture
def passing(jerked: Stand, monkeypatch: pytest.MonkeyPatch) -> StandClient:
    """What the verbs talk to: the touch ends by itself."""
    client = StandClient(jerked, jerked.now_ns + JERK_NS)
    monkeypatch.setattr(verbs, "DynamicsClient", lambda _: client)
    return client


def test_a_sweep_waits_for_a_limb_that_comes_to_rest(
    passing: StandClient, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    begun_ns = []

    def sweep_limb(client: DynamicsClient, *_: object) -> None:
        begun_ns.append(client.clock.now_ns())
        raise ServiceError("far enough")

    monkeypatch.setattr(verbs, "sweep_limb", sweep_limb)
    asked_ns = passing.clock.now_ns()
    assert main(["dynamics", "identify", SENSOR]) == 2
    assert "far enough" in capsys.readouterr().err
    assert JERK_NS < begun_ns[0] - asked_ns < NS_PER_S


def test_a_calibration_waits_for_a_limb_that_comes_to_rest(
    passing: StandClient, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["dynamics", "calibrate", SENSOR]) == 0
    assert SENSOR in capsys.readouterr().out
    found = passing.stand.health(SENSOR).offset
    assert found == pytest.approx(passing.stand.offsets[SENSOR], abs=0.02)


def test_a_touch_that_stays_is_told_once(jerked: Stand, capsys: pytest.CaptureFixture[str]) -> None:
    asked_ns = jerked.now_ns
    start = DynamicsRequest(action="identify", sensors=(SENSOR,), value="start")
    assert not StandClient(jerked).ask_at_rest(start)
    assert capsys.readouterr().err.count(REFUSAL) == 1
    assert jerked.now_ns - asked_ns == pytest.approx(REST_PATIENCE_S * NS_PER_S, rel=0.05)


def test_what_does_not_pass_by_itself_is_told_at_once(
    jerked: Stand, capsys: pytest.CaptureFixture[str]
) -> None:
    client = StandClient(jerked)
    start = DynamicsRequest(action="identify", sensors=("nose",), value="start")
    assert not client.ask_at_rest(start)
    assert client.calls == 1
    assert "no sensor 'nose' here" in capsys.readouterr().err
