"""Who takes part where solvers of inverse kinematics are compared."""

from dforc.ik.interior import FatropSolver, IpoptSolver
from services.experiments.ik.arm import Arm
from services.experiments.ik.contenders import Contender, Nothing, Ours, Stock
from services.experiments.ik.nlp import Form
from services.experiments.ik.peers import peers
from services.experiments.ik.poses import OURS, REFERENCE
from services.experiments.rows import Row


def ours(arm: Arm) -> list[Contender]:
    """The project's three solvers, the default one first."""
    return [
        Ours(OURS, arm),
        Ours("ours (fatrop)", arm, FatropSolver()),
        Ours("ours (IPOPT)", arm, IpoptSolver()),
    ]


def reference(arm: Arm) -> Contender:
    """What times are compared with: IPOPT on eq. 11 as anybody would write it."""
    made = Stock(arm, Form.SQUARED, "ipopt")
    made.name = REFERENCE
    return made


def everybody(arm: Arm) -> tuple[list[Contender], list[Row]]:
    """The empty call, ours, the reference, fatrop and all peers; a row for each that is missing."""
    others, missing = peers(arm)
    field = [Nothing(), *ours(arm), reference(arm), Stock(arm, Form.EXACT, "fatrop"), *others]
    return field, [Row(name, None, "", why) for name, why in missing.items()]
