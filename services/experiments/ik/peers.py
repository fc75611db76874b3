"""What somebody would use instead: TRAC-IK, KDL, pink, mink, SciPy. Each where it is installed."""

from collections.abc import Callable
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

from services.experiments.ik.arm import BETA, Arm, Array
from services.experiments.ik.contenders import Answer, Contender

POSITION_TOLERANCE_M, ANGLE_TOLERANCE_RAD = 1e-4, 1e-3  # where the iterations of pink and mink end
STEPS = 50
STEP_S = 0.05  # of one iteration: with unit gain the whole way
LIMIT_S = 0.005  # TRAC-IK's own deadline
TRAC_TOLERANCE = 1e-5
KDL_ITERATIONS, KDL_TOLERANCE = 100, 1e-6


class TracIk:
    """TRAC-IK, `Speed`: two threads, so that its time is the wall's."""

    name, by_wall = "TRAC-IK (wall)", True

    def __init__(self, arm: Arm) -> None:
        import pytracik

        self._call = pytracik.ik
        chain = [arm.model.names[arm.model.getJointId(joint)] for joint in arm.joints]
        urdf = _only(arm, chain)
        self._solver = pytracik.TRAC_IK(
            "root_link", arm.tips[0], urdf, LIMIT_S, TRAC_TOLERANCE, pytracik.SolveType.Speed
        )
        pytracik.set_joint_limits(self._solver, arm.lower, arm.upper)

    def solve(self, position: Array, rotation: Array, q0: Array) -> Answer:
        """One call; no answer where it finds none."""
        x, y, z, w = pin.Quaternion(rotation).coeffs()
        found = np.asarray(self._call(self._solver, q0, *position, x, y, z, w))
        return Answer(found[1:], True) if found[0] >= 0 else Answer(None, False)

    track = solve


class Kdl:
    """KDL's Newton-Raphson with joint limits."""

    name, by_wall = "KDL NR_JL", False

    def __init__(self, arm: Arm) -> None:
        import PyKDL as kdl  # noqa: N813  # its own name

        self._kdl, self._n = kdl, arm.n
        chain, place = kdl.Chain(), kdl.Frame()
        for link in arm.chain():
            here = place * kdl.Frame(kdl.Rotation(*link.R.ravel()), kdl.Vector(*link.p))
            if link.joint < 0:
                chain.addSegment(kdl.Segment(kdl.Joint(), here))
                break
            origin, axis = here.p, here.M * kdl.Vector(*link.axis)
            joint = kdl.Joint(f"j{link.joint}", origin, axis, kdl.Joint.RotAxis)
            chain.addSegment(kdl.Segment(joint, here))
            place = kdl.Frame()
        self._chain = chain
        self._forward = kdl.ChainFkSolverPos_recursive(chain)
        self._velocity = kdl.ChainIkSolverVel_pinv(chain)
        self._solver = kdl.ChainIkSolverPos_NR_JL(
            chain,
            self._joints(arm.lower),
            self._joints(arm.upper),
            self._forward,
            self._velocity,
            KDL_ITERATIONS,
            KDL_TOLERANCE,
        )

    def _joints(self, q: Array) -> object:
        made = self._kdl.JntArray(self._n)
        for i, value in enumerate(q.tolist()):
            made[i] = value
        return made

    def solve(self, position: Array, rotation: Array, q0: Array) -> Answer:
        """One call; its last posture also where it gives up."""
        kdl = self._kdl
        goal = kdl.Frame(kdl.Rotation(*rotation.ravel()), kdl.Vector(*position))
        found = kdl.JntArray(self._n)
        state = self._solver.CartToJnt(self._joints(q0), goal, found)
        return Answer(np.array([found[i] for i in range(self._n)]), bool(state >= 0))

    track = solve


