"""Arguments, warnings and closing of the Python module."""

import pathlib
import time
import unittest
import warnings

import numpy as np

import pointreel
from shared import NOWHERE, TemporaryFolder, lattice


class Arguments(TemporaryFolder):
    def test_wrong_types_are_named_and_no_token_is_printed(self):
        for call, wrong, named in (
                (lambda **more: pointreel.open("http://127.0.0.1:9/x", **more),
                 ({"fps": "15"}, {"ca_file": None}, {"topic": 5}, {"ahead": "3"}, {"layers": 1.5}),
                 "secret"),
                (lambda **more: pointreel.live(NOWHERE, **more),
                 ({"ca_file": None}, {"timeout": "1"}, {"max_memory": "1"}), "secret"),
                (lambda **more: pointreel.publish(NOWHERE, **more),
                 ({"fps": "30"}, {"fps": None}, {"name": 5}, {"up": 1}, {"codec": None}), "secret")):
            for arguments in wrong:
                with self.assertRaises(TypeError, msg=arguments) as raised:
                    call(token=named, **arguments)
                self.assertRegex(str(raised.exception), f"^{next(iter(arguments))} is ")
                self.assertNotIn("secret", str(raised.exception))
        for path in ("/nowhere/\udcff", "/nowhere/\ud800", 5):
            with self.assertRaises((pointreel.Error, ValueError, TypeError), msg=path) as raised:
                pointreel.open(path, token="secret")
            self.assertNotIn("secret", str(raised.exception))

    def test_names_of_files_need_not_be_utf8(self):
        folder = self.folder / "\udcff"
        self.assertEqual(pointreel.pack([lattice()], folder), 1)
        self.assertEqual(len(pointreel.open(folder)[0]), len(lattice()))

    def test_wrong_arguments_are_said_in_the_words_of_python(self):
        for wrong, call in (
                ("null character", lambda: pointreel.open("reel\0")),
                ("null character", lambda: pointreel.pack([lattice()], f"{self.folder}/a\0b")),
                ("masked", lambda: pointreel.encode(np.ma.masked_less(lattice(), 3))),
                ("origin is three numbers", lambda: pointreel.encode(lattice(), origin=(1, 2))),
                ("scalars is a dict", lambda: pointreel.encode(lattice(), scalars=[1])),
                ("data is bytes", lambda: pointreel.decode(5)),
                ("max_memory is at least 1", lambda: pointreel.decode(b"x", max_memory=-1)),
                ("layers is too large", lambda: pointreel.open("/nowhere", layers=2**33)),
                ("segment is too large",
                 lambda: pointreel.pack([lattice()], self.folder / "x", segment=2**33)),
                ("voxel is too large",
                 lambda: pointreel.pack([lattice()], self.folder / "x", voxel=10**400)),
                ("name has half of a surrogate pair",
                 lambda: pointreel.pack([lattice()], self.folder / "x", name="\ud800")),
                ("layers is at least 1", lambda: pointreel.open("/nowhere", layers=0)),
                ("ahead is at least 0", lambda: pointreel.open("/nowhere", ahead=-1)),
                ("size is the width", lambda: pointreel.render(lattice(), size=640)),
                ("width is too large", lambda: pointreel.render(lattice(), size=(2**31, 1))),
                ("width is at least 1", lambda: pointreel.render(lattice(), size=(0, 5))),
                ("target is one of feet", lambda: pointreel.render(lattice(), target="nose")),
                ("view is one of front", lambda: pointreel.render(lattice(), view="above")),
                ("view is yaw and pitch", lambda: pointreel.render(lattice(), view=(1, 2, 3))),
                ("not 'red'", lambda: pointreel.render(lattice(), background="red")),
                ("from 0 to 1", lambda: pointreel.render(lattice(), background=(255, 255, 255))),
                ("color_range is two numbers", lambda: pointreel.render(lattice(), color_range=1)),
                ("not 2 x 3", lambda: pointreel.render(lattice(), bounds=[0, 1])),
                ("positions is an array", lambda: pointreel.encode(None)),
                ("colors has 1 rows for 2 points",
                 lambda: pointreel.encode([[0, 0, 0], [1, 1, 1]], [[1, 2, 3]])),
                ("whole numbers up to 255",
                 lambda: pointreel.encode([[0, 0, 0]], [[0, 0, 256]])),
                ("frame 1: a frame has no position; it has positions, colors",
                 lambda: pointreel.pack([lattice(), {"position": [[0, 0, 0]]}], self.folder / "x")),
                ("frame 0: time is a number, not str",
                 lambda: pointreel.pack([{"positions": lattice(), "time": "9:30"}],
                                        self.folder / "x")),
                (r"clean.pointreel.open.file", lambda: pointreel.clean("walk.mcap")),
                ("clean..frame.", lambda: pointreel.clean(lattice())),
                ("pack.pointreel.open.file", lambda: pointreel.pack("walk.mcap", self.folder / "x")),
                ("pack..frame.", lambda: pointreel.pack(lattice(), self.folder / "x"))):
            with self.assertRaisesRegex((ValueError, TypeError), wrong):
                call()

    def test_what_does_not_go_together_is_said_in_the_words_of_python(self):
        for wrong, options in (
                ("^bitrate: fast is not a number of bits", {"bitrate": "fast"}),
                ("^bitrate: 0.0 is not", {"bitrate": 0}),
                ('^group needs codec="video"', {"group": 8}),
                ('^effort needs codec="video"', {"effort": 0}),
                ("^group is 65, not 1 to 64", {"codec": "video", "group": 65}),
                ("^effort is 10, not 0 to 9", {"codec": "video", "effort": 10}),
                ('^cube="frame" does not go with codec="video"', {"codec": "video", "cube": "frame"}),
                ("^cube is group or frame", {"cube": "sphere"}),
                ("^normals is auto, send, estimate or derive", {"normals": "some"}),
                ("^video has no depth", {"codec": "video", "depth": 9}),
                ("^segment is 1000000", {"segment": 1_000_000})):
            with self.assertRaisesRegex(pointreel.Error, wrong) as raised:
                pointreel.pack([lattice()], self.folder / "x", **options)
            self.assertEqual(raised.exception.code, "argument")
        for single in (lambda: pointreel.encode(lattice(), codec="video"),
                       lambda: pointreel.publish(NOWHERE, codec="video")):
            with self.assertRaisesRegex(pointreel.Error, 'codec="video" is for pack'):
                single()
        for options in ({"bitrate": True}, {"bitrate": b"1M"}, {"group": "3"}, {"effort": 1.5}):
            with self.assertRaisesRegex(TypeError, f"^{next(iter(options))} is "):
                pointreel.pack([lattice()], self.folder / "x", **options)

    def test_a_package_is_not_written_to_an_address(self):
        with self.assertRaisesRegex(pointreel.Error, "is an address"):
            pointreel.pack([lattice()], "s3://bucket/reel")
        self.assertFalse(pathlib.Path("s3:").exists())

    def test_files_are_read_as_the_arguments_say(self):
        (self.folder / "points.csv").write_text(
            "a,b,c,d\n" + "".join(f"{i},{i % 7},{i % 5},{2 * i}\n" for i in range(50)))
        with self.assertRaisesRegex(pointreel.Error, "[^-]columns"):
            pointreel.open(self.folder / "points.csv")
        reel = pointreel.open(self.folder / "points.csv", columns="x,y,-,z", scale=0.5,
                              rotate=(0, 0, 90))
        with warnings.catch_warnings(record=True):
            world = reel[0].world
        i = np.arange(50)
        np.testing.assert_allclose(world, 0.5 * np.stack([-(i % 7), i, 2 * i], axis=1), atol=1e-6)

    def test_pictures_take_the_names_that_the_commands_have(self):
        points = np.concatenate([lattice(), [[4.0, 30.0, 4.0]]])
        pictures = [pointreel.render(points, size=(64, 64), background="#102030", **named)
                    for named in ({"target": "head"}, {"target": "feet"}, {"view": "top"},
                                  {"view": "back"})]
        self.assertEqual(len({picture.tobytes() for picture in pictures}), 4)
        self.assertEqual(pictures[0][0, 0].tolist(), [0x10, 0x20, 0x30])
        np.testing.assert_array_equal(
            pictures[2], pointreel.render(points, size=(64, 64), view=(0, 90),
                                          background=(16 / 255, 32 / 255, 48 / 255)))


