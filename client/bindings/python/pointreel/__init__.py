"""Point clouds that move: reels, live streams, and encoded frames, as arrays of numpy.

    import pointreel

    reel = pointreel.open("http://127.0.0.1:8090/REEL")  # or a folder
    frame = reel[10]
    frame.positions  # float32, n x 3, without a copy
    for frame in reel[20:40]:  # the next frames are decoded meanwhile
        ...

All functions raise `pointreel.Error` if something fails, whose member `code` tells what kind of
failure it was, such as "argument" for a value out of range, and TypeError or ValueError for
arguments of the wrong type or shape. What is left out or guessed is a warning (`warnings.warn`).
They let other threads run while they fetch, decode or encode. Ctrl-C ends them.
"""

from __future__ import annotations

import collections
import json
import operator
import os
from typing import (Any, Deque, Dict, Generic, Iterable, Iterator, Mapping, Optional, Sequence,
                    Tuple, TypeVar, Union, overload)

import numpy as np
from numpy.typing import NDArray

from . import _native
from ._arguments import (_Axis, _check, _check_counts, _check_numbers, _check_texts, _color, _error,
                         _index, _named, _path, _Rate, _Steps, _up_of, _vector, _warn)
from ._native import Error, Frame, __version__
from ._points import Points, _arrays, _at_frame, _check_frames, _give, _points_of

__all__ = ["Error", "Frame", "Frames", "Points", "Reel", "Live", "Publisher", "open", "live",
           "encode", "decode", "clean", "pack", "publish", "render", "__version__"]


_EARLIEST = 1e9
"""Times from here on, in 2001, are Unix times."""


def _tell(native: Union[_native.Reel, _native.Writer]) -> None:
    for line in native.said():
        _warn(line)


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
        return self._reel.read(self._indices[_index(index, len(self))])

    def __iter__(self) -> Iterator[Frame]:
        return self._reel._ahead(self._indices)

    @property
    def fps(self) -> float:
        """The nominal frame rate; `times` of the reel are authoritative."""
        return self._reel.fps

    @property
    def up(self) -> str:
        """The axis that points up: x, -x, y, -y, z or -z."""
        return self._reel.up

    @property
    def captured(self) -> Optional[float]:
        """Unix time at which the first of them was captured, where it is known."""
        captured, start = self._reel.captured, _start_of(self)
        return None if captured is None or start is None else captured + start

    def __repr__(self) -> str:
        return f"<{len(self)} frames of {self._reel!r}>"


_Native = TypeVar("_Native", _native.Reel, _native.Live)
_Self = TypeVar("_Self", bound="_Source[Any]")


class _Source(Generic[_Native]):
    """What frames come from until it is closed."""

    _kind = ""

    def __init__(self, native: _Native, layers: Optional[int], max_memory: Optional[int]):
        self._native: Optional[_Native] = native
        self._layers, self._max_memory = layers, max_memory

    @property
    def trouble(self) -> str:
        """Why nothing comes over the network at present, or an empty text. For other threads."""
        return self._opened().trouble()

    def close(self) -> None:
        """Gives back files and connections. Frames that were read stay."""
        self._native = None

    def __enter__(self: _Self) -> _Self:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def _opened(self) -> _Native:
        if self._native is None:
            raise ValueError(f"the {self._kind} is closed")
        return self._native


