"""Which parts get torque estimates, given the sensors that work and the contacts that are assumed.

A joint's torque is known where every contact that is assumed beyond it can be told from all others.
Sensors cut the robot into sub-models, and one sub-model yields six numbers: with more unknowns than
that, as when a lost sensor makes its limb one with the trunk, a touch on the limb would be taken
for one elsewhere. A board that regulates such a torque does not give way to a touch, so its part
gets none: the HAL then makes it stiff. The assumption can say otherwise, by fewer contacts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from dforc.estimation.assumption import UNKNOWNS, Assumption
from services.wholebody.body import Body, BodyPart

SOLVABLE = 6


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether one part gets torques."""

    part: BodyPart
    sensors: tuple[int, ...]  # whose readings its torques stand on
    refusal: str  # why it gets none; empty = it gets them


@dataclass(frozen=True, slots=True)
class _Place:
    """One assumed contact."""

    above: tuple[str, ...]  # joints between it and the root, nearest first
    unknowns: int


class TorqueParts:
    """Judges every part once per set of working sensors."""

    def __init__(self, body: Body, assumption: Assumption) -> None:
        self._body = body
        self._parts = tuple(part for part in body.parts if part.felt)
        self._above = {joint: body.tree.joints_above(joint) for joint in body.joints}
        self._sensor_above = [body.tree.joints_above(s.frame) for s in body.sensors]
        self._contacts: tuple[_Place, ...] = ()
        self._held = 0
        self._known: dict[tuple[bool, ...], tuple[Verdict, ...]] = {}
        self.assume(assumption)

    def assume(self, assumption: Assumption) -> None:
        """Judge by other contacts from now on."""
        tree = self._body.tree
        self._contacts = tuple(
            _Place(tree.joints_above(contact.frame), UNKNOWNS[contact.kind])
            for contact in assumption.contacts
        )
        self._held = SOLVABLE if assumption.mainstay else 0
        self._known = {}

    def judge(self, valid: tuple[bool, ...]) -> tuple[Verdict, ...]:
        """A verdict for each part whose boards take torques."""
        verdicts = self._known.get(valid)
        if verdicts is None:
            verdicts = tuple(self._verdict(part, valid) for part in self._parts)
            self._known[valid] = verdicts
        return verdicts

    def sensors_of(self, joints: Sequence[str], valid: tuple[bool, ...]) -> tuple[int, ...]:
        """Working sensors next to the joints: the first above each, and the first below."""
        frames = {s.frame: i for i, s in enumerate(self._body.sensors) if valid[i]}
        found = set()
        for joint in joints:
            nearest = next((frames[a] for a in self._above[joint] if a in frames), None)
            if nearest is not None:
                found.add(nearest)
            found |= {i for i in frames.values() if joint in self._reach(i, frames)}
        return tuple(sorted(found))

    def _around(self, joints: Sequence[str], valid: tuple[bool, ...]) -> tuple[int, ...]:
        """Sensors next to the joints, and those around a sub-model whose contacts they bear."""
        frames = {s.frame: i for i, s in enumerate(self._body.sensors) if valid[i]}
        found = set(self.sensors_of(joints, valid))
        for joint in joints:
            for top in self._borne_by(joint, frames):
                found |= {frames[top]} if top else set()
                found |= {
                    i
                    for i in frames.values()
                    if self._top(self._sensor_above[i][1:], frames) == top
                }
        return tuple(sorted(found))

    def _verdict(self, part: BodyPart, valid: tuple[bool, ...]) -> Verdict:
        sensors = self._around(part.felt, valid)
        lost = [self._body.sensors[i].name for i in self._lost_next_to(part, valid)]
        why = f": {', '.join(lost)} cannot be used" if lost else ""
        if not sensors:
            return Verdict(part, (), f"no sensor feels it{why}")
        for joint in part.felt:
            if not self._is_known(joint, valid):
                refusal = f"a touch on it cannot be told from one elsewhere{why}"
                return Verdict(part, sensors, refusal)
        return Verdict(part, sensors, "")

    def _lost_next_to(self, part: BodyPart, valid: tuple[bool, ...]) -> list[int]:
        """Sensors that do not work and would count for a part if they did."""
        alone = [tuple(v or i == j for j, v in enumerate(valid)) for i in range(len(valid))]
        return [
            i
            for i, works in enumerate(valid)
            if not works and i in self.sensors_of(part.felt, alone[i])
        ]

    def _is_known(self, joint: str, valid: tuple[bool, ...]) -> bool:
        frames = {s.frame: i for i, s in enumerate(self._body.sensors) if valid[i]}
        unknowns: dict[str, int] = {"": self._held}
        for contact in self._contacts:
            top = self._top(contact.above, frames)
            unknowns[top] = unknowns.get(top, 0) + contact.unknowns
        return all(unknowns[top] <= SOLVABLE for top in self._borne_by(joint, frames))

    def _borne_by(self, joint: str, frames: dict[str, int]) -> set[str]:
        """Sub-models, by the sensor at their top, with contacts that a joint bears."""
        tops = set()
        for contact in self._contacts:
            top = self._top(contact.above, frames)
            until = contact.above.index(top) if top else len(contact.above)
            if joint in contact.above[:until]:
                tops.add(top)
        return tops

    @staticmethod
    def _top(above: Sequence[str], frames: dict[str, int]) -> str:
        """The first working sensor on the way to the root; empty where there is none."""
        return next((joint for joint in above if joint in frames), "")

    def _reach(self, sensor: int, frames: dict[str, int]) -> tuple[str, ...]:
        """Joints above a sensor, up to the next working one."""
        above = self._sensor_above[sensor][1:]  # the first is its own frame
        until = next((i for i, joint in enumerate(above) if joint in frames), len(above))
        return above[:until]
