"""What a recording holds, read without any of the product's code, and made for the tests by the product's programs."""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

TOOLS = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(TOOLS))

from record_check.event_log import split_events  # noqa: E402
from record_check.wire_types import WireType  # noqa: E402

SCAN_BLOCK = WireType("scan_block_t", (TOOLS.parent / "common/wire/scan_block_t.lcm").read_text(encoding="utf-8"))
RB = pathlib.Path(os.environ["RB_BIN"], "rb")
DATA = pathlib.Path(__file__).resolve().parent.parent / "data"
REFERENCES = 12  # channels of accelerations before them
NO_REFERENCE = (2, 4)  # bits of quality, for lines 0 and 1


def run(*command):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)


def rb(*arguments):
    return run(RB, *arguments)


def events(folder):
    """(channel, data) of each event of each segment."""
    for segment in sorted(pathlib.Path(folder).glob("seg-*.lcm")):
        log = segment.read_bytes()
        for channel, begin, end in split_events(log)[0]:
            yield channel.decode(), log[begin:end]


class Node:
    """Scans of a node: counts [scan, channel], time_ns; `there`: which scans are recorded."""

    def __init__(self, folder, number):
        blocks = {}
        for channel, data in events(folder):
            if channel != f"RB_BLOCK_{number}_SCAN":
                continue
            block = SCAN_BLOCK.decode(data)
            sequence, first, time_ns, period_ps, quality = (
                block[field] for field in ("sequence", "first_scan", "time_ns", "period_ps", "quality"))
            counts = np.array(block["counts"], "i4").reshape(20, 16)[:block["scans"]]
            blocks[sequence] = first, time_ns, period_ps, quality, counts
        end = max(first + len(counts) for first, _, _, _, counts in blocks.values())
        self.counts = np.zeros((end, 16), "i4")
        self.there = np.zeros((end, 16), bool)
        self.time_ns = np.zeros(end, "i8")
        for first, time_ns, period_ps, quality, counts in blocks.values():
            rows = slice(first, first + len(counts))
            self.counts[rows] = counts
            self.there[rows] = True
            for line, bit in enumerate(NO_REFERENCE):
                if quality & bit:
                    self.there[rows, REFERENCES + 2 * line:REFERENCES + 2 * line + 2] = False
            self.time_ns[rows] = time_ns + np.arange(len(counts)) * period_ps // 1000


VEHICLE = """
name = "test car"
[model]
kind = "seven_dof"
body_mass_kg = 1400
roll_inertia_kg_m2 = 500
pitch_inertia_kg_m2 = 2000
[model.front]
x_m = 1.3
half_track_m = 0.8
spring_n_m = 30000
damper_n_s_m = 2500
stabiliser_n_m = 10000
tyre_n_m = 250000
[model.rear]
x_m = -1.5
half_track_m = 0.8
spring_n_m = 30000
damper_n_s_m = 2500
stabiliser_n_m = 10000
tyre_n_m = 250000
"""


def vehicle_toml(rate_hz):
    """Two nodes of two channels, one of them with an offset and a scale of its own."""
    text = VEHICLE
    for wheel in ("front_left", "front_right", "rear_left", "rear_right"):
        text += f'[[wheel]]\nname = "{wheel}"\nmass_kg = 40\nrolling_radius_m = 0.3\nweight_radius_m = 0.2\n'
    for number, node in enumerate(("front", "rear"), 1):
        text += f'[[node]]\nname = "{node}"\nid = {number}\nrate_hz = {rate_hz}\n'
        text += f'[[node.channel]]\nname = "{node}_up"\nmount = "body"\nposition_m = [1, 0.5, 0]\nrange_m_s2 = 50\n'
        text += f'[[node.channel]]\nname = "{node}_side"\nmount = "body"\nposition_m = [0, 0, 0.25]\ndirection = [0, 1, 0]\nrange_m_s2 = 20\n'
        text += "calibration = { scale_m_s2_per_count = 0.0000025, offset_counts = 1234.5 }\n"
    return text


class Exports(unittest.TestCase):
    """Three recordings: `made` of known counts with a hole in one node and one in both, `wobble` of somebody else's car,
    `drive` of the simulated one with wheel angles."""

    RATE_HZ = 500
    ROWS = 10_000
    REAR_HOLE = slice(3000, 3007)
    HOLE = slice(5000, 6000)
    CHANNELS = ("front_up", "front_side", "rear_up", "rear_side")
    SCALE = np.array([50 / 2**23, 2.5e-6] * 2)
    OFFSET = np.array([0, 1234.5] * 2)

    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="rb-export-"))
        cls.addClassCleanup(shutil.rmtree, cls.root)
        cls.made = cls.root / "made"
        cls.make()

    @classmethod
    def make(cls):
        """Counts by chance from full scale to full scale, and what becomes of them where there are holes."""
        chance = np.random.default_rng(1)
        cls.counts = chance.integers(-(2**23) + 1, 2**23 - 1, (cls.ROWS, 4))
        cls.there = np.ones((cls.ROWS, 4), bool)
        cls.there[cls.REAR_HOLE, 2:] = False
        cls.there[cls.HOLE] = False
        cls.values = np.where(cls.there, (cls.counts - cls.OFFSET) * cls.SCALE, np.nan)
        cls.time_s = 3.0 + np.arange(cls.ROWS) / cls.RATE_HZ
        lines = ["time_s," + ",".join(cls.CHANNELS), "s,m/s^2,m/s^2,m/s^2,m/s^2"]
        for time_s, values in zip(cls.time_s, cls.values):
            if not np.isnan(values).all():
                lines.append(f"{time_s:.9f}," + ",".join("" if np.isnan(v) else repr(float(v)) for v in values))
        (cls.root / "made.csv").write_text("\n".join(lines) + "\n")
        (cls.root / "made.toml").write_text(vehicle_toml(cls.RATE_HZ))
        done = rb("import", "csv", "--samples", cls.root / "made.csv", "--vehicle", cls.root / "made.toml", "-o", cls.made)
        assert done.returncode == 3, done.stderr
        for first, node in ((0, Node(cls.made, 1)), (2, Node(cls.made, 2))):  # that the tests begin from the truth
            assert (node.there[:, :2] == cls.there[:, first:first + 2]).all()
            assert (node.counts[:, :2] == np.where(node.there[:, :2], cls.counts[:, first:first + 2], 0)).all()

    def import_of(self, name, samples, vehicle, *more):
        folder = self.root / name
        done = rb("import", "csv", "--samples", samples, "--vehicle", vehicle, "-o", folder, *more)
        self.assertIn(done.returncode, (0, 3), done.stderr)
        return folder

    def wobble(self):
        return self.import_of("wobble", DATA / "wobbletracker.csv", DATA / "wobbletracker.toml")

    def drive(self, name="drive", seconds=6):
        folder = self.root / name
        done = rb("demo", "--headless", "--json", "--seed", 3, "--drive-seconds", seconds, "--rate", "max", "--record", folder)
        self.assertTrue(folder.is_dir(), done.stderr)
        return folder

    def export(self, form, folder, name, *options, code=(0, 3)):
        file = self.root / name
        done = rb("export", "--format", form, folder, "-o", file, "--json", *options)
        self.assertIn(done.returncode, code, done.stderr)
        return file, json.loads(done.stdout) if done.stdout else done.stderr
