"""Point clouds that move: reels, live streams, and encoded frames, as arrays of numpy.

    import pointreel

    reel = pointreel.open("http://127.0.0.1:8090/REEL")  # or a folder
    frame = reel[10]
    frame.positions  # float32, n x 3, without a copy
    for frame in reel[20:40]:  # the next frames are decoded meanwhile
        ...

All functions raise `pointreel.Error`, whose member `code` tells what kind of failure it was, and
let other threads run while they fetch, decode or encode. Ctrl-C ends them.
"""

from __future__ import annotations

import collections
import json
import operator
import os
from typing import (Any, Deque, Dict, Iterable, Iterator, Mapping, NamedTuple, Optional, Sequence, Tuple,
                    Union, overload)

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._native import Error, Frame, __version__

__all__ = ["Error", "Frame", "Frames", "Points", "Reel", "Live", "Publisher", "open", "live",
           "encode", "decode", "clean", "pack", "publish", "render", "__version__"]


class Points(NamedTuple):
    """The points of a frame that is to be written."""

    positions: Any
    """n x 3. float64 keeps coordinates far from zero; of anything else, float32 is made."""
    colors: Any = None
    """n x 3, sRGB: uint8, uint16, or floats from 0 to 1."""
    normals: Any = None
    """n x 3, of any length."""
    origin: Tuple[float, float, float] = (0.0, 0.0, 0.0)
    """What positions of float32 are relative to."""
    time: Optional[float] = None
    """Seconds from the reel's start; None: one frame's time after the frame before."""
    scalars: Optional[Mapping[str, Any]] = None
    """Up to 8 scalar fields, such as intensities or classes: name to n numbers, NaN where unknown.
    Draco frames leave them out."""


def _error(message: str, code: str) -> Error:
    error = Error(message)
    error.code = code
    return error


def _rows(values: Any, name: str, dtype: Any = None) -> NDArray[Any]:
    array = np.asarray(values)
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
            raise ValueError(f"float colors must be from 0 to 1, and there is a {outside[0]:g}")
        rounded: NDArray[np.uint16] = np.rint(
            np.clip(np.nan_to_num(array), 0.0, 1.0) * 65535.0).astype(np.uint16)
        return rounded
    if array.dtype in (np.uint8, np.uint16):
        return array
    raise ValueError(f"colors are uint8, uint16 or floats from 0 to 1, not {array.dtype}")


def _scalars(values: Optional[Mapping[str, Any]]) -> Dict[str, NDArray[np.float32]]:
    fields = {}
    for name, numbers in (values or {}).items():
        array = np.asarray(numbers)
        if array.ndim != 1 or array.dtype.kind not in "fiub":
            raise ValueError(f"the scalar field {name} is not a list of numbers, one for each point")
        fields[str(name)] = np.ascontiguousarray(array, np.float32)
    return fields


def _arrays(points: Points) -> Tuple[NDArray[Any], Optional[NDArray[Any]],
                                     Optional[NDArray[Any]], Tuple[float, ...],
                                     Dict[str, NDArray[np.float32]]]:
    positions = _rows(points.positions, "positions")
    if positions.dtype != np.float64:
        positions = _rows(positions, "positions", np.float32)
    colors = _colors(points.colors)
    normals = None if points.normals is None else _rows(points.normals, "normals", np.float32)
    return (positions, colors, normals, tuple(map(float, points.origin)),
            _scalars(points.scalars))


def _points_of(item: Any) -> Points:
    """The points of whatever `pack` takes as a frame."""
    if isinstance(item, Points):
        return item
    if isinstance(item, dict):
        return Points(**item)
    if isinstance(item, (tuple, list)) and len(item) in (2, 3) and np.ndim(item[0]) == 2:
        return Points(*item)
    if hasattr(item, "points"):  # as Open3D's PointCloud
        def attribute(name: str) -> Optional[NDArray[Any]]:
            values = np.asarray(getattr(item, name, ()))
            return values if values.size else None
        return Points(np.asarray(item.points), attribute("colors"), attribute("normals"))
    return Points(item)


def _give(item: Any, add: Any, add_frame: Any) -> None:
    """Gives a frame, of whatever kind, to one of these."""
    if isinstance(item, Frame):
        add_frame(item, None)
    else:
        points = _points_of(item)
        add(*_arrays(points), points.time)


class Frames(Sequence[Frame]):
    """Frames of a reel in some order. Nothing is read before a frame is asked for."""

    def __init__(self, reel: Reel, indices: range):
        self._reel, self._indices = reel, indices

    def __len__(self) -> int:
        return len(self._indices)

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> Frames: ...
    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return Frames(self._reel, self._indices[index])
        return self._reel.read(self._indices[index])

    def __iter__(self) -> Iterator[Frame]:
        return self._reel._ahead(self._indices)

    def __repr__(self) -> str:
        return f"<{len(self)} frames of {self._reel!r}>"


