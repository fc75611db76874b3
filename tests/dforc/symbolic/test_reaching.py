"""Derivatives that were written out by hand, against those that CasADi makes of the same code."""

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from dforc import rotation
from dforc.arrays import Vector
from dforc.limits import JointLimits
from dforc.robot_model import RobotModel
from dforc.symbolic.kinematics import SymbolicChain, symbolic_chain
from dforc.symbolic.reaching import (
    Problem,
    nearest_problem,
    optimality_function,
    reaching_problem,
)

Make = Callable[[SymbolicChain, JointLimits], Problem]


def reaching(chain: SymbolicChain, limits: JointLimits) -> Problem:
    return reaching_problem(chain, limits.rows)


def nearest(chain: SymbolicChain, limits: JointLimits) -> Problem:
    return nearest_problem(chain, limits.rows, 1e4)


@pytest.fixture(scope="module")
def chain(model: RobotModel) -> SymbolicChain:
    return symbolic_chain(model.chain_description(), model.n)


def parameters(model: RobotModel, q: Vector, turn_rad: float, rest: Vector) -> Vector:
    """A target 5 cm from the posture's hand, turned by an angle."""
    R, p = model.tip_pose(q)
    turned = rotation.matrix(np.array([0.6, -0.48, 0.64]) * turn_rad) @ R
    weights = np.linspace(0.0, 0.01, model.n)
    return np.concatenate([p + np.array([0.03, -0.04, 0.0]), turned.flatten("F"), rest, weights])


@pytest.mark.parametrize("make", [reaching, nearest])
@pytest.mark.parametrize("turn_rad", [1e-4, 0.3, 2.0, 3.1])
def test_derivatives_are_exact(
    make: Make,
    turn_rad: float,
    chain: SymbolicChain,
    model: RobotModel,
    limits: JointLimits,
    rest: Vector,
    postures: list[Vector],
) -> None:
    problem = make(chain, limits)
    x, p, f, g = (problem.nlp[name] for name in ("x", "p", "f", "g"))
    lam_f, lam_g = ca.SX.sym("lam_f"), ca.SX.sym("lam_g", g.numel())
    lagrangian = lam_f * f + ca.dot(lam_g, g)
    gradient = ca.Function("gradient", [x, p], [ca.gradient(f, x)])
    jacobian = ca.Function("jacobian", [x, p], [ca.jacobian(g, x)])
    upper = ca.triu(ca.hessian(lagrangian, x)[0])
    hessian = ca.Function("hessian", [x, p, lam_f, lam_g], [upper])
    multipliers = np.linspace(-1.0, 2.0, g.numel())
    for q in postures[:5]:
        given = parameters(model, q, turn_rad, rest)
        own = np.array(problem.options["grad_f"](q, given)[1])
        scale = max(1.0, float(np.abs(own).max()))
        assert own == pytest.approx(np.array(gradient(q, given)), abs=1e-9 * scale)
        own = np.array(problem.options["jac_g"](q, given)[1])
        assert own == pytest.approx(np.array(jacobian(q, given)), abs=1e-9)
        own = np.array(problem.options["hess_lag"](q, given, 1.3, multipliers))
        scale = max(1.0, float(np.abs(own).max()))
        made = np.array(hessian(q, given, 1.3, multipliers))
        assert own == pytest.approx(made, abs=1e-8 * scale)


def test_cost_and_its_derivatives_are_finite_where_the_orientation_is_met_exactly(
    chain: SymbolicChain,
    model: RobotModel,
    limits: JointLimits,
    rest: Vector,
    postures: list[Vector],
) -> None:
    problem = reaching(chain, limits)
    given = parameters(model, postures[0], 0.0, rest)
    given[-model.n :] = 0.0
    cost, gradient = problem.options["grad_f"](postures[0], given)
    assert float(cost) == pytest.approx(0.0, abs=1e-14)
    assert np.array(gradient) == pytest.approx(np.zeros((model.n, 1)), abs=1e-7)
    hessian = np.array(problem.options["hess_lag"](postures[0], given, 1.0, np.zeros(8)))
    J = model.tip_jacobian(postures[0])[3:]
    assert hessian == pytest.approx(np.triu(2 * J.T @ J), abs=1e-9)


def test_optimality_function_splits_the_same_hessian(
    chain: SymbolicChain,
    model: RobotModel,
    limits: JointLimits,
    rest: Vector,
    postures: list[Vector],
) -> None:
    """With y = 2 lambda x, Hess(f + y . x) + 2 lambda J'J is the Lagrangian's of eq. 11."""
    q, given = postures[3], parameters(model, postures[3], 0.4, rest)
    x = model.tip_pose(q)[1] - given[:3]
    multipliers = np.zeros(8)
    multipliers[0] = 7.0
    whole = np.array(reaching(chain, limits).options["hess_lag"](q, given, 1.0, multipliers))
    _, split, residual, jacobian = (
        np.array(value) for value in optimality_function(chain)(q, given, 2 * 7.0 * x)
    )
    assert residual[:, 0] == pytest.approx(x, abs=1e-12)
    assert jacobian == pytest.approx(model.tip_jacobian(q)[:3], abs=1e-12)
    assert np.triu(split + 2 * 7.0 * jacobian.T @ jacobian) == pytest.approx(whole, abs=1e-9)
