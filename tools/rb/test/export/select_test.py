"""rb select: a part of a recording is a recording, the same bit for bit."""

import json
import shutil
import signal
import struct
import subprocess
import unittest

import numpy as np

from clocks_test import DRIFT, HOST_NS, OFFSET_NS, fit, insert, mark
from recorded import RB, Exports, Node, events, rb


def notes(folder):
    """(kind, host_ns, a, text) of each note."""
    for channel, data in events(folder):
        if channel == "RB_NOTE":
            _, _, host_ns, _, kind, a, _, size = struct.unpack_from(">qqqqiqqi", data)
            yield kind, host_ns, a, data[56:56 + size].decode()


def fits(folder, number):
    """(epoch, number, host_ns, node_ns) of each fit of a node's clock."""
    for channel, data in events(folder):
        if channel == f"RB_CLOCK_{number}":
            _, _, epoch, index, _, host_ns, node_ns = struct.unpack_from(">qiqqiqq", data)
            yield epoch, index, host_ns, node_ns


def gaps(folder, number):
    """(first scan, scans, cause) of each gap of a node."""
    for channel, data in events(folder):
        if channel == f"RB_BLOCK_{number}_GAP":
            _, _, _, _, first, scans, _, cause = struct.unpack_from(">qiqqqqqi", data)
            yield first, scans, cause


SUBSET, MARK, SOURCE_GAP = 19, 17, 6


