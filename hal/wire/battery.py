"""Battery board, class 6: no source tells its payloads, so they are named and kept as bytes."""

from hal.wire.can import CLASS_BATTERY_PERIODIC
from hal.wire.layout import opaque
from hal.wire.message import PeriodicMessage

MESSAGES: dict[int, PeriodicMessage] = {
    kind: PeriodicMessage(CLASS_BATTERY_PERIODIC, kind, f"BATTERY_{kind}", opaque())
    for kind in range(16)
}
"""Rows of class 6 by type."""
