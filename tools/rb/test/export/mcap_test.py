"""rb export --format mcap, read back by @mcap/core, which checks every CRC; RB_MCAP is the folder of its packages."""

import json
import os
import pathlib
import unittest

import numpy as np

from recorded import Exports, Node, run


class Mcap(Exports):
    def read(self, path):
        values = self.root / "values"
        done = run("node", pathlib.Path(os.environ["RB_MCAP"], "read.mjs"), path, values)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout), values

    def test_has_a_message_for_each_instant(self):
        path, said = self.export("mcap", self.made, "made.mcap", code=[3])
        found, values = self.read(path)
        topic = found["topics"]["/all"]
        self.assertEqual((topic["streamed"], topic["messages"], topic["stated"]), (self.ROWS,) * 3)
        self.assertEqual((topic["encoding"], topic["messageEncoding"]), ("ros2msg", "cdr"))
        fields = [line.split("#")[0].split() for line in topic["text"].splitlines()]
        self.assertEqual(fields, [["float64", name] for name in self.CHANNELS])
        rows = np.fromfile(values, [("time_ns", "<i8"), ("value", "<f8", 4)])
        self.assertEqual(rows["time_ns"][0], said["start_utc_us"] * 1000)
        np.testing.assert_allclose((rows["time_ns"] - rows["time_ns"][0]) * 1e-9, self.time_s - self.time_s[0],
                                   rtol=0, atol=2e-9)
        np.testing.assert_allclose(rows["value"], self.values, rtol=1e-14, atol=1e-14)
        counts = np.rint(rows["value"] / self.SCALE + self.OFFSET)
        np.testing.assert_array_equal(counts[self.there], self.counts[self.there])
        self.assertEqual(found["attachments"]["vehicle.toml"], (self.root / "made.toml").read_text())
        self.assertEqual(json.loads(found["metadata"]["description"]["json"])["vehicle"], "test car")

    def test_a_drive_with_wheel_angles(self):
        path, _ = self.export("mcap", self.drive(), "drive.mcap", "--channels", "front_right_angle_cos", "--to", 5)
        _, values = self.read(path)
        rows = np.fromfile(values, [("time_ns", "<i8"), ("value", "<f8")])
        node = Node(self.root / "drive", 1)
        np.testing.assert_array_equal(np.isnan(rows["value"]), ~node.there[:10000, 15])
        there = node.there[:10000, 15]
        np.testing.assert_array_equal(rows["value"][there] * 2**23, node.counts[:10000, 15][there])


if __name__ == "__main__":
    unittest.main()