class Warnings(TemporaryFolder):
    def test_what_is_left_out_is_a_warning_at_the_line_that_called(self):
        positions = lattice()
        positions[3] = np.nan
        colors = np.full_like(positions, 0.5)
        colors[0, 0] = np.nan
        heights = {"height": positions[:, 0]}
        for said, call in (
                ("1 of 1000 points", lambda: pointreel.encode(positions)),
                ("1 of 1000 points", lambda: pointreel.pack([positions], self.folder / "a")),
                ("1 of 1000 points", lambda: list(pointreel.clean([positions]))),
                ("time is off by up to",
                 lambda: pointreel.encode(lattice(), scalars={"time": 1.7e9 + np.arange(1000) / 1e4})),
                ("1 values of colors", lambda: pointreel.encode(lattice(), colors)),
                ("scalar_steps hight: no frame has such a scalar field; there are height",
                 lambda: pointreel.pack([pointreel.Points(lattice(), scalars=heights)],
                                        self.folder / "b", scalar_steps={"hight": 1.0})),
                ("Draco frames have none",
                 lambda: pointreel.encode(lattice(), scalars=heights, codec="draco"))):
            with self.assertWarnsRegex(UserWarning, said) as warned:
                call()
            self.assertEqual(warned.filename, __file__, said)

    def test_options_for_files_are_of_no_use_for_packages(self):
        pointreel.pack([lattice()], self.folder / "reel")
        for wrong in ({"scale": 2.0}, {"rotate": (0, 0, 90)}, {"fps": 5}, {"columns": "x,y,z"},
                      {"topic": "t"}, {"color_max": 255}):
            with self.assertWarnsRegex(UserWarning, f"reel: is a package.*: {next(iter(wrong))} is"):
                pointreel.open(self.folder / "reel", **wrong)

    def test_what_is_said_about_files_is_a_warning(self):
        (self.folder / "scan.txt").write_text("".join(f"{i} {i % 7} {i % 5} 9\n" for i in range(50)))
        with self.assertWarnsRegex(UserWarning, "read as.*columns"):
            pointreel.open(self.folder / "scan.txt")[0]


class Closing(TemporaryFolder):
    def test_reels_and_streams_can_be_closed(self):
        pointreel.pack([lattice()], self.folder / "reel")
        with pointreel.open(self.folder / "reel") as reel:
            frame = reel[0]
        self.assertEqual(len(frame), 1000)
        with pointreel.live(NOWHERE) as stream:
            self.assertIsNone(stream.next(timeout=0.05))
        for read in (lambda: reel[0], lambda: next(iter(reel)), lambda: stream.next(timeout=0.05)):
            with self.assertRaisesRegex(ValueError, "is closed"):
                read()

    def test_a_stream_without_a_frame_ends_at_once(self):
        begun = time.monotonic()
        with pointreel.publish(NOWHERE):
            pass
        self.assertLess(time.monotonic() - begun, 5.0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
