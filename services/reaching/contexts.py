"""Settings that were put aside under a number, to be taken up again."""

from collections.abc import Mapping
from typing import Generic, TypeVar

from services.core.errors import ServiceError

MOST = 100  # a client that stores in a loop must not fill the memory

SettingsT = TypeVar("SettingsT")


class ContextError(ServiceError):
    """There is no such context, or no room for another."""


class Contexts(Generic[SettingsT]):
    """Numbers count up from 1 and never come again; 0 is the start of the process."""

    def __init__(self, initial: Mapping[str, SettingsT]) -> None:
        """`initial` are the settings by limb that context 0 restores."""
        self._kept: dict[int, dict[str, SettingsT]] = {0: dict(initial)}
        self._next = 1

    @property
    def numbers(self) -> tuple[int, ...]:
        """All that can be restored."""
        return tuple(self._kept)

    def store(self, settings: Mapping[str, SettingsT]) -> int:
        """Put a copy aside.

        Raises:
            ContextError: a hundred are kept already.
        """
        if len(self._kept) > MOST:
            raise ContextError(f"{MOST} contexts are stored: delete one first")
        number = self._next
        self._next += 1
        self._kept[number] = dict(settings)
        return number

    def settings(self, number: int) -> dict[str, SettingsT]:
        """What was stored.

        Raises:
            ContextError: never stored, or deleted.
        """
        if number not in self._kept:
            known = ", ".join(str(one) for one in self._kept)
            raise ContextError(f"no context {number}; there are {known}")
        return dict(self._kept[number])

    def delete(self, number: int) -> None:
        """Forget one.

        Raises:
            ContextError: it is none, or the one of the start.
        """
        self.settings(number)
        if number == 0:
            raise ContextError("context 0 is the start of the process and stays")
        del self._kept[number]
