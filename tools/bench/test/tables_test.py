"""The tables of tools/bench: what counts as growth, what is drawn, how a log of LCM is counted, which rows are run."""

import dataclasses
import importlib.machinery
import importlib.util
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

BENCH = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(BENCH))
import drive  # noqa: E402
import programs  # noqa: E402


def load(name):
    loader = importlib.machinery.SourceFileLoader(name, str(BENCH / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    sys.dont_write_bytecode = True
    loader.exec_module(module)
    return module


growth = load("growth")


def curve(part, of, *costs):
    return [growth.Point(part, of, 2 ** k, cost, cost, 10.0 - k) for k, cost in enumerate(costs)]


EVERYTHING = [point for part in ("rb-node", "rb-recorder", "rb-analyser")
              for of in ("nodes", "rate, kHz", "channels of six nodes") for point in curve(part, of, 9.0, 8.0, 7.5)]
EVERYTHING += curve("cross spectra", "channels", 5.0, 10.0)


class Growth(unittest.TestCase):
    def test_is_faster_than_the_work_beyond_a_quarter(self):
        self.assertEqual([*growth.faster(curve("a", "b", 10.0, 9.0, 8.0))], [])
        self.assertEqual([*growth.faster(curve("a", "b", 10.0, 15.0, 12.4))], [])
        self.assertEqual([*growth.faster(curve("a", "b", 11.0, 10.0, 12.6))],
                         ["a grows faster than its work as b grow: 10 ns at 2, 12.6 ns at 4"])
        self.assertEqual([*growth.faster([point._replace(node_mb=mb) for point, mb in zip(
                             curve("a", "b", 10.0, 10.0), (8.0, 10.2))])],
                         ["a grows faster than its work as b grow: 8 MB a node at 1, 10.2 MB a node at 2"])
        self.assertEqual([*growth.faster([point._replace(node_mb=None) for point in curve("a", "b", 10.0, 10.0)])], [])

    def test_curves_are_apart_by_what_grows(self):
        self.assertEqual({key: len(points) for key, points in growth.curves(EVERYTHING).items()}["cross spectra", "channels"], 2)

    def test_is_drawn(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "growth.svg")
            growth.draw(EVERYTHING, file)
            picture = xml.etree.ElementTree.parse(file).getroot()
        self.assertTrue(picture.tag.endswith("svg"))
        told = "".join(picture.itertext())
        for title in ("Nodes, 16 channels", "Rate, 4 nodes", "Channels, 8 nodes", "Memory", "Cross spectra"):
            self.assertIn(title, told)


class Logs(unittest.TestCase):
    def count(self, *events, tail=b""):
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder, "log")
            log.write_bytes(b"".join(struct.pack(">IqqII", 0xEDA1DA01, 0, 0, len(channel), 3) + channel + b"abc"
                                     for channel in events) + tail)
            return programs.blocks_in(log)

    def test_blocks_are_counted_and_nothing_else(self):
        self.assertEqual(self.count(b"RB_BLOCK_1_SCAN", b"RB_ACK_1", b"RB_BLOCK_2_EDGE"), 2)

    def test_no_log_is_named(self):
        with self.assertRaisesRegex(RuntimeError, "no log of LCM at byte 46"):
            self.count(b"RB_BLOCK_1_SCAN", tail=28 * b"x")


class Calls(unittest.TestCase):
    def test_those_begun_in_time_are_counted_once(self):
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder, "log")
            log.write_text("7 10.0 read(3, 1) = 1\n7 11.0 poll( <unfinished ...>\n8 11.5 write(1, 2) = 2\n"
                           "7 12.0 <... poll resumed>) = 0\n7 12.5 --- SIGTERM {} ---\n7 12.6 +++ exited with 0 +++\n"
                           "7 13.0 close(3) = 0\n")
            self.assertEqual(drive.calls_between(log, 10.5, 13.0), 2)


class Rows(unittest.TestCase):
    def test_what_is_asked_is_met_or_missed_or_not_asked(self):
        row = programs.Row("a", 3.0, "ms", "b", 2.0, 1.5, "<=", 1.0)
        self.assertIs(row.met(), False)
        self.assertIs(dataclasses.replace(row, sign=">=").met(), True)
        self.assertIsNone(dataclasses.replace(row, sign=None).met())


class Run(unittest.TestCase):
    def run_bench(self, *arguments, **more):
        return subprocess.run([BENCH / "run", *arguments], capture_output=True, text=True, check=False, **more)

    def test_runs_the_rows_that_are_asked_for(self):
        done = self.run_bench("--only", "encoder")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = done.stdout.splitlines()[2:-1]
        self.assertEqual([row[:8] for row in rows], ["encoder,"] * 2, done.stdout)

    def test_says_that_no_row_has_the_name(self):
        done = self.run_bench("--only", "nonsense")
        self.assertEqual(done.returncode, 2)
        self.assertIn("nonsense", done.stderr)

    def test_names_a_program_that_is_not_there(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "CMakeCache.txt").write_text("CMAKE_BUILD_TYPE:STRING=Release\n")
            pathlib.Path(folder, "bin").mkdir()
            pathlib.Path(folder, "bin", "rb").touch()
            done = self.run_bench("--only", "pack", env=os.environ | {"RB_BIN": f"{folder}/bin"})
        self.assertEqual(done.returncode, 4)
        self.assertIn("bench-peers", done.stderr)


if __name__ == "__main__":
    unittest.main()
