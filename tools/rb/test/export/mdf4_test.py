"""rb export --format mdf4, read back by a reader written from the standard."""

import unittest

import numpy as np

import mdf4
from recorded import Exports, Node


class Mdf4(Exports):
    def test_is_a_finished_file_of_one_sorted_group_with_every_count(self):
        path, _ = self.export("mdf4", self.made, "made.mf4", code=[3])
        file = mdf4.File(path)
        self.assertEqual(len(file.groups), 1)
        group = file.groups[0]
        self.assertEqual([c.name for c in group.channels], ["time", *self.CHANNELS])
        np.testing.assert_allclose(group.channels[0].values, self.time_s - self.time_s[0], rtol=0, atol=2e-9)
        for c, channel in enumerate(group.channels[1:]):
            there = self.there[:, c]
            np.testing.assert_array_equal(channel.valid, there)
            np.testing.assert_array_equal(channel.raw[there], self.counts[there, c])
            np.testing.assert_allclose(channel.values, self.values[:, c], rtol=1e-14, atol=1e-14)
            self.assertEqual(channel.unit, "m/s^2")
        self.assertIn("direction (0, 1, 0)", group.channels[2].comment)
        self.assertEqual(file.attachments["vehicle.toml"].decode(), (self.root / "made.toml").read_text())
        self.assertEqual(file.start_ns, 3_000_000_000)  # the import's time is that of its stamps

    def test_a_drive_with_wheel_angles(self):
        path, _ = self.export("mdf4", self.drive(), "drive.mf4", "--from", 1.5)
        group = mdf4.File(path).groups[0]
        channels = {channel.name: channel for channel in group.channels}
        node = Node(self.root / "drive", 2)
        sine = channels["rear_left_angle_sin"]
        np.testing.assert_array_equal(sine.valid, node.there[3000:, 12])
        np.testing.assert_array_equal(sine.raw[sine.valid], node.counts[3000:, 12][sine.valid])
        self.assertEqual(sine.unit, "1")
        self.assertAlmostEqual(channels["time"].values[0], 1.5, places=9)

    def test_the_reader_sees_a_file_that_is_cut(self):
        path, _ = self.export("mdf4", self.made, "cut.mf4")
        data = path.read_bytes()
        for size in (len(data) - 8, len(data) // 2, 100):
            path.write_bytes(data[:size])
            with self.assertRaises(mdf4.Wrong):
                mdf4.File(path)


if __name__ == "__main__":
    unittest.main()
