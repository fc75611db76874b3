"""The modes there are, what each promises, and how one is made for a limb."""

from collections.abc import Mapping
from types import MappingProxyType

from dforc.collision.body import Body
from services.fields.dforc_mode import DforcMode
from services.fields.limbs import FieldLimb
from services.fields.mode import FieldMode, ModeOf
from services.fields.pmp_mode import PmpMode
from services.fields.ulna_mode import UlnaMode
from services.robotfile.robot_tables import RobotFile

DEFAULT_MODE = "ulna"
PROMISES: Mapping[str, str] = MappingProxyType(
    {
        "ulna": "the whole arm touches neither obstacles nor the body nor the other arm, and "
        "arrives where there is a way; where there is none it waits and says so",
        "dforc": "the paper's force field: the hand's centre is kept out of obstacles grown by the "
        "margin; arm and body are not looked at, and the point may be trapped",
        "pmp": "the paper's passive motion: as dforc, and limit fields or the time base may end it "
        "before the goal",
    }
)


def mode_makers(robot: RobotFile, body: Body) -> dict[str, ModeOf]:
    """By name; all of them share the robot's body."""

    def ulna(limb: FieldLimb, gains: Mapping[str, float]) -> FieldMode:
        frames = tuple(tip.frame for tip in robot.limbs[limb.name].tips)
        return UlnaMode(limb, gains, body, frames)

    return {"ulna": ulna, "dforc": DforcMode, "pmp": PmpMode}
