"""The plant against an independent integrator, the URDF's own model, and what friction must do."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from dforc.robot_model import RobotModel
from firmware_sim.description import MotorSpec, RigSpec
from firmware_sim.plants.couplings import motor_speeds
from firmware_sim.plants.kernel import ARMATURE
from firmware_sim.plants.plant import Plant
from firmware_sim.plants.rigid import Push

Vector = NDArray[np.float64]

FULL = (800,) * 7 + (1333,) * 3
ON, OFF = np.ones(10, dtype=np.bool_), np.zeros(10, dtype=np.bool_)
REST = np.zeros(10)
ELBOW, PROSUP = 6, 7


def plant_of(spec: RigSpec, step_s: float = 0.001) -> Plant:
    S = motor_speeds(spec.axes, [None] * 10)
    return Plant(spec.plant, spec.axes, spec.sensors, FULL, S, step_s)


def model_of(spec: RigSpec) -> RobotModel:
    joints = tuple(str(axis.joint) for axis in spec.axes)
    return RobotModel(spec.plant.urdf, joints, spec.plant.tip_frame, {"ft": "r_arm_ft_sensor"})


def with_motors(spec: RigSpec, **changes: float) -> RigSpec:
    def changed(motor: MotorSpec | None) -> MotorSpec:
        assert motor is not None
        return replace(motor, **changes)

    axes = tuple(replace(axis, motor=changed(axis.motor)) for axis in spec.axes)
    return replace(spec, axes=axes)


def counts(plant: Plant, joint: int, torque_nm: float) -> Vector:
    pwm = np.zeros(10)
    pwm[joint] = round(torque_nm / float(plant.drives.nm_per_count[joint]))
    return pwm


def test_falls_as_an_independent_integrator_says(exact_spec: RigSpec) -> None:
    loose = with_motors(exact_spec, coulomb_nm=0.0, viscous_nms_rad=0.0)
    plant = plant_of(loose, step_s=0.0001)
    for _ in range(3000):
        plant.step(REST, OFF)
    assert np.degrees(np.abs(plant.q_rad - start(loose))).max() > 5.0  # it did move
    assert plant.q_rad == pytest.approx(fallen(loose, 0.3), abs=2e-4)


def start(spec: RigSpec) -> Vector:
    return np.radians([axis.start_deg for axis in spec.axes])


def fallen(spec: RigSpec, seconds: float) -> Vector:
    """Joint angles after a fall without friction, by Runge-Kutta on M ddq = -h."""
    model = model_of(spec)
    rotor = np.array([a.motor.rotor_inertia_kg_m2 * a.motor.gear**2 for a in spec.axes if a.motor])
    still = np.zeros(model.n)

    def slope(_: float, state: Vector) -> Vector:
        q, dq = state[: model.n], state[model.n :]
        gravity = model.gravity(q)
        M = np.array([model.rnea(q, still, unit) - gravity for unit in np.eye(model.n)])
        ddq = np.linalg.solve(M + np.diag(rotor), -model.rnea(q, dq, still))
        return np.concatenate((dq, ddq))

    begin = np.concatenate((start(spec), still))
    result = solve_ivp(slope, (0.0, seconds), begin, rtol=1e-8, atol=1e-10)
    angles: Vector = result.y[: model.n, -1]
    return angles


def test_joint_below_its_coulomb_torque_sticks(exact_spec: RigSpec) -> None:
    plant = plant_of(exact_spec)
    before = plant.q_rad[PROSUP]
    for _ in range(5000):
        plant.step(counts(plant, PROSUP, 0.06), ON)
    assert abs(plant.q_rad[PROSUP] - before) < np.radians(0.01)


def test_joint_above_its_coulomb_torque_moves(exact_spec: RigSpec) -> None:
    plant = plant_of(exact_spec)
    before = plant.q_rad[PROSUP]
    for _ in range(1000):
        plant.step(counts(plant, PROSUP, 0.2), ON)
    # steady speed: (0.2 - 0.08) Nm over back-EMF 4^2/24 and viscous 0.05
    assert plant.dq_rad_s[PROSUP] == pytest.approx((0.2 - 0.08) / (16 / 24 + 0.05), rel=0.1)
    assert plant.q_rad[PROSUP] - before > np.radians(5.0)


def test_moving_joint_comes_to_rest_where_friction_holds_it(exact_spec: RigSpec) -> None:
    plant = plant_of(exact_spec)
    plant.dx[PROSUP] = 2.0
    for _ in range(1000):
        plant.step(REST, OFF)
    stopped = plant.q_rad[PROSUP]
    for _ in range(1000):
        plant.step(REST, OFF)
    assert abs(plant.q_rad[PROSUP] - stopped) < np.radians(0.001)


def test_open_bridge_does_not_brake(exact_spec: RigSpec) -> None:
    braked, free = plant_of(exact_spec), plant_of(exact_spec)
    for plant, enabled in ((braked, ON), (free, OFF)):
        plant.dx[ELBOW] = 2.0
        for _ in range(50):
            plant.step(REST, enabled)
    assert braked.dq_rad_s[ELBOW] < 0.2
    assert free.dq_rad_s[ELBOW] > 0.5


def test_negative_polarity_turns_the_joint_the_other_way(exact_spec: RigSpec) -> None:
    axes = list(exact_spec.axes)
    axes[PROSUP] = replace(axes[PROSUP], pwm_polarity=-1)
    turned = plant_of(replace(exact_spec, axes=tuple(axes)))
    pwm = np.zeros(10)
    pwm[PROSUP] = 400
    for _ in range(200):
        turned.step(pwm, ON)
    assert turned.q_rad[PROSUP] < np.radians(-5.0)


def test_hard_stop_holds_full_pwm_without_bouncing(exact_spec: RigSpec) -> None:
    plant = plant_of(exact_spec)
    stop_rad = np.radians(exact_spec.axes[ELBOW].hard_stop_deg[1])
    pwm, reached = np.zeros(10), []
    pwm[ELBOW] = 760
    for _ in range(2000):
        plant.step(pwm, ON)
        reached.append(float(plant.q_rad[ELBOW]))
    assert max(reached) < stop_rad + np.radians(1.5)
    first = next(i for i, angle in enumerate(reached) if angle > stop_rad)
    assert min(reached[first:]) > stop_rad - np.radians(0.5)
    assert abs(plant.dq_rad_s[ELBOW]) < 1e-3


def test_light_wrist_is_stable_in_its_stop(exact_spec: RigSpec) -> None:
    plant = plant_of(exact_spec)
    stop_rad = np.radians(exact_spec.axes[PROSUP].hard_stop_deg[1])
    pwm = np.zeros(10)
    pwm[PROSUP] = 900
    for _ in range(3000):
        plant.step(pwm, ON)
    assert plant.q_rad[PROSUP] == pytest.approx(stop_rad, abs=np.radians(0.05))
    assert abs(plant.dq_rad_s[PROSUP]) < 1e-4


def tracking_tips(spec: RigSpec, step_s: float) -> Vector:
    """Tip positions at each millisecond while a proportional servo moves all joints for 0.8 s."""
    plant = plant_of(spec, step_s)
    gain = np.array([2000.0] * 7 + [3000.0, 2000.0, 2000.0])
    begin, move = plant.q_rad.copy(), np.radians([-8, 5, -10, 20, 15, 10, 35, 20, -15, 8])
    tips = []
    for tick in range(800):
        way = min(tick / 500.0, 1.0)
        error = begin + move * (10 * way**3 - 15 * way**4 + 6 * way**5) - plant.q_rad
        pwm = np.trunc(np.clip(gain * error, -700.0, 700.0))
        for _ in range(round(0.001 / step_s)):
            plant.step(pwm, ON)
        tips.append(plant.tip_pose()[0])
    return np.array(tips)


def test_one_millisecond_follows_a_tenth_of_it_within_half_a_millimetre(spec: RigSpec) -> None:
    coarse, fine = tracking_tips(spec, 0.001), tracking_tips(spec, 0.0001)
    assert np.linalg.norm(coarse[-1] - coarse[0]) > 0.05
    assert np.linalg.norm(coarse - fine, axis=1).max() <= 0.5e-3


def test_sensor_reads_what_the_urdfs_model_says_of_the_same_motion(exact_spec: RigSpec) -> None:
    plant, model = plant_of(exact_spec), model_of(exact_spec)
    pwm = np.array([40.0, -30, 60, 50, -20, 70, 80, 300, -200, 100])
    for _ in range(5):
        q, dq = plant.q_rad.copy(), plant.dq_rad_s.copy()
        plant.step(pwm, ON)
    wrench = model.sensor_wrench(q, dq, plant.ddx, "ft")
    assert np.abs(plant.ddx).max() > 1.0
    assert plant.wrenches[0] == pytest.approx(wrench, abs=1e-9)


def at_the_tip(plant: Plant, force_n: Vector) -> Push:
    point = plant.rigid.push_point("r_hand_dh_frame", (0.0, 0.0, 0.0))
    assert point is not None
    return Push(point, force_n)


def test_push_reaches_the_sensor_and_the_joints_as_newton_and_euler_say(
    exact_spec: RigSpec,
) -> None:
    plant, model = plant_of(exact_spec), model_of(exact_spec)
    q, dq, force = plant.q_rad.copy(), np.zeros(10), np.array([3.0, -20.0, 7.0])
    plant.step(REST, OFF, [at_the_tip(plant, force)])
    (R, p), (_, tip) = model.sensor_pose(q, "ft"), model.tip_pose(q)
    added = np.concatenate((R.T @ force, R.T @ np.cross(tip - p, force)))
    inner = model.sensor_wrench(q, dq, plant.ddx, "ft")
    assert plant.wrenches[0] == pytest.approx(inner + added, abs=1e-9)
    # drives are off and nothing moved yet: what accelerates the links is gravity and the push
    driven = model.rnea(q, dq, plant.ddx) - model.tip_jacobian(q)[:3].T @ force
    opposed = plant.rigid.motion[ARMATURE, plant.rigid.columns] * plant.ddx
    assert driven == pytest.approx(-opposed, abs=1e-8)


def test_push_of_nothing_is_a_plain_step(spec: RigSpec) -> None:
    pushed, plain = plant_of(spec), plant_of(spec)
    for _ in range(20):
        pushed.step(REST, ON, [at_the_tip(pushed, np.zeros(3))])
        plain.step(REST, ON)
    assert pushed.q_rad.tolist() == plain.q_rad.tolist()
    assert pushed.wrenches[0] == pytest.approx(plain.wrenches[0], abs=1e-12)


def bodies(spec: RigSpec) -> tuple[Vector, Vector]:
    model = plant_of(spec).rigid._cut
    masses = np.array([model.inertias[i].mass for i in range(1, model.njoints)])
    return masses, np.array([model.inertias[i].lever for i in range(1, model.njoints)])


def test_masses_and_levers_are_off_by_what_the_spec_says(
    spec: RigSpec, exact_spec: RigSpec
) -> None:
    (mass, lever), (mass_0, lever_0) = bodies(spec), bodies(exact_spec)
    heavy = mass_0 > 0
    ratio = mass[heavy] / mass_0[heavy]
    assert heavy.tolist().count(False) == 3  # torso 1 and 2, wrist 1
    assert mass[~heavy].tolist() == [0.0, 0.0, 0.0]
    assert np.abs(ratio - 1.0).max() <= 0.05
    assert np.abs(ratio - 1.0).min() > 0.0
    assert np.linalg.norm(lever - lever_0, axis=1)[heavy] == pytest.approx(0.005)


def test_model_without_the_cut_weighs_the_same(spec: RigSpec) -> None:
    rigid = plant_of(spec).rigid
    assert pin.computeTotalMass(rigid._model) == pytest.approx(pin.computeTotalMass(rigid._cut))


def test_seed_decides_the_draws_and_levers_do_not_hang_on_masses(spec: RigSpec) -> None:
    other = replace(spec, plant=replace(spec.plant, seed=2))
    heavier = replace(spec, plant=replace(spec.plant, mass_error=0.2))
    assert bodies(spec)[0].tolist() == bodies(spec)[0].tolist()
    assert bodies(other)[0].tolist() != bodies(spec)[0].tolist()
    assert bodies(heavier)[1].tolist() == bodies(spec)[1].tolist()


def test_tip_pose_is_the_models(spec: RigSpec) -> None:
    plant, model = plant_of(spec), model_of(spec)
    R, p = model.tip_pose(plant.q_rad)
    position, rotation = plant.tip_pose()
    assert position == pytest.approx(p, abs=1e-12)
    assert pin.exp3(rotation) == pytest.approx(R, abs=1e-9)
