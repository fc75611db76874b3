"""The millisecond of a DSP motor board, in the order of can-protocol 10.4.

DELIBERATE: frames leave in the order they were made and none is lost on the way out; a real board's
transmit buffer holds ten and is emptied last-in-first-out. Partner boards are not watched.
"""

from firmware_sim.boards import parser
from firmware_sim.boards.axis import AxisPort
from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.board import RECEIVE_FIFO_FRAMES
from firmware_sim.boards.broadcasts import POSITION_SLOT, USED_SLOTS, broadcast, print_piece
from firmware_sim.boards.control import LAWS, drive, undefined, watch_current
from firmware_sim.boards.hardware import Firmware, Hardware
from firmware_sim.boards.node import BUILD, Node, Pair
from hal.wire.can import (
    CLASS_ANALOG_PERIODIC,
    CLASS_MANAGEMENT,
    CLASS_MOTOR_POLLING,
    EVERYBODY,
    HOST,
    Frame,
    class_of,
    low_of,
    source_of,
)
from hal.wire.message import CODE_MASK
from hal.wire.motor import GET_ADDITIONAL_INFO
from hal.wire.motor_periodic import BoardStatus, CanStatus

TEMPERATURE_PERIOD_MS = 5
_OVERTEMPERATURE = (int(BoardStatus.OVERTEMPERATURE_0), int(BoardStatus.OVERTEMPERATURE_1))
_LOOP_OVERRUN = int(BoardStatus.LOOP_OVERRUN)
_BUS_OFF = int(CanStatus.BUS_OFF)
_RX_OVERRUN = int(CanStatus.RX_OVERRUN)


