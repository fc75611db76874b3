"""Boards on a bench: motors that turn a wheel each, instead of a robot's limbs.

For a board that runs in a process of its own. A joint of the robot's body becomes a wheel as heavy
as the motor's own rotor is behind its gear, with the joint's friction and stops and without
gravity; couplings stay. Eyes and fingers are what they are in the robot. Sensors feel the robot
standing still with every joint at zero.
"""

from dataclasses import replace

from firmware_sim.description import AxisSpec, RigSpec
from firmware_sim.rig import Rig


class BenchRig(Rig):
    """The boards of a description with their motors on the bench."""

    def __init__(self, spec: RigSpec) -> None:
        super().__init__(replace(spec, axes=tuple(_on_bench(axis) for axis in spec.axes)))


def _on_bench(axis: AxisSpec) -> AxisSpec:
    if axis.mechanism != "body" or axis.motor is None:
        return replace(axis, driven=False)
    wheel_kg_m2 = axis.motor.rotor_inertia_kg_m2 * axis.motor.gear**2
    return replace(axis, driven=False, mechanism="single", inertia_kg_m2=wheel_kg_m2)
