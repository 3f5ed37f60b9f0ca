"""Recordings of nodes with clocks of their own or started again, and marks: events put in by hand."""

import json
import pathlib
import shutil
import struct
import sys
import unittest

import h5py
import numpy as np

import mdf4
from csv_test import read
from recorded import Exports, Node, rb

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "record_check" / "test"))
from records import event, message  # noqa: E402

HOST_NS = 10**12  # of the host's clock at the node's instant 0, about
DRIFT = {1: 40e-6, 2: -25e-6}
OFFSET_NS = {1: 0, 2: 123_456_789}


def insert(folder, added, among=b"_SCAN"):
    """Puts events before that many scan blocks; `among`: how the channels that count end."""
    segment = folder / "seg-000001.lcm"
    log, out, at, blocks = segment.read_bytes(), bytearray(), 0, 0
    while struct.unpack_from(">I", log, at)[0] == 0xEDA1DA01:
        _, _, _, name, size = struct.unpack_from(">IqqII", log, at)
        if log[at + 28:at + 28 + name].endswith(among):
            for data in added.get(blocks, []):
                out += data
            blocks += 1
        out += log[at:at + 28 + name + size]
        at += 28 + name + size
        if at + 28 > len(log):
            break
    segment.write_bytes(out)


def raw_events(folder):
    """Each event of the first segment, whole."""
    log, at = (folder / "seg-000001.lcm").read_bytes(), 0
    while at + 28 <= len(log) and struct.unpack_from(">I", log, at)[0] == 0xEDA1DA01:
        _, _, _, name, size = struct.unpack_from(">IqqII", log, at)
        yield log[at + 28:at + 28 + name], log[at:at + 28 + name + size]
        at += 28 + name + size


def epoch_of(folder, number):
    log = (folder / "seg-000001.lcm").read_bytes()
    at = log.index(f"RB_BLOCK_{number}_SCAN".encode()) + len(f"RB_BLOCK_{number}_SCAN")
    return struct.unpack_from(">q", log, at + 12)[0]


def fit(folder, number, host_ns, node_ns, drift, index=1, state=1, breaks=0):
    return event(f"RB_CLOCK_{number}".encode(),
                 message("clock_fit_t", node=number, epoch=epoch_of(folder, number), number=index, state=state, breaks=breaks,
                         host_ns=host_ns, node_ns=node_ns, drift=drift, uncertainty_s=1e-5, exchanges=10))


def mark(number, host_ns, text):
    return event(b"RB_NOTE", message("note_t", time_us=1_700_000_000_000_000 + host_ns // 1000, host_ns=host_ns,
                                     incarnation=1, kind=17, a=number, size=len(text),
                                     text=text + bytes(400 - len(text))))


