"""Servers and live streams in Python."""

import os
import re
import signal
import socket
import subprocess
import threading
import time
import unittest

import numpy as np

import pointreel
from shared import SERVER, TemporaryFolder, ball, lattice


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
            with self.assertWarnsRegex(UserWarning, "times before 2001 .* are left out"):
                for _ in range(3):
                    stream.send(pointreel.Points(*ball(), time=0.5))
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

    def test_threads_send_frames_one_after_another(self):
        troubles = set()

        def send():
            for _ in range(20):
                stream.send(lattice())
                troubles.add(stream.trouble)
                time.sleep(0.05)

        with pointreel.publish(f"ws://{self.serve('--live')}/live/ball") as stream:
            threads = [threading.Thread(target=send) for _ in range(4)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        self.assertEqual(stream.sent, 80)
        self.assertEqual(troubles, {""})

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
                stream.send(pointreel.Points(lattice(), time=1.6e9 + time_given))
                frame = viewer.next(timeout=30)
                while frame.index == len(seen) - 1:  # its finest layers come late
                    frame = viewer.next(timeout=30)
                seen.append(round(frame.time - 1.6e9, 6))
            with self.assertRaisesRegex(pointreel.Error, "give the time of its capture"):
                stream.send(pointreel.Points(lattice(), time=time.time() + 3600))
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


if __name__ == "__main__":
    unittest.main(verbosity=2)
