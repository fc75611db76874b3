"""`ulna dynamics`: what the whole-body dynamics of a running stack sees, and requests to it."""

import sys
from pathlib import Path

import msgspec
from rich.console import Console

from services.cli.complaint import complain
from services.cli.dynamics_client import DynamicsClient
from services.cli.dynamics_sweep import MOVES, sweep_limb
from services.cli.dynamics_tables import (
    contact_table,
    gain_table,
    known_lines,
    model_table,
    sensor_table,
    silent_lines,
)
from services.core.errors import ConfigError, ServiceError
from services.streams import DYNAMICS_HEALTH, DYNAMICS_MODELS, EXTERNAL
from services.wholebody.dynamics_messages import AssumedContact, DynamicsRequest, KnownLoad

FAILED = 2
REFUSED = 1
INTERRUPTED = 130


def dynamics_status(*, stack: str = "icub") -> int:
    """Sensors, contacts and sub-models of a running stack, once.

    Example: ulna dynamics status

    Args:
        stack: name of the running stack.

    Returns:
        Exit status: 0 when every sensor can be used, 1 when one cannot, 2 without an answer.
    """
    try:
        with DynamicsClient(stack) as client:
            health = client.wait_for(DYNAMICS_HEALTH)
            console = Console()
            console.print(sensor_table(health))
            for line in silent_lines(health):
                print(line)
            models = client.newest(DYNAMICS_MODELS)
            if models is not None:
                console.print(model_table(models))
                for line in known_lines(models):
                    print(line)
            contacts = client.newest(EXTERNAL)
            if contacts is not None:
                console.print(contact_table(contacts))
    except ServiceError as error:
        return _complain(error)
    return 0 if all(sensor.ok for sensor in health.sensors) else REFUSED


def dynamics_calibrate(*sensors: str, samples: int = 200, stack: str = "icub") -> int:
    """Find the offsets of FT sensors, all or those named. Nothing may touch their limbs.

    The limb may move slowly meanwhile; torques go on with the old offset until the new one is
    known.

    Example: ulna dynamics calibrate r_arm_ft

    Args:
        sensors: names of sensors. Default: all.
        samples: readings to average, 200 are a fifth of a second in virtual time, 0.8 s live.
        stack: name of the running stack.

    Returns:
        Exit status: 0 when the offsets are known, 1 when refused or given up, 2 without an answer.
    """
    request = DynamicsRequest(action="calibrate", sensors=sensors, samples=samples)
    try:
        with DynamicsClient(stack) as client:
            client.wait_for(DYNAMICS_HEALTH)
            if not client.ask_at_rest(request):
                return REFUSED
            health = client.wait_for_calibration(sensors)
    except KeyboardInterrupt:
        stop = " ".join(["ulna dynamics reset", *sensors])
        complain(f"the calibration goes on in the running stack; `{stop}` stops it")
        return INTERRUPTED
    except ServiceError as error:
        return _complain(error)
    asked = [sensor for sensor in health.sensors if not sensors or sensor.name in sensors]
    Console().print(sensor_table(msgspec.structs.replace(health, sensors=tuple(asked))))
    failed = [sensor for sensor in asked if not sensor.ok or sensor.reason]
    for sensor in failed:
        print(f"{sensor.name}: {sensor.reason or ', '.join(sensor.flags)}", file=sys.stderr)
    return REFUSED if failed else 0


def dynamics_reset(*sensors: str, stack: str = "icub") -> int:
    """Forget offset and found gain of FT sensors, all or those named: their limbs get no torques.

    Example: ulna dynamics reset r_arm_ft

    Args:
        sensors: names of sensors. Default: all.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    named = ", ".join(sensors) or "all sensors"
    request = DynamicsRequest(action="reset", sensors=sensors)
    return _request(request, stack, f"reset: offset and found gain of {named} are forgotten")


def dynamics_assume(
    contacts: str,
    /,
    *frames: str,
    known: tuple[str, ...] = (),
    hanging: bool = False,
    stack: str = "icub",
) -> int:
    """Say where the world may touch the robot, and what is known to act on it.

    default: one contact beyond each sensor. standing: hands and feet. crawling: wrists and knees,
    moving with the IMU. custom: the frames that follow, each `frame`, `frame=force` or
    `frame=wrench`.

    Example: ulna dynamics assume custom l_hand r_forearm=force --known r_hand=0,0,-3

    Args:
        contacts: default, standing, crawling or custom.
        frames: of custom, links or frames of the model.
        known: a load as `frame=fx,fy,fz` or `frame=fx,fy,fz,mx,my,mz` in N and Nm, in the axes of a
            link or frame and about its origin, or about a point of it as `frame@x,y,z=...` in m;
            may be repeated. Default: none, and those of before are forgotten.
        hanging: custom: nothing holds the base.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    pairs = [frame.partition("=") for frame in frames]
    listed = tuple(AssumedContact(frame=f, kind=kind or "wrench") for f, _, kind in pairs)
    try:
        loads = tuple(known_load(text) for text in known)
    except ServiceError as error:
        return _complain(error)
    request = DynamicsRequest(
        action="assume", value=contacts, contacts=listed, mainstay=not hanging, known=loads
    )
    count = f", {len(loads)} known load{'' if len(loads) == 1 else 's'}" if loads else ""
    return _request(request, stack, f"contacts: {' '.join([contacts, *frames])}{count}")


