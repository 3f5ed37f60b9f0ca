"""Somebody else's measurements -> recording -> each export -> back, count for count."""

import gzip
import unittest

import numpy as np
import scipy.io

import mcap_test
import mdf4
from recorded import DATA, Node, rb

TOML = DATA / "wobbletracker.toml"


class Wobbletracker(mcap_test.Mcap):
    test_has_a_message_for_each_instant = test_a_drive_with_wheel_angles = None

    def runs(self):
        """All that there are, whole."""
        packed = sorted(DATA.glob("wobbletracker-*.csv.gz"))
        self.assertEqual(len(packed), 3)
        (self.root / "runs").mkdir()
        for run in packed:
            (self.root / "runs" / run.stem).write_bytes(gzip.decompress(run.read_bytes()))
        return [self.root / "runs" / run.stem for run in packed]

    def test_each_export_of_each_run_comes_back(self):
        for run in self.runs():
            with self.subTest(run=run.name):
                folder = self.import_of(f"of_{run.stem}", run, TOML)
                self.check(Node(folder, 1), folder, run)

    def check(self, node, folder, run):
        names = run.read_text().splitlines()[0].split(",")[1:]
        source = np.genfromtxt(run, delimiter=",", skip_header=2)[:, 1:]
        counts = node.counts[:, :12]
        _, said = self.export("hdf5", folder, f"{run.stem}.h5", "--vehicle", self.root / f"{run.stem}.toml")
        channels = said["groups"][0]["channels"]
        self.assertEqual([c["name"] for c in channels], names)
        scale = np.array([c["scale"] for c in channels])
        offset = np.array([c["offset_counts"] for c in channels])
        # The recording is the run: what the file says in four decimals, to half a count of its converter.
        np.testing.assert_allclose((counts - offset) * scale, source, rtol=0, atol=0.51 * scale.max())
        self.back(node, run, {form: self.export(form, folder, f"{run.stem}.{form}")[0] for form in ("csv", "uff58", "wav")}
                  | {"hdf5": self.root / f"{run.stem}.h5"})
        as_counts = lambda values: np.rint(values / scale + offset)
        data = scipy.io.loadmat(self.export("mat", folder, f"{run.stem}.mat")[0])
        np.testing.assert_array_equal(as_counts(np.hstack([data[name] for name in names])), counts)
        group = mdf4.File(self.export("mdf4", folder, f"{run.stem}.mf4")[0]).groups[0]
        self.assertEqual([c.name for c in group.channels[1:]], names)
        np.testing.assert_array_equal(np.column_stack([c.raw for c in group.channels[1:]]), counts)
        _, values = self.read(self.export("mcap", folder, f"{run.stem}.mcap")[0])
        rows = np.fromfile(values, [("time_ns", "<i8"), ("value", "<f8", 12)])
        np.testing.assert_array_equal(as_counts(rows["value"]), counts)
        # An export's rows are a whole number of picoseconds apart, which half a picosecond a row comes from.
        np.testing.assert_allclose(rows["time_ns"] - rows["time_ns"][0], node.time_ns - node.time_ns[0], rtol=0,
                                   atol=2 + 0.5e-3 * len(rows))

    def back(self, node, run, files):
        """What rb import takes."""
        for form, file in files.items():
            again = self.root / f"{run.stem}_{form}_back"
            done = rb("import", form, "--samples", file, "--vehicle", self.root / f"{run.stem}.toml", "-o", again)
            self.assertEqual(done.returncode, 0, f"{form}: {done.stderr}")
            np.testing.assert_array_equal(Node(again, 1).counts, node.counts, form)
            np.testing.assert_allclose(np.diff(Node(again, 1).time_ns), np.diff(node.time_ns), rtol=0, atol=50)


if __name__ == "__main__":
    unittest.main()
