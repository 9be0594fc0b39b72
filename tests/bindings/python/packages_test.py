"""Reels, packages and pictures in Python."""

import gc
import subprocess
import threading
import types
import unittest
import warnings

import numpy as np

import pointreel
from shared import SERVER, TemporaryFolder, ball, lattice, rows


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

    def test_frames_know_which_axis_points_up(self):
        frame = pointreel.open(self.make(1, up="-z"))[0]
        self.assertEqual(frame.up, "-z")
        self.assertEqual(pointreel.decode(pointreel.encode(*ball())).up, "y")
        pictures = [pointreel.render(frame, size=(64, 48), view=(0, 20), **options)
                    for options in ({}, {"up": "-z"}, {"up": "y"})]
        np.testing.assert_array_equal(pictures[0], pictures[1])
        self.assertTrue((pictures[0] != pictures[2]).any())
        with self.assertWarnsRegex(UserWarning, "-z points up in the frames, but y in what is writ"):
            pointreel.pack((frame for _ in range(2)), self.folder / "list")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            pointreel.pack([frame], self.folder / "list", replace=True)
            pointreel.pack(iter([frame]), self.folder / "list", up="-z", replace=True)
        self.assertEqual(pointreel.open(self.folder / "list").up, "-z")

    def test_one_frame_is_no_list_of_frames(self):
        points = pointreel.Points(*ball())
        for frame in (ball(), ball()[:2], points, points._asdict(), ball()[0],
                      pointreel.decode(pointreel.encode(*ball()))):
            with self.assertRaisesRegex(TypeError, "frames is a list of frames"):
                pointreel.pack(frame, self.folder / "one")

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
            with self.assertRaisesRegex(IndexError, f"no frame {wrong}; there are 10 frames"):
                reel[wrong]
            with self.assertRaisesRegex(IndexError, f"no frame {wrong}"):
                reel.read(wrong)
        with self.assertRaisesRegex(TypeError, "an integer, not str"):
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

    def test_no_segment_exceeds_the_bit_rate(self):
        def bits_per_second(**options):
            reel = pointreel.open(self.make(replace=True, segment=5, **options))
            return [8 * sum(file["bytes"] for file in segment["files"]) / 0.5
                    for segment in reel.metadata["segments"]]

        for codec, text, number in (("octree", "0.2M", 2e5), ("draco", "1M", 1_000_000)):
            self.assertGreater(min(bits_per_second(codec=codec)), number)
            bounded = bits_per_second(codec=codec, bitrate=text)
            self.assertLessEqual(max(bounded), number)
            self.assertEqual(bounded, bits_per_second(codec=codec, bitrate=number))
        with self.assertRaisesRegex(pointreel.Error, "give a higher bitrate, or best_effort=True"):
            self.make(replace=True, bitrate=1000)
        with self.assertWarnsRegex(UserWarning, "more than the bit rate"):
            self.make(replace=True, bitrate=1000, best_effort=True)

    def test_packages_have_the_bytes_that_the_command_makes(self):
        files = self.folder / "files"
        subprocess.run([SERVER, "unpack", self.make(8), files], check=True,
                       stdout=subprocess.DEVNULL)
        for i, (options, words) in enumerate((
                ({}, []),
                ({"bitrate": "300k", "cube": "frame"}, ["--bitrate", "300k", "--cube", "frame"]),
                ({"codec": "video"}, []),
                ({"codec": "video", "group": 3, "effort": 0, "color_quality": 40, "segment": 6},
                 ["--group", "3", "--effort", "0", "--quality", "40", "--segment", "6"]),
                ({"codec": "video", "bitrate": "600k"}, ["--bitrate", "600k"]))):
            python, command = self.folder / f"python{i}", self.folder / f"command{i}"
            pointreel.pack(pointreel.open(files, fps=10), python, **options)
            codec = options.get("codec", "octree")
            subprocess.run([SERVER, "pack", files, command, "--codec", codec, "--fps", "10",
                            "--clean", "off", "--normals", "send", *words],
                           check=True, stdout=subprocess.DEVNULL)
            self.assertEqual(*({file.name: file.read_bytes() for file in reel.glob("*.prs")}
                               for reel in (python, command)), options)
            reel = pointreel.open(python)
            self.assertEqual((reel.codec, len(reel)), (codec, 8))
            radii = np.linalg.norm(reel[7].world, axis=1)
            np.testing.assert_allclose(np.median(radii), 1.7, atol=0.05)

    def test_normals_are_estimated_or_left_out(self):
        positions, colors, normals = ball()
        for how, has_normals in (("send", False), ("auto", False), ("estimate", True)):
            pointreel.pack([(positions, colors)] * 2, self.folder / how, normals=how)
            reel = pointreel.open(self.folder / how)
            self.assertEqual(reel[1].normals is not None, has_normals, how)
        along = np.sum(reel[0].normals * reel[0].world, axis=1)
        self.assertGreater(np.median(np.abs(along)), 0.95)
        pointreel.pack([ball()], self.folder / "derive", normals="derive")
        self.assertIsNone(pointreel.open(self.folder / "derive")[0].normals)
        with self.assertRaisesRegex(pointreel.Error, 'estimate" needs codec="octree"'):
            pointreel.pack([positions], self.folder / "a", normals="estimate", codec="video")

    def test_what_lies_far_away_is_left_out_or_gets_a_cube_of_its_own(self):
        stray = ball()[0].copy()
        stray[7] = [1e6, 0, 0]
        with self.assertRaisesRegex(pointreel.Error, "frame 0: point 7 .*best_effort=True"):
            pointreel.pack([stray], self.folder / "a")
        with self.assertWarnsRegex(UserWarning, "point 7 at 1000000 0 0 .* is left out"):
            pointreel.pack([stray], self.folder / "a", best_effort=True)
        far = [lattice(), lattice() + np.float64(1e7)]
        with self.assertRaisesRegex(pointreel.Error, 'segment, or give cube="frame"'):
            pointreel.pack(far, self.folder / "b")
        self.assertEqual(pointreel.pack(far, self.folder / "b", cube="frame"), 2)

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
        for wrong in ({"mode": "oil"}, {"size": (1 << 20, 5)}, {"up": "w"},
                      {"zoom": 0.0}, {"view": (0, 100)}, {"color": "taste"}, {"light": "moon"},
                      {"color_range": (0.0, 1.0)}, {"target": (float("nan"), 0, 0)}, {"bounds": reel.bounds[::-1]},
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
                        {"color": "plain", "light": "studio"}, {"target": (0.5, 0.0, 0.0)},
                        {"color": "height", "color_range": (0.0, 0.5)}):
            of_arrays, of_frame = (pointreel.render(item, size=(64, 64), **options).astype(int)
                                   for item in (points, frame))
            self.assertLess(np.abs(of_arrays - of_frame).mean(), 6.0, options)
            pictures.add(of_arrays.tobytes())
        self.assertEqual(len(pictures), 9, "each way looks different")
        with self.assertRaisesRegex(pointreel.Error, "color_range is two finite numbers"):
            pointreel.render(points, color="height", color_range=(1.0, 0.0))

    def test_pictures_are_drawn_of_arrays_of_any_size_and_place(self):
        positions, colors, normals = ball()
        for scale, offset in ((1.0, 3.0), (0.01, 0.0), (1000.0, -2500.0)):
            points = pointreel.Points(positions * scale + offset, colors, normals)
            frame = pointreel.decode(pointreel.encode(*points[:3]))
            for mode in ("surfel", "strip", "voxel"):
                of_arrays, of_frame = (pointreel.render(item, size=(64, 64), mode=mode).astype(int)
                                       for item in (points, frame))
                self.assertLess(np.abs(of_arrays - of_frame).mean(), 6.0, (mode, scale, offset))

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


