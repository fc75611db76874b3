"""What `ulna dynamics` prints."""

import math
from collections.abc import Sequence

from rich.table import Table

from services.wholebody.dynamics_messages import Contacts, DynamicsHealth, DynamicsModels


def sensor_table(health: DynamicsHealth) -> Table:
    """A row for each FT sensor; wrenches as force and moment."""
    table = Table(
        "sensor", "used", "offset N, Nm", "measured - model", "its spread", "doing", title="sensors"
    )
    for sensor in health.sensors:
        doing = sensor.task
        if sensor.task:
            of = f" of {sensor.wanted}" if sensor.wanted else ""
            doing = f"{sensor.task}, {sensor.samples}{of} samples"
        table.add_row(
            sensor.name,
            "yes" if sensor.ok else ", ".join(sensor.flags),
            _wrench(sensor.offset) + (", gain matrix" if sensor.gain else ""),
            _wrench(sensor.mean),
            _wrench(sensor.std),
            doing or sensor.reason,
        )
    return table


def silent_lines(health: DynamicsHealth) -> list[str]:
    """Parts that get no torques, what is wrong with the IMU, and what is to be calibrated."""
    lines = [f"no torques for {part}: {reason}" for part, reason in health.silent]
    if health.imu:
        lines.append(f"IMU: {health.imu}")
    # One that has another fault as well cannot be calibrated.
    only_uncalibrated = [s.name for s in health.sensors if s.flags == ("uncalibrated",)]
    if only_uncalibrated:
        names = ", ".join(only_uncalibrated)
        lines.append(f"no offset is known of {names}: `ulna dynamics calibrate` finds it")
    return lines


def contact_table(contacts: Contacts) -> Table:
    """A row for each place where the world may touch the robot."""
    table = Table("limb", "link", "place", "at m", "force N", "N", "touching", title="contacts")
    for contact in contacts.contacts:
        table.add_row(
            contact.limb,
            contact.link,
            contact.location,
            _numbers(contact.point_m, 3),
            _numbers(contact.force_n, 1),
            f"{math.hypot(*contact.force_n):.1f}",
            "yes" if contact.touching else "",
        )
    return table


def known_lines(models: DynamicsModels) -> list[str]:
    """What is known to act on the robot."""
    return [
        f"known: {_numbers(load.wrench[:3], 2)} N | {_numbers(load.wrench[3:], 3)} Nm at "
        f"{load.frame} {_numbers(load.point_m, 3)} m"
        for load in models.known
    ]


def model_table(models: DynamicsModels) -> Table:
    """A row for each sub-model."""
    held = "held at the base" if models.mainstay else "not held"
    x, y, z = models.centre_of_mass_m
    title = (
        f"contacts: {models.assumption}, {held}; motion from {models.source}; "
        f"{models.mass_kg:.2f} kg, centre at {x:.3f}, {y:.3f}, {z:.3f} m"
    )
    table = Table("between sensors", "links", "unknowns", "rank", "residual N", title=title)
    for sub in models.sub_models:
        table.add_row(
            ", ".join(sub.sensors),
            f"{sub.links[0]} ... {sub.links[-1]}" if len(sub.links) > 1 else ", ".join(sub.links),
            str(sub.unknowns),
            str(sub.rank),
            f"{sub.residual_n:.2f}",
        )
    return table


def gain_table(sensor: str, gain: Sequence[float]) -> str:
    """A sensor's gain matrix as a robot file or a site file has it."""
    rows = [gain[i : i + 6] for i in range(0, 36, 6)]
    lines = [f"    {', '.join(f'{value:.6f}' for value in row)}," for row in rows]
    return "\n".join([f"[sensors.{sensor}]", "gain = [", *lines, "]", ""])


def _wrench(values: Sequence[float]) -> str:
    return f"{_numbers(values[:3], 2)} | {_numbers(values[3:], 3)}" if values else ""


def _numbers(values: Sequence[float], digits: int) -> str:
    return " ".join(f"{value:.{digits}f}" for value in values)
