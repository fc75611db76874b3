"""Where a limb's joints are, and whether they take set-points: from the states of its parts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from services.core.service import Inputs
from services.messages import Floats, JointState
from services.reaching.limb_shape import LimbShape
from services.streams import JOINT_STATE

STATE_AGE_S = 0.05
DIRECT = 0x08  # codes of can-protocol 10.1
SCAN = "are the boards powered and found (`ulna can scan`)?"
CALIBRATE = "`ulna joints calibrate` calibrates joints and switches them on"
SWITCH_OVER = "`ulna joints direct` has them take set-points"
MODES = {
    0x00: "idle",
    0x01: "position mode",
    0x02: "velocity mode",
    0x03: "torque mode",
    0x07: "mixed mode",
    0x50: "PWM mode",
    0x60: "calibration",
    0xA0: "hardware fault",
    0xB0: "not configured",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """What is known of a limb in one period."""

    q_rad: Floats = ()  # empty while it is not known
    compliant: tuple[bool, ...] = ()
    modes: tuple[int, ...] = ()
    missing: str = ""  # why the posture is not known
    malformed: bool = False  # a state was none

    def not_direct(self, joints: Sequence[str], needed: Sequence[bool]) -> str:
        """Which needed joints are not in position-direct mode; empty when all are."""
        other = [
            f"{joint} is in {MODES.get(mode, f'mode {mode:#04x}')}"
            for joint, mode, wanted in zip(joints, self.modes, needed, strict=True)
            if wanted and mode != DIRECT
        ]
        if not other:
            return ""
        rest = f" and {len(other) - 1} more" if len(other) > 1 else ""
        return f"{other[0]}{rest}, not in position-direct mode; {SWITCH_OVER}"


def read_limb(shape: LimbShape, inputs: Inputs, age_s: float = STATE_AGE_S) -> Reading:
    """The newest states of a limb's parts, if all of them are young and valid."""
    states: list[JointState] = []
    for part, joints in shape.parts.items():
        state = inputs.fresh(JOINT_STATE[part], age_s)
        if state is None:
            return Reading(missing=f"no joint states of {part}; {SCAN}")
        if not state.valid:
            unknown = f"{part} has joints that are not calibrated or not heard"
            return Reading(missing=f"{unknown}; {CALIBRATE}")
        if not _is_posture(state, len(joints)):
            return Reading(missing=f"the joint states of {part} are malformed", malformed=True)
        states.append(state)
    return Reading(
        q_rad=tuple(q for state in states for q in state.q_rad),
        compliant=tuple(c for state in states for c in state.compliant),
        modes=tuple(mode for state in states for mode in state.control_mode),
    )


def _is_posture(state: JointState, count: int) -> bool:
    sizes = {len(state.q_rad), len(state.compliant), len(state.control_mode)}
    return sizes == {count} and math.isfinite(sum(q * q for q in state.q_rad))