class Reel(Frames):
    """A sequence of frames: `reel[10]`, `reel[-1]`, `reel[::5]`, `for frame in reel`."""

    def __init__(self, native: _native.Reel, layers: Optional[int], max_memory: Optional[int],
                 ahead: int):
        super().__init__(self, range(len(native)))
        self._native, self._layers = native, layers
        self._max_memory, self._ahead_frames = max_memory, ahead
        self.metadata: Dict[str, Any] = json.loads(native.metadata())
        """What the package's reel.json says."""
        self.times: NDArray[np.float64] = native.times()
        """When each frame is shown: seconds from the reel's start."""
        self.bounds: Optional[NDArray[np.float64]] = native.bounds()
        """The smallest and the largest coordinates of all frames, 2 x 3."""

    @property
    def name(self) -> str:
        return str(self.metadata["name"])

    @property
    def codec(self) -> str:
        """octree, draco, video or files."""
        return str(self.metadata["codec"])

    @property
    def fps(self) -> float:
        """The nominal frame rate; `times` are authoritative."""
        return float(self.metadata["fps"])

    @property
    def duration(self) -> float:
        """Seconds of one pass."""
        return float(self.metadata["duration_us"]) / 1e6

    @property
    def up(self) -> str:
        """The axis that points up: x, -x, y, -y, z or -z."""
        return str(self.metadata["up"])

    @property
    def layers(self) -> int:
        """How many layers its frames have, from coarse to fine; 0 for files."""
        return len(self.metadata["layers"])

    @property
    def trouble(self) -> str:
        """Why nothing comes over the network at present, or an empty text. For other threads."""
        return self._native.trouble()

    def read(self, index: int, layers: Optional[int] = None) -> Frame:
        """A frame, of its first `layers` layers if that is given."""
        return self._native.read(range(len(self))[index],
                                 self._layers if layers is None else layers, self._max_memory)

    def _ahead(self, indices: range) -> Iterator[Frame]:
        return self._native.read_ahead(list(indices), self._layers, self._max_memory,
                                       self._ahead_frames)

    def __repr__(self) -> str:
        return f"<pointreel.Reel {self.name!r} of {len(self)} frames>"


def open(where: Union[str, os.PathLike[str]], *, layers: Optional[int] = None, ahead: int = 3,
         fps: Optional[float] = None, topic: str = "", token: str = "", ca_file: str = "",
         follow_redirects: bool = False, max_memory: Optional[int] = None) -> Reel:
    """Opens a package (its folder, its reel.json, or an http:// or https:// address of either), a
    folder of files of points (PLY, Draco, PCD, LAS, text, OBJ, glTF, KITTI, nuScenes), one such
    file, an MCAP recording of ROS 2, or depth: a folder with depth/*.png, or .mkv.

    layers: fetch and decode the first layers of each frame only. ahead: how many frames iteration
    decodes ahead. fps: of folders of files, which do not tell it; 30, or the times of a recording.
    topic: of a recording that has several. token: bearer token for the server. ca_file:
    certificates to trust for https, in PEM form. max_memory: bytes that decoding a frame may take,
    1 GiB by default.
    """
    native = _native.Reel(os.fspath(where), fps, topic, token, ca_file, follow_redirects)
    return Reel(native, layers, max_memory, ahead)


class Live:
    """Frames of a live stream as they come; it never ends by itself."""

    def __init__(self, native: _native.Live, timeout: Optional[float], layers: Optional[int],
                 max_memory: Optional[int]):
        self._native, self._timeout = native, timeout
        self._layers, self._max_memory = layers, max_memory

    def __iter__(self) -> Iterator[Frame]:
        return self

    def __next__(self) -> Frame:
        frame = self.next(self._timeout)
        if frame is None:
            raise TimeoutError(self.trouble or f"no frame has come for {self._timeout} s")
        return frame

    def next(self, timeout: Optional[float] = None) -> Optional[Frame]:
        """The newest frame that was not given yet; None if there is none within `timeout` seconds.
        A frame whose finest layers come late is given again."""
        return self._native.next(timeout, self._layers, self._max_memory)

    @property
    def trouble(self) -> str:
        """Why nothing comes, or an empty text."""
        return self._native.trouble()


def live(url: str, *, timeout: Optional[float] = None, layers: Optional[int] = None,
         token: str = "", ca_file: str = "", follow_redirects: bool = False,
         max_memory: Optional[int] = None) -> Live:
    """Watches ws(s)://HOST/live/NAME: `for frame in pointreel.live(url)`. Older frames are skipped
    where the program is too slow for all. A broken connection is made again.

    timeout: seconds without a frame after which iteration raises TimeoutError; without it, it
    waits.
    """
    return Live(_native.Live(url, token, ca_file, follow_redirects), timeout, layers, max_memory)


