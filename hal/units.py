"""Between SI units and what a motor board counts in (can-protocol 9.1 and 9.2).

The sign of an axis is inside ticks_per_deg. Torques are in joint sign; stiffness and damping act on
ticks, so they inherit that sign.
"""

import math

from hal.description import Joint
from hal.wire.numbers import round_half_away, saturate_i16, saturate_i32

TORQUE_HALF_RANGE = 0x8000  # torque units per TorqueMax
PEAK_OVER_MEAN = 1.875  # speed of a minimum-jerk move
DAMPING_SCALE = 1000  # the board counts damping in thousandths


class AxisUnits:
    """Conversions of one joint."""

    __slots__ = (
        "_ticks_per_deg",
        "_velocity_scale",
        "_zero_deg",
        "board_high_ticks",
        "board_low_ticks",
        "high_ticks",
        "low_ticks",
        "max_acceleration_rad_s2",
        "max_move_speed_counts",
        "max_rad",
        "max_velocity_rad_s",
        "min_rad",
        "rad_per_tick",
        "ticks_per_rad",
        "torque_counts_per_nm",
        "torque_limit_nm",
        "zero_rad",
    )

    def __init__(self, joint: Joint, velocity_shift: int) -> None:
        """`velocity_shift` is the scale of VELOCITY_MOVE: ticks/ms * 2^velocity_shift."""
        self._ticks_per_deg = joint.ticks_per_deg
        self._zero_deg = joint.zero_deg
        self.rad_per_tick = math.radians(1.0 / joint.ticks_per_deg)
        self.ticks_per_rad = math.degrees(joint.ticks_per_deg)
        self.zero_rad = math.radians(joint.zero_deg)
        low_deg, high_deg = joint.min_deg + joint.margin_deg, joint.max_deg - joint.margin_deg
        self.min_rad = math.radians(low_deg)
        self.max_rad = math.radians(high_deg)
        self.max_acceleration_rad_s2 = math.radians(joint.max_acceleration_deg_s2)
        self.limit_velocity(joint.max_velocity_deg_s)
        limits = (self._ticks_of_deg(joint.min_deg), self._ticks_of_deg(joint.max_deg))
        self.board_low_ticks, self.board_high_ticks = min(limits), max(limits)
        inside = (self._ticks_of_deg(low_deg), self._ticks_of_deg(high_deg))
        self.low_ticks, self.high_ticks = min(inside), max(inside)
        self._velocity_scale = self.ticks_per_rad / 1000.0 * 2**velocity_shift
        source = joint.torque_source
        self.torque_limit_nm = math.nan if source is None else source.full_scale_nm
        self.torque_counts_per_nm = TORQUE_HALF_RANGE / self.torque_limit_nm

    def limit_velocity(self, max_velocity_deg_s: float) -> None:
        """Set the speed that no set-point and no move exceeds."""
        self.max_velocity_rad_s = math.radians(max_velocity_deg_s)
        fastest_ticks_s = max_velocity_deg_s * abs(self._ticks_per_deg) / PEAK_OVER_MEAN
        self.max_move_speed_counts = min(max(int(fastest_ticks_s / 10.0), 1), 0x7FFF)

    def _ticks_of_deg(self, angle_deg: float) -> int:
        return saturate_i32((angle_deg + self._zero_deg) * self._ticks_per_deg)

    def ticks(self, q_rad: float) -> int:
        """Encoder ticks of a joint angle, rounded half away from zero."""
        return self._ticks_of_deg(math.degrees(q_rad))

    def limited_ticks(self, q_rad: float) -> int:
        """Encoder ticks of a joint angle, inside the joint's limits."""
        return min(max(self.ticks(q_rad), self.low_ticks), self.high_ticks)

    def q_rad(self, ticks: int) -> float:
        """Joint angle of an encoder reading."""
        return ticks * self.rad_per_tick - self.zero_rad

    def velocity_counts(self, dq_rad_s: float) -> int:
        """Argument of VELOCITY_MOVE."""
        return saturate_i16(dq_rad_s * self._velocity_scale)

    def torque_counts(self, tau_nm: float) -> int:
        """Torque units of a torque, 1 unit = TorqueMax / 0x8000; clamped to the 16-bit range."""
        return saturate_i16(tau_nm * self.torque_counts_per_nm)

    def stiffness_counts(self, stiffness_nm_deg: float) -> int:
        """Torque units per tick; not limited: a spring that no frame can carry is refused."""
        scale = TORQUE_HALF_RANGE / self.torque_limit_nm
        return round_half_away(stiffness_nm_deg * scale / self._ticks_per_deg)

    def damping_counts(self, damping_nms_deg: float) -> int:
        """Thousandths of torque units per tick/s; not limited either."""
        scale = TORQUE_HALF_RANGE / self.torque_limit_nm
        return round_half_away(damping_nms_deg * scale / self._ticks_per_deg * DAMPING_SCALE)


def move_speed_counts(delta_ticks: int, duration_s: float) -> int:
    """Speed argument of POSITION_MOVE, 10 ticks/s: the move takes 100 |delta| / speed ms."""
    if duration_s <= 0.0:
        return 0x7FFF
    return min(max(round_half_away(abs(delta_ticks) / (10.0 * duration_s)), 1), 0x7FFF)


def move_duration_ns(delta_ticks: int, speed_counts: int) -> int:
    """How long the board's minimum-jerk move takes."""
    return 100 * abs(delta_ticks) * 1_000_000 // speed_counts
