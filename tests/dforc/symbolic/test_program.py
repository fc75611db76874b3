"""Derivatives that were written out by hand, against those that CasADi makes of the same code."""

import casadi as ca
import numpy as np
import pytest

from dforc import rotation
from dforc.arrays import Vector
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel
from dforc.symbolic.nonlinear import Method, Prepared
from dforc.symbolic.program import Program, Structure, TipParameters, reaching_program

AXIS = np.array([0.6, -0.48, 0.64])


class Bent:
    """A constraint with curvature."""

    size = 1

    def symbolic(self, q: ca.SX) -> ca.SX:
        return ca.sumsqr(q) * q[0]


@pytest.fixture(scope="module")
def program(model: RobotModel, limits: JointLimits) -> Program:
    """Two tips at the same hand, and a constraint beside the rows."""
    chain = tuple(model.chain_description())
    return reaching_program(Structure(model.n, (chain, chain), limits.rows != 0.0, Bent()))


def parameters(
    model: RobotModel, limits: JointLimits, rest: Vector, q: Vector, turn_rad: float
) -> Vector:
    """Every weight in use; targets 5 cm from the posture's hand, turned by an angle."""
    R, p = model.tip_pose(q)
    tips = []
    for weights in ((2.0, 1.0, 1.0, 0.3), (0.5, 0.7, 0.2, 1.5)):
        tip = TipParameters(
            position_m=p + np.array([0.03, -0.04, 0.0]),
            rotation=rotation.matrix(AXIS * turn_rad) @ R,
            offset_m=np.array([0.02, 0.01, -0.05]),
            cost_position=weights[0],
            cost_orientation=weights[1],
            condition_position=weights[2],
            condition_orientation=weights[3],
            radius=0.4,
            pull=np.array([0.1, 0.2, -0.3]),
        )
        tips.append(tip.values())
    spread = np.linspace(0.0, 0.01, model.n)
    return np.concatenate([*tips, rest, spread, [7.0], limits.rows[limits.rows != 0.0]])


@pytest.mark.parametrize("turn_rad", [1e-4, 0.3, 2.0, 3.1])
def test_derivatives_are_exact(
    turn_rad: float,
    program: Program,
    model: RobotModel,
    limits: JointLimits,
    rest: Vector,
    postures: list[Vector],
) -> None:
    lagrangian = program.factor * program.f + ca.dot(program.multipliers, program.g)
    arguments = [program.z, program.p, program.factor, program.multipliers]
    own = [program.gradient, program.jacobian, program.hessian]
    made = [
        ca.gradient(program.f, program.z),
        ca.jacobian(program.g, program.z),
        ca.hessian(lagrangian, program.z)[0],
    ]
    both = ca.Function("both", arguments, [*own, *made])
    multipliers = np.linspace(-1.0, 2.0, program.g.numel())
    for q in postures[:4]:
        given = parameters(model, limits, rest, q, turn_rad)
        z = np.concatenate([q, np.linspace(-0.5, 0.5, 12)])
        values = [np.array(value) for value in both(z, given, 1.3, multipliers)]
        for ours, casadi in zip(values[:3], values[3:], strict=True):
            assert ours == pytest.approx(casadi, abs=1e-8 * max(1.0, float(np.abs(ours).max())))


def test_cost_and_condition_are_finite_where_the_pose_is_met_exactly(
    program: Program,
    model: RobotModel,
    limits: JointLimits,
    rest: Vector,
    postures: list[Vector],
) -> None:
    q = postures[0]
    given = parameters(model, limits, rest, q, 0.0)
    outputs = [program.gradient, program.jacobian, program.hessian]
    arguments = [program.z, program.p, program.factor, program.multipliers]
    function = ca.Function("f", arguments, outputs)
    z = np.concatenate([q, np.zeros(12)])
    for value in function(z, given, 1.0, np.ones(program.g.numel())):
        assert np.isfinite(np.array(value)).all()


def test_fatrop_is_given_the_written_out_hessian(program: Program) -> None:
    solver = Prepared(program, Method.FATROP).solver({"print_level": 0})
    inner = solver.get_function("nlp_hess_l").find_functions()
    plain = ca.Function(
        "nlp", [program.z, program.p], [program.f, program.g], ["x", "p"], ["f", "g"]
    )
    outputs = ["grad:gamma:x", "hess:gamma:x:x"]
    made = plain.factory("h", ["x", "p", "lam:f", "lam:g"], outputs, {"gamma": ["f", "g"]})
    assert sum(function.n_instructions() for function in inner) < 0.75 * made.n_instructions()
