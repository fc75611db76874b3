"""The limbs of a robot: chains from the base to a hand, and both arms over one waist."""

from collections.abc import Mapping

import msgspec

BOTH_ARMS = "both_arms"
MEMBERS = (
    "left_arm",
    "right_arm",
)  # of both arms; what they share counts once, as the first has it


class LimbPart(msgspec.Struct, frozen=True, kw_only=True):
    """One part of a limb: a value for each of its joints."""

    home_deg: tuple[float, ...]
    rest_deg: tuple[float, ...]
    rest_weights: tuple[float, ...]


class LimbTip(msgspec.Struct, frozen=True, kw_only=True):
    """Where a limb ends."""

    limb: str  # whose hand it is
    frame: str
    sensor: str  # FT sensor on the way to it


class Limb(msgspec.Struct, frozen=True, kw_only=True):
    """Joints that move one hand, or two."""

    name: str
    tips: tuple[LimbTip, ...]
    parts: dict[str, LimbPart]  # base to tip
    compliant: tuple[str, ...]
    rest_beta: float
    trajectory_time_s: float

    @property
    def home_deg(self) -> tuple[float, ...]:
        """Where a motion starts."""
        return tuple(value for part in self.parts.values() for value in part.home_deg)

    @property
    def rest_deg(self) -> tuple[float, ...]:
        """What is preferred where the target leaves a choice."""
        return tuple(value for part in self.parts.values() for value in part.rest_deg)

    @property
    def rest_weights(self) -> tuple[float, ...]:
        """How strongly."""
        return tuple(value for part in self.parts.values() for value in part.rest_weights)


def with_both_arms(limbs: Mapping[str, Limb]) -> dict[str, Limb]:
    """The limbs, and both arms as one where there are both."""
    if BOTH_ARMS in limbs or not set(MEMBERS) <= set(limbs):
        return dict(limbs)
    members = [limbs[name] for name in MEMBERS]
    shared = [name for name in members[0].parts if all(name in limb.parts for limb in members)]
    parts = {name: members[0].parts[name] for name in shared}
    for limb in members:
        parts |= {name: part for name, part in limb.parts.items() if name not in shared}
    compliant = dict.fromkeys(joint for limb in members for joint in limb.compliant)
    both = Limb(
        name=BOTH_ARMS,
        tips=tuple(tip for limb in members for tip in limb.tips),
        parts=parts,
        compliant=tuple(compliant),
        rest_beta=members[0].rest_beta,
        trajectory_time_s=max(limb.trajectory_time_s for limb in members),
    )
    return {**limbs, BOTH_ARMS: both}