def dynamics_source(source: str, /, *, stack: str = "icub") -> int:
    """Say where the motion of the base is taken from: base (it stands still), or an IMU by name.

    Example: ulna dynamics source head_imu

    Args:
        source: base, or the name of an IMU board.
        stack: name of the running stack.

    Returns:
        Exit status: 0, 1 when refused, 2 without an answer.
    """
    request = DynamicsRequest(action="source", value=source)
    return _request(request, stack, f"motion of the base from: {source}")


def dynamics_identify(
    sensor: str,
    /,
    *,
    moves: int = MOVES,
    degrees: float = 20.0,
    out: Path | None = None,
    stack: str = "icub",
) -> int:
    """Find the gain matrix and offset of one FT sensor while its limb moves slowly, free of touch.

    The limb goes through postures about the one that it is in, in position mode, and back. Both
    hold until the stack ends; the table that is printed, put into the robot file or a site file,
    keeps the gain.

    Example: ulna dynamics identify r_arm_ft --degrees 15 --out r_arm_ft.toml

    Args:
        sensor: name of a sensor.
        moves: postures to go to; each takes two seconds or more.
        degrees: how far each joint goes to either side at most, inside its limits.
        out: file to write that table to as well.
        stack: name of the running stack.

    Returns:
        Exit status: 0 when the new gain is in use, 1 when refused, 2 without an answer.
    """
    try:
        with DynamicsClient(stack) as client:
            if not client.ask_at_rest(_sweep(sensor, "start")):
                return REFUSED
            try:
                sweep_limb(client, sensor, moves, degrees)
            except BaseException:
                client.ask(_sweep(sensor, "discard"))
                raise
            if not client.ask(_sweep(sensor, "solve")):
                client.ask(_sweep(sensor, "discard"))
                complain(
                    f"the sweep is discarded; one with more than --moves {moves} or "
                    f"--degrees {degrees:g} shows more"
                )
                return REFUSED
            client.wait_for(DYNAMICS_HEALTH)  # may have been on its way before the request
            health = client.wait_for(DYNAMICS_HEALTH)
            table = next(gain_table(s.name, s.gain) for s in health.sensors if s.name == sensor)
            print(table)
            if out is not None:
                _write(out, table)
    except ServiceError as error:
        return _complain(error)
    return 0


def known_load(text: str) -> KnownLoad:
    """A load as it is written on a command line.

    Raises:
        ConfigError: it is written otherwise.
    """
    place, _, numbers = text.partition("=")
    frame, _, point = place.partition("@")
    try:
        x, y, z = _floats(point or "0,0,0")
        fx, fy, fz, *moment = _floats(numbers)
        mx, my, mz = moment or (0.0, 0.0, 0.0)
    except ValueError as error:
        raise ConfigError(
            f"{text!r} is no load: frame=fx,fy,fz or frame@x,y,z=fx,fy,fz,mx,my,mz"
        ) from error
    return KnownLoad(frame=frame, wrench=(fx, fy, fz, mx, my, mz), point_m=(x, y, z))


def _floats(text: str) -> list[float]:
    return [float(number) for number in text.split(",")]


def _sweep(sensor: str, stage: str) -> DynamicsRequest:
    return DynamicsRequest(action="identify", sensors=(sensor,), value=stage)


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"cannot write {path}: {error.strerror}") from error


def _request(request: DynamicsRequest, stack: str, done: str) -> int:
    try:
        with DynamicsClient(stack) as client:
            if not client.ask(request):
                return REFUSED
    except ServiceError as error:
        return _complain(error)
    print(done)
    return 0


def _complain(error: ServiceError) -> int:
    complain(error)
    return FAILED
