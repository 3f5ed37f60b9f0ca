"""rb export --format mat, read back by SciPy."""

import json
import unittest

import numpy as np
import scipy.io

from recorded import Exports, Node


class Mat(Exports):
    def test_has_a_column_in_its_unit_for_each_channel(self):
        file, _ = self.export("mat", self.made, "made.mat", code=[3])
        data = scipy.io.loadmat(file)
        self.assertEqual({name for name in data if name[0] != "_"}, {"description", "all_time_s", *self.CHANNELS})
        np.testing.assert_allclose(data["all_time_s"][:, 0], self.time_s - self.time_s[0], rtol=0, atol=2e-9)
        for c, name in enumerate(self.CHANNELS):
            self.assertEqual(data[name].shape, (self.ROWS, 1))
            np.testing.assert_allclose(data[name][:, 0], self.values[:, c], rtol=1e-14, atol=1e-14)
            there = self.there[:, c]
            np.testing.assert_array_equal(np.rint(data[name][there, 0] / self.SCALE[c] + self.OFFSET[c]),
                                          self.counts[there, c])
        said = json.loads(data["description"][0])
        channel = said["groups"][0]["channels"][3]
        self.assertEqual((channel["unit"], channel["scale"], channel["offset_counts"]), ("m/s^2", 2.5e-6, 1234.5))

    def test_a_drive_with_wheel_angles(self):
        file, _ = self.export("mat", self.drive(), "drive.mat")
        data = scipy.io.loadmat(file)
        node = Node(self.root / "drive", 2)
        cosine = data["rear_right_angle_cos"][:, 0]
        np.testing.assert_array_equal(np.isnan(cosine), ~node.there[:, 15])
        np.testing.assert_array_equal(cosine[node.there[:, 15]] * 2**23, node.counts[node.there[:, 15], 15])


if __name__ == "__main__":
    unittest.main()
