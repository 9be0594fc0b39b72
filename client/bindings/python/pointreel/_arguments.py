"""What programs give to pointreel: checked, and as arrays. Programs use pointreel itself."""

from __future__ import annotations

import operator
import os
import re
import sys
import warnings
from typing import Any, Collection, Mapping, Optional, Tuple, Union

import numpy as np

from ._native import Error, Frame


_MOST_NUMBER = 2**1023  # Larger ones do not become floats.
_MOST_COUNT, _MOST_BYTES = 2**31 - 1, 2**63 - 1


def _error(message: str, code: str) -> Error:
    error = Error(message)
    error.code = code
    return error


def _check(kind: Any, what: str, /, **arguments: Any) -> None:
    """Refuses arguments that are not of this kind. The message of pybind11 would print all arguments
    of the call, tokens among them."""
    for argument, value in arguments.items():
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            raise TypeError(f"{argument} is {what}, not {type(value).__name__}")


def _check_texts(**arguments: Any) -> None:
    _check(str, "a text", **arguments)
    for argument, value in arguments.items():
        if any("\ud800" <= letter <= "\udfff" for letter in value):
            raise ValueError(f"{argument} has half of a surrogate pair")


def _check_numbers(**arguments: Any) -> None:
    """None stands for the default."""
    given = {name: value for name, value in arguments.items() if value is not None}
    _check((int, float, np.integer, np.floating), "a number", **given)
    for name, value in given.items():
        if isinstance(value, int) and abs(value) > _MOST_NUMBER:
            raise ValueError(f"{name} is too large")


def _check_counts(**arguments: Any) -> None:
    """None stands for the default."""
    given = {name: value for name, value in arguments.items() if value is not None}
    _check((int, np.integer), "a whole number", **given)
    for name, value in given.items():
        if value < 1:
            raise ValueError(f"{name} is at least 1")
        if value > (_MOST_BYTES if name == "max_memory" else _MOST_COUNT):
            raise ValueError(f"{name} is too large")


def _path(where: Union[str, os.PathLike[str]]) -> bytes:
    """As bytes, because names of files need not be UTF-8, which pybind11 would refuse."""
    path = os.fsencode(where)
    if b"\0" in path:
        raise ValueError("a path has no null character")
    return path


def _vector(values: Any, name: str) -> Tuple[float, float, float]:
    try:
        x, y, z = map(float, values)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is three numbers") from None
    return x, y, z


def _warn(message: str) -> None:
    """Blames the line that called this package."""
    level, caller = 1, sys._getframe()
    while caller.f_back is not None and caller.f_globals.get("__package__") == __package__:
        level, caller = level + 1, caller.f_back
    warnings.warn(message, stacklevel=level)


def _named(argument: str, name: str, known: Mapping[str, Any]) -> Any:
    if name not in known:
        raise ValueError(f"{argument} is one of {', '.join(known)}, or numbers, not {name!r}")
    return known[name]


def _color(text: str) -> Tuple[float, ...]:
    if not re.fullmatch("#[0-9a-fA-F]{6}", text):
        raise ValueError(f"background is a color such as #ffffff, not {text!r}")
    return tuple(part / 255.0 for part in bytes.fromhex(text[1:]))


class _Steps:
    """Tells where the names of scalar fields given by the user are of no use."""

    def __init__(self, codec: str, steps: Optional[Mapping[str, float]]):
        self._unused, self._draco, self._warned = set(steps or {}), codec == "draco", False

    def see(self, fields: Collection[str]) -> None:
        self._unused.difference_update(fields)
        if self._draco and not self._warned and fields:
            self._warned = True
            _warn("scalar fields are left out: Draco frames have none")

    def end(self) -> None:
        if self._unused:
            _warn(f"scalar_steps: no frame has the field {', '.join(sorted(self._unused))}")


class _Axis:
    """The axis that points up in what is written, and a warning where frames have another one."""

    def __init__(self, up: Optional[str], default: Optional[str] = None):
        self.up = next(axis for axis in (up, default, "y") if axis is not None)
        self._is_guess = up is None

    def see(self, frame: Any) -> None:
        up = _up_of(frame)
        if self._is_guess and up not in (None, self.up):
            self._is_guess = False
            _warn(f"{up} points up in the frames, but {self.up} in what is written; pass "
                  f"up={up!r} to keep their axis")


class _Rate:
    """Warns where frames of a reel, one after another, do not keep its rate in what is written."""

    def __init__(self, fps: float):
        self._fps, self._last, self._is_right = fps, None, True

    def see(self, frame: Frame) -> None:
        if not self._is_right:
            return
        last, self._last = self._last, frame.time
        if last is not None and self._last > last:
            rate = 1.0 / (self._last - last)
            if not 0.8 < rate / self._fps < 1.25:
                self._is_right = False
                _warn(f"the frames come from a reel with {rate:.4g} of them per second, and are "
                      f"written with {self._fps:.4g}; pass fps={rate:.4g} to keep their rate")


def _up_of(frames: Any) -> Optional[str]:
    """The axis that points up in a frame, in a reel, in a part of it, or in a list of its frames, if
    known."""
    if isinstance(frames, (list, tuple)) and not hasattr(frames, "up"):
        return next((up for up in map(_up_of, frames) if up is not None), None)
    return frames.get("up") if isinstance(frames, dict) else getattr(frames, "up", None)


def _index(index: Any, count: int) -> int:
    """The index, from 0, of one of `count` frames; negative ones count from the end."""
    try:
        number = operator.index(index)
    except TypeError:
        raise TypeError(f"a frame's index is an integer, not {type(index).__name__}") from None
    if not -count <= number < count:
        raise IndexError(f"there is no frame {number}; there are {count} frames")
    return number % count