class Reel(_Source[_native.Reel], Frames):
    """A sequence of frames: `reel[10]`, `reel[-1]`, `reel[::5]`, `for frame in reel`."""

    _kind = "reel"

    def __init__(self, native: _native.Reel, layers: Optional[int], max_memory: Optional[int],
                 ahead: int):
        _Source.__init__(self, native, layers, max_memory)
        Frames.__init__(self, self, range(len(native)))
        self._ahead_frames = ahead
        self._metadata: Dict[str, Any] = json.loads(native.metadata())
        self._times, self._bounds = native.times(), native.bounds()
        _tell(native)

    @property
    def metadata(self) -> Dict[str, Any]:
        """What the package's reel.json says."""
        return self._metadata

    @property
    def times(self) -> NDArray[np.float64]:
        """When each frame is shown: seconds from the reel's start."""
        return self._times

    @property
    def bounds(self) -> Optional[NDArray[np.float64]]:
        """The smallest and the largest coordinates of all frames, 2 x 3."""
        return self._bounds

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
    def captured(self) -> Optional[float]:
        """Unix time at which the first frame was captured, where it is known."""
        captured = self.metadata.get("captured_us")
        return None if captured is None else float(captured) / 1e6

    def read(self, index: int, layers: Optional[int] = None) -> Frame:
        """A frame, of its first `layers` layers if that is given."""
        _check_counts(layers=layers)
        frame = self._opened().read(_index(index, len(self)),
                                    self._layers if layers is None else layers, self._max_memory)
        _tell(self._opened())
        return frame

    def _ahead(self, indices: range) -> Iterator[Frame]:
        frames = self._opened().read_ahead(list(indices), self._layers, self._max_memory,
                                           self._ahead_frames)
        return _Told(frames, self)

    def __repr__(self) -> str:
        return f"<pointreel.Reel {self.name!r} of {len(self)} frames>"


class _Told(Iterator[Frame]):
    """Frames of a reel, with the warnings about them. Threads may share it."""

    def __init__(self, frames: _native.ReadAhead, reel: Reel):
        self._frames, self._reel = frames, reel

    def __next__(self) -> Frame:
        frame = next(self._frames)
        if self._reel._native is not None:
            _tell(self._reel._native)
        return frame


