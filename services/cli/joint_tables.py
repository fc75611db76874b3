"""What `ulna joints status` prints."""

import math
from collections.abc import Mapping, Sequence

from rich import box
from rich.table import Table

from hal.wire.modes import ControlMode
from services.messages import JointState
from services.robot_messages import RobotStatus
from services.robotfile.robot_tables import RobotFile

MODE_NAMES = {int(mode): mode.name.lower().replace("_", " ") for mode in ControlMode}


def joint_table(
    robot: RobotFile, joints: Sequence[str], states: Mapping[str, JointState], status: RobotStatus
) -> Table:
    """A row for each joint below one with its part's name; 80 columns hold it."""
    title = f"joints: {status.phase}"
    table = Table(title=title, box=box.SIMPLE_HEAD, show_edge=False)
    table.add_column("joint", no_wrap=True)
    for quantity in ("deg", "deg/s", "Nm"):
        table.add_column(quantity, justify="right", no_wrap=True)
    for heading in ("mode", "compliant", "valid"):
        table.add_column(heading)
    calibration = dict(status.calibration)
    for part, state in states.items():
        table.add_row(part, style="bold")
        for i, joint in enumerate(robot.parts[part]):
            if joint not in joints:
                continue
            code = state.control_mode[i]
            table.add_row(
                f"  {joint}",
                f"{math.degrees(state.q_rad[i]):.2f}",
                f"{math.degrees(state.dq_rad_s[i]):.2f}",
                "" if math.isnan(state.tau_nm[i]) else f"{state.tau_nm[i]:.2f}",
                MODE_NAMES.get(code, f"0x{code:02X}"),
                "yes" if state.compliant[i] else "",
                _validity(state, calibration.get(joint, "")),
            )
    return table


def _validity(state: JointState, calibration: str) -> str:
    """Validity is told of a part; whose calibration is open or has failed is told of a joint."""
    if state.valid:
        return "yes"
    return "no" if calibration in ("", "done") else calibration
