"""Names for the words of one axis in a bank: attributes that read and write an array."""

import numpy as np
from numpy.typing import NDArray

Row = NDArray[np.int64]


class View:
    """Some words of a row; `attach` moves it to another bank's row."""

    __slots__ = ("row", "words")
    row: Row
    words: memoryview

    def attach(self, row: Row) -> None:
        """Speak of `row` from now on."""
        self.row = row
        self.words = row.data


class Word:
    """An integer at a place of a view's words."""

    def __init__(self, place: int) -> None:
        self._place = place

    def __get__(self, view: View, owner: type[View]) -> int:
        return view.words[self._place]

    def __set__(self, view: View, value: int) -> None:
        view.words[self._place] = value


class Flag:
    """A truth value at a place of a view's words."""

    def __init__(self, place: int) -> None:
        self._place = place

    def __get__(self, view: View, owner: type[View]) -> bool:
        return view.words[self._place] != 0

    def __set__(self, view: View, value: bool) -> None:
        view.words[self._place] = bool(value)


class Block(View):
    """A part of the row that begins at `start`, with words counted from there."""

    __slots__ = ("start",)

    def __init__(self, start: int) -> None:
        self.start = start

    def attach(self, row: Row) -> None:
        """Speak of `row` from now on."""
        self.row = row
        self.words = row.data[self.start :]
