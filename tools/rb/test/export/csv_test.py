"""rb export --format csv: values, holes, limits, and the way back through rb import."""

import csv
import math
import os
import shutil
import unittest

import numpy as np

from recorded import Exports, Node, rb


def read(file):
    """Names, units, and cells as numbers; an empty one is NaN."""
    with open(file, newline="", encoding="ascii") as text:
        rows = list(csv.reader(text))
    return rows[0], rows[1], np.array([[float(cell) if cell else math.nan for cell in row] for row in rows[2:]])


class Csv(Exports):
    def test_has_names_units_times_and_values_and_leaves_empty_what_is_missing(self):
        file, said = self.export("csv", self.made, "made.csv.out", code=[3])
        names, units, cells = read(file)
        self.assertEqual(names, ["time_s", *self.CHANNELS])
        self.assertEqual(units, ["s"] + ["m/s^2"] * 4)
        np.testing.assert_allclose(cells[:, 0], self.time_s - self.time_s[0], rtol=0, atol=2e-9)
        np.testing.assert_array_equal(np.isnan(cells[:, 1:]), ~self.there)
        counts = np.rint(cells[:, 1:] / self.SCALE + self.OFFSET)
        np.testing.assert_array_equal(counts[self.there], self.counts[self.there])
        self.assertEqual(said["rows"], self.ROWS)
        self.assertEqual(said["rows_missing"], 2 * 1000 + 7)
        self.assertEqual([channel["name"] for channel in said["groups"][0]["channels"]], list(self.CHANNELS))

    def test_comes_back_through_import_count_for_count(self):
        file, _ = self.export("csv", self.made, "there.csv", "--vehicle", self.root / "there.toml")
        back = self.import_of("back", file, self.root / "there.toml")
        for number in (1, 2):
            first, again = Node(self.made, number), Node(back, number)
            np.testing.assert_array_equal(first.there, again.there)
            np.testing.assert_array_equal(first.counts, again.counts)
            there = first.there[:, 0]
            np.testing.assert_allclose(np.diff(first.time_ns[there]), np.diff(again.time_ns[there]), rtol=0, atol=2)

    def test_somebody_elses_measurement_comes_back_count_for_count(self):
        wobble = self.wobble()
        file, _ = self.export("csv", wobble, "wobble.csv", "--vehicle", self.root / "wobble.toml")
        first, again = Node(wobble, 1), Node(self.import_of("wobble_back", file, self.root / "wobble.toml"), 1)
        np.testing.assert_array_equal(first.counts, again.counts)
        np.testing.assert_array_equal(first.there, again.there)

    def test_a_drive_has_accelerations_and_wheel_angles_of_all_nodes(self):
        drive = self.drive()
        file, said = self.export("csv", drive, "drive.csv")
        names, units, cells = read(file)
        self.assertEqual(units[names.index("front_left_angle_cos")], "1")
        front = Node(drive, 1)
        column = names.index("front_left_angle_cos")
        np.testing.assert_array_equal(np.isnan(cells[:, column]), ~front.there[:, 13])
        known = front.there[:, 13]
        self.assertGreater(known.sum(), 5000)
        np.testing.assert_array_equal(np.rint(cells[known, column] * 2**23), front.counts[known, 13])
        scales = {c["name"]: (c["scale"], c["offset_counts"], c["node"]) for c in said["groups"][0]["channels"]}
        for number, node in ((1, front), (2, Node(drive, 2))):
            prefix = "f" if number == 1 else "r"
            for k, name in enumerate(n for n in names if n.startswith((prefix + "l_", prefix + "r_"))):
                scale, offset, _ = scales[name]
                np.testing.assert_array_equal(np.rint(cells[:, names.index(name)] / scale + offset), node.counts[:, k])

    def test_a_drive_comes_back_with_its_pulses(self):
        drive = self.drive()
        pulses = self.root / "pulses.csv"
        file, said = self.export("csv", drive, "with_pulses.csv", "--pulses", pulses, "--vehicle", self.root / "drive.toml")
        lines = pulses.read_text().splitlines()
        self.assertEqual(lines[0], "time_s,wheel,kind")
        self.assertEqual(said["pulses"], len(lines) - 1)
        times = [float(line.split(",")[0]) for line in lines[1:]]
        self.assertEqual(times, sorted(times))
        back = self.import_of("drive_back", file, self.root / "drive.toml", "--pulses", pulses)
        for number in (1, 2):
            first, again = Node(drive, number), Node(back, number)
            np.testing.assert_array_equal(first.counts[:, :12], again.counts[:, :12])
            both = first.there & again.there
            self.assertGreater(both[:, 12].sum(), 5000)
            # The angle comes from the same pulses, at instants that differ by the stamps' last digit.
            np.testing.assert_allclose(first.counts[:, 12:][both[:, 12:]], again.counts[:, 12:][both[:, 12:]],
                                       rtol=0, atol=2**23 * 1e-4)
        again = self.root / "pulses_again.csv"
        self.export("csv", back, "again.csv", "--pulses", again)
        twice = again.read_text().splitlines()
        self.assertEqual([line.split(",")[1:] for line in lines], [line.split(",")[1:] for line in twice])
        np.testing.assert_allclose([float(line.split(",")[0]) for line in twice[1:]], times, rtol=0, atol=2e-9)

    def test_gives_the_time_and_the_channels_asked_for(self):
        file, said = self.export("csv", self.made, "part.csv", "--from", 2, "--to", 2.5, "--channels", "rear_side,front")
        names, _, cells = read(file)
        self.assertEqual(names, ["time_s", "rear_side", "front_up", "front_side"])
        rows = slice(1000, 1250)  # 2.5 s itself is not included
        np.testing.assert_allclose(cells[:, 0], np.arange(1000, 1250) / 500, atol=2e-9)
        np.testing.assert_array_equal(np.rint(cells[:, 1] / self.SCALE[3] + self.OFFSET[3]), self.counts[rows, 3])
        np.testing.assert_array_equal(np.rint(cells[:, 2] / self.SCALE[0]), self.counts[rows, 0])

    def test_refuses_what_cannot_be_and_leaves_nothing(self):
        (self.root / "empty").mkdir()
        (self.root / "is_there").write_text("mine")
        for arguments, code, words in (
                (("--format", "cvs", self.made, "-o", self.root / "x"), 2, "--format: cvs not in"),
                (("--format", "csv", self.root / "nowhere", "-o", self.root / "x"), 4, "nowhere"),
                (("--format", "csv", self.root / "empty", "-o", self.root / "x"), 4, "empty"),
                (("--format", "csv", self.made, "-o", self.root / "is_there"), 4, "is_there: exists already"),
                (("--format", "csv", self.made, "-o", self.root / "no" / "x"), 4, "no: no such folder"),
                (("--format", "csv", self.made, "-o", self.made / "x"), 4, "which stays as it is"),
                (("--format", "csv", self.made, "-o", self.root / "x", "--marks", self.made / "x"), 4, "which stays as it is"),
                (("--format", "csv", self.made, "-o", self.root / "x", "--vehicle", self.root / "is_there"), 4, "is_there: exists already"),
                (("--format", "csv", self.made, "-o", self.root / "x", "--pulses", self.root / "is_there"), 4, "is_there: exists already"),
                (("--format", "csv", self.made, "-o", self.root / "x", "--pulses", self.root / "x"), 2, "--pulses"),
                (("--format", "csv", self.made, "-o", self.root / "x", "--vehicle", self.root / "x"), 2, "--vehicle"),
                (("--format", "csv", self.made, "-o", self.root / "x", "--channels", "roof"), 2, "front_side"),
                (("--format", "csv", self.made, "-o", self.root / "x", "--from", 50), 2, "no sample"),
                (("--format", "csv", self.made, "-o", self.root / "x", "--from", 5, "--to", 5), 2, "--to")):
            done = rb("export", *arguments)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(words, done.stderr)
            self.assertEqual(done.stdout, "")
        self.assertEqual((self.root / "is_there").read_text(), "mine")
        self.assertEqual([p for p in self.root.iterdir() if p.name.startswith("x")], [])

    def test_says_when_the_recording_is_damaged_and_marks_what_is_lost(self):
        damaged = self.root / "damaged"
        shutil.copytree(self.made, damaged)
        segment = damaged / "seg-000001.lcm"
        data = bytearray(segment.read_bytes())
        at = data.index(b"RB_BLOCK_1_SCAN", len(data) // 2) + 500  # inside of one block
        data[at] ^= 0x10
        segment.write_bytes(data)
        file, said = self.export("csv", damaged, "damaged.csv", code=[1])
        self.assertEqual(said["blocks_refused"] + said["blocks_missing"] > 0, True)
        _, _, cells = read(file)
        lost = np.isnan(cells[:, 1]) & self.there[:, 0]
        self.assertEqual(lost.sum(), 20)  # the scans of that block
        np.testing.assert_array_equal(np.isnan(cells[:, 3]), ~self.there[:, 2])

    def test_what_a_power_cut_tore_off_is_no_damage_but_of_a_finished_segment(self):
        for name, finished, code in (("copied-half", True, 1), ("power-cut", False, 3)):  # 3: the holes of `made`
            torn = self.root / name
            shutil.copytree(self.made, torn)
            segment = torn / "seg-000001.lcm"
            os.truncate(segment, segment.stat().st_size - 7)
            if not finished:
                for of_a_finished_one in ("manifest.json", "seg-000001.idx"):
                    (torn / of_a_finished_one).unlink()
            self.assertEqual(rb("verify", torn).returncode, code)
            for command in (("export", "--format", "csv", torn, "-o", self.root / f"{name}.csv"),
                            ("select", torn, "-o", self.root / f"{name}-selected")):
                done = rb(*command)
                self.assertEqual(done.returncode, code, f"{command}: {done.stderr}")
                self.assertEqual("is damaged" in done.stderr, finished)
            self.assertEqual("is damaged" in rb("levels", torn).stderr, finished)


if __name__ == "__main__":
    unittest.main()