def _encoding(codec: str, depth: Optional[int], voxel: Optional[float], delta: Optional[float],
              color_quality: Optional[int], normal_quality: Optional[int], fast: bool,
              scalar_steps: Optional[Mapping[str, float]]) -> _native.Encoding:
    def number(name: str, value: Any, kind: Any) -> Any:  # 0: the default
        if value is None:
            return 0
        if value == 0:
            raise _error(f"{name} must be above 0", "argument")
        return kind(value)

    return _native.Encoding(codec, number("depth", depth, operator.index),
                            number("voxel", voxel, float),
                            number("color_quality", color_quality, operator.index),
                            number("normal_quality", normal_quality, operator.index), fast,
                            number("delta", delta, float), dict(scalar_steps or {}))


def encode(positions: Any, colors: Any = None, normals: Any = None, *,
           origin: Tuple[float, float, float] = (0.0, 0.0, 0.0), codec: str = "octree",
           depth: Optional[int] = None, voxel: Optional[float] = None,
           delta: Optional[float] = None, color_quality: Optional[int] = None,
           normal_quality: Optional[int] = None, fast: bool = False,
           scalars: Optional[Mapping[str, Any]] = None,
           scalar_steps: Optional[Mapping[str, float]] = None) -> bytes:
    """Encodes a single frame; `decode` reads it. The arrays are those of `Points`.

    codec: octree or draco. depth: levels of the octree, or bits of Draco's positions. voxel: the
    edge of a voxel instead. delta: instead of both, the share of the points, 0.05 by default, that
    may fall into the voxel of another. color_quality, normal_quality: of octrees, 1 to 100, at which
    colours are lossless. fast: an octree that decodes in half the time and is 25 % larger.
    scalar_steps: of scalar fields by name, in what steps their values are kept; by default exactly,
    or in 255 steps.
    """
    arrays = _arrays(Points(positions, colors, normals, origin, scalars=scalars))
    return _native.encode(*arrays,
                          _encoding(codec, depth, voxel, delta, color_quality, normal_quality, fast,
                                    scalar_steps))


def decode(data: Any, *, layers: Optional[int] = None, max_memory: Optional[int] = None) -> Frame:
    """Decodes what `encode` made, or a whole file of points that is recognised by its first bytes.
    `data`: bytes, or anything with a buffer. `layers` and `max_memory` as for `open`."""
    return _native.decode(data, layers, max_memory)


def clean(frames: Iterable[Any], *, before: int = 2, after: int = 2,
          radius: Optional[float] = None) -> Iterator[Points]:
    """Cleans noisy scans, one frame after another: points move onto the surface that they are
    samples of, and those without a surface go. Frames that are smooth, or not scans, stay as they
    are. `for points in pointreel.clean(reel): ...`

    frames: whatever `pack` takes. before, after: how many frames on either side help, 0 to 4. Frames
    of a camera are not to wait for later ones: `after=0`. radius: within which the surface is
    smoothed, in the unit of the points; by default as much as the noise asks for.
    """
    cleaner = _native.Cleaner(radius, before, after)
    times: Deque[Optional[float]] = collections.deque()

    def cleaned() -> Iterator[Points]:
        while True:
            frame = cleaner.next()
            if frame is None:
                return
            yield Points(frame.positions, frame.colors, frame.normals,
                         tuple(frame.origin.tolist()), times.popleft(), frame.scalars)

    for item in frames:
        if not isinstance(item, Frame):
            item = _points_of(item)
        times.append(item.time if isinstance(item, Points) else None)
        _give(item, cleaner.add, cleaner.add_frame)
        yield from cleaned()
    cleaner.end()
    yield from cleaned()


def pack(frames: Iterable[Any], path: Union[str, os.PathLike[str]], *, fps: float = 30.0,
         name: str = "", up: str = "y", replace: bool = False, segment: int = 30,
         codec: str = "octree", depth: Optional[int] = None, voxel: Optional[float] = None,
         delta: Optional[float] = None, color_quality: Optional[int] = None,
         normal_quality: Optional[int] = None, fast: bool = False,
         scalar_steps: Optional[Mapping[str, float]] = None) -> int:
    """Writes a package, which players and servers take, and returns how many frames it has.

    frames: for each frame its positions, (positions, colors), (positions, colors, normals),
    `Points`, a dict with the same names, a `Frame`, or anything with points, colors and normals, as
    Open3D's PointCloud. They may come from a generator: only a segment of them is held.

    The package is complete or absent, whatever fails. replace: one that is already there. segment:
    frames that share a file. The rest is as for `encode`. Noisy scans: `pack(clean(frames), path)`.
    """
    encoding = _encoding(codec, depth, voxel, delta, color_quality, normal_quality, fast,
                         scalar_steps)
    writer = _native.Writer(os.fspath(path), name, fps, up, replace, segment, encoding)
    count = 0
    for item in frames:
        _give(item, writer.add, writer.add_frame)
        count += 1
    writer.finish()
    return count


