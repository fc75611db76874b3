"""The whole robot with every service in one process and in virtual time: a reach from power-up."""

from services.cli.demo import COMPLIANT_BAR_M
from services.config import load_robot
from services.experiments.rows import Row, at_least, at_most
from services.reaching.reach import ReachOptions
from services.reaching.reach_virtual import run_virtual

SPEED_BAR = 1.2


def services_rows() -> list[Row]:
    """Speed of the whole stack, and that the reach is as good as with the reaching limb alone."""
    robot = load_robot("icub")
    report = run_virtual(robot, ReachOptions(seed=0, position_bar_m=COMPLIANT_BAR_M)).report
    wall, error_mm = report["wall"], report["position_error_mm"]
    assert isinstance(wall, dict)
    name = "whole robot, every service, one core"
    return [
        at_least(f"{name}: realtime_factor", float(wall["realtime_factor"]), "x", SPEED_BAR),
        Row(f"{name}: reached", str(report["reached"]), "", "True", bool(report["reached"])),
        Row(f"{name}: position error", error_mm if isinstance(error_mm, float) else None, "mm"),
        *(
            at_most(f"{name}: {key}", float(str(report[key])), "", 0)
            for key in ("limit_violations", "board_faults", "frames_lost", "frames_dropped")
        ),
        Row(f"{name}: boards step, median", float(wall["boards_us_p50"]), "us"),
        Row(f"{name}: HAL step, median", float(wall["robot_us_p50"]), "us"),
    ]
