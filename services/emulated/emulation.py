"""Turns a robot file into the description of its emulated twin."""

from dataclasses import replace

from firmware_sim.description import (
    AxisSpec,
    BoardSpec,
    FingerSpec,
    MotorSpec,
    PlantSpec,
    RigSpec,
    SensorSpec,
)
from services.robotfile.model_file import model_path
from services.robotfile.robot_tables import MotorTable, RobotFile
from services.robotfile.wiring import firmware_of, joint_limits_deg


def rig_spec(robot: RobotFile, seed: int, mass_error: float = 0.05) -> RigSpec:
    """Boards, axes, sensors and plant of a robot; boards that are real at this site are left out.

    `seed` draws how far the plant's masses, levers and sensors are from the model the services use;
    `mass_error` is the bound on the relative error of each mass.
    """
    plant = PlantSpec(urdf=str(model_path(robot)), tip_frame=robot.reach.tip_frame, seed=seed)
    return RigSpec(
        boards=tuple(
            BoardSpec(
                bus=robot.buses[board.bus].number,
                address=board.address,
                type=board.type,
                firmware=firmware_of(robot, name),
                name=name,
                faithful=board.faithful,
                coupled=board.coupled,
                frame=board.frame,
            )
            for name, board in robot.boards.items()
            if robot.is_simulated(name)
        ),
        axes=tuple(_axis(robot, name) for joints in robot.parts.values() for name in joints),
        sensors=tuple(
            _sensor(robot, name)
            for name, sensor in robot.sensors.items()
            if robot.is_simulated(sensor.board)
        ),
        plant=replace(plant, mass_error=mass_error),
    )


def _axis(robot: RobotFile, name: str) -> AxisSpec:
    joint = robot.joints[name]
    absolute = joint.encoder == "absolute"
    bus, address, axis = robot.axis_place(name)
    return AxisSpec(
        bus=bus,
        address=address,
        axis=axis,
        joint=name,
        motor=_motor(robot.motors[joint.motor]),
        pwm_polarity=joint.motor_polarity,
        ticks_per_deg=joint.ticks_per_deg,
        zero_deg=joint.zero_deg,
        absolute_offset=round(joint.calibration.p3) if absolute else None,
        hard_stop_deg=joint.hard_stops_deg,
        limit_deg=joint_limits_deg(robot, name),
        start_deg=joint.power_up_deg,
        mechanism=joint.mechanism,
        inertia_kg_m2=joint.inertia_kg_m2,
        fingers=tuple(
            FingerSpec(name=finger.name, range_deg=finger.range_deg, hall=finger.hall)
            for finger in joint.fingers
        ),
        driven=not robot.is_simulated(joint.board),
    )


def _motor(table: MotorTable) -> MotorSpec:
    return MotorSpec(
        supply_v=table.supply_v.value,
        torque_constant_nm_a=table.torque_constant_nm_a.value,
        resistance_ohm=table.resistance_ohm.value,
        gear=table.gear.value,
        rotor_inertia_kg_m2=table.rotor_inertia_kg_m2.value,
        coulomb_nm=table.coulomb_nm.value,
        viscous_nms_rad=table.viscous_nms_rad.value,
    )


def _sensor(robot: RobotFile, name: str) -> SensorSpec:
    sensor = robot.sensors[name]
    board = robot.boards[sensor.board]
    return SensorSpec(
        name=name,
        frame=sensor.frame,
        bus=robot.buses[board.bus].number,
        address=board.address,
        full_scale=sensor.full_scale,
    )
