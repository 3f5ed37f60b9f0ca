"""Signals of the car, edges of every kind and an absent device in a record: the checker takes what the product takes."""

import math
import pathlib
import shutil
import struct
import tempfile
import unittest

from records import COMPLETE, DAMAGED, INCOMPLETE, RB, Record, altered, check, message, record_a_drive, run


class Signals(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="rb-check-signals-"))
        cls.addClassCleanup(shutil.rmtree, cls.root)
        cls.drive = cls.root / "drive"
        record_a_drive(cls.drive, seconds=3)

    def setUp(self):
        self.folder = self.root / self.id().rsplit(".", 1)[1]
        shutil.copytree(self.drive, self.folder)
        self.record = Record(self.folder).without_journal()
        self.at = self.record.places("EDGE")[3]

    def put(self, name, channel, **fields):
        """Puts a message in the place of an edge block: a block without scans too."""
        _, epoch, sequence, first_scan, _, time_ns = struct.unpack_from(">iqqqqq", self.record.events[self.at][1], 8)
        data = message(name, node=1, epoch=epoch, sequence=sequence, first_scan=first_scan, time_ns=time_ns, **fields)
        self.record.events[self.at] = channel, data
        self.record.with_true_sums().write()

    def put_signals(self, samples=2, times=(10, 20), values=(1.5, -2.0), numbers=(0, 255), **fields):
        fill = lambda given: list(given) + [0] * (64 - len(given))
        self.put("signal_block_t", b"RB_BLOCK_1_SIGNAL", samples=samples, sample_ns=fill(times), value=fill(values),
                 signal=fill(numbers), **fields)

    def agrees(self, verdict):
        code, found = check(self.folder)
        self.assertEqual(code, verdict, found)
        self.assertEqual(run(RB, "verify", self.folder).returncode, verdict, "rb verify")
        return found

    def test_good_ones(self):
        for samples in (0, 2, 64):
            self.put_signals(samples)
            self.assertEqual(self.agrees(COMPLETE)["messages_refused"], 0)

    def test_what_no_node_may_send(self):
        for fields in ({"samples": 65}, {"samples": -1}, {"numbers": (0, 256)}, {"numbers": (-1, 0)}, {"scans": 1},
                       {"values": (1.5, math.nan)}, {"values": (-math.inf, 0)}, {"times": (1 << 61, (1 << 61) + 1)}):
            self.put_signals(**fields)
            self.assertEqual(self.agrees(DAMAGED)["messages_refused"], 1, fields)

    def test_what_does_not_count_may_be_anything(self):
        self.put_signals(samples=1, numbers=(0, 999), times=(1, (1 << 61) + 1))
        self.agrees(COMPLETE)

    def test_on_another_channel(self):
        self.put_signals()
        self.record.events[self.at] = b"RB_BLOCK_1_EDGE", self.record.events[self.at][1]
        self.record.write()
        self.assertEqual(self.agrees(DAMAGED)["messages_refused"], 1)

    def test_edges_of_every_kind(self):
        self.put_edges([10 << 4 | kind << 2 | 2 | line for kind in range(1, 4) for line in range(2)] + [10 << 2, (1 << 31) - 2 << 2])
        self.agrees(COMPLETE)

    def test_edges_that_no_node_may_send(self):
        for codes, fields in (([0x50], {"edges": 2}), ([0x50], {"edges": 0}), ([0x50], {"size": 1201}), ([0x50], {"size": -1}),
                              ([0x50], {"size": 2}), ([0x0C], {}), ([0x50, 0xB6], {}), ([0x52], {}), ([1 << 35], {})):
            self.put_edges(codes, **fields)
            self.assertEqual(self.agrees(DAMAGED)["messages_refused"], 1, (codes, fields))

    def put_edges(self, codes, **fields):
        """Codes in the shortest form; 0x0C is of an edge before the block's time, 0x52 a tooth as if it were another kind."""
        data = bytearray()
        for code in codes:
            while code >= 0x80:
                data.append(code & 0x7F | 0x80)
                code >>= 7
            data.append(code)
        given = {"edges": len(codes), "size": len(data), "codes": bytes(data) + bytes(1200 - len(data))} | fields
        self.put("edge_block_t", b"RB_BLOCK_1_EDGE", **given)

    def test_a_device_that_was_not_there(self):
        at = self.record.places("SCAN")[10]
        _, epoch, sequence, first_scan, scans, time_ns = struct.unpack_from(">iqqqqq", self.record.events[at][1], 8)
        self.record.events[at] = b"RB_BLOCK_1_GAP", message("gap_t", node=1, epoch=epoch, sequence=sequence, scans=scans,
                                                            first_scan=first_scan, time_ns=time_ns, cause=8)
        end = self.record.places("END")[0]
        channel, data = self.record.events[end]
        sealed, missing = struct.unpack_from(">qq", data, 60)
        data = altered(data, "end_t", "scans_sealed", sealed - scans)
        self.record.events[end] = channel, altered(data, "end_t", "scans_missing", missing + scans)
        self.record.with_true_sums().write()
        gaps = next(epoch["gaps"] for epoch in self.agrees(INCOMPLETE)["nodes"] if epoch["node"] == 1)
        self.assertEqual([(gap["cause"], gap["scans"]) for gap in gaps], [("device_gone", scans)])
        self.assertIn("device_gone", run(RB, "verify", self.folder).stdout)


if __name__ == "__main__":
    unittest.main()
