"""The points of a frame, as programs give them, and as arrays. Programs use pointreel itself."""

from __future__ import annotations

import collections.abc
import contextlib
import os
from typing import Any, Collection, Dict, Iterator, Mapping, NamedTuple, Optional, Tuple

import numpy as np
from numpy.typing import NDArray

from ._arguments import _check_numbers, _check_texts, _vector, _warn
from ._native import Frame


class Points(NamedTuple):
    """The points of a frame that is to be written."""

    positions: Any
    """n x 3. float64 keeps coordinates far from zero; of anything else, float32 is made."""
    colors: Any = None
    """n x 3, sRGB: uint8, uint16, other whole numbers up to 255, or floats from 0 to 1."""
    normals: Any = None
    """n x 3, of any length."""
    origin: Tuple[float, float, float] = (0.0, 0.0, 0.0)
    """What positions are relative to."""
    time: Optional[float] = None
    """Seconds from the reel's start, or Unix time, from that of the first frame; None: one frame's
    time after the frame before."""
    scalars: Optional[Mapping[str, Any]] = None
    """Up to 8 scalar fields, such as intensities or classes: name to n numbers, NaN where unknown.
    Draco frames leave them out."""
    up: Optional[str] = None
    """The axis that points up, where it is known: x, -x, y, -y, z or -z."""


def _arrays(points: Points) -> Tuple[NDArray[Any], Optional[NDArray[Any]],
                                     Optional[NDArray[Any]], Tuple[float, ...],
                                     Dict[str, NDArray[np.float32]]]:
    positions = _rows(points.positions, "positions")
    origin = _vector(points.origin, "origin")
    if positions.dtype != np.float64:
        positions = _rows(positions, "positions", np.float32)
    elif any(origin):
        positions, origin = positions + origin, (0.0, 0.0, 0.0)
    lost = len(positions) - np.count_nonzero((np.abs(positions) < 1e38).all(axis=1))
    if lost:
        _warn(f"{lost} of {len(positions)} points have no finite position (NaN, infinite, or too "
              "large for a float) and are left out")
    colors = _colors(points.colors)
    normals = None if points.normals is None else _rows(points.normals, "normals", np.float32)
    _check_lengths(len(positions), colors=colors, normals=normals)
    return positions, colors, normals, origin, _scalars(points.scalars)


def _points_of(item: Any) -> Points:
    """The points of whatever `pack` takes as a frame."""
    if isinstance(item, Points):
        _check_numbers(time=item.time)
        if item.up is not None:
            _check_texts(up=item.up)
        return item
    if isinstance(item, Frame):
        return Points(item.positions, item.colors, item.normals, _vector(item.origin, "origin"),
                      scalars=item.scalars, up=item.up)
    if isinstance(item, dict):
        unknown = set(item) - set(Points._fields)
        if unknown:
            raise ValueError(f"a frame has no {', '.join(sorted(map(str, unknown)))}; it has "
                             + ", ".join(Points._fields))
        if "positions" not in item:
            raise ValueError("a frame has no positions")
        return _points_of(Points(**item))
    if isinstance(item, (tuple, list)) and len(item) in (2, 3) and np.ndim(item[0]) == 2:
        return Points(*item)
    if hasattr(item, "points"):  # as Open3D's PointCloud
        def attribute(name: str) -> Optional[NDArray[Any]]:
            values = np.asarray(getattr(item, name, ()))
            return values if values.size else None
        return Points(np.asarray(item.points), attribute("colors"), attribute("normals"))
    return Points(item)


def _rows(values: Any, name: str, dtype: Any = None) -> NDArray[Any]:
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise ValueError(f"{name} has masked values: give {name}[~mask]")
    array = np.asarray(values)
    if array.ndim == 0:
        raise TypeError(f"{name} is an array of n x 3 numbers, not {type(values).__name__}")
    if array.size == 0:
        array = array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name} has the shape {array.shape}, not n x 3")
    if array.dtype.kind not in "fiub":
        raise ValueError(f"{name} holds {array.dtype}, not numbers")
    return np.ascontiguousarray(array, dtype)


