"""What the firmware of one motor board keeps beside its axes: links, flash, boot loader."""

from firmware_sim.boards.axis_state import Axis
from firmware_sim.boards.couplings import SHOULDER_RATIO, shoulder_lower, shoulder_upper
from firmware_sim.boards.hall import Tendon
from firmware_sim.boards.hardware import Firmware
from firmware_sim.boards.links import Links
from firmware_sim.boards.loader import Loader
from firmware_sim.boards.node import Pair

DEFAULT_SPEED_SHIFT = 5
MICRO_SACCADE = 20  # the debug parameter of three words, of the head
_PER_MILLE = 1000
_RATIO = int(SHOULDER_RATIO * _PER_MILLE)
_UPPER = {10: -_RATIO, 11: _RATIO}
_LOWER = {12: -_RATIO, 13: _RATIO, 14: _RATIO}
_SHOULDER_UPPER = 0x50


class Unit:
    """Belongs to one board; its axes reach it through their node."""

    __slots__ = (
        "_pairs",
        "axes",
        "coupling",
        "decoupling",
        "firmware",
        "flash_writes",
        "links",
        "loader",
        "micro_saccade",
        "moves",
        "rotor_before",
        "rotor_shifts",
        "standing",
    )

    def __init__(self, firmware: Firmware, axes: tuple[Axis, ...], pairs: tuple[Pair, ...]) -> None:
        """`axes` live in a bank already."""
        self.firmware = firmware
        self.axes = axes
        self._pairs = pairs
        self.links = Links(firmware.partner, axes)
        self.links.attach(axes)
        self.loader = Loader(pairs[0].address)
        self.flash_writes = 0  # of address and label
        self.boot()

    def boot(self) -> None:
        """State at power-up; address and label stand in the flash."""
        self.links.boot()
        self.loader.leave()
        self.moves: dict[int, tuple[int, int]] = {}  # of coupled axes calibrated before the other
        self.standing: set[int] = set()  # axes that creep and have come to a stop
        self.micro_saccade: tuple[int, ...] = (0, 0, 0)
        self.rotor_shifts = [DEFAULT_SPEED_SHIFT] * len(self.axes)
        self.rotor_before = [axis.port.raw_encoder for axis in self.axes]
        self.decoupling = self._default_decoupling()
        self.coupling = self.firmware.coupling  # what the board's motors and encoders act by

    def tendon(self, axis: Axis) -> Tendon | None:
        """The axis as a hand's tendon, None on other boards."""
        hall = self.links.hall
        return None if hall is None else hall.of(axis)

    def move_to(self, address: int) -> None:
        """SET_BOARD_ID: the CAN controller starts afresh at another address."""
        for number, pair in enumerate(self._pairs):
            pair.address = address + number
            pair.can_status = 0
        node = self.axes[0].node
        node.address = address
        node.printer.move_to(address)
        self.loader.move_to(address)

    def set_joint_zero(self, axes: list[Axis]) -> None:
        """The joints of these axes stand at 0 from now on; coupled ones share the change."""
        for axis in axes:
            row = self.firmware.coupling.encoders[axis.number]
            seen = [(own, one) for own, one in zip(row, self.axes, strict=True) if own]
            if len(axes) > 1 or len(seen) == 1:
                axis.encoder_offset = axis.port.raw_encoder
                continue
            half = axis.position // 2
            for (own, encoder), share in zip(seen, (axis.position - half, half), strict=True):
                encoder.encoder_offset += int(own) * share
        for axis in self.axes:
            axis.rebase()

    def gain_changed(self, axis: Axis) -> None:
        """Some position gain is new: the sign of kp tells a thumb which hand it is."""
        if self.firmware.thumb is not None and axis is self.axes[0]:
            self.coupling = self.firmware.thumb[axis.position_pid.kp >= 0]

    def set_decoupling(self, index: int, per_mille: int) -> bool:
        """Change a coefficient of the shoulder; False when this firmware has not got it.

        DELIBERATE: only coefficients of a board's own motors act; the sheet does not say what the
        others do there.
        """
        if index not in self.decoupling:
            return False
        self.decoupling[index] = per_mille
        ratios = [value / _PER_MILLE for value in self.decoupling.values()]
        major, minor = self.firmware.version
        if minor == _SHOULDER_UPPER:
            self.coupling = shoulder_upper(*ratios)
        else:
            self.coupling = shoulder_lower(*ratios, motor_encoder=major == 1)
        return True

    def _default_decoupling(self) -> dict[int, int]:
        minor = self.firmware.version[1]
        if self.firmware.partner is None:
            return {}
        return dict(_UPPER if minor == _SHOULDER_UPPER else _LOWER)
