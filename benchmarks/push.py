"""The robot must give way to a push of 20 N as its commanded stiffness says, and come back."""

import sys
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from services.config import load_robot
from services.experiments.rows import Row, at_most, within
from services.reaching.limb import limb_model
from services.reaching.reach import Push, ReachOptions
from services.reaching.reach_record import Recording
from services.reaching.reach_virtual import run_virtual
from services.robotfile.robot_tables import RobotFile

Vector = NDArray[np.float64]

FORCES_N = ((0.0, 0.0, -20.0), (0.0, -20.0, 0.0))
AVERAGED_S = 0.1
BACK_BAR_MM = 3.0


def push_rows(robot: RobotFile, seeds: Iterable[int]) -> list[Row]:
    """Both directions, every seed."""
    ratios, back, gated, reached = [], [], [], []
    for seed in seeds:
        for force in FORCES_N:
            print(f"push {force} N, seed {seed} ...", file=sys.stderr, flush=True)
            options = ReachOptions(seed=seed, push=Push(force_n=force))
            recording = run_virtual(robot, options).recording
            reached.append(bool(recording.report()["reached"]))
            ratios.append(deflection_ratio(robot, recording, np.array(force)))
            back.append(recording.trace.position_error_m[-1] * 1e3)
            gated.append(gated_share(recording))
    return [
        Row("push 20 N: reached before", str(all(reached)), "", "True", all(reached)),
        within("push 20 N: deflection over K^-1 J' F, smallest", min(ratios), "", 0.9, 1.1),
        within("push 20 N: deflection over K^-1 J' F, largest", max(ratios), "", 0.9, 1.1),
        at_most("push 20 N: error 5 s after it, largest", max(back), "mm", BACK_BAR_MM),
        within("push 20 N: share of the push with the outer loop gated", min(gated), "", 0.9, 1.0),
    ]


def deflection_ratio(robot: RobotFile, recording: Recording, force_n: Vector) -> float:
    """Hand displacement at the end of the push, along the one predicted, over the predicted one."""
    trace = recording.trace
    before, during = (
        _mean_at(recording, recording.push_begin_ns),
        _mean_at(recording, recording.push_end_ns),
    )
    begin_s = _seconds(recording, recording.push_begin_ns)
    start = np.searchsorted(trace.time_s, begin_s) - 1
    predicted = predicted_deflection_m(robot, np.array(trace.q_rad[int(start)]), force_n)
    return float((during - before) @ predicted / (predicted @ predicted))


def predicted_deflection_m(robot: RobotFile, q_rad: Vector, force_n: Vector) -> Vector:
    """Where the compliant springs meet the force, q = q0 + K^-1 J(q)' F: hand shift (3,)."""
    model = limb_model(robot)
    compliance = np.zeros(len(robot.chain))
    for name in robot.reach.compliant:
        impedance = robot.joints[name].impedance
        assert impedance is not None
        stiffness_nm_rad = impedance.stiffness_nm_deg * 180.0 / np.pi
        compliance[robot.chain.index(name)] = 1.0 / stiffness_nm_rad
    pushed = q_rad.copy()
    for _ in range(50):
        pushed = q_rad + compliance * (model.tip_jacobian(pushed)[:3].T @ force_n)
    deflection: Vector = model.tip_pose(pushed)[1] - model.tip_pose(q_rad)[1]
    return deflection


def gated_share(recording: Recording) -> float:
    """Share of the samples between push and release at which the outer loop was frozen."""
    trace = recording.trace
    begin = np.searchsorted(trace.time_s, _seconds(recording, recording.push_begin_ns))
    end = np.searchsorted(trace.time_s, _seconds(recording, recording.push_end_ns))
    return float(np.mean(trace.gated[int(begin) : int(end)]))


def _mean_at(recording: Recording, instant_ns: int | None) -> Vector:
    """Mean hand position over the last tenth of a second before an instant."""
    end_s = _seconds(recording, instant_ns)
    trace = recording.trace
    first, last = np.searchsorted(trace.time_s, (end_s - AVERAGED_S, end_s))
    mean: Vector = np.mean(np.array(trace.tip_m[int(first) : int(last)]), axis=0)
    return mean


def _seconds(recording: Recording, instant_ns: int | None) -> float:
    assert instant_ns is not None, "the push was never given"
    return (instant_ns - recording.begin_ns) * 1e-9


if __name__ == "__main__":
    for row in push_rows(load_robot("icub:reach"), range(1)):
        print(row)
