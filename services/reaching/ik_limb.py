"""One limb of the IK service: its problem, the set-up in use, and the solvers asked for so far."""

import math
from typing import Literal

import numpy as np

from dforc.arrays import Vector
from dforc.ik.inverse_kinematics import InverseKinematics
from dforc.ik.problem import IkProblem, TipTarget
from dforc.ik.solver import Solver
from dforc.ik.sqp import Sqp
from services.core.errors import ConfigError
from services.core.service import Inputs
from services.reaching.limb import find_limb, joined, limb_joints, limb_problem
from services.reaching.limb_setup import apply_setup
from services.reaching.messages import LimbSetup
from services.robotfile.robot_tables import RobotFile
from services.streams import JOINT_STATE

STATE_AGE_S = 0.1
DEFAULT_SOLVER = "sqp"
# Deadlines are kept by counting: what a slow core does in a ms, and no solver's name but these.
ITERATIONS_PER_MS = {"sqp": 100.0, "ipopt": 3.0, "fatrop": 4.0}


class IkLimb:
    """What is kept of a limb from one answer to the next."""

    def __init__(self, robot: RobotFile, name: str) -> None:
        """Load its model.

        Raises:
            ConfigError: the parts in use make up no such limb.
        """
        limb = find_limb(robot, name)
        self.name = limb.name
        self.joints = limb_joints(robot, name)
        self.states = tuple(JOINT_STATE[part] for part in limb.parts)
        self.waist = frozenset(robot.parts.get("torso", ()))
        self.home_rad: Vector = np.radians(limb.home_deg)
        self.setup = LimbSetup(limb=limb.name)
        self._plain = limb_problem(robot, name)  # as the robot file has it
        self.problem = self._plain
        self._solvers: dict[tuple[str, str], Solver] = {}

    @property
    def tips(self) -> int:
        """Hands that it moves."""
        return len(self._plain.tips)

    def set_up(self, setup: LimbSetup) -> None:
        """Keep to a set-up from the next answer on.

        Raises:
            ConfigError: it does not fit; the one before stays.
        """
        self.problem = self.problem_of(setup)
        self.setup = setup

    def problem_of(self, setup: LimbSetup) -> IkProblem:
        """The limb's problem under a set-up.

        Raises:
            ConfigError: the set-up is another limb's, or does not fit.
        """
        if setup.limb not in ("", self.name):
            raise ConfigError(f"a set-up of {setup.limb!r} for {self.name!r}")
        if setup.iterations < 0:
            raise ConfigError(f"a search of {setup.iterations} iterations")
        if setup.solver not in ("", *ITERATIONS_PER_MS):
            known = ", ".join(ITERATIONS_PER_MS)
            raise ConfigError(f"unknown solver {setup.solver!r}; known: {known}")
        return apply_setup(self._plain, setup)

    def solver(self, name: str, user: Literal["stream", "requests"]) -> Solver:
        """A solver, made when it is first asked for; each user has tables of its own."""
        key = (name or DEFAULT_SOLVER, user)
        if key not in self._solvers:
            self._solvers[key] = _solver(key[0])
        return self._solvers[key]

    def warm(self) -> None:
        """Search once, so that what is compiled has been when somebody waits for it."""
        homes = [tip.pose(self.home_rad) for tip in self._plain.tips]
        targets = [TipTarget.checked(p, R) for R, p in homes]
        InverseKinematics(self._plain, self.solver("", "stream")).track(targets, self.home_rad)

    def measured(self, inputs: Inputs) -> Vector | None:
        """The posture as measured; None while it is not known."""
        joints = joined(tuple(inputs.fresh(state, STATE_AGE_S) for state in self.states))
        if joints is None or len(joints[0]) != len(self.joints):
            return None
        # A sum of squares is finite only if every term is, and no term is beyond squaring.
        return np.array(joints[0]) if math.isfinite(sum(q * q for q in joints[0])) else None


def _solver(name: str) -> Solver:
    if name == "sqp":
        return Sqp()
    from dforc.ik.interior import InteriorSolver  # CasADi takes half a second to load
    from dforc.symbolic.nonlinear import Method

    return InteriorSolver(Method(name))