class Clocks(Exports):
    def with_clocks(self, source=None, nodes=(1, 2), after=0):
        folder = self.root / "clocks"
        shutil.copytree(source or self.made, folder)
        fits = [fit(folder, n, HOST_NS + OFFSET_NS[n], 0, DRIFT[n]) for n in nodes]
        insert(folder, {after: [*fits, mark(1, HOST_NS + 4 * 10**9, b"pothole")]})
        return folder

    def host_s(self, folder, number):
        node = Node(folder, number)
        return node, (HOST_NS + OFFSET_NS[number] + node.time_ns / (1 + DRIFT[number])) * 1e-9

    def test_each_node_has_its_own_instants_on_the_hosts_time(self):
        folder = self.with_clocks()
        front, front_s = self.host_s(folder, 1)
        rear, rear_s = self.host_s(folder, 2)
        path, said = self.export("hdf5", folder, "clocks.h5")
        with h5py.File(path) as data:
            for name, node, time_s in (("front", front, front_s), ("rear", rear, rear_s)):
                there = node.there[:, 0]
                np.testing.assert_allclose(data[name]["time_s"][...][there], time_s[there] - front_s[0], rtol=0, atol=1e-8)
                self.assertTrue((np.diff(data[name]["time_s"]) > 0).all())
                np.testing.assert_array_equal(data[name][name + "_up"][...][there], node.counts[there, 0])
        rates = {group["name"]: group["rate_hz"] for group in said["groups"]}
        for number, name in ((1, "front"), (2, "rear")):
            self.assertAlmostEqual(rates[name], 500 * (1 + DRIFT[number]), places=5)
        self.assertAlmostEqual(said["marks"][0]["time_s"], HOST_NS * 1e-9 + 4 - front_s[0], places=7)
        self.assertTrue(said["start_by_clock"])
        self.assertAlmostEqual(said["start_utc_us"], 1.7e15 + front_s[0] * 1e6, delta=2)

    def test_marks_behind_the_first_hundred_thousand_are_not_left_out_in_silence(self):
        folder = self.with_clocks()
        insert(folder, {0: [mark(2 + k, HOST_NS + 4 * 10**9 + k, b"") for k in range(100_002)]})
        for form in ("csv", "hdf5", "mcap", "mdf4"):
            done = rb("export", "--format", form, folder, "-o", self.root / f"many.{form}", "--json", "--channels", "front")
            self.assertEqual(done.returncode, 3, done.stderr)
            self.assertIn("3 marks left out", done.stderr)
            said = json.loads(done.stdout)
            self.assertEqual((len(said["marks"]), said["marks_left_out"]), (100_000, 3))
        _, said = self.export("csv", self.made, "few.csv")
        self.assertEqual(said["marks_left_out"], 0)

    def test_mdf4_has_a_group_for_each_node_and_the_mark(self):
        path, _ = self.export("mdf4", self.with_clocks(), "clocks.mf4")
        file = mdf4.File(path)
        self.assertEqual([group.name for group in file.groups], ["front", "rear"])
        self.assertEqual([text for _, text in file.events], ["pothole"])
        shutil.rmtree(self.root / "clocks")

    def test_csv_takes_one_node_and_says_so(self):
        folder = self.with_clocks()
        done = rb("export", "--format", "csv", folder, "-o", self.root / "two.csv")
        self.assertEqual(done.returncode, 2)
        self.assertIn("front rear", done.stderr)
        self.assertFalse((self.root / "two.csv").exists())
        path, _ = self.export("csv", folder, "rear.csv", "--channels", "rear")
        _, _, cells = read(path)
        node, time_s = self.host_s(folder, 2)
        _, front_s = self.host_s(folder, 1)
        there = node.there[:, 0]
        np.testing.assert_allclose(cells[there[:len(cells)], 0], time_s[there] - front_s[0], rtol=0, atol=1e-8)

    def test_a_node_that_was_started_again_goes_on_in_the_same_columns(self):
        """What the first run still had to send came behind the beginning of the second."""
        later = [f"{float(line.split(',')[0]) + 30:.9f}," + line.split(",", 1)[1] if k > 1 else line
                 for k, line in enumerate((self.root / "made.csv").read_text().splitlines())]
        (self.root / "later.csv").write_text("\n".join(later) + "\n")
        second = self.import_of("second", self.root / "later.csv", self.root / "made.toml")
        shutil.copytree(self.made, self.root / "clocks")
        first = list(raw_events(self.made))
        late = [k for k, (channel, _) in enumerate(first) if channel == b"RB_BLOCK_1_SCAN"][-60:]
        log = [data for k, (_, data) in enumerate(first) if k not in late]
        log += [data for _, data in raw_events(second)] + [first[k][1] for k in late]
        (self.root / "clocks" / "seg-000001.lcm").write_bytes(b"".join(log))
        path, said = self.export("csv", self.root / "clocks", "again.csv", code=(0, 1, 3))
        names, _, cells = read(path)
        self.assertEqual(names, ["time_s", *self.CHANNELS])
        self.assertEqual(len(cells), 15_000 + self.ROWS)  # 30 s at 500 Hz
        np.testing.assert_allclose(cells[:, 0], np.arange(25_000) / 500, rtol=0, atol=5e-9)
        for begin in (0, 15_000):
            part = cells[begin:begin + self.ROWS, 1:]
            np.testing.assert_array_equal(np.isnan(part), ~self.there)
            np.testing.assert_array_equal(np.rint(part / self.SCALE + self.OFFSET)[self.there], self.counts[self.there])
        self.assertTrue(np.isnan(cells[self.ROWS:15_000, 1:]).all())
        self.assertEqual(said["rows_missing"], 2 * (2 * 1000 + 5000) + 2 * 7)

    def test_pulses_before_the_first_fit_are_on_the_clock_of_the_samples(self):
        drive = self.drive()
        _, truth = self.export("hdf5", drive, "truth.h5", "--pulses", self.root / "truth.csv")
        folder = self.with_clocks(drive, after=400)
        front_s, rear_s = (self.host_s(folder, n)[1][0] for n in (1, 2))
        start_s = min(front_s, rear_s)
        path, said = self.export("hdf5", folder, "late.h5", "--pulses", self.root / "late.csv")
        with h5py.File(path) as data:
            self.assertAlmostEqual(data["front"]["time_s"][0], front_s - start_s, places=8)
        self.assertEqual(said["pulses"], truth["pulses"])
        read_pulses = lambda name: [line.split(",") for line in (self.root / name).read_text().splitlines()[1:]]
        late, true = read_pulses("late.csv"), read_pulses("truth.csv")
        times = [float(time_s) for time_s, _, _ in late]
        self.assertEqual(times, sorted(times))
        node_start_s = min(Node(drive, n).time_ns[0] for n in (1, 2)) * 1e-9
        for wheels, number in ((("front_left", "front_right"), 1), (("rear_left", "rear_right"), 2)):
            for wheel in wheels:
                node_s = np.array([float(time_s) for time_s, name, _ in true if name == wheel]) + node_start_s
                expected = HOST_NS * 1e-9 + OFFSET_NS[number] * 1e-9 + node_s / (1 + DRIFT[number]) - start_s
                found = [float(time_s) for time_s, name, _ in late if name == wheel]
                np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)

    def test_a_node_whose_clock_is_never_known_is_left_out_and_named(self):
        folder = self.with_clocks(nodes=(1,))
        done = rb("export", "--format", "hdf5", folder, "-o", self.root / "one.h5", "--json")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn(f"node rear: its clock is not known, {self.ROWS} samples left out", done.stderr)
        said = json.loads(done.stdout)
        self.assertEqual(said["left_out"], [{"node": "rear", "samples": self.ROWS}])
        self.assertEqual([group["name"] for group in said["groups"]], ["front"])
        self.assertAlmostEqual(said["marks"][0]["time_s"], HOST_NS * 1e-9 + 4 - self.host_s(folder, 1)[1][0], places=7)
        with h5py.File(self.root / "one.h5") as data:
            self.assertEqual([name for name in data if isinstance(data[name], h5py.Group)], ["front"])
            self.assertEqual(data["front"]["time_s"][0], 0)

    def test_behind_a_break_of_the_time_base_samples_go_on_and_pulses_are_left_out(self):
        """Until the next fit nobody knows how the node's clock stands."""
        drive = self.drive()
        folder = self.root / "clocks"
        shutil.copytree(drive, folder)
        first = fit(folder, 1, HOST_NS, 0, 0.0)
        broken = fit(folder, 1, 0, 0, 0.0, index=2, state=0, breaks=1)
        again = fit(folder, 1, HOST_NS + 2 * 10**9, 0, 0.0, index=3, breaks=1)
        insert(folder, {0: [first], 200: [broken], 400: [again]}, b"RB_BLOCK_1_SCAN")
        _, said = self.export("hdf5", folder, "break.h5", "--channels", "front", "--pulses", self.root / "break.csv")
        with h5py.File(self.root / "break.h5") as data:
            steps = np.diff(data["front"]["time_s"])
        jumps = steps[steps > 1.5]
        self.assertEqual(len(jumps), 1)
        np.testing.assert_allclose(steps[steps < 1.5], 1 / 2000, rtol=0, atol=2e-9)
        self.assertAlmostEqual(jumps[0], 2 + 1 / 2000, places=7)
        self.assertGreater(said["pulses_left_out"], 0)

    def test_info_says_which_clock_was_never_known(self):
        folder = self.root / "clocks"
        shutil.copytree(self.made, folder)
        insert(folder, {0: [fit(folder, 1, 10**9, 0, 0.0, state=0), fit(folder, 2, HOST_NS, 0, DRIFT[2])]})
        self.assertIn("  clock: not known: 10 answers, 0 questions without\n", rb("info", folder).stdout)
        told = {clock["node"]: clock for clock in json.loads(rb("info", folder, "--json").stdout)["clocks"]}
        self.assertEqual([told[1]["drift"], told[1]["uncertainty_s"]], [None, None])
        self.assertEqual([told[2]["drift"], told[2]["uncertainty_s"]], [DRIFT[2], 1e-5])

    def tearDown(self):
        shutil.rmtree(self.root / "clocks", ignore_errors=True)

    def test_a_candump_log_of_the_node_that_began_later_keeps_its_instants(self):
        folder = self.with_clocks()
        log, dbc, marks = (self.root / f"rear.{end}" for end in ("log", "dbc", "marks"))
        self.export("candump", folder, "rear.log", "--channels", "rear", "--dbc", dbc, "--marks", marks)
        front, rear = (self.host_s(folder, n)[1] for n in (1, 2))
        head, node = (self.root / "made.toml").read_text().split("[[node]]\nname = \"front\"")
        (self.root / "rear.toml").write_text(head + "[[node]]" + node.split("[[node]]", 1)[1])
        back = self.root / "rear"
        done = rb("import", "candump", "--samples", log, "--dbc", dbc, "--marks", marks, "--vehicle", self.root / "rear.toml", "-o", back)
        self.assertIn(done.returncode, (0, 3), done.stderr)
        self.assertGreater(rear[0] - front[0], 0.12)
        self.assertAlmostEqual(Node(back, 2).time_ns[0] * 1e-9, rear[0] - front[0], delta=2e-6)
        again = self.root / "rear-again.marks"  # counts from the rear node's first sample, which is the first now
        self.export("csv", back, "rear-again.csv", "--marks", again)
        said = float(again.read_text().split("\n")[1].split(",")[0])
        self.assertAlmostEqual(said, (HOST_NS + 4 * 10**9) * 1e-9 - rear[0], delta=2e-6)


if __name__ == "__main__":
    unittest.main()
