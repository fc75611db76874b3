"""Every fault that can be switched on in an emulated robot: its name, where, and what it does.

A row's function does it to a target and returns how to undo it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from firmware_sim.boards.axis import AxisPort
from firmware_sim.boards.board import Board
from firmware_sim.boards.motor_board import MotorBoard
from firmware_sim.boards.mtb import Mtb
from firmware_sim.boards.sensor_board import SensorBoard
from firmware_sim.boards.skin_patch import REST
from firmware_sim.boards.strain import Strain
from firmware_sim.spoiling import Effect, Path, Spoiler
from hal.wire.analog import CHANNELS
from hal.wire.skin import BOARD_TAXELS, TRIANGLES, TriangleError

Undo = Callable[[], None]

TRIP_MA = 30_000  # beyond the 25 A of every bridge (can-protocol 10.3)
HALL_CODES = 8
STUCK_WORD = 0xFFFF
NO_SUCH_TAXEL_LEVEL = 600  # the taxel leaves 0..255 however it was calibrated


class SwitchError(ValueError):
    """A fault cannot be switched like that; the text says why."""


class Needs(Enum):
    """Where a fault happens; the value is how users read it."""

    BUS_OR_BOARD = "bus, or board (bus and address)"
    ANYTHING = "nothing (all), bus, or board"
    AXIS = "axis (bus, address, axis)"
    MOTOR_BOARD = "motor board (bus, address)"
    SENSOR = "sensor board (bus, address)"
    FT_SENSOR = "FT board (bus, address)"
    SKIN = "skin board (bus, address)"


@dataclass(frozen=True, kw_only=True, slots=True)
class FaultSpec:
    """One fault as it is asked for. What is None is not said; which rows use what: see SWITCHES."""

    kind: str
    bus: int | None = None
    address: int | None = None
    axis: int | None = None  # 0 or 1 at the address
    value: int | None = None
    can_id: int | None = None  # frames: only this identifier
    count: int = 0  # frames: so many, then no more; 0 without end
    share: float = 1.0  # frames: so many of all, drawn from the seed
    seed: int = 0
    milliseconds: int = 0  # delay; how long a board is away


@dataclass(frozen=True, kw_only=True, slots=True)
class Target:
    """What a fault is done to, looked up."""

    boards: tuple[Board, ...]
    ports: tuple[AxisPort, ...]
    paths: Callable[[], tuple[Path, ...]]  # ways of its frames, both directions
    hold: Callable[[Undo], Undo]  # do this each millisecond; the result ends that
    later: Callable[[int, Undo], None]  # do this after so many milliseconds


@dataclass(frozen=True, slots=True)
class SwitchRow:
    """One kind of fault. `value` says what FaultSpec.value is, empty when it is not used."""

    name: str
    needs: Needs
    text: str
    do: Callable[[Target, FaultSpec], Undo | None]  # None: it is over at once
    value: str = ""


def _spoil(effect: Effect) -> Callable[[Target, FaultSpec], Undo]:
    def do(target: Target, spec: FaultSpec) -> Undo:
        if effect is Effect.DELAY and spec.milliseconds < 1:
            raise SwitchError("delay needs milliseconds, at least 1")
        spoiler = Spoiler(
            effect,
            can_id=spec.can_id,
            count=spec.count,
            share=spec.share,
            seed=spec.seed,
            delay_ms=spec.milliseconds,
        )
        return _lay(target, spoiler)

    return do


def _unplug(target: Target, spec: FaultSpec) -> Undo:  # noqa: ARG001  (a row's function)
    return _lay(target, Spoiler(Effect.DROP))


def _lay(target: Target, spoiler: Spoiler) -> Undo:
    paths = target.paths()
    for path in paths:
        path.spoilers.append(spoiler)

    def undo() -> None:
        for path in paths:
            path.spoilers.remove(spoiler)

    return undo


def _bus_off(target: Target, spec: FaultSpec) -> Undo:  # noqa: ARG001
    def switch(off: bool) -> None:
        for board in target.boards:
            board.bus_off = off

    switch(True)
    return lambda: switch(False)


def _no_power(target: Target, spec: FaultSpec) -> Undo:  # noqa: ARG001
    for board in target.boards:
        board.powered = False
    return lambda: _power_up(target)


def _reboot(target: Target, spec: FaultSpec) -> None:
    for board in target.boards:
        board.powered = False
    if spec.milliseconds:
        target.later(spec.milliseconds, lambda: _power_up(target))
    else:
        _power_up(target)


def _power_up(target: Target) -> None:
    for board in target.boards:
        board.power_cycle()


def _overrun(target: Target, spec: FaultSpec) -> None:  # noqa: ARG001
    for board in target.boards:
        if isinstance(board, MotorBoard):
            board.loop_overrun = True


def _set_flag(name: str) -> Callable[[Target, FaultSpec], Undo]:
    """Set an input of drives for as long as the switch is on."""

    def do(target: Target, spec: FaultSpec) -> Undo:  # noqa: ARG001
        def switch(on: bool) -> None:
            for port in target.ports:
                setattr(port, name, on)

        switch(True)
        return lambda: switch(False)

    return do


def _hall(target: Target, spec: FaultSpec) -> Undo:
    code = _within(spec.value, HALL_CODES, "Hall code", 1)
    if code == 0:
        raise SwitchError("Hall code 0 is no error")

    def switch(hall_fault: int) -> None:
        for port in target.ports:
            port.hall_fault = hall_fault

    switch(code)
    return lambda: switch(0)


def _overcurrent(target: Target, spec: FaultSpec) -> Undo:
    current_ma = TRIP_MA if spec.value is None else spec.value

    def flow() -> None:
        for port in target.ports:
            if port.enabled:  # nothing flows through an open bridge
                port.current_ma = current_ma

    return target.hold(flow)


def _mute(target: Target, spec: FaultSpec) -> Undo:  # noqa: ARG001
    sensors = [board for board in target.boards if isinstance(board, SensorBoard)]

    def switch(silent: bool) -> None:
        for board in sensors:
            board.silent = silent

    switch(True)
    return lambda: switch(False)


def _saturate(target: Target, spec: FaultSpec) -> Undo:
    channel = _within(spec.value, CHANNELS, "channel", 0)
    sensors = [board for board in target.boards if isinstance(board, Strain)]
    for board in sensors:
        board.stuck_words[channel] = STUCK_WORD

    def undo() -> None:
        for board in sensors:
            board.stuck_words.pop(channel, None)

    return undo


def _freeze(target: Target, spec: FaultSpec) -> Undo:  # noqa: ARG001
    sensors = [board for board in target.boards if isinstance(board, Strain)]

    def switch(frozen: bool) -> None:
        for board in sensors:
            board.frozen = frozen

    switch(True)
    return lambda: switch(False)


def _taxel(target: Target, spec: FaultSpec) -> Undo:
    taxel = _within(spec.value, BOARD_TAXELS, "taxel", 0)
    skins = [board for board in target.boards if isinstance(board, Mtb)]

    def show(level: int) -> None:
        for board in skins:
            board.taxels[taxel] = level

    end = target.hold(lambda: show(NO_SUCH_TAXEL_LEVEL))

    def undo() -> None:
        end()
        show(REST)

    return undo


def _triangle(target: Target, spec: FaultSpec) -> Undo:
    triangle = _within(spec.value, TRIANGLES, "triangle", 0)
    skins = [board for board in target.boards if isinstance(board, Mtb)]

    def switch(error: TriangleError) -> None:
        for board in skins:
            board.triangle_errors[triangle] = error

    switch(TriangleError.NO_ANSWER)
    return lambda: switch(TriangleError.OK)


def _within(value: int | None, end: int, what: str, default: int) -> int:
    number = default if value is None else value
    if not 0 <= number < end:
        raise SwitchError(f"{what} {number} is not one of 0..{end - 1}")
    return number


_FRAMES = Needs.BUS_OR_BOARD
SWITCHES = {
    row.name: row
    for row in (
        SwitchRow("drop", _FRAMES, "frames vanish", _spoil(Effect.DROP)),
        SwitchRow("corrupt", _FRAMES, "data bytes arrive inverted", _spoil(Effect.CORRUPT)),
        SwitchRow("delay", _FRAMES, "frames arrive milliseconds late", _spoil(Effect.DELAY)),
        SwitchRow("duplicate", _FRAMES, "frames arrive twice", _spoil(Effect.DUPLICATE)),
        SwitchRow("unplug", _FRAMES, "its cable is out; boards run on", _unplug),
        SwitchRow("bus_off", _FRAMES, "the CAN controllers have left the bus", _bus_off),
        SwitchRow("no_power", _FRAMES, "silent, drives nothing; off: it boots", _no_power),
        SwitchRow("reboot", _FRAMES, "boots, after milliseconds without power", _reboot),
        SwitchRow(
            "estop", Needs.ANYTHING, "button pressed, bridges open", _set_flag("external_fault")
        ),
        SwitchRow("encoder", Needs.AXIS, "absolute encoder unreadable", _set_flag("encoder_fault")),
        SwitchRow("hall", Needs.AXIS, "Hall sensors of the motor wrong", _hall, "code 1..7"),
        SwitchRow("overheat", Needs.AXIS, "above 75 degrees", _set_flag("overheated")),
        SwitchRow("overcurrent", Needs.AXIS, "motor current beyond the trip", _overcurrent, "mA"),
        SwitchRow("overrun", Needs.MOTOR_BOARD, "one control loop lasts more than 1 ms", _overrun),
        SwitchRow("mute", Needs.SENSOR, "answers, but sends no samples", _mute),
        SwitchRow("saturate", Needs.FT_SENSOR, "a channel at its end", _saturate, "channel 0..5"),
        SwitchRow("freeze", Needs.FT_SENSOR, "repeats its last sample for ever", _freeze),
        SwitchRow("taxel", Needs.SKIN, "a taxel out of range", _taxel, "taxel 0..191"),
        SwitchRow(
            "triangle", Needs.SKIN, "a triangle is silent on I2C", _triangle, "triangle 0..15"
        ),
    )
}
"""By name."""
