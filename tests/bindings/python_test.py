"""The Python module, as a program in Python uses it.

    python_test.py SERVER [TEST...]

SERVER is the program pointreel-server. PYTHONPATH has the module.
"""

import ast
import copy
import gc
import os
import pathlib
import random
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest

import numpy as np

import pointreel

SERVER = None
POINTS = 3000


def ball(frame=0, points=POINTS):
    """Positions on a sphere that grows, with colours and normals."""
    i = np.arange(points)
    z = 1.0 - (2.0 * i + 1.0) / points
    r, angle = np.sqrt(1.0 - z * z), 2.399963229728653 * i
    normals = np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)
    colors = np.stack([i % 256, i // 2 % 256, i // 4 % 256], axis=1).astype(np.uint8)
    return ((1.0 + 0.1 * frame) * normals).astype(np.float32), colors, normals.astype(np.float32)


def lattice():
    """Points that decode to themselves."""
    i = np.arange(1000)
    return np.stack([i % 10, i // 10 % 10, i // 100], axis=1).astype(np.float32)


def rows(array):
    return sorted(map(tuple, np.asarray(array).tolist()))


def address(array):
    return array.__array_interface__["data"][0]


class TemporaryFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)


class Codec(unittest.TestCase):
    def test_a_lattice_comes_back_exactly_with_its_colors(self):
        positions = lattice()
        colors = (positions * 25).astype(np.uint8)
        data = pointreel.encode(positions, colors, origin=(100.0, 0.0, -5.0), color_quality=100)
        frame = pointreel.decode(data)
        self.assertEqual(len(frame), 1000)
        self.assertEqual(rows(frame.world), rows(positions + np.array([100.0, 0.0, -5.0])))
        source = np.rint(frame.world - [100.0, 0.0, -5.0]).astype(int)
        np.testing.assert_array_equal(frame.colors8, source * 25)
        np.testing.assert_array_equal(frame.colors, source * 25 * 257)
        self.assertIsNone(frame.normals)

    def test_doubles_far_from_zero_keep_their_precision(self):
        positions = 1e-3 * lattice().astype(np.float64) + [4e6, 5e5, 100.0]
        frame = pointreel.decode(pointreel.encode(positions))
        np.testing.assert_allclose(np.sort(frame.world, axis=0), np.sort(positions, axis=0),
                                   atol=1e-4)
        self.assertLess(np.abs(frame.positions).max(), 1.0)

    def test_points_that_floats_cannot_hold_do_not_move_the_others(self):
        positions = np.random.default_rng(1).random((1000, 3)) + [500000, 5400000, 100]
        positions[::7] = [1e39, 0, 0]
        positions[1::7] = np.nan
        frame = pointreel.decode(pointreel.encode(positions))
        kept = positions[np.arange(1000) % 7 > 1]
        np.testing.assert_allclose(np.sort(frame.world, axis=0), np.sort(kept, axis=0), atol=0.01)

    def test_a_cloud_that_would_collapse_is_an_error_that_names_the_point(self):
        near = np.random.default_rng(1).random((1000, 3)) + [500000, 5400000, 100]
        a_third, single = near.copy(), near.copy()
        a_third[::3] = 0
        single[5] = [1e30, 0, 0]
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = os.path.join(folder.name, "far.reel")
        for far, named in ((a_third, "the point at 0 0 0"), (single, "the point at 1e+30 0 0")):
            with self.assertRaisesRegex(pointreel.Error, re.escape(named)):
                pointreel.encode(far)
            with self.assertRaisesRegex(pointreel.Error, "frame 0: .*" + re.escape(named)):
                pointreel.pack([far], path)
        single[5] = [1e12, 0, 0]
        with self.assertRaisesRegex(pointreel.Error, r"^frame 1: the point at 1e\+12 .*\(frame 0: "):
            pointreel.pack([near, single], path)
        with self.assertRaisesRegex(pointreel.Error, "let fewer frames share a segment"):
            pointreel.pack([near, near + 1e7], path)
        self.assertEqual(pointreel.pack([near, near + 1e7], path, segment=1), 2)

    def test_colors_may_be_floats_and_arrays_may_have_gaps(self):
        positions, colors, normals = ball()
        data = pointreel.encode(positions[::-1][::2], colors[::-1][::2] / 255.0,
                                np.asfortranarray(normals)[::-1][::2], color_quality=100)
        same = pointreel.encode(positions[1::2], colors[1::2].astype(np.uint16) * 257,
                                normals[1::2].astype(np.float64), color_quality=100)
        self.assertEqual(data, same)

    def test_scalar_fields_come_back_by_name(self):
        positions, colors, _ = ball()
        heat = positions[:, 1].astype(np.float64)
        kind = np.where(heat > 0, 2, 7)
        patchy = np.where(heat > 0, heat, np.nan)
        frame = pointreel.decode(pointreel.encode(
            positions, depth=14, scalars={"heat": heat, "class": kind, "patchy": patchy}))
        self.assertEqual(list(frame.scalars), ["heat", "class", "patchy"])
        height = frame.positions[:, 1] + frame.origin[1]
        for values in frame.scalars.values():
            self.assertEqual((values.dtype, values.shape), (np.float32, (len(frame),)))
            self.assertFalse(values.flags.writeable)
        self.assertLess(np.abs(frame.scalars["heat"] - height).max(), np.ptp(heat) / 255)
        sure = np.abs(height) > 0.01
        np.testing.assert_array_equal(frame.scalars["class"][sure],
                                      np.where(height > 0, 2, 7)[sure])
        np.testing.assert_array_equal(np.isnan(frame.scalars["patchy"])[sure],
                                      (height < 0)[sure])
        self.assertEqual(pointreel.decode(pointreel.encode(positions, colors)).scalars, {})
        with self.assertRaises(pointreel.Error):
            pointreel.encode(positions, scalars={"short": [1.0, 2.0]})
        with self.assertRaises(pointreel.Error):
            pointreel.encode(positions, scalars={"": heat})
        with self.assertRaises(ValueError):
            pointreel.encode(positions, scalars={"words": ["a"] * len(heat)})

    def test_scalar_fields_are_packed(self):
        positions, colors, _ = ball()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = os.path.join(folder.name, "scalars.reel")
        points = pointreel.Points(positions, colors, scalars={"height": positions[:, 1]})
        pointreel.pack([points, pointreel.decode(pointreel.encode(
            positions, scalars={"height": positions[:, 1]}))], path)
        reel = pointreel.open(path)
        self.assertEqual([field["name"] for field in reel.metadata["scalars"]], ["height"])
        for frame in reel:
            self.assertEqual(frame.scalars["height"].shape, (len(frame),))

    def test_the_size_of_voxels_follows_delta_and_that_of_steps_what_is_given(self):
        positions, _, _ = ball(points=100_000)
        height = {"height": positions[:, 2]}
        counts = [len(pointreel.decode(pointreel.encode(positions, delta=delta)))
                  for delta in (0.01, 0.5)]
        self.assertGreaterEqual(counts[0], 99_000)
        self.assertLess(counts[1], 90_000)
        for step in (0.5, 0.001):
            frame = pointreel.decode(pointreel.encode(positions, scalars=height,
                                                      scalar_steps={"height": step}))
            values = frame.scalars["height"] / step
            np.testing.assert_allclose(values, np.rint(values), atol=1e-2)

    def test_draco_and_files_are_decoded(self):
        frame = pointreel.decode(pointreel.encode(lattice(), codec="draco"))
        self.assertEqual(len(frame), 1000)
        ply = (b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
               b"property float z\nend_header\n1 2 3\n4 5 6\n")
        frame = pointreel.decode(memoryview(ply))
        self.assertEqual(rows(frame.world), [(1.0, 2.0, 3.0), (4.0, 5.0, 6.0)])
        self.assertIsNone(frame.colors)

    def test_fewer_layers_are_coarser(self):
        data = pointreel.encode(*ball(points=20000), depth=10)
        self.assertLess(len(pointreel.decode(data, layers=1)), len(pointreel.decode(data)))
        self.assertEqual(pointreel.decode(data, layers=1).layers, 1)

    def test_frames_without_points_are_frames(self):
        frame = pointreel.decode(pointreel.encode(np.zeros((0, 3))))
        self.assertEqual(len(frame), 0)
        self.assertEqual(frame.positions.shape, (0, 3))
        self.assertEqual(len(pointreel.decode(pointreel.encode([[np.nan, 0, 0]]))), 0)

    def test_damaged_bytes_are_errors(self):
        data = pointreel.encode(*ball(points=200))
        for cut in range(0, len(data), 7):
            with self.assertRaises(pointreel.Error) as raised:
                pointreel.decode(data[:cut])
            self.assertEqual(raised.exception.code, "invalid")
        choose = random.Random(1)
        for _ in range(500):
            damaged = bytearray(data)
            damaged[choose.randrange(len(data))] ^= 1 << choose.randrange(8)
            with self.assertRaises(pointreel.Error):
                pointreel.decode(damaged)
        with self.assertRaises(pointreel.Error) as raised:
            pointreel.decode(data, max_memory=100)
        self.assertEqual(raised.exception.code, "limit")
        self.assertIn("max_memory", str(raised.exception))

    def test_wrong_arguments_are_errors(self):
        positions, colors, normals = ball()
        for wrong in ({"codec": "zip"}, {"depth": 30}, {"voxel": -1.0}, {"color_quality": 101},
                      {"depth": 5, "voxel": 0.1}, {"codec": "draco", "fast": True},
                      {"delta": 2.0}, {"delta": 0.1, "depth": 5}, {"scalar_steps": {"a": 0.0}},
                      {"delta": 0}, {"depth": 0}, {"voxel": 0.0}, {"color_quality": 0},
                      {"origin": (np.inf, 0, 0)}):
            with self.assertRaises(pointreel.Error, msg=wrong) as raised:
                pointreel.encode(positions, **wrong)
            self.assertEqual(raised.exception.code, "argument")
        with self.assertRaises(pointreel.Error):
            pointreel.encode(positions, colors[1:])
        with self.assertRaisesRegex(ValueError, "from 0 to 1, and there is a 2"):
            pointreel.encode(positions, np.full_like(positions, 2.0))
        with self.assertRaisesRegex(TypeError, "as an integer"):
            pointreel.encode(positions, depth=9.5)
        for wrong in (positions[:, :2], positions.ravel(), "text", [[None] * 3]):
            with self.assertRaises((ValueError, TypeError)):
                pointreel.encode(wrong)
        with self.assertRaises(ValueError):
            pointreel.encode(positions, colors.astype(np.int32))
        with self.assertRaises(TypeError):
            pointreel.decode("text")


class Arrays(unittest.TestCase):
    def test_arrays_are_the_frames_own_memory_and_keep_it(self):
        frame = pointreel.decode(pointreel.encode(*ball()))
        for name in ("positions", "colors", "normals"):
            array = getattr(frame, name)
            self.assertEqual(address(array), address(getattr(frame, name)), name)
            self.assertFalse(array.flags.owndata or array.flags.writeable, name)
            self.assertTrue(array.flags.c_contiguous, name)
        positions, before = frame.positions, frame.positions.copy()
        del frame
        gc.collect()
        others = [pointreel.decode(pointreel.encode(*ball(i))) for i in range(20)]
        np.testing.assert_array_equal(positions, before)
        self.assertEqual(len(others), 20)

    def test_frames_are_made_by_the_module_only(self):
        frame = pointreel.decode(pointreel.encode(lattice()))
        derived = type("Derived", (pointreel.Frame,), {})
        for make in (pointreel.Frame, lambda: pointreel.Frame.__new__(pointreel.Frame), derived,
                     lambda: derived.__new__(derived), lambda: object.__new__(pointreel.Frame),
                     lambda: copy.copy(frame)):
            with self.assertRaises(TypeError):
                make()


class Packages(TemporaryFolder):
    def make(self, frames=10, **options):
        path = self.folder / "ball.reel"
        count = pointreel.pack((ball(i) for i in range(frames)), path, fps=10, **options)
        self.assertEqual(count, frames)
        return path

    def test_any_axis_points_up(self):
        for up in ("x", "-x", "y", "-y", "z", "-z"):
            self.assertEqual(pointreel.open(self.make(1, up=up, replace=True)).up, up)
        with self.assertRaises(pointreel.Error):
            self.make(1, up="Y", replace=True)

    def test_a_package_has_what_was_packed(self):
        reel = pointreel.open(self.make(up="z", name="a ball", segment=4))
        self.assertEqual((len(reel), reel.fps, reel.up, reel.name), (10, 10.0, "z", "a ball"))
        self.assertEqual((reel.codec, reel.duration), ("octree", 1.0))
        np.testing.assert_allclose(reel.times, np.arange(10) / 10)
        np.testing.assert_allclose(reel.bounds, [[-1.9] * 3, [1.9] * 3], atol=0.01)
        self.assertEqual(reel.metadata["name"], "a ball")
        for i in (0, 7):
            frame = reel[i]
            self.assertEqual((frame.index, frame.time), (i, i / 10))
            radii = np.linalg.norm(frame.world, axis=1)
            np.testing.assert_allclose(radii, 1.0 + 0.1 * i, atol=0.05)

    def test_indices_and_slices_are_those_of_lists(self):
        reel = pointreel.open(self.make())
        indices = list(range(10))
        for part in (slice(None), slice(2, 5), slice(None, None, -1), slice(8, 2, -3),
                     slice(5, 5), slice(-3, 100)):
            self.assertEqual([frame.index for frame in reel[part]], indices[part], part)
            self.assertEqual(len(reel[part]), len(indices[part]))
        self.assertEqual(reel[-1].index, 9)
        self.assertEqual(reel.read(-2).index, 8)
        self.assertEqual(reel[2:8][1:][::2][-1].index, indices[2:8][1:][::2][-1])
        self.assertEqual([frame.index for frame in reversed(reel[:3])], [2, 1, 0])
        for wrong in (10, -11):
            with self.assertRaises(IndexError):
                reel[wrong]
        with self.assertRaises(TypeError):
            reel["first"]

    def test_iteration_gives_what_indexing_gives(self):
        reel = pointreel.open(self.make(), ahead=1)
        for i, frame in enumerate(reel):
            np.testing.assert_array_equal(frame.positions, reel[i].positions)
        iterator = iter(pointreel.open(self.folder / "ball.reel", ahead=5))
        next(iterator)
        del iterator  # in the middle of reading ahead

    def test_threads_read_one_reel(self):
        reel, seen = pointreel.open(self.make()), []
        threads = [threading.Thread(target=lambda: seen.append(
            [frame.index for frame in reel])) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(seen, [list(range(10))] * 4)

    def test_threads_share_one_iterator(self):
        reel = pointreel.open(self.make())
        for _ in range(20):
            iterator, seen = iter(reel), []

            def take():
                for frame in iterator:
                    seen.append(frame.index)

            threads = [threading.Thread(target=take) for _ in range(4)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            self.assertEqual(sorted(seen), list(range(10)))

    def test_frames_of_all_kinds_are_packed(self):
        positions, colors, normals = ball()
        # As Open3D's PointCloud: vectors of doubles, colours from 0 to 1, empty where absent.
        cloud = types.SimpleNamespace(points=positions.astype(np.float64), colors=colors / 255.0,
                                      normals=np.zeros((0, 3)))
        frame = pointreel.decode(pointreel.encode(positions, colors))
        path = self.folder / "mixed"
        pointreel.pack([positions, (positions, colors), [positions, colors, normals],
                        {"positions": positions, "normals": normals}, cloud, frame,
                        pointreel.Points(positions, time=2.0), positions.tolist()], path)
        reel = pointreel.open(path)
        self.assertEqual([frame.colors is not None for frame in reel],
                         [False, True, True, False, True, True, False, False])
        self.assertEqual([frame.normals is not None for frame in reel],
                         [False, False, True, True, False, False, False, False])
        self.assertEqual(reel.times[6], 2.0)
        self.assertGreater(reel.times[7], 2.0)
        # And back to Open3D's arrays.
        frame = reel[4]
        self.assertEqual(frame.world.dtype, np.float64)
        self.assertLessEqual((frame.colors / 65535.0).max(), 1.0)

    def test_a_package_is_complete_or_absent(self):
        def failing():
            yield ball()
            raise KeyError("the camera was unplugged")

        path = self.folder / "broken"
        with self.assertRaises(KeyError):
            pointreel.pack(failing(), path)
        gc.collect()
        self.assertEqual(list(self.folder.iterdir()), [])
        with self.assertRaises(pointreel.Error):
            pointreel.pack([], path)
        made = self.make(frames=1)
        with self.assertRaises(pointreel.Error) as raised:
            self.make(frames=2)
        self.assertEqual(raised.exception.code, "argument")
        self.make(frames=2, replace=True)
        self.assertEqual(len(pointreel.open(made)), 2)

    def test_a_folder_of_files_is_a_reel(self):
        subprocess.run([SERVER, "unpack", "-i", self.make(), "-o", self.folder / "files"],
                       check=True, stdout=subprocess.DEVNULL)
        reel = pointreel.open(self.folder / "files", fps=5)
        self.assertEqual((len(reel), reel.fps, reel.codec, reel.layers), (10, 5.0, "files", 0))
        self.assertGreater(len(reel[3]), 0)

    def test_a_reel_that_was_cut_from_video_has_the_frames_that_are_shown(self):
        files, whole, cut = (self.folder / name for name in ("files", "whole", "cut"))
        for command in (["unpack", self.make(), files],
                        ["pack", files, whole, "--codec", "video", "--fps", "10", "--group", "8"],
                        ["cut", whole, cut, "--frames", "5-9"]):
            subprocess.run([SERVER, *command], check=True, stdout=subprocess.DEVNULL)
        reel, all_frames = pointreel.open(cut), pointreel.open(whole)
        self.assertGreater(sum(len(segment["times_us"]) for segment in reel.metadata["segments"]), 5)
        self.assertEqual((len(reel), len(all_frames)), (5, 10))
        np.testing.assert_allclose(reel.times, np.arange(5) / 10)
        for i, frame in enumerate(reel):
            self.assertEqual((frame.index, frame.time), (i, i / 10))
            self.assertEqual(rows(frame.world), rows(all_frames[5 + i].world))

    def test_what_is_not_there_is_an_error(self):
        for where, code in (("/nowhere", "not_found"), ("gopher://host/reel", "argument"),
                            (self.folder, "not_found")):
            with self.assertRaises(pointreel.Error) as raised:
                pointreel.open(where)
            self.assertEqual(raised.exception.code, code)
            self.assertIn(str(where), str(raised.exception))

    def test_pictures_show_the_frame(self):
        reel = pointreel.open(self.make(frames=2))
        for mode in ("surfel", "voxel", "point"):
            picture = pointreel.render(reel[0], size=(200, 100), mode=mode, background=(0, 0, 0))
            self.assertEqual((picture.shape, picture.dtype), ((100, 200, 3), np.uint8))
            self.assertEqual(picture[:, :20].max(), 0)
            self.assertGreater((picture[40:60, 90:110].max(axis=2) > 0).mean(), 0.8)
        small = pointreel.render(reel[0], size=(200, 100), bounds=reel.bounds * 3)
        self.assertGreater(np.ptp(picture.astype(int), axis=(0, 1)).max(), 0)
        self.assertLess((small != small[0, 0]).sum(), (picture != picture[0, 0]).sum())
        for wrong in ({"mode": "oil"}, {"size": (0, 5)}, {"size": (1 << 20, 5)}, {"up": "w"},
                      {"zoom": 0.0}, {"view": (0, 100)}, {"color": "taste"}, {"light": "moon"},
                      {"target": (float("nan"), 0, 0)}, {"bounds": reel.bounds[::-1]},
                      {"bounds": reel.bounds * float("nan")}):
            with self.assertRaises(pointreel.Error, msg=wrong):
                pointreel.render(reel[0], **wrong)

    def test_pictures_are_drawn_of_arrays_in_all_ways(self):
        positions, colors, normals = ball()
        height = {"height": positions[:, 2]}
        points = pointreel.Points(positions, colors, normals, scalars=height)
        frame = pointreel.decode(pointreel.encode(*points[:3], scalars=height))
        pictures = set()
        for options in ({}, {"mode": "strip"}, {"color": "height"}, {"color": "normals"},
                        {"color": "plain"}, {"color": "plain", "light": "none"},
                        {"color": "plain", "light": "studio"}, {"target": (0.5, 0.0, 0.0)}):
            of_arrays, of_frame = (pointreel.render(item, size=(64, 64), **options).astype(int)
                                   for item in (points, frame))
            self.assertLess(np.abs(of_arrays - of_frame).mean(), 6.0, options)
            pictures.add(of_arrays.tobytes())
        self.assertEqual(len(pictures), 8, "each way looks different")

    def test_noisy_scans_are_cleaned_with_the_help_of_other_frames(self):
        noise = np.random.default_rng(1)

        def scan(time):
            positions, colors, normals = ball(points=20_000)
            off = noise.normal(scale=0.02, size=(len(positions), 1))
            return pointreel.Points(positions + off * normals, colors, normals, time=time)

        def error(points):
            return np.std(np.linalg.norm(points.positions + np.asarray(points.origin), axis=1))

        scans = [scan(time) for time in (0.0, 0.5, 1.5, 1.75)]
        alone = list(pointreel.clean(scans, before=0, after=0))
        together = list(pointreel.clean(scans))
        self.assertEqual([points.time for points in together], [0.0, 0.5, 1.5, 1.75])
        for one, two in zip(alone, together):
            self.assertLess(error(one), 0.5 * error(scans[0]))
            self.assertLess(error(two), 0.8 * error(one))
        given = []
        live = pointreel.clean((given.append(points) or points for points in scans), after=0)
        next(live)
        self.assertEqual(len(given), 1, "a camera's frame does not wait for the next one")
        self.assertEqual(pointreel.pack(together, self.folder / "reel"), 4)
        np.testing.assert_allclose(pointreel.open(self.folder / "reel").times,
                                   [0.0, 0.5, 1.5, 1.75])
        lattices = list(pointreel.clean([lattice()] * 3))
        self.assertEqual(rows(lattices[1].positions), rows(lattice()), "not a scan")
        for wrong in ({"radius": 0.0}, {"before": 5}):
            with self.assertRaises(pointreel.Error, msg=wrong):
                list(pointreel.clean(scans, **wrong))


class Servers(TemporaryFolder):
    def serve(self, *options):
        """Starts a server; returns its address."""
        server = subprocess.Popen([SERVER, "serve", *options, "--listen", "127.0.0.1:0"],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(server.stdout.close)
        self.addCleanup(server.wait)
        self.addCleanup(server.terminate)
        for line in server.stdout:
            found = re.match(r"listening on http://(\S+)", line)
            if found:
                return found[1]
        self.fail("the server did not start")

    def test_reels_are_read_over_http(self):
        pointreel.pack((ball(i) for i in range(6)), self.folder / "reel")
        address = self.serve(self.folder / "reel")
        remote, local = pointreel.open(f"http://{address}/reel"), pointreel.open(self.folder / "reel")
        self.assertEqual(len(remote), 6)
        np.testing.assert_array_equal(remote[5].positions, local[5].positions)
        for a, b in zip(remote[::2], local[::2]):
            np.testing.assert_array_equal(a.colors, b.colors)
        self.assertEqual(remote.trouble, "")
        with self.assertRaises(pointreel.Error) as raised:
            pointreel.open(f"http://{address}/nothing")
        self.assertEqual(raised.exception.code, "not_found")

    def test_live_streams_are_iterators(self):
        pointreel.pack((ball(i) for i in range(6)), self.folder / "reel")
        subprocess.run([SERVER, "unpack", "-i", self.folder / "reel", "-o", self.folder / "files"],
                       check=True, stdout=subprocess.DEVNULL)
        url = f"ws://{self.serve('--live')}/live/ball"
        self.assertIsNone(pointreel.live(url).next(timeout=0.1))
        publisher = subprocess.Popen(
            [SERVER, "publish", "-i", self.folder / "files", "--loop", "--to", url],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(publisher.wait)
        self.addCleanup(publisher.terminate)
        numbers = []
        for frame in pointreel.live(url, timeout=30):
            self.assertGreater(len(frame), 0)
            self.assertLess(abs(frame.time - time.time()), 60)
            numbers.append(frame.index)
            if len(numbers) == 5:
                break
        self.assertEqual(numbers, sorted(numbers))

    def test_published_frames_arrive(self):
        url = f"ws://{self.serve('--live')}/live/ball"
        viewer, seen = pointreel.live(url), []
        with pointreel.publish(url, fps=10, color_quality=100) as stream:
            deadline = time.time() + 30
            while len(seen) < 5 and time.time() < deadline:
                stream.send(ball(len(seen)))
                stream.send(pointreel.Points(*ball(), time=time.time()))
                stream.send(pointreel.decode(pointreel.encode(*ball())))
                frame = viewer.next(timeout=0.2)
                if frame is not None:
                    seen.append(frame)
            self.assertEqual(len(seen), 5, stream.trouble)
            stream._native.flush()
            self.assertGreaterEqual(stream.sent, 5)
            self.assertGreaterEqual(stream.accepted, 5)
            self.assertEqual(stream.trouble, "")
        self.assertTrue(all(frame.colors is not None and len(frame) > 2000 for frame in seen))
        with self.assertRaises(ValueError):
            stream.send(ball())
        self.assertGreaterEqual(stream.accepted, 5)
        self.assertEqual((stream.sent % 3, stream.trouble), (0, ""))

    def test_a_stream_of_which_nothing_arrives_is_an_error(self):
        with self.assertRaises(pointreel.Error) as raised:
            with pointreel.publish("ws://127.0.0.1:9/live/ball") as stream:
                stream.send(ball())
        self.assertEqual(raised.exception.code, "io")
        self.assertRegex(str(raised.exception), "nothing arrived at the server; .*nothing answers")
        self.assertEqual((stream.sent, stream.accepted), (1, 0))
        with self.assertRaises(ZeroDivisionError):
            with pointreel.publish("ws://127.0.0.1:9/live/ball") as stream:
                stream.send(ball())
                1 / 0

    def test_a_stream_goes_on_where_the_times_given_do_not(self):
        url = f"ws://{self.serve('--live')}/live/ball"
        viewer, seen = pointreel.live(url), []
        with pointreel.publish(url, fps=10) as stream:
            for time_given in (1000.0, 1000.1, 500.0, 500.1, 500.2, 500.2, 500.2, 1000.9):
                stream.send(pointreel.Points(lattice(), time=time_given))
                frame = viewer.next(timeout=30)
                while frame.index == len(seen) - 1:  # its finest layers come late
                    frame = viewer.next(timeout=30)
                seen.append(frame.time)
        np.testing.assert_allclose(
            seen, [1000.0, 1000.1, 1000.2, 1000.3, 1000.4, 1000.5, 1000.6, 1000.9])

    def test_publishing_fails_where_the_server_says_no(self):
        with self.assertRaises(pointreel.Error) as raised:
            pointreel.publish("ws://127.0.0.1:9/")
        self.assertEqual(raised.exception.code, "argument")
        url = f"ws://{self.serve('--live', '--publish-token', 'right')}/live/ball"
        with self.assertRaises(pointreel.Error):
            with pointreel.publish(url, token="wrong") as stream:
                for _ in range(200):
                    stream.send(ball())
                    time.sleep(0.05)

    def test_iteration_ends_where_nothing_comes_for_the_given_time(self):
        with self.assertRaises(TimeoutError):
            next(pointreel.live("ws://127.0.0.1:9/live/nobody", timeout=0.2))

    def test_an_interrupt_ends_waiting(self):
        def interrupt():
            time.sleep(0.3)
            os.kill(os.getpid(), signal.SIGINT)

        with socket.create_server(("127.0.0.1", 0)) as silent:
            address = f"127.0.0.1:{silent.getsockname()[1]}"
            for wait in (lambda: next(pointreel.live(f"ws://{address}/live/nobody")),
                         lambda: pointreel.open(f"http://{address}/reel")):
                thread = threading.Thread(target=interrupt)
                thread.start()
                with self.assertRaises(KeyboardInterrupt):
                    wait()
                thread.join()


class Threads(unittest.TestCase):
    def test_other_threads_run_while_a_frame_is_decoded(self):
        data = pointreel.encode(*ball(points=200_000), color_quality=100)
        rounds, ended = [0], threading.Event()

        def count():
            while not ended.is_set():
                rounds[0] += 1
                time.sleep(0)

        thread = threading.Thread(target=count)
        thread.start()
        begin = rounds[0]
        for _ in range(3):
            # The switch interval is longer than a decode, so that only a released lock counts.
            sys.setswitchinterval(100)
            pointreel.decode(data)
        sys.setswitchinterval(0.005)
        during = rounds[0] - begin
        ended.set()
        thread.join()
        self.assertGreater(during, 3)

    def test_daemon_threads_inside_the_module_let_python_end(self):
        for inside in ("next(pointreel.live('ws://127.0.0.1:9/live/nobody'))",
                       "pointreel.decode(data)",
                       "pointreel.encode(positions)"):
            program = f"""
import threading
import numpy as np
import pointreel
positions = np.random.default_rng(1).random((20000, 3))
data = pointreel.encode(positions)
inside = threading.Event()
def work():
    while True:
        inside.set()
        {inside}
threading.Thread(target=work, daemon=True).start()
inside.wait()
threading.Event().wait(0.1)
"""
            ended = subprocess.run([sys.executable, "-c", program], stderr=subprocess.PIPE,
                                   text=True)
            self.assertEqual((ended.returncode, ended.stderr), (0, ""), inside)


class Types(unittest.TestCase):
    def test_everything_public_is_explained(self):
        for name in pointreel.__all__:
            if name != "__version__":
                self.assertTrue(getattr(pointreel, name).__doc__, name)
        for name in dir(pointreel.Frame):
            if not name.startswith("_"):
                self.assertTrue(getattr(pointreel.Frame, name).__doc__, name)

    def test_the_stub_names_what_the_module_has(self):
        folder = pathlib.Path(pointreel.__file__).parent
        self.assertTrue((folder / "py.typed").exists())
        stub = ast.parse((folder / "_native.pyi").read_text())
        for node in stub.body:
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                self.assertTrue(hasattr(pointreel._native, node.name), node.name)
            if isinstance(node, ast.ClassDef) and node.name != "Error":
                named = {member.name for member in node.body
                         if isinstance(member, ast.FunctionDef) and not member.name.startswith("_")}
                has = {name for name in dir(getattr(pointreel._native, node.name))
                       if not name.startswith("_")}
                self.assertEqual(named, has, node.name)


if __name__ == "__main__":
    SERVER = sys.argv.pop(1)
    unittest.main(verbosity=2)