class Select(Exports):
    def select(self, source, *options, code=0, name="part"):
        folder = self.root / name
        shutil.rmtree(folder, ignore_errors=True)
        done = rb("select", source, "-o", folder, "--json", *options)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertFalse(folder.with_name(name + ".part").exists())
        return folder, json.loads(done.stdout) if done.stdout else done.stderr

    def verdict(self, folder):
        done = rb("verify", folder)
        return done.returncode, done.stdout

    def same(self, part, whole, rows, channels=slice(0, 16)):
        """Counts, what is there and instants of a node are those of rows of the whole."""
        np.testing.assert_array_equal(part.there, whole.there[rows])
        np.testing.assert_array_equal(part.counts[:, channels], whole.counts[rows, channels])
        there = part.there[:, 0]
        np.testing.assert_array_equal(part.time_ns[there], whole.time_ns[rows][there])

    def test_a_stretch_without_a_gap_is_complete_and_bit_exact(self):
        """Borders stand in the middle of blocks of 20 scans."""
        folder, said = self.select(self.made, "--from", "1.014", "--to", "5.006")
        self.assertEqual(self.verdict(folder)[0], 0)
        rows = slice(507, 2503)
        for number in (1, 2):
            self.same(Node(folder, number), Node(self.made, number), rows)
        self.assertEqual([e["samples_recorded"] for e in said["record"]["nodes"]], [1996, 1996])
        told = [note for note in notes(folder) if note[0] == SUBSET]
        self.assertIn("part of made, from 1.014 s, to 5.006 s", told[0][3])
        self.assertIn("from 1.014 s to 5.006 s", told[1][3])

    def test_gaps_come_along_cut_at_the_borders_with_their_cause(self):
        """The rear's hole lies within, that of both nodes reaches over the end."""
        folder, said = self.select(self.made, "--from", 5.9, "--to", 10.5, code=3)
        code, told = self.verdict(folder)
        self.assertEqual(code, 3, told)
        self.assertIn("every gap declared", told)
        for number in (1, 2):
            whole, part = Node(self.made, number), Node(folder, number)
            self.same(part, whole, slice(2950, 5000))
            self.assertEqual(len(part.there), 2050)
        self.assertEqual(list(gaps(folder, 1)), [(2050, 250, SOURCE_GAP)])
        self.assertEqual(list(gaps(folder, 2)), [(50, 7, SOURCE_GAP), (2050, 250, SOURCE_GAP)])
        self.assertEqual([e["samples_missing"] for e in said["record"]["nodes"]], [250, 257])

    def test_nodes_and_channels_that_are_left_out_are_gone_and_unused(self):
        folder, _ = self.select(self.made, "--nodes", "rear", "--channels", "rear_side", "--to", 4)
        self.assertEqual(self.verdict(folder)[0], 0)
        whole, part = Node(self.made, 2), Node(folder, 2)
        np.testing.assert_array_equal(part.counts[:, 1], whole.counts[:2000, 1])
        self.assertFalse(part.counts[:, 0].any())
        self.assertFalse([channel for channel, _ in events(folder) if channel == "RB_BLOCK_1_SCAN"])
        _, told = self.export("csv", folder, "rear.csv")
        self.assertEqual([c["name"] for group in told["groups"] for c in group["channels"]], ["rear_side"])
        for options, words in ((("--nodes", "middle"), "allowed: front rear"), (("--channels", "none"), "rear_side"),
                               (("--nodes", "front", "--channels", "rear_up"), "in both")):
            _, said = self.select(self.made, *options, code=2)
            self.assertIn(words, said)

    def test_a_drive_keeps_its_edges_references_and_angles(self):
        drive = self.drive()
        folder, _ = self.select(drive, "--from", 2, "--to", 5)
        for number in (1, 2):
            whole = Node(drive, number)
            first = int(np.searchsorted(whole.time_ns, min(Node(drive, n).time_ns[0] for n in (1, 2)) + 2 * 10**9))
            self.same(Node(folder, number), whole, slice(first, first + 6000))
        pulses = {}
        for name, source, options in (("whole", drive, ("--from", 2, "--to", 5)), ("part", folder, ())):
            rb("export", "--format", "hdf5", source, "-o", self.root / f"{name}.h5", "--pulses", self.root / f"{name}.csv",
               *options)
            pulses[name] = [(float(t), wheel, kind) for t, wheel, kind in
                            (line.split(",") for line in (self.root / f"{name}.csv").read_text().splitlines()[1:])]
        begin = 2.0
        self.assertEqual(len(pulses["part"]), len(pulses["whole"]))
        self.assertGreater(len(pulses["part"]), 1000)
        for (t, *what), (t_whole, *what_whole) in zip(pulses["part"], pulses["whole"]):
            self.assertEqual(what, what_whole)
            self.assertAlmostEqual(t + begin, t_whole, places=8)

    def test_clocks_and_marks_come_along_and_times_are_the_hosts(self):
        source = self.root / "clocks"
        shutil.rmtree(source, ignore_errors=True)
        shutil.copytree(self.made, source)
        added = [fit(source, n, HOST_NS + OFFSET_NS[n], 0, DRIFT[n]) for n in (1, 2)]
        added += [mark(1, HOST_NS + 4 * 10**9, b"pothole"), mark(2, HOST_NS + 15 * 10**9, b"bridge")]
        insert(source, {0: added})
        whole = {n: Node(source, n) for n in (1, 2)}
        host_ns = {n: HOST_NS + OFFSET_NS[n] + whole[n].time_ns / (1 + DRIFT[n]) for n in (1, 2)}
        folder, _ = self.select(source, "--from-mark", 1, "--from", -0.5, "--to-mark", 1, "--to", 1)
        for n in (1, 2):
            at = HOST_NS + 4 * 10**9
            wanted = np.flatnonzero((host_ns[n] >= at - 5 * 10**8) & (host_ns[n] < at + 10**9))
            self.assertEqual(len(wanted), 750)
            self.same(Node(folder, n), whole[n], slice(wanted[0], wanted[-1] + 1))
            epoch = {struct.unpack_from(">q", d, 12)[0] for c, d in events(folder) if c == f"RB_BLOCK_{n}_SCAN"}
            self.assertEqual(set(fits(folder, n)), {(epoch.pop(), 1, HOST_NS + OFFSET_NS[n], 0)})
        self.assertEqual([note[1:] for note in notes(folder) if note[0] == MARK], [(HOST_NS + 4 * 10**9, 1, "pothole")])
        _, said = self.select(source, "--from-mark", 3, code=2)
        self.assertIn("--from-mark: 3: no such mark; allowed: 1 2", said)

    def test_clean_leaves_out_all_that_is_missing_of_any_node(self):
        lines = (self.root / "made.csv").read_text().splitlines()
        quiet = [[float(value) / 2 if value else None for value in line.split(",")[1:]] for line in lines[2:]]
        quiet[8500][0] = 50.0  # of a range of 50: overloaded, and the block of 20 with it
        text = [",".join([line.split(",")[0], *("" if v is None else repr(v) for v in values)])
                for line, values in zip(lines[2:], quiet)]
        (self.root / "quiet.csv").write_text("\n".join(lines[:2] + text) + "\n")
        source = self.import_of("quiet", self.root / "quiet.csv", self.root / "made.toml")
        _, said = self.select(source, "--clean")
        self.assertEqual([p["to_s"] for p in said["pieces"]], [6, 10, 19])  # the last is shorter than a second
        folder, said = self.select(source, "--clean", "--at-least", 0.5)
        self.assertEqual(self.verdict(folder)[0], 0)
        self.assertEqual([(round(p["from_s"], 9), round(p["to_s"], 9)) for p in said["pieces"]],
                         [(0, 6), (6.014, 10), (12, 19), (19.04, 20)])

    def test_speed_takes_the_time_in_which_the_car_was_so_fast(self):
        """The simulated car never stands: it speeds up and slows down all the time."""
        drive = self.drive()
        classes = json.loads(rb("levels", drive, "--json").stdout)["speed_classes"]
        least, most = (f([3.6 * c[k] for c in classes]) for f, k in ((min, "from_m_s"), (max, "to_m_s")))
        folder, said = self.select(drive, "--speed", f"{least}:{most}", "--at-least", 0.5)
        self.assertEqual(self.verdict(folder)[0], 0)
        self.assertGreater(sum(p["to_s"] - p["from_s"] for p in said["pieces"]), 4)
        _, said = self.select(drive, "--speed", f"{most + 1}:", code=2)
        self.assertIn("--speed", said)
        for wrong in ("fast", "80", ":", "90:80", "1:2:3"):
            self.assertIn("--speed", self.select(drive, "--speed", wrong, code=2)[1])

    def test_the_same_again_is_the_same_and_a_part_of_a_part_says_both(self):
        first, _ = self.select(self.made, "--to", 4, name="first")
        second, _ = self.select(self.made, "--to", 4, name="second")
        self.assertEqual((first / "seg-000001.lcm").read_bytes(), (second / "seg-000001.lcm").read_bytes())
        part, _ = self.select(first, "--from", 1)
        self.same(Node(part, 1), Node(self.made, 1), slice(500, 2000))
        words = " ".join(note[3] for note in notes(part) if note[0] == SUBSET)
        self.assertIn("part of made, to 4 s", words)
        self.assertIn("part of first, from 1 s", words)

    def test_an_epoch_without_an_end_stays_without_one_unless_the_part_ends_before(self):
        """What a crash of the recording computer leaves."""
        source = self.root / "open"
        shutil.rmtree(source, ignore_errors=True)
        shutil.copytree(self.made, source)
        (source / "seg-000001.idx").unlink()
        (source / "manifest.json").unlink()
        segment = source / "seg-000001.lcm"
        segment.write_bytes(segment.read_bytes()[:segment.stat().st_size * 9 // 10])
        self.assertEqual(self.verdict(source)[0], 3)
        self.assertIn("complete", self.verdict(self.select(source, "--to", 5)[0])[1].splitlines()[-1])
        rest, _ = self.select(source, "--from", 5, code=3)
        self.assertIn("no end", self.verdict(rest)[1])

    def damaged(self, whole):
        """Of which one bit is wrong, in the 21st block of samples of node 1."""
        source = self.root / "damaged"
        shutil.rmtree(source, ignore_errors=True)
        shutil.copytree(whole, source)
        segment = source / "seg-000001.lcm"
        log = bytearray(segment.read_bytes())
        at = -1
        for _ in range(21):
            at = log.index(b"RB_BLOCK_1_SCAN", at + 1)
        log[at + 100] ^= 1
        segment.write_bytes(log)
        return source

    def test_of_a_damaged_recording_all_say_the_same_and_end_alike(self):
        source = self.damaged(self.drive())
        words = ("damaged_bytes", "blocks_refused", "blocks_missing")
        warnings, counts = [], []
        for command in (("select",), ("reduce", "--factor", 2), ("export", "--format", "csv")):
            made = self.root / f"{command[0]} of damaged"
            done = rb(*command, source, "-o", made, "--json")
            self.assertEqual(done.returncode, 1, f"{command}: {done.stderr}")
            self.assertTrue(made.exists(), "the rest is there")
            said = json.loads(done.stdout)
            counts.append([said[word] for word in words])
            warnings += [line.replace(f"rb {command[0]}: ", "") for line in done.stderr.splitlines()
                         if "is damaged" in line]
        self.assertEqual(counts, [counts[0]] * 3)
        self.assertEqual(warnings, [warnings[0]] * 3)

    def test_what_is_missing_undeclared_becomes_a_declared_gap(self):
        folder, said = self.select(self.damaged(self.made), "--to", 5, code=1)
        self.assertEqual(said["blocks_refused"], 1)
        self.assertEqual(self.verdict(folder)[0], 3)
        self.assertEqual(list(gaps(folder, 1)), [(400, 20, 7)])

    def test_identification_of_all_of_a_drive_is_the_same_bit_for_bit_and_of_every_fourth_sample_nearly(self):
        folder = self.root / "long"
        rb("demo", "--headless", "--json", "--seed", 4, "--drive-seconds", 90, "--rate", "max", "--record", folder)
        part, _ = self.select(folder)
        fewer = self.root / "fewer"
        self.assertEqual(rb("reduce", folder, "-o", fewer, "--factor", 4).returncode, 0)
        whole, same, near = (json.loads(rb("identify", one, "--json").stdout) for one in (folder, part, fewer))
        self.assertEqual(whole, same)
        self.assertEqual(len(whole["wheels"]), 4)
        for one, other in zip(whole["wheels"], near["wheels"]):
            # The same samples behind another low-pass: far less than what a drive leaves unknown.
            self.assertLess(abs(one["unbalance_g"] - other["unbalance_g"]), 0.1 * one["sigma_g"])

    def test_it_refuses_what_cannot_be_and_leaves_nothing_when_it_is_stopped(self):
        _, said = self.select(self.made, "--from", 30, code=2)
        self.assertIn("no sample", said)
        _, said = self.select(self.made, "--from", 5, "--to", 5, code=2)
        self.assertIn("--to", said)
        taken = self.root / "taken"
        shutil.copytree(self.made, taken)
        self.assertEqual(rb("select", self.made, "-o", taken).returncode, 4)
        self.assertIn("no such file", rb("select", self.root / "none", "-o", self.root / "x").stderr.lower())
        drive = self.drive()
        for _ in range(5):
            process = subprocess.Popen([RB, "select", drive, "-o", self.root / "stopped"], stderr=subprocess.PIPE)
            process.send_signal(signal.SIGINT)
            process.communicate()
            self.assertIn(process.returncode, (0, 4, -signal.SIGINT))
            self.assertFalse((self.root / "stopped.part").exists())
            self.assertEqual((self.root / "stopped").exists(), process.returncode == 0)
            shutil.rmtree(self.root / "stopped", ignore_errors=True)

    def tearDown(self):
        shutil.rmtree(self.root / "drive", ignore_errors=True)


if __name__ == "__main__":
    unittest.main()