class Publisher:
    """A live stream that this program publishes."""

    def __init__(self, native: _native.Publisher):
        self._native: Optional[_native.Publisher] = native
        self._last: Tuple[int, int, str] = (0, 0, "")

    def send(self, frame: Any) -> None:
        """Encodes a frame, which is whatever `pack` takes, and hands it to a thread that sends it.
        Its `time`, if it has one, is the Unix time of its capture. Where the link is too slow,
        frames are left out."""
        if self._native is None:
            raise ValueError("the stream is closed")
        _give(frame, self._native.send, self._native.send_frame)

    @property
    def sent(self) -> int:
        """How many frames were given."""
        return self._state()[0]

    @property
    def accepted(self) -> int:
        """How many of them the server has accepted; after `close`, in all."""
        return self._state()[1]

    @property
    def trouble(self) -> str:
        """Why nothing can be sent at present, or an empty text."""
        return self._state()[2]

    def close(self) -> None:
        """Gives what was sent last some time to arrive, and ends the stream. An `Error` if the
        server has accepted none of the frames."""
        self._end()
        sent, accepted, trouble = self._last
        if sent > 0 and accepted == 0:
            raise _error("nothing arrived at the server" + (f"; {trouble}" if trouble else ""),
                         "io")

    def _state(self) -> Tuple[int, int, str]:
        native = self._native
        return self._last if native is None else (native.sent(), native.accepted(), native.trouble())

    def _end(self) -> None:
        if self._native is not None:
            self._native.flush()
            self._last = self._state()
            self._native = None

    def __enter__(self) -> Publisher:
        return self

    def __exit__(self, error: Any, *_: Any) -> None:
        if error is None:
            self.close()
        else:
            self._end()


def publish(url: str, *, token: str = "", ca_file: str = "", name: str = "", fps: float = 30.0,
            up: str = "y", codec: str = "octree", depth: Optional[int] = None,
            voxel: Optional[float] = None, delta: Optional[float] = None,
            color_quality: Optional[int] = None, normal_quality: Optional[int] = None,
            fast: bool = True, scalar_steps: Optional[Mapping[str, float]] = None) -> Publisher:
    """Publishes frames as they come: `with pointreel.publish(url) as stream: stream.send(frame)`.

    url: ws(s)://HOST/live/NAME on a server that was started with --live. token: the server's for
    publishers. fps: the nominal frame rate. A lost connection is restored. The rest is as for
    `encode`, but octrees are `fast` by default.
    """
    encoding = _encoding(codec, depth, voxel, delta, color_quality, normal_quality,
                         fast and codec == "octree", scalar_steps)
    return Publisher(_native.Publisher(url, token, ca_file, name, fps, up, encoding))


def render(frame: Any, *, size: Tuple[int, int] = (1280, 720), mode: str = "surfel",
           view: Optional[Tuple[float, float]] = None, zoom: float = 1.0, up: str = "y",
           bounds: Any = None, target: Optional[Tuple[float, float, float]] = None,
           color: str = "colors", light: str = "flat",
           background: Tuple[float, float, float] = (0.11, 0.12, 0.14)) -> NDArray[np.uint8]:
    """Draws a frame without a display or a graphics card: uint8, height x width x 3, sRGB.

    frame: a `Frame`, or whatever `pack` takes. mode: surfel, voxel, point or strip. view: yaw and
    pitch of the camera in degrees, (0, 0) from the front; by default slightly from above. bounds:
    what the picture shows, 2 x 3; give `reel.bounds` to draw several frames alike. target: what the
    camera looks at, by default the middle of that. up: the axis that points up, as `reel.up`.
    color: colors, normals, plain, curvature, accessibility, depth, contours, or the name of a scalar
    field. light: flat, studio or none.
    """
    if not isinstance(frame, Frame):
        frame = _native.frame(*_arrays(_points_of(frame)))
    if bounds is not None:
        bounds = np.asarray(bounds, dtype=np.float64).tolist()
    return _native.picture(frame, operator.index(size[0]), operator.index(size[1]), mode,
                           None if view is None else list(map(float, view)), zoom, up, bounds,
                           list(map(float, background)), color, light,
                           None if target is None else list(map(float, target)))
