"""Which board is plugged into a bus: what a robot file says of its place, or what is said by hand.

The answer is the robot file again, narrowed to that one board: whoever builds an emulated robot of
it gets the board with the motors, joints and sensors that it has in the robot.
"""

import re
from dataclasses import dataclass
from typing import get_args

import msgspec

from services.core.errors import ConfigError
from services.robotfile.robot_tables import (
    BoardTable,
    BoardTypeName,
    BusTable,
    JointTable,
    RobotFile,
)

AXES = {"bll": 2, "bll_ie": 2, "bll_dc": 2, "dc4": 4}
BLL_FAMILY = ("bll", "bll_ie", "bll_dc")  # all of them report the type BLL
FORCE_TORQUE = ("strain", "strain2")
BENCH = "bench"  # name of a board that is no board of the robot, and of its axes
BENCH_INERTIA_KG_M2 = 0.02  # assumed: a short aluminium bar on the shaft
BENCH_REACH_DEG = 170.0  # either way; within one turn of the absolute encoder
FIRMWARE = re.compile(r"\d{1,2}\.\d{1,2}")


@dataclass(frozen=True, kw_only=True)
class Place:
    """Where a board is to be plugged in, and what it is to be where the robot file does not say.

    `bus` is a name, a number or a channel of the robot file; `type` and `firmware` may be empty.
    """

    bus: str
    address: int
    type: str = ""
    firmware: str = ""


@dataclass(frozen=True, kw_only=True)
class Plugged:
    """One board on one bus."""

    robot: RobotFile  # with nothing but this board
    name: str
    bus: BusTable

    @property
    def board(self) -> BoardTable:
        """Its table."""
        return self.robot.boards[self.name]

    @property
    def joints(self) -> dict[int, str]:
        """Joint by axis of the board."""
        return {joint.axis: name for name, joint in self.robot.joints.items()}

    @property
    def addresses(self) -> tuple[int, ...]:
        """CAN addresses that it owns."""
        return addresses_of(self.board)

    @property
    def text(self) -> str:
        """What it is, for people."""
        joints = ", ".join(name for _, name in sorted(self.joints.items()))
        board = self.board
        return (
            f"{self.name}: {board.type}, firmware {board.firmware}, bus {self.bus.number}, "
            f"address {board.address}" + (f", moves {joints}" if joints else "")
        )


def addresses_of(board: BoardTable) -> tuple[int, ...]:
    """CAN addresses that a board owns."""
    count = max(1, AXES.get(board.type, 0) // 2)
    return tuple(range(board.address, board.address + count))


def plugged(robot: RobotFile, place: Place) -> Plugged:
    """The board for a place.

    Type and firmware are the robot file's. With a firmware given by hand the type may differ from
    the robot file's, or the robot file need not know the place: then bench motors turn.

    Raises:
        ConfigError: the robot file has no such bus or address, or another type there.
    """
    if place.type and place.type not in get_args(BoardTypeName):
        known = ", ".join(get_args(BoardTypeName))
        raise ConfigError(f"unknown board type {place.type!r}; known: {known}")
    if place.firmware and not FIRMWARE.fullmatch(place.firmware):
        raise ConfigError(f"firmware {place.firmware!r} is not of the form major.minor, as 2.50")
    bus_name = _bus(robot, place)
    name = _board_at(robot, bus_name, place)
    if name is None:
        return _by_hand(robot, bus_name, place)
    board = robot.boards[name]
    board = msgspec.structs.replace(
        board, firmware=place.firmware or board.firmware, simulated=True
    )
    joints = {key: joint for key, joint in robot.joints.items() if joint.board == name}
    return _narrowed(robot, name, board, joints)


def _bus(robot: RobotFile, place: Place) -> str:
    for name, bus in robot.buses.items():
        if place.bus in (name, bus.channel, str(bus.number)):
            return name
    known = ", ".join(f"{name} ({bus.channel})" for name, bus in robot.buses.items())
    raise ConfigError(f"{robot.path}: no bus {place.bus!r}; buses: {known}")


def _board_at(robot: RobotFile, bus: str, place: Place) -> str | None:
    """The robot file's board at the place; None where it is to be built by hand."""
    on_bus = {name: board for name, board in robot.boards.items() if board.bus == bus}
    for name, board in on_bus.items():
        if place.address not in addresses_of(board):
            continue
        if place.address != board.address:
            raise ConfigError(
                f"address {place.address} is the second one of {name} on bus {bus}; "
                f"say --address {board.address}"
            )
        if _fits(place.type, board.type):
            return name
        if place.firmware:
            return None
        raise ConfigError(
            f"{name} at bus {bus} address {board.address} is a {board.type} in {robot.path}, "
            f"not a {place.type}; to plug a {place.type} in all the same, give its --firmware"
        )
    if place.type and place.firmware:
        return None
    there = ", ".join(f"{b.address} {name} ({b.type})" for name, b in on_bus.items()) or "none"
    raise ConfigError(
        f"{robot.path} has no board at bus {bus} address {place.address}; boards there: {there}; "
        "to plug in one that the file does not know, give --type and --firmware"
    )


def _fits(asked: str, known: str) -> bool:
    """`bll` stands for its family: the robot file knows which of them it is."""
    return asked in ("", known) or (asked == "bll" and known in BLL_FAMILY)


def _by_hand(robot: RobotFile, bus: str, place: Place) -> Plugged:
    if not 1 <= place.address <= 14:
        raise ConfigError(f"address {place.address} is outside 1..14")
    board = msgspec.convert(
        {
            "bus": bus,
            "address": place.address,
            "type": place.type,
            "firmware": place.firmware,
            "simulated": True,
        },
        BoardTable,
    )
    joints = {
        f"{BENCH}_{axis}": _bench_joint(robot, axis) for axis in range(AXES.get(place.type, 0))
    }
    return _narrowed(robot, BENCH, board, joints)


def _bench_joint(robot: RobotFile, axis: int) -> JointTable:
    """A free bar with an absolute encoder, turned by the first kind of motor of the file."""
    example = next(joint for joint in robot.joints.values() if joint.encoder == "absolute")
    return msgspec.structs.replace(
        example,
        board=BENCH,
        axis=axis,
        ticks_per_deg=11.375,
        zero_deg=180.0,
        limits_deg=(-BENCH_REACH_DEG, BENCH_REACH_DEG),
        hard_stops_deg=(-BENCH_REACH_DEG, BENCH_REACH_DEG),
        power_up_deg=0.0,
        park_deg=0.0,
        motor_polarity=1,
        mechanism="single",
        inertia_kg_m2=BENCH_INERTIA_KG_M2,
        fingers=(),
    )


def _narrowed(
    robot: RobotFile, name: str, board: BoardTable, joints: dict[str, JointTable]
) -> Plugged:
    sensors = {key: one for key, one in robot.sensors.items() if one.board == name}
    if board.type in FORCE_TORQUE and not sensors:
        like = next(iter(robot.sensors.values()))
        sensors = {name: msgspec.structs.replace(like, board=name)}
    narrowed = msgspec.structs.replace(
        robot,
        buses={board.bus: robot.buses[board.bus]},
        boards={name: board},
        joints=joints,
        parts={name: tuple(joints)} if joints else {},
        selections={},
        sensors=sensors,
        virtual_sensors={},
    )
    return Plugged(robot=narrowed, name=name, bus=robot.buses[board.bus])
