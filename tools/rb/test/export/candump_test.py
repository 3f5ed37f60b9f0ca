"""rb export --format candump, read back by can-utils, by rb import candump, and by its description alone."""

import re
import unittest

import numpy as np

from recorded import REFERENCES, Exports, Node, rb, run

LINE = re.compile(r"\((\d{10})\.(\d{6})\) can0 ([0-9A-F]{3})#([0-9A-F]*)")
SIGNAL = re.compile(r'BO_ (\d+) (\w+): 4 \w+\n SG_ (\w+) : 0\|32@1- \(([^,]+),([^)]+)\) \[0\|0\] "([^"]*)"')


def number(data):
    return int.from_bytes(bytes.fromhex(data), "little", signed=True)


class Candump(Exports):
    def log(self, name, folder, *options, code=(0, 3)):
        dbc = self.root / f"{name}.dbc"
        file, _ = self.export("candump", folder, f"{name}.log", "--dbc", dbc, *options, code=code)
        return file, dbc

    def import_as(self, name, file, dbc, vehicle=None, *more):
        folder = self.root / name
        done = rb("import", "candump", "--samples", file, "--dbc", dbc, "--vehicle", vehicle or self.root / "made.toml", "-o", folder, *more)
        return folder, done

    def test_has_every_count_at_its_microsecond_and_nothing_where_samples_are_missing(self):
        file, dbc = self.log("made", self.made, code=[3])
        first, *lines = file.read_text().splitlines()
        meaning = re.search(r"\nBO_ 254 recording_start: 4 roadbalance\n SG_ channels_crc32c : 0\|32@1\+ \(1,0\) \[(\d+)\|\1\] ", dbc.read_text())
        can_id, data = LINE.fullmatch(first).groups()[2:]
        self.assertEqual((can_id, int.from_bytes(bytes.fromhex(data), "little")), ("0FE", int(meaning[1])))
        signals = {int(number): rest for number, *rest in SIGNAL.findall(dbc.read_text())}
        names = [signals[k][0] for k in sorted(signals)]
        self.assertEqual(tuple(names), self.CHANNELS)
        found = np.full((self.ROWS, 4), np.iinfo("i8").min)
        empty, first_us = [], None
        for line in lines:
            seconds, micros, can_id, data = LINE.fullmatch(line).groups()
            time_us = int(seconds) * 1_000_000 + int(micros)
            first_us = time_us if first_us is None else first_us
            row, left_us = divmod(time_us - first_us + 1, 1_000_000 // self.RATE_HZ)
            self.assertLessEqual(left_us, 2)
            if can_id == "0FF":
                self.assertEqual(data, "")
                empty.append(row)
            else:
                found[row, names.index(signals[int(can_id, 16)][0])] = number(data)
        np.testing.assert_array_equal(found != np.iinfo("i8").min, self.there)
        np.testing.assert_array_equal(found[self.there], self.counts[self.there])
        self.assertEqual(empty, list(range(self.HOLE.start, self.HOLE.stop)))
        for c, name in enumerate(self.CHANNELS):
            _, signal, scale, offset, unit = signals[0x100 + c]
            self.assertEqual((signal, float(scale), unit), (name, self.SCALE[c], "m/s^2"))
            there = self.there[:, c]
            np.testing.assert_allclose(found[there, c] * float(scale) + float(offset), self.values[there, c], rtol=1e-12, atol=1e-12)

    def test_can_utils_reads_every_frame(self):
        file, _ = self.log("played", self.made, "--to", 2, code=[3, 0])
        frames = [LINE.fullmatch(line).groups() for line in file.read_text().splitlines()]
        asc = self.root / "played.asc"
        done = run("log2asc", "-I", file, "-O", asc, "can0")
        self.assertEqual(done.returncode, 0, done.stderr)
        read = re.findall(r"^\s*([\d.]+)\s+1\s+([0-9A-F]+)\s+Rx\s+d (\d)((?: [0-9A-F]{2})*)", asc.read_text(), re.M)
        self.assertEqual(len(read), len(frames))
        first_us = int(frames[0][0]) * 1_000_000 + int(frames[0][1])
        for (time_s, can_id, size, data), (seconds, micros, sent_id, sent) in zip(read, frames):
            self.assertEqual((int(can_id, 16), data.replace(" ", ""), int(size)), (int(sent_id, 16), sent, len(sent) // 2))
            self.assertAlmostEqual(float(time_s), (int(seconds) * 1_000_000 + int(micros) - first_us) * 1e-6, delta=1.1e-4)

    def test_comes_back_count_for_count_and_gap_for_gap(self):
        for name, folder, nodes in (("back", self.made, (1, 2)), ("wobbled", self.wobble(), (1,))):
            file, dbc = self.log(name, folder, "--vehicle", self.root / f"{name}.toml")
            back, done = self.import_as(f"{name}-again", file, dbc, self.root / f"{name}.toml")
            self.assertIn(done.returncode, (0, 3), done.stderr)
            for number_of_node in nodes:
                was, found = Node(folder, number_of_node), Node(back, number_of_node)
                np.testing.assert_array_equal(found.there, was.there)
                np.testing.assert_array_equal(found.counts[found.there], was.counts[was.there])

    def test_a_part_of_a_drive_stays_in_step_with_its_pulses_and_marks(self):
        drive = self.drive()
        file, dbc = self.log("part", drive, "--from", 2, "--to", 5, "--vehicle", self.root / "part.toml",
                             "--pulses", self.root / "part.pulses")
        marks = 'time_s,number,text\n2.500000000,1,"bump"\n'
        (self.root / "part.marks").write_text(marks)
        back, done = self.import_as("part", file, dbc, self.root / "part.toml", "--pulses", self.root / "part.pulses",
                                    "--marks", self.root / "part.marks")
        self.assertEqual(done.returncode, 0, done.stderr)
        for number_of_node in (1, 2):
            was, found = Node(drive, number_of_node), Node(back, number_of_node)
            from_start_s = (was.time_ns - was.time_ns[0]) * 1e-9
            rows = (from_start_s >= 2) & (from_start_s < 5)
            np.testing.assert_array_equal(found.counts[:, :REFERENCES], was.counts[rows, :REFERENCES])
            np.testing.assert_allclose(found.time_ns * 1e-9, from_start_s[rows], rtol=0, atol=2e-6)
            # The angles, computed anew from the pulses: wheels turn by more than 360 degrees a second.
            for line in range(2):
                cos_sin = slice(REFERENCES + 2 * line, REFERENCES + 2 * line + 2)
                both = was.there[rows, cos_sin].all(axis=1) & found.there[:, cos_sin].all(axis=1)
                self.assertGreater(both.sum(), 0.7 * rows.sum())
                then, now = (c[both, cos_sin] @ [1, 1j] for c in (was.counts[rows], found.counts))
                self.assertLess(np.abs(np.angle(now * then.conj())).max(), np.radians(3))
        again = self.root / "part-again.marks"  # times of an export count from its recording's first sample
        self.export("csv", back, "part-again.csv", "--marks", again)
        self.assertAlmostEqual(float(again.read_text().split("\n")[1].split(",")[0]), 0.5, delta=2e-6)

    def test_refuses_the_description_of_other_channels(self):
        file, dbc = self.log("mine", self.made, code=[0, 3])
        other = self.root / "other.toml"
        text = (self.root / "made.toml").read_text()
        cases = {"turned": ("scale_m_s2_per_count = 0.0000025", "scale_m_s2_per_count = 0.000005")}
        for name, (old, new) in cases.items():
            other.write_text(text.replace(old, new))
            folder = self.root / f"{name}-made"
            self.assertEqual(rb("import", "csv", "--samples", self.root / "made.csv", "--vehicle", other, "-o", folder).returncode, 3)
            _, theirs = self.log(name, folder, code=[0, 3])
            for log, description in ((file, theirs), (self.root / f"{name}.log", dbc)):
                back, done = self.import_as(f"{name}-back", log, description)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn(f"{log.name}:1: its channels are not those of ", done.stderr)
                self.assertFalse(back.exists())
        swapped = dbc.read_text().replace(": 4 front", ": 4 behind").replace(": 4 rear", ": 4 front").replace(": 4 behind", ": 4 rear")
        (self.root / "swapped.dbc").write_text(swapped)
        _, done = self.import_as("swapped", file, self.root / "swapped.dbc")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("channel front_up comes from node rear", done.stderr)

    def test_refuses_a_log_without_its_start_which_alone_tells_cars_apart(self):
        file, dbc = self.log("whole", self.made, code=[0, 3])
        meaning = re.search(r"\[(\d+)\|\1\]", dbc.read_text())[1]
        other = dbc.read_text().replace(f"[{meaning}|{meaning}]", f"[{int(meaning) ^ 1}|{int(meaning) ^ 1}]")
        # Two channels of one node change places: names and nodes are still the vehicle's.
        other = other.replace("front_up", "front_there").replace("front_side", "front_up").replace("front_there", "front_side")
        theirs = self.root / "theirs-whole.dbc"
        theirs.write_text(other)
        start, text = file.read_text().split("\n", 1)
        lines = text.split("\n")
        headless, late = self.root / "headless.log", self.root / "late.log"
        headless.write_text(text)
        late.write_text("\n".join([*lines[:8], start, *lines[8:]]))
        for log in (headless, late):
            for description in (theirs, dbc):
                back, done = self.import_as("headless", log, description)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn(f"{log.name}:1: no frame recording_start stands before it", done.stderr)
                self.assertIn("allowed: the log of rb export from its first line on", done.stderr)
                self.assertFalse(back.exists())

    def test_identifiers_and_columns_do_not_depend_on_what_is_exported(self):
        file, dbc = self.log("some", self.made, "--channels", "rear_side,front_up", "--to", 1)
        ids = {line.split()[2][:3] for line in file.read_text().splitlines()} - {"0FE", "0FF"}
        self.assertEqual(ids, {"100", "103"})
        self.assertEqual({int(number): name for number, name, *_ in SIGNAL.findall(dbc.read_text())}, {0x100: "front_up", 0x103: "rear_side"})
        table, _ = self.export("csv", self.made, "some.csv", "--channels", "rear_side,front_up", code=(0, 3))
        self.assertEqual(table.read_text().split("\n", 1)[0], "time_s,rear_side,front_up")

    def test_refuses_a_log_of_two_recordings(self):
        file, dbc = self.log("one", self.made, "--to", 1)
        twice = self.root / "twice.log"
        twice.write_text(file.read_text() * 2)
        folder, done = self.import_as("twice", twice, dbc)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn(f"twice.log:{file.read_text().count(chr(10)) + 1}: a recording's start behind its frames", done.stderr)
        self.assertFalse(folder.exists())

    def test_takes_a_log_of_somebody_elses_sensors(self):
        dbc = self.root / "theirs.dbc"
        dbc.write_text('VERSION ""\nBU_: ecu\nBO_ 2364540158 Front: 4 ecu\n SG_ front_up : 7|16@0- (0.001,0) [-30|30] "g" ecu\n'
                       ' SG_ front_side : 23|16@0- (0.01,0) [-327|327] "m/s^2" ecu\n'
                       'BO_ 291 Rear: 3 ecu\n SG_ rear_up : 0|12@1- (0.01,0) [-20|20] "m/s^2" ecu\n'
                       ' SG_ rear_side : 12|12@1- (0.01,1) [-18|20] "m/s^2" ecu\n')
        rng, lines = np.random.default_rng(2), []
        up, side, low, high = rng.integers(-3000, 3000, (4, 1000)) // np.array([[1], [2], [2], [2]])
        for k in range(1000):
            stamp = f"({1700000000 + (2 * k) // 1000}.{2 * k % 1000:03d}000) can1"
            front = int(up[k]).to_bytes(2, "big", signed=True) + int(side[k]).to_bytes(2, "big", signed=True)
            rear = (int(low[k]) & 0xFFF) | (int(high[k]) & 0xFFF) << 12
            lines += [f"{stamp} 0CF004FE#{front.hex().upper()}", f"{stamp} 123#{rear.to_bytes(3, 'little').hex().upper()}",
                      f"{stamp} 7DF#0102", f"{stamp} 123#R", f"{stamp} 20000080#0000000000000000"]
        file = self.root / "theirs.log"
        file.write_text("\n".join(lines) + "\n")
        folder, done = self.import_as("theirs", file, dbc)
        self.assertEqual(done.returncode, 0, done.stderr)
        front, rear = Node(folder, 1), Node(folder, 2)
        np.testing.assert_array_equal(front.counts[:, 0], np.rint(up * 0.001 * 9.80665 * 2**23 / 50))
        # Half a count above a whole one: either neighbour is as near.
        np.testing.assert_allclose(front.counts[:, 1], side * 0.01 / 2.5e-6 + 1234.5, rtol=0, atol=0.5001)
        np.testing.assert_array_equal(rear.counts[:, 0], np.rint(low * 0.01 * 2**23 / 50))
        np.testing.assert_allclose(rear.counts[:, 1], (high * 0.01 + 1) / 2.5e-6 + 1234.5, rtol=0, atol=0.5001)

    def test_says_what_is_wrong(self):
        file, dbc = self.log("good", self.made, "--to", 1, code=[0, 3])
        (start, text), description = file.read_text().split("\n", 1), dbc.read_text()
        start, lines = start + "\n", text.split("\n")
        for k, (log, words) in enumerate((
                ("", "no frame"), ("neither this nor that\n", ":2: \"neither this nor that\" is no frame"),
                (text[:-3], f":{len(lines)}: 3 bytes; message"), ("\n".join([*lines[4:8], *lines[:4]]), ":6: its time goes back"),
                ("\n".join([lines[0], *lines]), ":3: front_up stands twice"), (text.replace("can0 103", "can1 103"), ":5: frames of can1 and can0"),
                ("\n".join([*lines[:4], *(line.replace(line[1:line.index(".")], "4294967295") for line in lines[4:8])]), ":6: its time is too far off"))):
            bad = self.root / f"bad{k}.log"
            bad.write_text(start + log)
            folder, done = self.import_as(f"bad{k}", bad, dbc)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(f"bad{k}.log", done.stderr)
            self.assertIn(words, done.stderr)
            self.assertFalse(folder.exists())
        dbc.write_text(description.replace('"m/s^2"', '"furlong"'))
        self.assertIn("good.log: channel front_up: its unit", self.import_as("units", file, dbc)[1].stderr)
        self.assertIn("furlong", self.import_as("units", file, dbc)[1].stderr)
        self.assertEqual(self.import_as("none", self.root / "none", self.root / "good.dbc")[1].returncode, 4)
        done = rb("export", "--format", "candump", self.made, "-o", self.root / "no.log")
        self.assertEqual(done.returncode, 2)
        self.assertIn("--dbc", done.stderr)
        self.assertFalse((self.root / "no.log").exists())
        done = rb("export", "--format", "csv", self.made, "-o", self.root / "no.csv", "--dbc", self.root / "no.dbc")
        self.assertEqual(done.returncode, 2)


if __name__ == "__main__":
    unittest.main()
