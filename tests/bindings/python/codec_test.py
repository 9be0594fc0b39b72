"""Encoding and decoding of single frames in Python, their arrays, threads and types."""

import ast
import copy
import gc
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import pointreel
from shared import ball, lattice, rows


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

    def test_a_whole_frame_and_lists_of_numbers_are_encoded(self):
        colored = {"positions": lattice(), "colors": lattice().astype(int).tolist()}
        frame = pointreel.decode(pointreel.encode(colored, color_quality=100))
        source = np.rint(frame.world).astype(int)
        np.testing.assert_array_equal(frame.colors8, source)
        again = pointreel.decode(pointreel.encode(frame, color_quality=100))
        self.assertEqual(rows(again.world), rows(frame.world))
        np.testing.assert_array_equal(again.colors8, frame.colors8)

    def test_positions_of_every_type_are_relative_to_the_origin(self):
        for dtype in (np.float32, np.float64, np.int32):
            frame = pointreel.decode(pointreel.encode(lattice().astype(dtype), origin=(1000, 0, 0)))
            self.assertEqual(rows(frame.world), rows(lattice() + [1000, 0, 0]), dtype)

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
        with self.assertWarnsRegex(UserWarning, "286 of 1000 points have no finite position"):
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
        for far, named in ((a_third, "the point at 0 0 0"), (single, "at 1e+30 0 0")):
            with self.assertRaisesRegex(pointreel.Error, re.escape(named)):
                pointreel.encode(far)
            with self.assertRaisesRegex(pointreel.Error, "frame 0: .*" + re.escape(named)):
                pointreel.pack([far], path)
        single[5] = [1e12, 0, 0]
        with self.assertRaisesRegex(pointreel.Error, r"^frame 1: point 5 at 1e\+12 .*\(frame 0: "):
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

    def test_normals_have_the_quality_that_is_asked_for(self):
        positions, _, normals = ball()
        normals = normals + np.random.default_rng(1).normal(scale=0.3, size=normals.shape)
        sizes = [len(pointreel.encode(positions, None, normals, **options))
                 for options in ({}, {"normal_quality": 43}, {"normal_quality": 100})]
        self.assertEqual(sizes, sorted(set(sizes)))

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
        with self.assertWarns(UserWarning):
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
        with self.assertRaisesRegex(ValueError, "colors has"):
            pointreel.encode(positions, colors[1:])
        with self.assertRaisesRegex(ValueError, "from 0 to 1, and there is a 2"):
            pointreel.encode(positions, np.full_like(positions, 2.0))
        with self.assertRaisesRegex(TypeError, "as an integer"):
            pointreel.encode(positions, depth=9.5)
        for wrong in (positions[:, :2], positions.ravel(), "text", [[None] * 3]):
            with self.assertRaises((ValueError, TypeError)):
                pointreel.encode(wrong)
        with self.assertRaises(ValueError):
            pointreel.encode(positions, colors.astype(np.int32) + 1000)
        with self.assertRaises(TypeError):
            pointreel.decode("text")


def address(array):
    return array.__array_interface__["data"][0]


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
    unittest.main(verbosity=2)
