"""Ways to solve inverse kinematics, all asked the same way: ours and the stock solvers."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from dforc.ik.inverse_kinematics import IkResult, IkStatus, InverseKinematics
from dforc.ik.problem import IkProblem, Tip, TipTarget
from dforc.ik.solver import Solver
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel
from services.experiments.ik.arm import BETA, TOLERANCE_M, Arm, Array
from services.experiments.ik.nlp import Form, PlainNlp


@dataclass(frozen=True, eq=False)
class Answer:
    """A posture, if there is one, and what the solver says about the position."""

    q: Array | None
    reached: bool | None  # None: the solver does not say


class Contender(Protocol):
    """One solver. An answer depends on the arguments alone, so that the best of three is fair."""

    name: str
    by_wall: bool  # it has threads of its own: only the time on the wall is fair

    def solve(self, position: Array, rotation: Array, q0: Array) -> Answer:
        """Search from q0."""
        ...

    def track(self, position: Array, rotation: Array, q_before: Array) -> Answer:
        """Follow a stream whose last answer was q_before."""
        ...


class Nothing:
    """The empty call: what measuring itself costs."""

    name, by_wall = "empty call", False

    def solve(self, position: Array, rotation: Array, q0: Array) -> Answer:  # noqa: ARG002
        """Give the start back."""
        return Answer(q0, None)

    track = solve


class Ours:
    """The project's inverse kinematics, by whichever of its solvers."""

    by_wall = False

    def __init__(self, name: str, arm: Arm, solver: Solver | None = None) -> None:
        """`solver` None = the project's own default."""
        self.name = name
        self.problem = problem_of(arm)
        self.ik = InverseKinematics(self.problem, solver)

    def solve(self, position: Array, rotation: Array, q0: Array) -> Answer:
        """With as many starts as it likes."""
        return _answer(self.ik.solve([TipTarget.checked(position, rotation)], q0))

    def track(self, position: Array, rotation: Array, q_before: Array) -> Answer:
        """One tick, with the step limit it has by itself."""
        return _answer(self.ik.track([TipTarget.checked(position, rotation)], q_before))


class Stock:
    """CasADi with a stock solver, in one form of the problem."""

    by_wall = False

    def __init__(self, arm: Arm, form: Form, plugin: str) -> None:
        self.name = f"{'IPOPT' if plugin == 'ipopt' else plugin}, {form.value}"
        self._nlp = PlainNlp(arm, form, plugin)

    def solve(self, position: Array, rotation: Array, q0: Array) -> Answer:
        """One run."""
        return Answer(self._nlp.solve(position, rotation, q0), None)

    track = solve


def problem_of(arm: Arm) -> IkProblem:
    """An arm as the project's solvers take it."""
    tips = [Tip(tip, RobotModel(arm.urdf, arm.joints, tip, {})) for tip in arm.tips]
    limits = JointLimits.make(arm.lower, arm.upper, arm.A, arm.row_lower, arm.row_upper)
    problem = IkProblem.make(tips, limits, arm.rest, arm.weights)
    return problem.changed(beta=BETA, position_tolerance_m=TOLERANCE_M)


def _answer(found: IkResult) -> Answer:
    reached = None if found.status is IkStatus.OUT_OF_TIME else found.status is IkStatus.CONVERGED
    return Answer(np.array(found.q_rad), reached)
