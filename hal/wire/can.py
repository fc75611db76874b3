"""The 11-bit identifier of the iCub's CAN protocol and the two shapes a frame has inside Ulna.

Source: can-protocol fact sheet, section 1.  id = class << 8 | source << 4 | (destination or type)
"""

Frame = tuple[int, bytes]
"""An outgoing frame: identifier and 0 to 8 data bytes."""

Received = tuple[int, bytes, int]
"""An incoming frame: identifier, data, and the arrival time in ns of the receiver's clock."""

HOST = 0
EVERYBODY = 15

CLASS_MOTOR_POLLING = 0
CLASS_MOTOR_PERIODIC = 1
CLASS_ANALOG_POLLING = 2
CLASS_ANALOG_PERIODIC = 3
CLASS_SKIN_PERIODIC = 4
CLASS_INERTIAL_PERIODIC = 5
CLASS_BATTERY_PERIODIC = 6
CLASS_MANAGEMENT = 7


def frame_id(can_class: int, source: int, low: int) -> int:
    """Identifier of a frame; `low` is the destination (polling classes) or the message type."""
    return can_class << 8 | source << 4 | low


def class_of(can_id: int) -> int:
    """Message class, bits 10..8."""
    return can_id >> 8


def source_of(can_id: int) -> int:
    """Sender's address, bits 7..4."""
    return can_id >> 4 & 0xF


def low_of(can_id: int) -> int:
    """Destination address (polling, management) or message type (periodic classes), bits 3..0."""
    return can_id & 0xF
