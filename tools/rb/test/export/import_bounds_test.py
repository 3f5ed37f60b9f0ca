"""rb import of numbers that are too large: each format refuses them, and says where they stand."""

import unittest

import h5py
import numpy as np

from imports import Imports
from recorded import Node, rb


class ImportBounds(Imports):
    def at_time(self, form, first_s, time_s):
        """A file of `made.toml`'s channels as somebody else wrote it."""
        value = np.sin(time_s - first_s)
        channels = {name: (value, "m/s^2") for name in self.CHANNELS}
        if form == "hdf5":
            return self.write_hdf5("far.h5", time_s, **channels)
        file = self.root / f"far.{form}"
        if form == "csv":
            lines = ["time_s," + ",".join(channels), "s" + ",m/s^2" * len(channels)]
            lines += [f"{t:.6f}" + f",{v}" * len(channels) for t, v in zip(time_s, value)]
        else:
            lines = []
            for name in channels:
                lines += ["    -1", "    58", name, *["NONE"] * 4, "    1" + " " * 75,
                          f"         4{len(value):10}         1{first_s:13.5E}{1 / self.RATE_HZ:13.5E}{0:13.5E}", *["0"] * 4]
                lines += ["".join(f"{v:20.11E}" for v in value[k:k + 4]) for k in range(0, len(value), 4)] + ["    -1"]
        file.write_text("\n".join(lines) + "\n")
        return file

    def test_a_time_is_countable_or_refused(self):
        for form, place in (("csv", ":3: time_s:"), ("hdf5", ": time_s: row 0:"), ("uff58", ":9: abscissa:")):
            for first_s in (1.7e9, -1.7e9, 2.3e9, -2.3e9, 3e9, 1e10, 1e300):
                with self.subTest(form, first_s=first_s):
                    file = self.at_time(form, first_s, first_s + np.arange(1000) / self.RATE_HZ)
                    name = f"far-{form}-{first_s:g}"
                    folder, done = self.import_as(form, name, file, self.root / "made.toml")
                    if abs(first_s) < 2e9:
                        self.assertEqual(done.returncode, 0, done.stderr)
                        self.assertEqual(rb("verify", folder).returncode, 0)
                        self.assertAlmostEqual(Node(folder, 1).time_ns[0] * 1e-9, first_s, delta=1e-6)
                    else:
                        self.assertEqual(done.returncode, 2, done.stderr)
                        self.assertIn(f"{file.name}{place} ", done.stderr)
                        self.assertIn("too far off; allowed: -2e9 to 2e9 s", done.stderr)
                        self.assertFalse(folder.exists())
        good = self.export("wav", self.made, "soon.wav", "--to", 1)[0].read_bytes()
        for was, late in ((b'"first_s":0.0', b'"first_s":3e9'), (b'"first_s":0.0', b'"first_s":9e9'),
                          (b'"rate_hz":500.0', b'"rate_hz":1e-10')):
            self.assertIn(was, good)
            file = self.root / "far.wav"
            file.write_bytes(good.replace(was, late))
            folder, done = self.import_as("wav", "far-wav", file, self.root / "made.toml")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("far.wav: ", done.stderr)
            self.assertIn("too far off", done.stderr)
            self.assertFalse(folder.exists())

    NO_SCALE = "scale_factor or add_offset is no number, or"

    def refuse(self, form, file, words):
        folder, done = self.import_as(form, "refused", file, self.root / "made.toml")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn(f"{file.name}{words} is too large", done.stderr)
        self.assertFalse(folder.exists())

    def test_a_sample_that_is_infinite_in_si_units_is_refused(self):
        file = self.root / "large.csv"
        file.write_text("time_s," + ",".join(self.CHANNELS) + "\ns,m/s^2,g,g,g\n0,1e308,1,1,1\n0.002,1,1,-1e308,1\n")
        self.refuse("csv", file, ": channel rear_up: its sample at 0.002 s")
        time_s = np.arange(1000) / self.RATE_HZ
        value = np.where(np.arange(1000) == 700, 1e308, 0.0)
        file = self.write_hdf5("large.h5", time_s, **{name: (value, "g") for name in self.CHANNELS})
        self.refuse("hdf5", file, ": channel front_side: its sample at 1.4 s")
        for attribute in ("scale_factor", "add_offset"):
            for number, place in ((1e308, "row 700:"), (np.inf, self.NO_SCALE), (np.nan, self.NO_SCALE)):
                with h5py.File(file, "a") as data:
                    data["mine"]["front_side"].attrs[attribute] = number
                self.refuse("hdf5", file, f": front_side: {place}")
            with h5py.File(file, "a") as data:
                data["mine"]["front_side"].attrs[attribute] = 1.0

    def test_a_signal_that_is_infinite_in_si_units_is_refused(self):
        dbc, file = self.root / "large.dbc", self.root / "large.log"
        signals = "".join(f' SG_ {name} : {8 * k}|8@1- (1e306,0) [0|0] "g" ecu\n' for k, name in enumerate(self.CHANNELS))
        dbc.write_text('VERSION ""\nBU_: ecu\nBO_ 291 All: 4 ecu\n' + signals)
        file.write_text("(1700000000.000000) can0 123#01010101\n(1700000000.002000) can0 123#01016401\n")
        done = rb("import", "candump", "--samples", file, "--dbc", dbc, "--vehicle", self.root / "made.toml",
                  "-o", self.root / "signal")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("large.log: channel rear_up: its sample at 0.002 s is too large", done.stderr)


if __name__ == "__main__":
    unittest.main()