class MotorBoard:
    """BLL or 4DC, as its `Hardware` and `Firmware` say. Two axes for each address."""

    def __init__(self, address: int, hardware: Hardware, firmware: Firmware) -> None:
        self.addresses = tuple(range(address, address + hardware.axes // 2))
        self.bus_off = False
        self.powered = True
        self.loop_overrun = False  # input: this millisecond took longer than it may, reported once
        self.raw_adc: list[int] = []
        self._hardware = hardware
        self._firmware = firmware
        self._node = Node(address, firmware.version)
        self.dropped = self._node.dropped
        self._pairs = tuple(Pair(own) for own in self.addresses)
        self.axes = tuple(
            Axis(number % 2, hardware, wiring, self._node, self._pairs[number // 2])
            for number, wiring in enumerate(firmware.axes)
        )
        self._addressed = tuple(
            (pair, (self.axes[2 * number], self.axes[2 * number + 1]))
            for number, pair in enumerate(self._pairs)
        )
        self.ports: tuple[AxisPort, ...] = tuple(axis.port for axis in self.axes)
        self._received: list[Frame] = []

    def accepts(self, can_id: int) -> bool:
        """Hardware filter: commands to the board, every class 3 frame, class 7 from the host."""
        kind = class_of(can_id)
        if kind == CLASS_MOTOR_POLLING:
            return low_of(can_id) in self.addresses
        if kind == CLASS_MANAGEMENT:
            addressed = low_of(can_id) in (self.addresses[0], EVERYBODY)
            return addressed and source_of(can_id) == HOST
        return kind == CLASS_ANALOG_PERIODIC

    def on_frame(self, can_id: int, data: bytes) -> None:
        """Queue a frame for the next tick; the 31st overruns the FIFO and is lost."""
        received = self._received
        if len(received) < RECEIVE_FIFO_FRAMES:
            received.append((can_id, data))
            return
        self.dropped["overrun"] += 1
        for pair in self._pairs:
            pair.can_status |= _RX_OVERRUN

    def power_cycle(self) -> None:
        """Boot again; label and fault counters are kept."""
        self.powered = True
        self._received.clear()
        self._node.boot()
        for pair in self._pairs:
            pair.boot()
        for axis in self.axes:
            axis.boot()

    def tick(self) -> list[Frame]:
        """One millisecond."""
        if not self.powered:
            self._received.clear()
            for axis in self.axes:
                axis.idle()
            return []
        now_ms = self._node.ms = self._node.ms + 1
        sent: list[Frame] = []
        if self._received or self.bus_off or now_ms == 1:
            self._listen(sent)
        self._control(now_ms)
        if self.bus_off:
            sent.clear()
        elif self._pairs[0].mask:  # mask 0 silences the second address too
            self._broadcast(now_ms, sent)
        self._supervise(now_ms)
        return sent

    def _listen(self, sent: list[Frame]) -> None:
        if self._node.ms == 1:
            for axis in self.axes:
                axis.rebase()
        if self.bus_off:
            self._received.clear()
            for axis in self.axes:
                axis.fault()
                axis.pair.can_status |= _BUS_OFF
            return
        self._parse(sent)

    def _control(self, now_ms: int) -> None:
        axes = self.axes
        slot = now_ms % self._hardware.speed_window_ms
        for axis in axes:
            axis.sense(slot)
        # A coupling of encoders goes here: joint positions from what the axes sensed.
        for sensor in self._node.sensors.values():
            if sensor.watchdog_ms:
                sensor.watchdog_ms -= 1
        for axis in axes:
            if axis.enabled:
                axis.pwm_wanted = LAWS.get(axis.mode, undefined)(axis)
        # A coupling of motors goes here: PWM of the motors from those of the joints.
        for axis in axes:
            if axis.enabled:
                drive(axis, axis.pwm_wanted)

    def _supervise(self, now_ms: int) -> None:
        if now_ms % TEMPERATURE_PERIOD_MS == 0:
            self._watch_temperature()
        for axis in self.axes:
            if axis.i2t or abs(axis.port.current_ma) > axis.current_limit_ma:
                watch_current(axis)
        if self.loop_overrun:
            self.loop_overrun = False
            for pair in self._pairs:
                pair.board_status |= _LOOP_OVERRUN

    def _parse(self, sent: list[Frame]) -> None:
        tolerated = self._firmware.tolerated_types
        received = self._received
        self._received = []
        for number, (can_id, data) in enumerate(received, 1):
            kind = can_id >> 8
            if kind == CLASS_ANALOG_PERIODIC:
                parser.virtual_torque(self._node, tolerated, can_id, data)
            elif kind != CLASS_MOTOR_POLLING:
                self._manage(can_id, data, sent)
            elif not self._command(can_id, data, sent):
                self._received = received[number:]  # the rest waits for the next millisecond
                return

    def _command(self, can_id: int, data: bytes, sent: list[Frame]) -> bool:
        number = low_of(can_id) - self.addresses[0]
        if not data or not 0 <= number < len(self.addresses):
            self.dropped["address"] += 1
            return True
        axis = self._addressed[number][1][data[0] >> 7]
        if data[0] & CODE_MASK == GET_ADDITIONAL_INFO.code:
            parser.send_label(axis, source_of(can_id), sent)
            return True
        return parser.command(axis, data, source_of(can_id), sent)

    def _manage(self, can_id: int, data: bytes, sent: list[Frame]) -> None:
        if parser.is_discovery(self.addresses[0], can_id, data):
            for pair in self._pairs:
                pair.mask = 0
            for axis in self.axes:
                if axis.enabled:
                    axis.idle()
        sent += parser.manage(self._node, can_id, data, self._hardware.board_type, BUILD)

    def _broadcast(self, now_ms: int, sent: list[Frame]) -> None:
        slot = now_ms % self._hardware.slots
        if slot < USED_SLOTS and not (slot == POSITION_SLOT and self._hides_position()):
            for pair, axes in self._addressed:
                if pair.mask:
                    broadcast(pair, axes, slot, now_ms, sent)
        if self._node.printer.waiting:
            print_piece(self._node, self._pairs[0].mask, sent)

    def _hides_position(self) -> bool:
        needs_encoders = self._firmware.position_needs_encoders
        return needs_encoders and any(port.encoder_fault for port in self.ports)

    def _watch_temperature(self) -> None:
        for axis in self.axes:
            if axis.port.overheated:
                axis.pair.board_status |= _OVERTEMPERATURE[axis.index]
                axis.fault()