class Pink:
    """pink with daqp: a hand task and a posture task, until the hand is there."""

    name, by_wall = "pink + daqp", False

    def __init__(self, arm: Arm) -> None:
        import pink
        from pink.limits import ConfigurationLimit

        self._pink, self._arm = pink, arm
        model = arm.model.copy()
        model.lowerPositionLimit = arm.model_order(arm.lower)
        model.upperPositionLimit = arm.model_order(arm.upper)
        self._model, self._data = model, model.createData()
        self._hand = pink.tasks.FrameTask(arm.tips[0], 1.0, 1.0)
        self._posture = pink.tasks.PostureTask(cost=1e-3)
        self._posture.set_target(arm.model_order(arm.rest))
        self._limits = [ConfigurationLimit(model)]

    def solve(self, position: Array, rotation: Array, q0: Array) -> Answer:
        """At most 50 iterations."""
        return self._run(position, rotation, q0, STEPS)

    def track(self, position: Array, rotation: Array, q_before: Array) -> Answer:
        """One iteration per tick, as it is meant to be used."""
        return self._run(position, rotation, q_before, 1)

    def _run(self, position: Array, rotation: Array, q0: Array, steps: int) -> Answer:
        self._hand.set_target(pin.SE3(rotation, position))
        at = self._pink.Configuration(
            self._model, self._data, self._arm.model_order(q0), copy_data=False
        )
        for _ in range(steps):
            error = self._hand.compute_error(at)
            if _close(error):
                break
            speed = self._pink.solve_ik(
                at,
                [self._hand, self._posture],
                STEP_S,
                solver="daqp",
                limits=self._limits,
                safety_break=False,
            )
            at.integrate_inplace(speed, STEP_S)
        return Answer(self._arm.own_order(at.q), None)


class Mink:
    """mink with daqp, on MuJoCo's reading of the URDF."""

    name, by_wall = "mink + daqp", False

    def __init__(self, arm: Arm) -> None:
        import mink
        import mujoco

        self._mink, self._arm = mink, arm
        model = mujoco.MjModel.from_xml_string(_only(arm, arm.joints, bodies=True))
        at = [model.joint(name).qposadr[0] for name in arm.joints]
        self._at = np.array(at)
        for name, low, high in zip(arm.joints, arm.lower, arm.upper, strict=True):
            model.joint(name).range[:] = low, high
        self._configuration = mink.Configuration(model)
        body, self._offset = _body_of(arm)
        self._hand = mink.FrameTask(body, "body", 1.0, 1.0)
        self._posture = mink.PostureTask(model, cost=1e-3)
        self._posture.set_target(self._theirs(arm.rest))
        self._limits = [mink.ConfigurationLimit(model)]

    def _theirs(self, q: Array) -> Array:
        made = np.zeros(len(self._at))
        made[self._at] = q
        return made

    def solve(self, position: Array, rotation: Array, q0: Array) -> Answer:
        """At most 50 iterations."""
        return self._run(position, rotation, q0, STEPS)

    def track(self, position: Array, rotation: Array, q_before: Array) -> Answer:
        """One iteration per tick."""
        return self._run(position, rotation, q_before, 1)

    def _run(self, position: Array, rotation: Array, q0: Array, steps: int) -> Answer:
        mink, at = self._mink, self._configuration
        goal = (pin.SE3(rotation, position) * self._offset.inverse()).homogeneous
        self._hand.set_target(mink.SE3.from_matrix(goal))
        at.update(self._theirs(q0))
        for _ in range(steps):
            if _close(self._hand.compute_error(at)):
                break
            speed = mink.solve_ik(
                at,
                [self._hand, self._posture],
                STEP_S,
                "daqp",
                limits=self._limits,
            )
            at.integrate_inplace(speed, STEP_S)
        return Answer(np.array(at.q[self._at]), None)


