"""What the arm does when a process of the stack is gone: compliant, at the target, virtual time."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from hal.wire.modes import ControlMode
from services.boards import Boards
from services.core.service import Inputs, Outputs, Period, Service
from services.core.stream import AnyStream
from services.emulated.simulation import Simulation
from services.reaching.reach import Reach, ReachOptions
from services.robot import RobotService
from services.robot_messages import RobotRequest
from services.robotfile.robot_tables import RobotFile
from services.streams import GUARD_CALL

HELD_MM = 4.0  # friction and the switch to stiff move the hand by a few millimetres at most


class Mortal(Service):
    """A service that can be killed: from then on it does nothing at all."""

    def __init__(self, service: Service) -> None:
        self._service = service
        self.reads, self.writes = service.reads, service.writes
        self.serves, self.calls = service.serves, service.calls
        self.trigger = service.trigger
        self.alive = True

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:
        if self.alive:
            self._service.step(now_ns, inputs, outputs)


class Supervisor(Service):
    """Asks the guard to bring the limbs down once it is told to."""

    trigger = Period(0.01)
    reads: tuple[AnyStream, ...] = ()
    calls = (GUARD_CALL,)

    def __init__(self) -> None:
        self.told = False

    def step(self, now_ns: int, inputs: Inputs, outputs: Outputs) -> None:  # noqa: ARG002
        if self.told:
            self.told = False
            outputs.call(GUARD_CALL, RobotRequest(action="stop"))


@dataclass
class Holding:
    """A robot that holds its target compliantly, and what it said when it began to."""

    simulation: Simulation
    mortals: dict[str, Mortal]
    start_m: "np.ndarray[tuple[int], np.dtype[np.float64]]"
    supervisor: Supervisor

    def run(self, seconds: float) -> float:
        """Go on for a while; returns how far the hand is from where it was, in mm."""
        self.simulation.executor.run(seconds)
        return self.moved_mm()

    def moved_mm(self) -> float:
        now_m = np.array(self.simulation.rig.tip_pose()[0])
        return float(np.linalg.norm(now_m - self.start_m)) * 1e3

    def compliant(self) -> list[bool]:
        rig = self.simulation.rig
        return [a.compliant for address in (1, 2) for a in rig.board(2, address).axes]

    def modes(self) -> set[int]:
        rig = self.simulation.rig
        return {int(a.mode) for address in (1, 2) for a in rig.board(2, address).axes}


@pytest.fixture
def holding(robot: RobotFile) -> Iterator[Holding]:
    mortals: dict[str, Mortal] = {}

    def mortal(name: str, service: Service) -> Service:
        mortals[name] = Mortal(service)
        return mortals[name]

    job = Reach(robot, ReachOptions(hold_s=100.0))
    supervisor = Supervisor()
    guests = {"reach": job, "supervisor": supervisor}
    simulation = Simulation(robot, wrapped=mortal, guests=guests)
    assert simulation.executor.run(40.0, until=lambda: job.progress == "holding")
    mortals["reach"].alive = False
    yield Holding(simulation, mortals, np.array(simulation.rig.tip_pose()[0]), supervisor)
    simulation.close()


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("field", marks=pytest.mark.slow),
        pytest.param("ik", marks=pytest.mark.slow),
        "cartesian",  # the only one of the three whose words the HAL hears
        pytest.param("guard", marks=pytest.mark.slow),
    ],
)
def test_arm_holds_its_last_reference_and_stays_compliant(holding: Holding, name: str) -> None:
    holding.mortals[name].alive = False
    assert holding.run(2.0) < HELD_MM
    assert all(holding.compliant())
    assert holding.simulation.rig.board_faults == 0


def test_without_torques_the_hal_makes_the_arm_stiff_before_the_boards_fault(
    holding: Holding,
) -> None:
    holding.mortals["dynamics"].alive = False
    holding.run(0.1)
    assert not any(holding.compliant())
    assert holding.run(2.0) < HELD_MM
    assert holding.simulation.rig.board_faults == 0
    service = holding.simulation.services["robot"]
    assert isinstance(service, RobotService)
    assert any("made stiff" in fault for fault in service.faults)


@pytest.mark.slow
def test_without_the_hal_the_guard_makes_the_arm_stiff(holding: Holding) -> None:
    holding.mortals["robot"].alive = False
    holding.run(0.15)
    assert not any(holding.compliant())
    assert holding.run(2.0) < HELD_MM
    assert holding.simulation.rig.board_faults == 0


@pytest.mark.slow
def test_guard_that_was_asked_to_stop_before_it_noticed_the_silence_stops(holding: Holding) -> None:
    holding.mortals["robot"].alive = False
    holding.supervisor.told = True
    holding.run(4.0)
    assert holding.modes() == {ControlMode.IDLE}
    assert holding.simulation.rig.board_faults == 0


@pytest.mark.slow
def test_without_hal_and_guard_the_boards_fault_and_the_arm_goes_limp(holding: Holding) -> None:
    holding.mortals["robot"].alive = False
    holding.mortals["guard"].alive = False
    holding.run(0.3)
    assert holding.modes() == {ControlMode.HW_FAULT}
    assert holding.run(2.0) > 50.0


@pytest.mark.slow
def test_without_the_bus_the_boards_fault_and_the_report_says_so(holding: Holding) -> None:
    holding.simulation.network.faults("vcan2").bus_off = True
    holding.run(0.5)
    assert ControlMode.HW_FAULT in holding.modes()
    service = holding.simulation.services["robot"]
    assert isinstance(service, RobotService)
    assert any("bus 2 is off" in fault for fault in service.faults)


@pytest.mark.slow
def test_without_boards_the_hal_names_them(holding: Holding) -> None:
    holding.mortals["boards"].alive = False
    holding.run(0.3)
    service = holding.simulation.services["robot"]
    assert isinstance(service, RobotService)
    silent = " ".join(service.faults)
    for board in ("torso_yaw", "waist", "r_shoulder", "r_elbow", "r_forearm", "r_arm_strain"):
        assert f"board {board} " in silent
    assert isinstance(holding.simulation.services["boards"], Boards)
