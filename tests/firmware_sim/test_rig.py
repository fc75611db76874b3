"""Wiring of the rig, with boards that only record, and frames between them."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from firmware_sim.description import BoardSpec, RigSpec
from firmware_sim.network import RigError
from firmware_sim.rig import Rig
from hal.wire.can import Frame

POSITIONS = {"bll_ie": 2, "dc4": 4, "strain": 0}
ELBOW, PROSUP = 6, 7


class RecordingPort:
    def __init__(self) -> None:
        self.raw_encoder, self.current_ma, self.pwm, self.enabled = 0, 0, 0, False


class RecordingAxis:
    def __init__(self) -> None:
        self.port = RecordingPort()
        self.calibrated = False
        self.fault_entries = 0


class RecordingBoard:
    """Takes polling frames to its addresses and POSITION of board 1; sends what it is told."""

    def __init__(self, spec: BoardSpec) -> None:
        self.addresses = (spec.address, spec.address + 1) if spec.type == "dc4" else (spec.address,)
        self.axes = tuple(RecordingAxis() for _ in range(POSITIONS[spec.type]))
        self.ports = tuple(axis.port for axis in self.axes)
        self.raw_adc = [0x8000] * 6
        self.bus_off, self.powered, self.dropped = False, True, Counter[str]()
        self.seen: list[Frame] = []
        self.to_send: list[Frame] = []
        self.power_cycles = 0

    def accepts(self, can_id: int) -> bool:
        return can_id == 0x111 or (can_id >> 8 == 0 and can_id & 0xF in self.addresses)

    def on_frame(self, can_id: int, data: bytes) -> None:
        self.seen.append((can_id, data))

    def tick(self) -> list[Frame]:
        sent, self.to_send = self.to_send, []
        return sent

    def power_cycle(self) -> None:
        self.power_cycles += 1


def recording(rig: Rig, bus: int, address: int) -> RecordingBoard:
    board: object = rig.board(bus, address)
    assert isinstance(board, RecordingBoard)
    return board


@pytest.fixture
def make(monkeypatch: pytest.MonkeyPatch, exact_spec: RigSpec) -> RigSpec:
    def recorder(spec: BoardSpec, full_scale: Sequence[float] | None = None) -> RecordingBoard:
        assert (full_scale is not None) == (spec.type == "strain")
        return RecordingBoard(spec)

    monkeypatch.setattr("firmware_sim.network.make_board", recorder)
    return exact_spec


def drive(rig: Rig, joint: int, pwm: int, ticks: int) -> None:
    port = rig._wires._foreign[joint].port
    port.pwm, port.enabled = pwm, True
    for _ in range(ticks):
        rig.step({})


def test_absolute_encoder_shows_angle_plus_zero_plus_offset_on_twelve_bits(make: RigSpec) -> None:
    rig = Rig(make)
    # shoulder pitch at -30 deg: 1672.125 to the nearest tick, plus 348
    assert recording(rig, 2, 1).ports[0].raw_encoder == 2020
    # shoulder yaw at 0 deg: 2252.25 to the nearest, plus 448
    assert recording(rig, 2, 2).ports[0].raw_encoder == 2700
    # torso yaw: 180 * 11.375 = 2047.5 to the nearest, plus 2613 goes round
    assert recording(rig, 0, 5).ports[0].raw_encoder == 2048 + 2613 - 4096


def test_third_axis_of_a_4dc_answers_at_the_second_address(make: RigSpec) -> None:
    rig = Rig(make)
    board = recording(rig, 2, 3)
    assert recording(rig, 2, 4) is board
    # wrist yaw at 0 deg: 180 * 11.375 = 2047.5 to the nearest, plus 1058
    assert board.ports[2].raw_encoder == 3106
    drive(rig, 9, -300, 20)
    assert board.ports[2].pwm == -300


def test_incremental_encoder_counts_from_power_up(make: RigSpec) -> None:
    rig = Rig(make)
    port = recording(rig, 2, 3).ports[0]
    assert port.raw_encoder == 0
    drive(rig, PROSUP, 400, 300)
    rig.step({})
    moved_deg = np.degrees(rig.q_rad[PROSUP])
    assert moved_deg > 10.0
    assert port.raw_encoder == pytest.approx(-706.67 * moved_deg, abs=120.0)  # one step older


def test_boards_wake_up_once_the_encoders_show_the_posture(make: RigSpec) -> None:
    assert recording(Rig(make), 2, 1).power_cycles > 0


def test_current_is_measured_in_milliamperes(make: RigSpec) -> None:
    rig = Rig(make)
    drive(rig, ELBOW, -100, 1)
    rig.step({})
    # 36 V, 1.2 ohm, 100 of 800 counts: 3.75 A less what the first millisecond's speed takes away
    assert -3750 <= recording(rig, 2, 2).ports[1].current_ma < -3000


def test_pwm_behind_an_open_bridge_moves_nothing(make: RigSpec) -> None:
    rig, still = Rig(make), Rig(make)
    recording(rig, 2, 3).ports[0].pwm = 1000
    for _ in range(20):
        rig.step({})
        still.step({})
    assert rig.q_rad == still.q_rad


def test_open_bridge_carries_no_current(make: RigSpec) -> None:
    rig = Rig(make)
    rig.plant.dx[ELBOW] = 2.0
    rig.step({})
    rig.step({})
    assert recording(rig, 2, 2).ports[1].current_ma == 0


def test_strain_board_gets_the_weight_of_the_arm_from_the_first_millisecond(make: RigSpec) -> None:
    rig = Rig(make)
    rig.step({})
    words = np.array(recording(rig, 2, 13).raw_adc) - 0x8000
    mass_kg = 0.729 + 0.074 + 0.525 + 0.213
    assert np.linalg.norm(words[:3] * 1500.0 / 0x8000) == pytest.approx(mass_kg * 9.81, abs=0.05)


def test_strain_board_gets_the_wrench_of_the_plants_last_step(make: RigSpec) -> None:
    rig = Rig(make)
    drive(rig, ELBOW, 300, 20)
    wrench = rig.plant.wrenches[0].copy()
    rig.step({})
    scale = np.array([1500.0] * 3 + [35.0] * 3) / 0x8000
    words = np.array(recording(rig, 2, 13).raw_adc) - 0x8000
    assert words.tolist() == np.floor(wrench / scale + 0.5).tolist()


def test_frame_reaches_the_board_that_owns_the_address_and_no_other(make: RigSpec) -> None:
    rig = Rig(make)
    rig.step({2: [(0x004, b"\x07\x00", 0)], 0: []})
    assert recording(rig, 2, 3).seen == [(0x004, b"\x07\x00")]
    assert recording(rig, 2, 1).seen == []
    assert recording(rig, 0, 5).seen == []


def test_frame_that_nobody_takes_is_let_pass(make: RigSpec) -> None:
    strange = [(0x7FF, b"", 0), (0x1FFFFFFF, b"", 0)]
    assert Rig(make).step({2: strange, 9: [(0x001, b"\x07", 0)]}) == {0: [], 2: []}


def test_boards_hear_each_other_one_millisecond_later_and_not_themselves(make: RigSpec) -> None:
    rig = Rig(make)
    first, second = recording(rig, 2, 1), recording(rig, 2, 2)
    first.to_send = [(0x111, bytes(8)), (0x113, bytes(8))]
    assert rig.step({}) == {0: [], 2: [(0x111, bytes(8)), (0x113, bytes(8))]}
    assert second.seen == []
    rig.step({})
    assert second.seen == [(0x111, bytes(8))]
    assert first.seen == []
    assert recording(rig, 0, 5).seen == []  # another bus


def test_push_deflects_the_tip_along_the_force_and_ends(make: RigSpec) -> None:
    rig, still = Rig(make), Rig(make)
    rig.push((0.0, 60.0, 0.0), 0.1)
    for _ in range(100):
        rig.step({})
        still.step({})
    assert rig.tip_pose()[0][1] - still.tip_pose()[0][1] > 0.002
    assert rig._pushes.step() == ()


@pytest.mark.parametrize(
    ("force", "duration"),
    [((float("nan"), 0, 0), 1.0), ((1, 0, 0), 0.0), ((1, 0, 0), float("inf"))],
)
def test_push_that_makes_no_sense_is_refused(
    make: RigSpec, force: tuple[float, float, float], duration: float
) -> None:
    with pytest.raises(RigError, match="cannot push"):
        Rig(make).push(force, duration)


def test_limit_violations_count_what_the_plant_does(make: RigSpec) -> None:
    rig = Rig(make)
    drive(rig, ELBOW, 760, 1000)
    assert np.degrees(rig.q_rad[ELBOW]) > 110.0
    assert rig.limit_violations == 0  # nobody has calibrated it
    recording(rig, 2, 2).axes[1].calibrated = True
    drive(rig, ELBOW, -400, 150)  # back inside
    assert 15.0 < np.degrees(rig.q_rad[ELBOW]) < 106.0
    drive(rig, ELBOW, 760, 700)
    assert 0 < rig.limit_violations < 700


def test_joints_that_wait_for_their_limits_are_named(make: RigSpec) -> None:
    rig = Rig(make)
    assert rig.limits_waiting == rig.joints
    recording(rig, 2, 2).axes[1].calibrated = True
    rig.step({})
    assert rig.limits_waiting == tuple(name for name in rig.joints if name != "r_elbow")


def test_board_faults_add_up_over_all_axes(make: RigSpec) -> None:
    rig = Rig(make)
    recording(rig, 2, 2).axes[1].fault_entries = 2
    recording(rig, 0, 5).axes[1].fault_entries = 1
    assert rig.board_faults == 3


def test_unknown_address_is_refused_with_what_there_is(make: RigSpec) -> None:
    with pytest.raises(RigError, match="bus 2 address 9; boards: bus 0 address 5"):
        Rig(make).board(2, 9)


def test_two_boards_at_one_address_are_refused(make: RigSpec) -> None:
    twice = BoardSpec(bus=2, address=4, type="bll_ie", firmware=(2, 0x50))
    with pytest.raises(RigError, match="claim bus 2 address 4"):
        Rig(replace(make, boards=(*make.boards, twice)))


def test_axis_that_the_board_does_not_have_is_refused(make: RigSpec) -> None:
    axis = replace(make.axes[0], axis=2)
    with pytest.raises(RigError, match="bus 0 address 6 has no axis 2"):
        Rig(replace(make, axes=(axis, *make.axes[1:])))


def test_axis_without_a_joint_keeps_its_encoder_where_it_is(make: RigSpec) -> None:
    finger = replace(
        make.axes[9], axis=1, joint=None, motor=None, ticks_per_deg=-4.0, zero_deg=-100.0
    )
    rig = Rig(replace(make, axes=(*make.axes, finger)))
    port = recording(rig, 2, 3).ports[3]
    port.pwm, port.enabled = 1000, True
    rig.step({})
    assert port.raw_encoder == 400 + 1058
    assert len(rig.q_rad) == 10
