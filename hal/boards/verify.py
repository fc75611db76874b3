"""Reading back what was written: a setting that did not arrive is written once more, then named.

A board's transmit buffer holds ten frames and answers last-in-first-out (can-protocol 1), so
questions go in small groups and answers are told apart by their code.
"""

from collections.abc import Generator, Iterable, Sequence

from hal.axis import Axis
from hal.boards.settings import Setting
from hal.wire import motor
from hal.wire.message import AxisCommand

GROUP = 4  # questions per address and millisecond
ANSWER_NS = 100_000_000  # they come within milliseconds; a busy machine may be late
TRIES = 5

_GETTERS = {command.name: command for command in motor.COMMANDS.values()}

Reading = tuple[Setting, tuple[int, ...] | None]


def getter_of(row: AxisCommand) -> AxisCommand | None:
    """The question for what a SET has written; None where the firmware has none."""
    return _GETTERS.get(row.name.replace("SET_", "GET_", 1)) if row.name[:4] == "SET_" else None


def verify(axis: Axis, settings: Iterable[Setting]) -> Generator[None, None, str]:
    """Compare the board with the settings; what differs is written again and compared again."""
    wrong = yield from _differing(axis, [s for s in settings if getter_of(s[0]) is not None])
    if not wrong:
        return ""
    for (row, values), _ in wrong:
        axis.command(row, *values)
    wrong = yield from _differing(axis, [setting for setting, _ in wrong])
    return "; ".join(_text(axis, reading) for reading in wrong)


def _differing(axis: Axis, settings: Sequence[Setting]) -> Generator[None, None, list[Reading]]:
    wrong: list[Reading] = []
    for start in range(0, len(settings), GROUP):
        group = settings[start : start + GROUP]
        answers = yield from _answers(axis, [row for row, _ in group])
        for setting, answer in zip(group, answers, strict=True):
            written = setting[1]
            # GET_IMPEDANCE_PARAMS has the offset behind them, which is a set-point.
            if answer is None or answer[: len(written)] != written:
                wrong.append((setting, answer))
    return wrong


def _answers(
    axis: Axis, rows: Sequence[AxisCommand]
) -> Generator[None, None, list[tuple[int, ...] | None]]:
    getters = [getter for row in rows if (getter := getter_of(row)) is not None]
    for getter in getters:
        axis.replies.pop(getter.code, None)
    for _ in range(TRIES):
        open_questions = [getter for getter in getters if getter.code not in axis.replies]
        frames = [getter.request(axis.address, axis.number) for getter in open_questions]
        axis.line.probe(axis.address, *frames)
        while axis.line.pending(axis.address):
            yield
        deadline_ns = axis.line.now_ns + ANSWER_NS
        while axis.line.now_ns < deadline_ns:
            yield
            if all(getter.code in axis.replies for getter in open_questions):
                return [axis.replies[getter.code] for getter in getters]
    return [axis.replies.get(getter.code) for getter in getters]


def _text(axis: Axis, reading: Reading) -> str:
    (row, values), read = reading
    wrote = " ".join(map(str, values))
    found = "no answer" if read is None else f"read {' '.join(map(str, read[: len(values)]))}"
    return f"{axis.name} {row.name}: wrote {wrote}, {found}"
