"""Who gets torques now: inputs, sensors and assumption taken together, and why others get none."""

from dforc.estimation.assumption import Assumption
from services.wholebody.body import Body, BodyPart
from services.wholebody.joint_bank import JointBank
from services.wholebody.kinematic_source import KinematicSource
from services.wholebody.sensor_bank import SensorBank
from services.wholebody.torque_parts import TorqueParts


class TorqueGate:
    """Judges anew when something comes or goes."""

    def __init__(
        self,
        body: Body,
        assumption: Assumption,
        bank: SensorBank,
        joints: JointBank,
        source: KinematicSource,
    ) -> None:
        self.speaking: tuple[tuple[BodyPart, tuple[int, ...]], ...] = ()  # with their sensors
        self.silent: tuple[tuple[str, str], ...] = ()  # parts that get none, and why
        self.heard = (False,) * len(body.sensors)  # whether the joints around a sensor are known
        self.postured: tuple[BodyPart, ...] = ()  # parts whose gravity torques are known
        self._body = body
        self._bank = bank
        self._joints = joints
        self._source = source
        self._parts = TorqueParts(body, assumption)
        named = {part.name: part for part in body.parts}
        self._around = [named[sensor.part] for sensor in body.sensors]
        self._judged: object = None

    def trouble_around(self, sensor: int) -> str:
        """Why the joints around a sensor are not known; empty = they are."""
        return self._trouble(self._around[sensor])

    def assume(self, assumption: Assumption) -> None:
        """Judge by other contacts from now on."""
        self._parts.assume(assumption)
        self._judged = None

    def update(self) -> None:
        """Once per step."""
        state = (self._bank.valid, self._joints.fresh, self._source.trouble)
        if state == self._judged:
            return
        self._judged = state
        troubles = {part.name: self._trouble(part) for part in self._body.parts}
        speaking, silent = [], []
        for verdict in self._parts.judge(self._bank.valid):
            name = verdict.part.name
            refusal = troubles[name] or verdict.refusal
            if refusal:
                silent.append((name, refusal))
            else:
                speaking.append((verdict.part, verdict.sensors))
        self.speaking, self.silent = tuple(speaking), tuple(silent)
        self.heard = tuple([not troubles[part.name] for part in self._around])
        self.postured = tuple(p for p in self._body.parts if p.felt and not troubles[p.name])

    def _trouble(self, part: BodyPart) -> str:
        """Which joints or motion is not known that a part's torques need; empty = none."""
        missing = self._joints.missing_for(part)
        if self._source.frame:
            missing += tuple(n for n in self._source.parts if not self._joints.is_heard(n))
        if missing:
            return f"joints of {', '.join(dict.fromkeys(missing))} are not heard or not calibrated"
        return self._source.trouble