def _colors(values: Any) -> Optional[NDArray[Any]]:
    if values is None:
        return None
    array = _rows(values, "colors")
    if array.dtype.kind == "f":
        # Interpolated colors may be a little outside.
        outside = array[(array < -0.1) | (array > 1.1)]
        if outside.size:
            raise ValueError(f"float colors must be from 0 to 1, and there is a {outside[0]:g}"
                             + (": divide by 255" if 1.1 < outside.max() <= 255.0 else ""))
        unknown = np.count_nonzero(np.isnan(array))
        if unknown:
            _warn(f"{unknown} values of colors are not numbers and become 0")
        rounded: NDArray[np.uint16] = np.rint(
            np.clip(np.nan_to_num(array), 0.0, 1.0) * 65535.0).astype(np.uint16)
        return rounded
    if array.dtype in (np.uint8, np.uint16):
        return array
    if array.dtype.kind in "iu" and array.size and 0 <= array.min() and array.max() <= 255:
        return array.astype(np.uint8)  # as a list of numbers is
    raise ValueError("colors are uint8, uint16, whole numbers up to 255 or floats from 0 to 1, not "
                     f"{array.dtype}")


def _check_lengths(points: int, **arrays: Optional[NDArray[Any]]) -> None:
    for name, array in arrays.items():
        if array is not None and len(array) != points:
            raise ValueError(f"{name} has {len(array)} rows for {points} points")


def _scalars(values: Optional[Mapping[str, Any]]) -> Dict[str, NDArray[np.float32]]:
    fields = {}
    if values is not None and not isinstance(values, collections.abc.Mapping):
        raise TypeError("scalars is a dict of arrays by name")
    for name, numbers in (values or {}).items():
        array = np.asarray(numbers)
        if array.ndim != 1 or array.dtype.kind not in "fiub":
            raise ValueError(f"the scalar field {name} is not a list of numbers, one for each point")
        kept = np.ascontiguousarray(array, np.float32)
        if array.dtype.itemsize > 2 and array.dtype != np.float32:
            known = array[np.isfinite(array)].astype(np.float64)
            lost = np.abs(known - known.astype(np.float32)).max(initial=0.0)
            extent = np.ptp(known) if known.size else 0.0
            if extent > 0.0 and lost > 0.5 * extent / 255.0:
                _warn(f"the scalar field {name} is off by up to {lost:.3g}, because it is kept in 32 "
                      "bits: subtract an offset from it before")
        _check_texts(**{f"the name {name!r} of scalars": str(name)})
        fields[str(name)] = kept
    return fields


@contextlib.contextmanager
def _at_frame(index: int) -> Iterator[None]:
    """Names the frame whose arguments are wrong."""
    try:
        yield
    except (TypeError, ValueError) as error:
        raise type(error)(f"frame {index}: {error}") from None


def _check_frames(frames: Any, function: str, rest: str = "") -> None:
    is_arrays = (isinstance(frames, tuple) and len(frames) in (2, 3) and
                 all(isinstance(part, np.ndarray) for part in frames))
    if frames is None or is_arrays or isinstance(
            frames, (str, bytes, os.PathLike, np.ndarray, Frame, Points, dict)):
        raise TypeError(f"frames is a list of frames, not {type(frames).__name__}; give one frame "
                        f"as {function}([frame]{rest}), and files as "
                        f"{function}(pointreel.open(file){rest})")


def _give(item: Any, add: Any, add_frame: Any, time: Optional[float] = None
          ) -> Collection[str]:
    """Gives a frame, of whatever kind, to one of these. `time`: of a `Frame`. Returns the names of
    its scalar fields."""
    if isinstance(item, Frame):
        add_frame(item, time)
        return item.scalars
    points = _points_of(item)
    arrays = _arrays(points)
    add(*arrays, points.time)
    return arrays[-1]
