"""A command's way to a posture: the IK service of a running stack, or the robot's model here."""

from services.cli.stack_client import StackClient
from services.core.clock import NS_PER_MS, RealClock
from services.core.errors import ServiceError
from services.reaching.ik_job import IkJob
from services.reaching.ik_limb import IkLimb
from services.reaching.ik_statistics import SearchCount
from services.reaching.limb import find_limb
from services.reaching.messages import IkReply, IkRequest
from services.robotfile.robot_tables import RobotFile
from services.streams import IK_CALL


class IkClient(StackClient):
    """One client of a stack."""

    def ask(self, request: IkRequest) -> IkReply:
        """Send a request to the IK service.

        Raises:
            ServiceError: there is no such service, or no answer comes.
        """
        if "ik" not in self.bus.alive():
            raise self.silence(IK_CALL.name)
        return self.call(IK_CALL, request)

    def silence(self, name: str) -> ServiceError:
        """What to say of a stream that is silent though the stack is up."""
        if "ik" not in self.bus.alive():
            return ServiceError(
                f"no ik process in stack {self.stack!r}: its parts make up no limb, "
                f"or it has ended; see `ulna up`'s log"
            )
        return ServiceError(f"{name} is silent; see `ulna up`'s log")


def solve_here(robot: RobotFile, request: IkRequest) -> tuple[IkReply, float]:
    """What the service would answer from the home posture, and how long that takes in ms.

    The second time is told: the first one reads the compiled code and makes tables.

    Raises:
        ConfigError: no such request can be answered; the text says what is wrong with it.
    """
    limb = IkLimb(robot, find_limb(robot, request.limb).name)
    clock = RealClock()
    begun_ns = 0
    for _ in range(2):
        job = IkJob(limb, request, limb.home_rad, SearchCount())
        begun_ns = clock.now_ns()
        while job.waiting:
            job.advance()
    return job.reply(0), (clock.now_ns() - begun_ns) / NS_PER_MS
