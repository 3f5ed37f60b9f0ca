"""Records whose samples are hashes: each single wrong one shows, though every CRC is good."""

import json
import pathlib
import shutil
import struct
import tempfile
import unittest

from records import COMPLETE, DAMAGED, INCOMPLETE, TYPES, UNREADABLE, Record, check, message, record_a_drive, with_crc

from record_check.truth import ACCELERATIONS, CHANNELS, HashedEpoch

COUNTS_AT = TYPES["scan_block_t"].offset("counts")
JOURNAL = b"RB_JOURNAL"


def counts(data):
    return list(struct.unpack_from(">320i", data, COUNTS_AT))


def true_epoch(node, epoch):
    """What truth.json says of an epoch that one run of a node began and ended, and of which nothing was promised."""
    return {"node": node, "epoch": epoch, "openings": 1, "scans": 0, "ended": True, "killed": False, "promised": 0,
            "declared": [], "obeyed": []}


def with_counts(data, values):
    return with_crc(data[:COUNTS_AT] + struct.pack(">320i", *values) + data[COUNTS_AT + 1280:])


class TruthMode(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="rb-check-truth-"))
        cls.addClassCleanup(shutil.rmtree, cls.root)
        cls.drive = cls.root / "drive"
        record_a_drive(cls.drive)
        cls.hash_the_samples(Record(cls.drive))

    @classmethod
    def hash_the_samples(cls, record):
        """Gives a recorded drive the samples of test mode.  Its journal, which knew the others, goes."""
        cls.epochs = {}
        record.events = [each for each in record.events if each[0] != JOURNAL]
        for node in (1, 2):
            for at in record.places("SCAN", node):
                channel, data = record.events[at]
                _, epoch, _, first, scans = struct.unpack_from(">iqqqq", data, 8)
                true = cls.epochs.setdefault(node, true_epoch(node, epoch))
                true["scans"] += scans
                values, rows = counts(data), HashedEpoch(node, epoch).rows(first)
                for row in range(20):
                    values[CHANNELS * row:CHANNELS * row + ACCELERATIONS] = rows[ACCELERATIONS * row:ACCELERATIONS * (row + 1)]
                record.events[at] = channel, with_counts(data, values)
        record.with_true_sums().write()

    def setUp(self):
        self.folder = self.root / self.id().rsplit(".", 1)[1]
        shutil.copytree(self.drive, self.folder)
        self.record = Record(self.folder)
        self.true = json.loads(json.dumps(self.epochs))

    def says(self, verdict):
        path = self.folder / "truth.json"
        path.write_text(json.dumps({"hashed": True, "epochs": list(self.true.values())}), encoding="utf-8")
        code, found = check(self.folder, "--truth", path)
        self.assertEqual(code, verdict, found)
        return found

    def says_of_node_1(self, line):
        self.assertEqual(self.says(DAMAGED)["nodes"][0]["contradictions"], [line])

    def change(self, places, change):
        """`change` the counts of the blocks in these places, all together."""
        values = [counts(self.record.events[at][1]) for at in places]
        change(*values)
        for at, new in zip(places, values):
            channel, data = self.record.events[at]
            self.record.events[at] = channel, with_counts(data, new)
        self.record.with_true_sums().write()

    def test_every_sample_in_its_place(self):
        self.says(COMPLETE)

    def test_one_altered_sample(self):
        def alter(values):
            values[16 * 7 + 11] ^= 1
        self.change(self.record.places("SCAN", 2)[40:41], alter)
        found = self.says(DAMAGED)
        self.assertEqual(check(self.folder)[0], COMPLETE, "without the truth nothing can show it")
        self.assertIn("channel 12 of scan", found["nodes"][1]["contradictions"][0])

    def test_two_samples_swapped_within_a_scan(self):
        def swap(values):
            values[0], values[1] = values[1], values[0]
        self.change(self.record.places("SCAN")[40:41], swap)
        self.says(DAMAGED)

    def test_one_scan_there_twice_in_place_of_its_neighbour(self):
        def double(values):
            values[16 * 4:16 * 5] = values[16 * 3:16 * 4]
        self.change(self.record.places("SCAN")[40:41], double)
        self.says(DAMAGED)

    def test_two_blocks_that_changed_places_and_numbers(self):
        def swap(left, right):
            left[:], right[:] = right[:], left[:]
        self.change(self.record.places("SCAN")[40:42], swap)
        self.says(DAMAGED)

    def test_fewer_scans_than_were_produced(self):
        self.true["1"]["scans"] += 1
        self.says(DAMAGED)

    def test_more_scans_than_were_produced(self):
        self.true["1"]["scans"] -= 1
        self.says(DAMAGED)

    def test_an_epoch_that_is_not_there(self):
        self.true["3"] = true_epoch(3, 5) | {"scans": 100}
        self.says(DAMAGED)

    def test_an_epoch_that_two_runs_shared(self):
        self.true["1"]["openings"] = 2
        self.says_of_node_1("2 runs of the node had this epoch")

    def test_a_truth_that_names_an_epoch_twice_is_refused(self):
        self.true["again"] = self.true["1"]
        self.says(UNREADABLE)

    def test_a_node_that_obeyed_a_recorder_of_the_past(self):
        self.true["1"]["obeyed"] = [5, 7, 7, 8]
        self.says(COMPLETE)
        self.true["1"]["obeyed"] = [5, 7, 5]
        self.says_of_node_1("the node obeyed recorder 5 after recorder 7")

    def test_more_was_called_durable_than_is_there(self):
        last = self.sequence(self.record.places("END")[0])
        self.true["1"]["promised"] = last
        self.says(COMPLETE)
        self.true["1"]["promised"] = last + 1
        self.says_of_node_1(f"called durable through block {last + 1}, recorded through {last}")

    def sequence(self, at):
        return struct.unpack_from(">q", self.record.events[at][1], 20)[0]

    def lose_a_block_at_the_node(self):
        """A recorder's gap takes the place of one block; returns its number."""
        at = self.record.places("SCAN", 1)[40]
        _, epoch, sequence, first_scan, scans = struct.unpack_from(">iqqqq", self.record.events[at][1], 8)
        gap = message("gap_t", node=1, epoch=epoch, sequence=sequence, first_scan=first_scan, scans=scans, cause=4)
        self.record.events[at] = b"RB_BLOCK_1_GAP", gap
        self.record.write()
        return sequence

    def declare(self, sequence, promised, released, may_lack_more=False):
        self.true["1"]["declared"] = [{"sequence": sequence, "promised": promised, "released": released,
                                       "may_lack_more": may_lack_more}]

    def test_a_loss_at_the_node_of_what_another_recorder_has(self):
        lost = self.lose_a_block_at_the_node()
        self.declare(lost, promised=lost - 1, released=lost)
        self.says(INCOMPLETE)

    def test_a_loss_at_the_node_of_what_nobody_has(self):
        lost = self.lose_a_block_at_the_node()
        self.declare(lost, promised=lost - 1, released=lost - 1)
        self.says_of_node_1(f"the node gave back blocks through {lost}; through {lost - 1} they were called durable")

    def test_a_loss_at_a_node_that_is_dead(self):
        lost = self.lose_a_block_at_the_node()
        self.declare(lost, promised=lost - 1, released=lost - 1, may_lack_more=True)
        self.says(INCOMPLETE)

    def test_a_loss_of_what_was_called_durable(self):
        lost = self.lose_a_block_at_the_node()
        for dead in (False, True):
            self.declare(lost, promised=lost, released=lost, may_lack_more=dead)
            self.says_of_node_1(f"blocks {lost} to {lost} are declared lost; through {lost} they were called durable")

    def test_a_loss_that_its_recorder_never_declared(self):
        lost = self.lose_a_block_at_the_node()
        self.says_of_node_1(f"gap {lost} is one that its recorder never declared")

    def kill_node_1(self, declared):
        end = self.record.places("END")[0]
        _, epoch, sequence, first_scan = struct.unpack_from(">iqqq", self.record.events[end][1], 8)
        del self.record.events[end]
        if declared:
            gap = message("gap_t", node=1, epoch=epoch, sequence=sequence, first_scan=first_scan, cause=5)
            self.record.events.append((b"RB_BLOCK_1_GAP", gap))
            self.declare(sequence, promised=sequence - 1, released=sequence - 1, may_lack_more=True)
        self.record.write()
        self.true["1"].update(killed=True, ended=False, scans=self.true["1"]["scans"] + 30)

    def test_a_killed_nodes_tail_is_declared(self):
        self.kill_node_1(declared=True)
        self.says(INCOMPLETE)

    def test_a_killed_nodes_tail_that_nobody_declared(self):
        self.kill_node_1(declared=False)
        self.says(DAMAGED)


if __name__ == "__main__":
    unittest.main()