class Times(TemporaryFolder):
    def reel(self, times, up="z"):
        path = self.folder / f"source {times[0]} {len(times)}"
        pointreel.pack([pointreel.Points(lattice(), time=at) for at in times], path, fps=10, up=up)
        return pointreel.open(path)

    def test_reels_keep_their_times_rate_and_axis(self):
        reel = self.reel([0.0, 0.1, 0.4, 0.5])
        for i, (frames, times) in enumerate(((reel, [0.0, 0.1, 0.4, 0.5]), (reel[1:], [0, 0.3, 0.4]),
                                             (pointreel.clean(reel), [0.0, 0.1, 0.4, 0.5]),
                                             (list(reel), [0.0, 0.1, 0.2, 0.3]))):
            path = self.folder / str(i)
            is_list = isinstance(frames, list)
            with warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                pointreel.pack(frames, path)
            self.assertEqual(["pass fps=10 to keep" in str(one.message) for one in said],
                             [True] * is_list)
            packed = pointreel.open(path)
            self.assertEqual((packed.fps, packed.up), (30.0 if is_list else 10.0, "z"))
            if not is_list:
                np.testing.assert_allclose(packed.times, times)
        cleaned = list(pointreel.clean(reel))
        self.assertEqual(cleaned[2].up, "z")
        pointreel.pack(cleaned, self.folder / "cleaned")
        self.assertEqual(pointreel.open(self.folder / "cleaned").up, "z")
        tall = pointreel.Points(lattice() * (1.0, 1.0, 4.0), up="z")
        standing, again, lying = (
            pointreel.render(points, size=(64, 48), **options)
            for points, options in ((tall, {}), (tall._replace(up=None), {"up": "z"}),
                                    (tall, {"up": "y"})))
        np.testing.assert_array_equal(standing, again)
        self.assertTrue((standing != lying).any())
        pointreel.pack(reel[::-1], self.folder / "backward", fps=5, up="x")
        backward = pointreel.open(self.folder / "backward")
        self.assertEqual((backward.fps, backward.up), (5.0, "x"))
        np.testing.assert_allclose(backward.times, [0.0, 0.2, 0.4, 0.6])

    def test_unix_times_count_from_the_first_frame(self):
        reel = self.reel([1.7e9, 1.7e9 + 0.5, 1.7e9 + 2.0])
        np.testing.assert_allclose(reel.times, [0.0, 0.5, 2.0])
        self.assertLess(reel.duration, 3.0)
        self.assertAlmostEqual(reel.captured, 1.7e9)
        for i, frames in enumerate((reel, pointreel.clean(reel))):
            pointreel.pack(frames, self.folder / str(i))
            self.assertAlmostEqual(pointreel.open(self.folder / str(i)).captured, 1.7e9)
        pointreel.pack(reel[1:], self.folder / "later")
        self.assertAlmostEqual(pointreel.open(self.folder / "later").captured, 1.7e9 + 0.5)


if __name__ == "__main__":
    unittest.main(verbosity=2)
