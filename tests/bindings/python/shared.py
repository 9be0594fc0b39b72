"""What the tests of the Python module share. POINTREEL_SERVER is the program pointreel-server, and
PYTHONPATH has the module."""

import os
import pathlib
import tempfile
import unittest

import numpy as np

SERVER = os.environ["POINTREEL_SERVER"]
NOWHERE = "ws://127.0.0.1:9/live/nobody"
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


class TemporaryFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