def open(where: Union[str, os.PathLike[str]], *, layers: Optional[int] = None, ahead: int = 3,
         fps: Optional[float] = None, topic: str = "", token: str = "", ca_file: str = "",
         follow_redirects: bool = False, max_memory: Optional[int] = None,
         columns: Union[str, Sequence[str]] = "", color_max: Optional[float] = None,
         scale: float = 1.0, rotate: Tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Reel:
    """Opens a package (its folder, its reel.json, or an http://, https:// or s3:// address of
    either), a folder of files of points (PLY, Draco, PCD, LAS, text, numpy, OBJ, glTF, KITTI,
    nuScenes), one such file, an MCAP recording of ROS 2, or depth: a folder with depth/*.png, or
    .mkv. `with pointreel.open(...) as reel:` closes it.

    layers: fetch and decode the first layers of each frame only. ahead: how many frames iteration
    decodes ahead. fps: of folders of files, which do not tell it; 30, or the times of a recording.
    topic: of a recording that has several. token: bearer token for the server. ca_file:
    certificates to trust for https, in PEM form. max_memory: bytes that decoding a frame may take,
    1 GiB by default. Of files: columns, what the columns of text or of .bin files are, as in
    "x,y,z,intensity"; color_max, what stands for full brightness, 1, 255 or 65535; scale, by which
    coordinates are multiplied; rotate, degrees about the axes x, then y, then z.
    """
    _check_texts(topic=topic, token=token, ca_file=ca_file)
    _check_numbers(fps=fps, color_max=color_max, scale=scale)
    _check_counts(layers=layers, max_memory=max_memory)
    _check((int, np.integer), "a whole number", ahead=ahead)
    if ahead < 0:
        raise ValueError("ahead is at least 0")
    names = columns.split(",") if isinstance(columns, str) else columns
    _check(str, "the name of a column", **{f"columns[{i}]": name for i, name in enumerate(names)})
    files = _native.FileOptions(fps, topic, ["_" if name.strip() == "-" else name.strip()
                                             for name in names if name.strip()],
                                color_max or 0.0, scale, _vector(rotate, "rotate"))
    native = _native.Reel(_path(where), files, token, ca_file, bool(follow_redirects))
    return Reel(native, layers, max_memory, ahead)


class Live(_Source[_native.Live], Iterator[Frame]):
    """Frames of a live stream as they come; it never ends by itself."""

    _kind = "stream"

    def __init__(self, native: _native.Live, timeout: Optional[float], layers: Optional[int],
                 max_memory: Optional[int]):
        super().__init__(native, layers, max_memory)
        self._timeout = timeout

    def __next__(self) -> Frame:
        frame = self.next(self._timeout)
        if frame is None:
            raise TimeoutError(self.trouble or f"no frame has come for {self._timeout} s")
        return frame

    def next(self, timeout: Optional[float] = None) -> Optional[Frame]:
        """The newest frame that was not given yet; None if there is none within `timeout` seconds.
        A frame whose finest layers come late is given again."""
        _check_numbers(timeout=timeout)
        return self._opened().next(timeout, self._layers, self._max_memory)


def live(url: str, *, timeout: Optional[float] = None, layers: Optional[int] = None,
         token: str = "", ca_file: str = "", follow_redirects: bool = False,
         max_memory: Optional[int] = None) -> Live:
    """Watches ws(s)://HOST/live/NAME, or http(s):// where only that passes: `for frame in
    pointreel.live(url)`. Older frames are skipped where the program is too slow for all. A broken
    connection is made again.

    timeout: seconds without a frame after which iteration raises TimeoutError; without it, it
    waits.
    """
    _check_texts(url=url, token=token, ca_file=ca_file)
    _check_numbers(timeout=timeout)
    _check_counts(layers=layers, max_memory=max_memory)
    return Live(_native.Live(url, token, ca_file, bool(follow_redirects)), timeout, layers,
                max_memory)


def _encoding(codec: str, depth: Optional[int], voxel: Optional[float], delta: Optional[float],
              color_quality: Optional[int], normal_quality: Optional[int], fast: bool,
              scalar_steps: Optional[Mapping[str, float]]) -> _native.Encoding:
    def number(name: str, value: Any, kind: Any) -> Any:  # 0: the default
        if value is None:
            return 0
        if value == 0:
            raise _error(f"{name} must be above 0", "argument")
        return kind(value)

    _check_texts(codec=codec)
    _check_numbers(voxel=voxel, delta=delta)
    steps = dict(scalar_steps or {})
    _check_texts(**{f"the name of scalar_steps {i}": name for i, name in enumerate(steps)})
    _check_numbers(**{f"scalar_steps[{name!r}]": step for name, step in steps.items()})
    return _native.Encoding(codec, number("depth", depth, operator.index),
                            number("voxel", voxel, float),
                            number("color_quality", color_quality, operator.index),
                            number("normal_quality", normal_quality, operator.index), bool(fast),
                            number("delta", delta, float), steps)


def encode(positions: Any, colors: Any = None, normals: Any = None, *,
           origin: Tuple[float, float, float] = (0.0, 0.0, 0.0), codec: str = "octree",
           depth: Optional[int] = None, voxel: Optional[float] = None,
           delta: Optional[float] = None, color_quality: Optional[int] = None,
           normal_quality: Optional[int] = None, fast: bool = False,
           scalars: Optional[Mapping[str, Any]] = None,
           scalar_steps: Optional[Mapping[str, float]] = None) -> bytes:
    """Encodes a single frame; `decode` reads it. The arrays are those of `Points`; in place of
    positions, it may be a whole frame, as `pack` takes it.

    codec: octree or draco. depth: levels of the octree, or bits of Draco's positions. voxel: the
    edge of a voxel instead. delta: instead of both, the share of the points, 0.05 by default, that
    may fall into the voxel of another. color_quality, normal_quality: of octrees, 1 to 100, at which
    colours are lossless. fast: an octree that decodes in half the time and is 25 % larger.
    scalar_steps: of scalar fields by name, in what steps their values are kept; by default exactly,
    or in 255 steps.
    """
    encoding = _encoding(codec, depth, voxel, delta, color_quality, normal_quality, fast,
                         scalar_steps)
    if isinstance(positions, (Frame, Points, dict)):
        if colors is not None or normals is not None or scalars is not None:
            raise ValueError("colors, normals and scalars are those of the frame")
        arrays = _arrays(_points_of(positions))
    else:
        arrays = _arrays(Points(positions, colors, normals, origin, scalars=scalars))
    steps = _Steps(codec, scalar_steps)
    steps.see(arrays[-1])
    steps.end()
    return _native.encode(*arrays, encoding)


def decode(data: Any, *, layers: Optional[int] = None, max_memory: Optional[int] = None) -> Frame:
    """Decodes what `encode` made, or a whole file of points that is recognised by its first bytes.
    `data`: bytes, or anything with a buffer. `layers` and `max_memory` as for `open`."""
    _check_counts(layers=layers, max_memory=max_memory)
    try:
        data = memoryview(data)
    except TypeError:
        raise TypeError(f"data is bytes, not {type(data).__name__}") from None
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
    _check_frames(frames, "clean")
    _check_numbers(radius=radius)
    _check((int, np.integer), "a whole number", before=before, after=after)
    return _Cleaned(frames, _native.Cleaner(radius, before, after))


class _Cleaned(Iterator[Points]):
    """Cleaned frames, with what `pack` takes from a reel."""

    def __init__(self, frames: Iterable[Any], cleaner: _native.Cleaner):
        for name in ("fps", "up", "captured"):
            if hasattr(frames, name):
                setattr(self, name, getattr(frames, name))
        self._points = self._clean(frames, cleaner)

    def __next__(self) -> Points:
        return next(self._points)

    @staticmethod
    def _clean(frames: Iterable[Any], cleaner: _native.Cleaner) -> Iterator[Points]:
        known: Deque[Tuple[Optional[float], Optional[str]]] = collections.deque()
        start = _start_of(frames)

        def cleaned() -> Iterator[Points]:
            while True:
                frame = cleaner.next()
                if frame is None:
                    return
                time, up = known.popleft()
                yield _points_of(frame)._replace(time=time, up=up)

        for item in frames:
            if isinstance(item, Frame):
                known.append((None if start is None else item.time - start, item.up))
            else:
                item = _points_of(item)
                known.append((item.time, item.up))
            _give(item, cleaner.add, cleaner.add_frame)
            yield from cleaned()
        cleaner.end()
        yield from cleaned()


def _start_of(frames: Iterable[Any]) -> Optional[float]:
    """When the first frame of a reel, or of a part of it, is shown; None if the frames are of
    something else, or not in the order of their times."""
    if isinstance(frames, Frames) and len(frames) > 0 and frames._indices.step > 0:
        return float(frames._reel.times[frames._indices[0]])
    return None


def pack(frames: Iterable[Any], path: Union[str, os.PathLike[str]], *, fps: Optional[float] = None,
         name: str = "", up: Optional[str] = None, replace: bool = False,
         segment: Optional[int] = None, codec: str = "octree", depth: Optional[int] = None,
         voxel: Optional[float] = None, delta: Optional[float] = None,
         color_quality: Optional[int] = None, normal_quality: Optional[int] = None,
         fast: bool = False, scalar_steps: Optional[Mapping[str, float]] = None,
         bitrate: Union[float, str, None] = None, group: Optional[int] = None,
         effort: Optional[int] = None, cube: str = "group", normals: str = "send",
         best_effort: bool = False) -> int:
    """Writes a package, which players and servers take, and returns how many frames it has.

    frames: for each frame its positions, (positions, colors), (positions, colors, normals),
    `Points`, a dict with the same names, a `Frame`, or anything with points, colors and normals, as
    Open3D's PointCloud. They may come from a generator: only a segment of them is held. Of a reel, a
    part of it, or `clean` of these, times, `fps`, `up` and `captured` are kept; of a list of its
    frames, `up` alone. fps: by default that of the reel, or 30. up: the axis that points up, by
    default that of the reel, or y.

    The package is complete or absent, whatever fails. replace: one that is already there. segment:
    frames that share a cube and a file, 30, or of video 48. cube: "group", or "frame" for a cube of
    its own for each frame. bitrate: bits per second, as a number or as in "20M", that no segment
    exceeds on average; depth and qualities are lowered for this. normals: "send" those that frames
    have; "estimate" those that they lack, too; "auto" does so where it pays, by the first frame;
    "derive": send none, and let players estimate them. best_effort: warn instead of
    failing, leave out stray points, and pack what lies too far apart or exceeds the bit rate.

    codec: octree, draco, or video, which takes a fraction of the bits for dense, clean surfaces
    that move. Of video, color_quality is that of depth, too; group: frames that are decoded
    together, 24, up to 64; effort: from 0, the fastest, to 9, the smallest, by default 4. The rest
    is as for `encode`. Noisy scans: `pack(clean(frames), path)`.
    """
    encoding = _encoding(codec, depth, voxel, delta, color_quality, normal_quality, fast,
                         scalar_steps)
    _check_frames(frames, "pack", ", path")
    rate = None if fps is not None or hasattr(frames, "fps") else _Rate(30.0)
    fps = getattr(frames, "fps", 30.0) if fps is None else fps
    axis = _Axis(up, _up_of(frames))
    up = axis.up
    _check_texts(name=name, up=up, cube=cube, normals=normals)
    _check_numbers(fps=fps)
    _check_counts(segment=segment, group=group)
    _check((int, np.integer), "a whole number", effort=4 if effort is None else effort)
    if bitrate is not None and not isinstance(bitrate, str):
        _check_numbers(bitrate=bitrate)
        bitrate = repr(float(bitrate))
    packing = _native.Packing(encoding, bitrate, segment, group, effort, cube, normals,
                              bool(best_effort))
    writer = _native.Writer(_path(path), name, fps, up, bool(replace), packing)
    start, unix_start = _start_of(frames), None
    captured = getattr(frames, "captured", None)
    count = 0
    for item in frames:
        time = None
        axis.see(item)
        with _at_frame(count):
            if isinstance(item, Frame):
                time = None if start is None else item.time - start
                if rate is not None:
                    rate.see(item)
            else:
                item = _points_of(item)
                if count == 0 and item.time is not None and item.time >= _EARLIEST:
                    captured = unix_start = item.time
                if unix_start is not None and item.time is not None:
                    item = item._replace(time=item.time - unix_start)
            _give(item, writer.add, writer.add_frame, time)
        _tell(writer)
        count += 1
    if captured is not None:
        writer.captured(captured)
    writer.finish()
    _tell(writer)
    return count


class Publisher:
    """A live stream that this program publishes."""

    def __init__(self, native: _native.Publisher, steps: _Steps, axis: _Axis):
        self._native: Optional[_native.Publisher] = native
        self._steps, self._axis = steps, axis
        self._last: Tuple[int, int, str] = (0, 0, "")
        self._time_told = False

    def send(self, frame: Any) -> None:
        """Encodes a frame, which is whatever `pack` takes, and hands it to a thread that sends it.
        The `time` of `Points` is the Unix time of their capture; other times, as of cleaned frames of
        a reel, are left out. Where the link is too slow, frames are left out. Several threads may
        send, one after another."""
        if self._native is None:
            raise ValueError("the stream is closed")
        if not isinstance(frame, Frame):
            frame = _points_of(frame)
            if frame.time is not None and frame.time < _EARLIEST:
                frame = frame._replace(time=None)
                if not self._time_told:
                    self._time_told = True
                    _warn("times before 2001 are no times of capture, and are left out")
        self._axis.see(frame)
        self._steps.see(_give(frame, self._native.send, self._native.send_frame))

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
            if self._last[0] > 0:
                self._steps.end()

    def __enter__(self) -> Publisher:
        return self

    def __exit__(self, error: Any, *_: Any) -> None:
        if error is None:
            self.close()
        else:
            self._end()


def publish(url: str, *, token: str = "", ca_file: str = "", name: str = "", fps: float = 30.0,
            up: Optional[str] = None, codec: str = "octree", depth: Optional[int] = None,
            voxel: Optional[float] = None, delta: Optional[float] = None,
            color_quality: Optional[int] = None, normal_quality: Optional[int] = None,
            fast: bool = True, scalar_steps: Optional[Mapping[str, float]] = None) -> Publisher:
    """Publishes frames as they come: `with pointreel.publish(url) as stream: stream.send(frame)`.

    url: ws(s)://HOST/live/NAME on a server that was started with --live. token: the server's for
    publishers. fps: the nominal frame rate; each frame leaves when `send` is called. up: the axis
    that points up, by default y. A lost connection is restored, and a program that was killed and
    started again by the same user takes the name back at once. The rest is as for `encode`, but
    octrees are `fast` by default.
    """
    encoding = _encoding(codec, depth, voxel, delta, color_quality, normal_quality,
                         fast and codec == "octree", scalar_steps)
    axis = _Axis(up)
    _check_texts(url=url, token=token, ca_file=ca_file, name=name, up=axis.up)
    _check((int, float, np.integer, np.floating), "a number", fps=fps)
    _check_numbers(fps=fps)
    return Publisher(_native.Publisher(url, token, ca_file, name, fps, axis.up, encoding),
                     _Steps(codec, scalar_steps), axis)


def render(frame: Any, *, size: Tuple[int, int] = (1280, 720), mode: str = "surfel",
           view: Union[str, Tuple[float, float], None] = None, zoom: float = 1.0,
           up: Optional[str] = None, bounds: Any = None,
           target: Union[str, Tuple[float, float, float], None] = None,
           color: str = "colors", color_range: Optional[Tuple[float, float]] = None,
           light: str = "flat",
           background: Union[str, Tuple[float, float, float]] = (0.11, 0.12, 0.14)
           ) -> NDArray[np.uint8]:
    """Draws a frame without a display or a graphics card: uint8, height x width x 3, sRGB.

    frame: a `Frame`, or whatever `pack` takes. mode: surfel, voxel, point or strip. view: front,
    back, left, right, top or bottom, or yaw and pitch of the camera in degrees, (0, 0) from the
    front; by default slightly from above. bounds: what the picture shows, 2 x 3; give `reel.bounds`
    to draw several frames alike. target: what the camera looks at, a point, or feet, middle or head;
    by default the middle of `bounds`. up: the axis that points up, by default that of the
    frame, or y. color: colors, normals, plain, curvature, accessibility, depth, contours, or the name
    of a scalar field; color_range: the values at the ends of its ramp, by default those of the reel,
    or of the frame. light: flat, studio or none. background: three numbers from 0 to 1, or "#rrggbb".
    """
    if isinstance(frame, (Frames, Live)):
        raise TypeError(f"frame is a single frame, such as reel[0], not {type(frame).__name__}")
    up = up or _up_of(frame) or "y"
    _check_texts(mode=mode, up=up, color=color, light=light)
    _check_numbers(zoom=zoom)
    height = None
    if isinstance(target, str):
        height, target = _named("target", target, _native.heights), None
    color_behind = _vector(_color(background) if isinstance(background, str) else background,
                           "background")
    if not all(0.0 <= part <= 1.0 for part in color_behind):
        raise ValueError("background is three numbers from 0 to 1, or a text such as #ffffff")
    try:
        width, rows = map(operator.index, size)
    except (TypeError, ValueError):
        raise ValueError("size is the width and the height in pixels, as whole numbers") from None
    _check_counts(width=width, height=rows)
    angles = None
    if view is not None:
        angles = tuple(map(float, _named("view", view, _native.views) if isinstance(view, str) else view))
        if len(angles) != 2:
            raise ValueError("view is yaw and pitch in degrees, or one of " + ", ".join(_native.views))
    if not isinstance(frame, Frame):
        frame = _native.frame(*_arrays(_points_of(frame)))
    if color_range is not None:
        try:
            least, most = map(float, color_range)
        except (TypeError, ValueError):
            raise ValueError("color_range is two numbers") from None
        color_range = least, most
    if bounds is not None:
        bounds = np.asarray(bounds, dtype=np.float64)
        if bounds.shape != (2, 3):
            raise ValueError(f"bounds has the shape {bounds.shape}, not 2 x 3")
        bounds = bounds.tolist()
    return _native.picture(frame, width, rows, mode, angles, zoom, up, bounds, color_behind, color,
                           light, None if target is None else _vector(target, "target"), height,
                           color_range)
