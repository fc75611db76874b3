"""What `ulna cartesian` prints."""

import math
from collections.abc import Iterator, Sequence

from rich import box
from rich.table import Table

from dforc import rotation
from services.messages import CartesianStatus
from services.reaching.cartesian_messages import MotionState
from services.reaching.client_types import Pose, Posture, Settings


def status_lines(status: CartesianStatus, motion: MotionState) -> Iterator[str]:
    """What the controller does, and its newest motion."""
    yield f"{status.mode}, {status.limb}: {status.state}"
    if status.reason:
        yield f"nothing is commanded: {status.reason}"
    if motion.motion:
        yield motion_line(motion)
    if status.ignored:
        yield f"{status.ignored} virtual points ignored while requests commanded"


def motion_line(motion: MotionState) -> str:
    """A motion in one line."""
    name = f"motion {motion.motion} of {motion.limb}"
    short = f"; out of reach: {motion.out_of_reach}" if motion.out_of_reach else ""
    if not motion.done:
        return f"{name}: {100.0 * motion.progress:.0f} % of the way{short}"
    away = f"{motion.position_error_m * 1e3:.1f} mm"
    if not math.isnan(motion.orientation_error_rad):
        away += f" and {math.degrees(motion.orientation_error_rad):.1f} deg"
    away += " from the nearest pose" if short else " away"
    reason = f": {motion.reason}" if motion.reason else f", {away}"
    return f"{name}: {motion.outcome}{reason}{short}"


def pose_lines(poses: Sequence[Pose]) -> Iterator[str]:
    """Hands, in the form in which `ulna cartesian go` takes them."""
    for pose in poses:
        place = " ".join(f"{x:.4f}" for x in pose.position_m)
        turned = " ".join(f"{x:.4f}" for x in rotation.rotation_vector(pose.rotation))
        yield f"hand: --position {place} --rotation {turned}"


def posture_table(posture: Posture) -> Table:
    """Joint angles of an answer."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False)
    table.add_column("joint")
    table.add_column("deg", justify="right")
    for joint, angle in posture.angles_rad.items():
        table.add_row(joint, f"{math.degrees(angle):.2f}")
    return table


def verdict(posture: Posture) -> str:
    """How near the pose it is."""
    answer = posture.answer
    away = f"position {answer.position_error_m * 1e3:.2f} mm off"
    turned = f"orientation {math.degrees(answer.orientation_error_rad):.2f} deg off"
    return f"{answer.status}: {away}, {turned}"


def info_table(settings: Settings) -> Table:
    """How each joint is used."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False)
    table.add_column("joint")
    table.add_column("free")
    for heading in ("rest deg", "weight", "from deg", "to deg"):
        table.add_column(heading, justify="right")
    for joint, free in settings.free.items():
        low, high = settings.limits_rad[joint]
        table.add_row(
            joint,
            "yes" if free else "blocked",
            f"{math.degrees(settings.rest_rad[joint]):.1f}",
            f"{settings.rest_weights[joint]:g}",
            f"{math.degrees(low):.1f}",
            f"{math.degrees(high):.1f}",
        )
    return table
