"""The last check before the bytes: set-points that are not finite or do not fit are refused."""

import math
from collections.abc import Sequence

from hal.decoupling import shoulders
from hal.machine import Machine
from hal.setpoints import Setpoints
from hal.torques import VirtualSensor
from hal.wire.modes import ControlMode


class Commands:
    """Takes what controllers want, for joints by index, and hands on what may be sent."""

    def __init__(self, machine: Machine, setpoints: tuple[Setpoints, ...]) -> None:
        self._machine = machine
        self._setpoints = setpoints
        self._sensor_of: list[VirtualSensor | None] = [
            machine.torques_of(axis) for axis in machine.axes
        ]
        self._shoulders = shoulders([(one.board, one.axes) for one in machine.boards])
        self.arrivals_ns: list[int] = []  # of the torques that leave with the next step

    def set_positions(self, joints: Sequence[int], q_rad: Sequence[float]) -> bool:
        """Position-direct references."""
        if not self._accepts("positions", joints, q_rad, ControlMode.DIRECT):
            return False
        for joint, value in zip(joints, q_rad, strict=True):
            self._setpoints[joint].set_position(value)
        return True

    def set_velocities(self, joints: Sequence[int], dq_rad_s: Sequence[float]) -> bool:
        """Velocity references."""
        if not self._accepts("velocities", joints, dq_rad_s, ControlMode.VELOCITY):
            return False
        for joint, value in zip(joints, dq_rad_s, strict=True):
            self._setpoints[joint].set_velocity(value)
        return True

    def set_torques(self, joints: Sequence[int], tau_nm: Sequence[float]) -> bool:
        """Torque references."""
        axes = self._machine.axes
        blind = [axes[joint].name for joint in joints if axes[joint].joint.torque_source is None]
        if blind:
            self._refuse(f"torques: no torque source for {', '.join(blind)}")
            return False
        if not self._accepts("torques", joints, tau_nm, ControlMode.TORQUE):
            return False
        for joint, value in zip(joints, self._decoupled(joints, tau_nm), strict=True):
            self._setpoints[joint].set_torque(value, self._machine.now_ns)
        return True

    def set_duties(self, joints: Sequence[int], duty_percent: Sequence[float]) -> bool:
        """Open-loop PWM."""
        if not self._accepts("duties", joints, duty_percent, ControlMode.OPENLOOP):
            return False
        for joint, value in zip(joints, duty_percent, strict=True):
            self._setpoints[joint].set_duty(value, self._machine.now_ns)
        return True

    def set_impedance_offsets(self, joints: Sequence[int], tau_nm: Sequence[float]) -> bool:
        """Offsets of the joints that can be compliant; the others need none."""
        if not self._accepts("impedance offsets", joints, tau_nm, None):
            return False
        axes = self._machine.axes
        for joint, value in zip(joints, self._decoupled(joints, tau_nm), strict=True):
            if axes[joint].can_be_compliant:
                self._setpoints[joint].set_offset(value)
        return True

    def _decoupled(self, joints: Sequence[int], tau_nm: Sequence[float]) -> Sequence[float]:
        """The same torques, as the loops of coupled motors have to be told them.

        A joint of a shoulder that is not among them counts with its estimated torque.
        """
        at = {joint: i for i, joint in enumerate(joints)}
        estimated = self._machine.readings.tau_nm
        sent = list(tau_nm)
        for shoulder in self._shoulders:
            three = [tau_nm[at[j]] if j in at else estimated[j] for j in shoulder.joints]
            if all(map(math.isfinite, three)):
                for joint, value in zip(shoulder.joints, shoulder.bent(three), strict=True):
                    if joint in at:
                        sent[at[joint]] = value
        return sent

    def set_joint_torques(
        self, joints: Sequence[int], tau_nm: Sequence[float], arrival_ns: int
    ) -> bool:
        """Estimated torques for the virtual sensors."""
        if not self._accepts("joint torques", joints, tau_nm, None):
            return False
        readings = self._machine.readings
        touched: set[VirtualSensor] = set()
        for joint, value in zip(joints, tau_nm, strict=True):
            readings.tau_nm[joint] = value
            sensor = self._sensor_of[joint]
            if sensor is not None:
                sensor.set(joint, value)
                touched.add(sensor)
        for sensor in touched:
            sensor.refresh(min(arrival_ns, self._machine.now_ns))
        if touched:
            self.arrivals_ns.append(arrival_ns)
        return True

    def _accepts(
        self, what: str, joints: Sequence[int], values: Sequence[float], mode: ControlMode | None
    ) -> bool:
        if len(joints) != len(values):
            self._refuse(f"{what}: {len(values)} values for {len(joints)} joints")
            return False
        if not all(map(math.isfinite, values)):
            axes = self._machine.axes
            bad = [
                axes[j].name for j, v in zip(joints, values, strict=True) if not math.isfinite(v)
            ]
            self._refuse(f"{what} not finite: {', '.join(bad)}")
            return False
        if mode is not None:
            modes = self._machine.readings.control_mode
            if any(modes[joint] != mode for joint in joints):
                # not reported: a controller may start before the switch is confirmed
                self._machine.faults.refuse(f"{what}: a joint is not in {mode.name.lower()} mode")
                return False
        return True

    def _refuse(self, text: str) -> None:
        faults = self._machine.faults
        faults.refuse(text)
        faults.report(self._machine.now_ns, f"refused {text}", text)
