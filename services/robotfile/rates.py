"""How often the robot process works and publishes: by the robot file, other live than virtual."""

from dataclasses import dataclass

from services.robotfile.robot_tables import RobotFile

RATED = ("hal", "wrench", "joint_state")


@dataclass(frozen=True, kw_only=True)
class Rates:
    """How often to publish, in Hz."""

    hal_hz: int  # of the service's own step
    wrench_hz: int
    joint_state_hz: int

    @classmethod
    def virtual(cls, robot: RobotFile) -> "Rates":
        """Those of virtual time."""
        hal, wrench, state = (robot.rates[name].virtual_hz for name in RATED)
        return cls(hal_hz=hal, wrench_hz=wrench, joint_state_hz=state)

    @classmethod
    def live(cls, robot: RobotFile) -> "Rates":
        """Those of a live stack."""
        hal, wrench, state = (robot.rates[name].live_hz for name in RATED)
        return cls(hal_hz=hal, wrench_hz=wrench, joint_state_hz=state)

    def steps_per_message(self, rate_hz: int) -> int:
        """Steps of the service from one message of a stream to the next."""
        return max(1, round(self.hal_hz / rate_hz))
