"""rb export --format hdf5, read back by h5py."""

import json
import unittest

import h5py
import numpy as np

from recorded import Exports, Node


def values(data_set):
    """As the CF conventions say it."""
    counts = data_set[...]
    there = counts != data_set.attrs["_FillValue"][0]
    return np.where(there, counts * data_set.attrs["scale_factor"] + data_set.attrs["add_offset"], np.nan)


class Hdf5(Exports):
    def test_has_the_counts_and_all_it_takes_to_understand_them(self):
        file, _ = self.export("hdf5", self.made, "made.h5", code=[3])
        with h5py.File(file) as data:
            group = data["all"]
            self.assertEqual(list(group), sorted(["time_s", *self.CHANNELS]))
            self.assertAlmostEqual(group.attrs["rate_hz"], self.RATE_HZ, places=6)
            np.testing.assert_allclose(group["time_s"], self.time_s - self.time_s[0], rtol=0, atol=2e-9)
            for c, name in enumerate(self.CHANNELS):
                counts = group[name][...]
                np.testing.assert_array_equal(counts[self.there[:, c]], self.counts[self.there[:, c], c])
                np.testing.assert_allclose(values(group[name]), self.values[:, c], rtol=1e-14, atol=1e-14)
                self.assertEqual(group[name].attrs["units"], "m/s^2")
            side = group["rear_side"].attrs
            self.assertEqual((side["node"], side["mount"], side["range"]), ("rear", "body", 20))
            np.testing.assert_array_equal(side["direction"], [0, 1, 0])
            np.testing.assert_array_equal(group["front_up"].attrs["position_m"], [1, 0.5, 0])
            self.assertEqual(data["vehicle_toml"][()].decode(), (self.root / "made.toml").read_text())
            said = json.loads(data["description"][()])
            self.assertEqual([c["name"] for c in said["groups"][0]["channels"]], list(self.CHANNELS))

    def test_somebody_elses_measurement_and_a_drive(self):
        file, _ = self.export("hdf5", self.wobble(), "wobble.h5")
        node = Node(self.root / "wobble", 1)
        with h5py.File(file) as data:
            names = list(json.loads(data["description"][()])["groups"][0]["channels"])
            for k, channel in enumerate(names):
                counts = data["axle" if "axle" in data else "all"][channel["name"]][...]
                np.testing.assert_array_equal(counts[node.there[:, k]], node.counts[node.there[:, k], k])
        file, _ = self.export("hdf5", self.drive(), "drive.h5", "--channels", "front", "--from", 1, "--to", 3)
        node = Node(self.root / "drive", 1)
        with h5py.File(file) as data:
            sine = data["all"]["front_left_angle_sin"]
            np.testing.assert_allclose(data["all"]["time_s"], 1 + np.arange(4000) / 2000, atol=1e-9)
            there = node.there[2000:6000, 12]
            np.testing.assert_array_equal(sine[...][there], node.counts[2000:6000, 12][there])
            self.assertEqual(sine.attrs["units"], "1")

    def test_more_than_a_chunk_and_a_part_of_the_next(self):
        drive = self.drive("long", seconds=13)
        node = Node(drive, 1)
        file, _ = self.export("hdf5", drive, "long.h5", "--channels", "front")
        with h5py.File(file) as data:
            chunk = data["all"]["time_s"].chunks[0]
            self.assertGreater(len(node.counts), chunk)
            self.assertNotEqual(len(node.counts) % chunk, 0)
            sets = [name for name in data["all"] if name != "time_s"]
            self.assertEqual(len(sets), 16)
            np.testing.assert_allclose(np.diff(data["all"]["time_s"]), 1 / 2000, rtol=0, atol=2e-9)
            said = {c["name"]: k for k, c in enumerate(json.loads(data["description"][()])["groups"][0]["channels"])}
            for name in sets:
                k, counts = said[name], data["all"][name][...]
                self.assertEqual(len(counts), len(node.counts))
                np.testing.assert_array_equal(counts[node.there[:, k]], node.counts[node.there[:, k], k])


if __name__ == "__main__":
    unittest.main()