class SciPy:
    """SLSQP of SciPy on eq. 11 with three equations, kinematics and Jacobian by pinocchio."""

    name, by_wall = "SciPy SLSQP, x = 0", False

    def __init__(self, arm: Arm) -> None:
        from scipy.optimize import Bounds, minimize

        self._minimize, self._arm = minimize, arm
        self._bounds = Bounds(arm.lower, arm.upper)
        below, above = np.isfinite(arm.row_lower), np.isfinite(arm.row_upper)
        C = np.vstack([arm.A[below], -arm.A[above]])
        least = np.concatenate([arm.row_lower[below], -arm.row_upper[above]])
        self._rows = {"type": "ineq", "fun": lambda q: C @ q - least, "jac": lambda _: C}

    def solve(self, position: Array, rotation: Array, q0: Array) -> Answer:
        """One run."""
        arm = self._arm

        def cost(q: Array) -> tuple[float, Array]:
            e = pin.log3(arm.pose(q)[0] @ rotation.T)
            away = q - arm.rest
            slope = 2.0 * arm.jacobian(q)[3:].T @ e + 2.0 * BETA * arm.weights * away
            return float(e @ e) + BETA * float(arm.weights @ (away * away)), slope

        reach = {
            "type": "eq",
            "fun": lambda q: arm.pose(q)[1] - position,
            "jac": lambda q: arm.jacobian(q)[:3],
        }
        found = self._minimize(
            cost,
            q0,
            jac=True,
            bounds=self._bounds,
            constraints=[reach, self._rows],
            method="SLSQP",
            options={"maxiter": 200, "ftol": 1e-8},
        )
        return Answer(np.asarray(found.x), bool(found.success))

    track = solve


PEERS: dict[str, tuple[Callable[[Arm], Contender], str]] = {
    "TRAC-IK": (TracIk, "./ulna setup peers"),
    "KDL": (Kdl, "Debian's python3-pykdl"),
    "pink": (Pink, "./ulna setup peers"),
    "mink": (Mink, "./ulna setup peers"),
    "SciPy": (SciPy, "pip install scipy"),
}


def peers(
    arm: Arm, names: tuple[str, ...] = tuple(PEERS)
) -> tuple[list[Contender], dict[str, str]]:
    """Those that are installed, and for the others why they are not measured."""
    found: list[Contender] = []
    missing = {}
    for name in names:
        make, source = PEERS[name]
        try:
            found.append(make(arm))
        except ImportError as error:
            missing[name] = f"not measured: {error}; {source}"
        except ValueError as error:  # MuJoCo cannot read this model
            missing[name] = f"not measured: {error}"
    return found, missing


def _close(error: Array) -> bool:
    return bool(
        np.linalg.norm(error[:3]) < POSITION_TOLERANCE_M
        and np.linalg.norm(error[3:]) < ANGLE_TOLERANCE_RAD
    )


def _only(arm: Arm, joints: tuple[str, ...] | list[str], *, bodies: bool = False) -> str:
    """The URDF as text in which no other joint moves, without shapes."""
    root = ElementTree.parse(arm.urdf).getroot()
    for link in root.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    for joint in root.iter("joint"):
        if joint.get("name") not in joints:
            joint.set("type", "fixed")
    if bodies:  # MuJoCo wants to be told, and no mass may be missing
        options = {"fusestatic": "true", "balanceinertia": "true", "strippath": "true"}
        ElementTree.SubElement(ElementTree.SubElement(root, "mujoco"), "compiler", options)
    return ElementTree.tostring(root, encoding="unicode")


def _body_of(arm: Arm) -> tuple[str, "pin.SE3"]:
    """The link that the last joint moves, which MuJoCo keeps, and where the tip sits in it."""
    frame = arm.model.frames[arm.model.getFrameId(arm.tips[0])]
    root = ElementTree.parse(arm.urdf).getroot()
    last = arm.model.names[frame.parentJoint]
    for joint in root.iter("joint"):
        child = joint.find("child")
        if joint.get("name") == last and child is not None:
            return str(child.get("link")), frame.placement
    raise ValueError(f"{arm.urdf} has no joint {last}")
