"""Damages records of the real recorder by hand: the checker finds each damage and says what `rb verify` says."""

import json
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
import unittest

from records import (COMPLETE, DAMAGED, INCOMPLETE, RB, SEGMENT, TOOLS, TYPES, UNREADABLE, Record, altered, check, event, message,
                     record_a_drive, run, segment, with_crc)

from bus_url import bus_url
from record_check.blocks import Block
from record_check.crc32c import crc
from record_check.event_log import HEADER, split_events
from record_check.journals import OF_NODE, OF_RUN, JournalCheck


class CheckRecord(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="rb-check-record-"))
        cls.addClassCleanup(shutil.rmtree, cls.root)
        cls.drive = cls.root / "drive"
        record_a_drive(cls.drive)

    def setUp(self):
        self.folder = self.root / self.id().rsplit(".", 1)[1]
        shutil.copytree(self.drive, self.folder)
        self.record = Record(self.folder)

    def agrees(self, verdict):
        """Both say this; returns what the checker has found."""
        code, found = check(self.folder)
        self.assertEqual(code, verdict, found)
        product = run(RB, "verify", self.folder, "--json")
        self.assertEqual(product.returncode, verdict, "rb verify")
        if product.stdout:
            self.assertEqual([epoch["gaps"] for epoch in found["nodes"]],
                             [[{key: gap[key] for key in gap if key != "milliseconds"} for gap in epoch["gaps"]]
                              for epoch in json.loads(product.stdout)["nodes"]])
        return found

    def printed_gaps(self):
        """The lines on gaps of both, without the milliseconds that only `rb verify` says."""
        said = [run(sys.executable, TOOLS / "check_record.py", self.folder).stdout, run(RB, "verify", self.folder).stdout]
        checker, product = [[re.sub(r", [\d.]+ ms", "", line) for line in each.splitlines() if line.startswith("  gap")]
                            for each in said]
        self.assertEqual(checker, product)
        return checker

    def node(self, found, node=1):
        return next(epoch for epoch in found["nodes"] if epoch["node"] == node)

    def test_a_record_as_it_was_written(self):
        found = self.agrees(COMPLETE)
        self.assertEqual([epoch["samples_recorded"] for epoch in found["nodes"]], [24000, 24000])

    def test_written_back_without_a_change(self):
        before = (self.folder / SEGMENT).read_bytes()
        self.record.write()
        self.assertEqual(len((self.folder / SEGMENT).read_bytes()), len(before))
        self.agrees(COMPLETE)

    def test_a_bit_turned_anywhere_in_a_block(self):
        at = self.record.places("SCAN")[7]
        channel, data = self.record.events[at]
        for place in (0, 9, 14, 22, 30, 60, 700, len(data) - 1):
            self.record.events[at] = channel, data[:place] + bytes([data[place] ^ 4]) + data[place + 1:]
            self.record.write()
            self.assertEqual(self.agrees(DAMAGED)["messages_refused"], 1, f"byte {place}")

    def test_a_block_taken_away(self):
        for kind in ("SCAN", "EDGE", "META"):
            record = Record(self.drive)
            record.folder = self.folder
            del record.events[record.places(kind)[0]]
            record.write()
            self.assertEqual(len(self.node(self.agrees(DAMAGED))["undeclared_blocks"]), 1, kind)

    def test_a_block_put_in_twice(self):
        at = self.record.places("SCAN")[3]
        self.record.events.insert(at + 5, self.record.events[at])
        self.record.write()
        self.assertEqual(self.node(self.agrees(DAMAGED))["identical_repeats"], 1)

    def test_another_block_with_a_number_that_is_taken(self):
        at = self.record.places("SCAN")[3]
        channel, data = self.record.events[at]
        self.record.events.insert(at + 1, (channel, altered(data, "scan_block_t", "overload", 1, ">i")))
        self.record.write()
        self.assertEqual(self.node(self.agrees(DAMAGED))["other_repeats"], 1)

    def test_blocks_that_lie_in_another_order(self):
        first, second = self.record.places("SCAN")[3:5]
        events = self.record.events
        events[first], events[second] = events[second], events[first]
        self.record.write()
        self.assertEqual(len(self.node(self.agrees(DAMAGED))["journal_contradictions"]), 1)
        self.record.without_journal().write()
        self.agrees(COMPLETE)

    def test_scans_that_do_not_run_on(self):
        at = self.record.places("SCAN")[3]
        channel, data = self.record.events[at]
        first, = struct.unpack_from(">q", data, 28)
        for moved in (-1, 1):
            self.record.events[at] = channel, altered(data, "scan_block_t", "first_scan", first + moved)
            self.record.write()
            node = self.node(self.agrees(DAMAGED))
            self.assertTrue(node["undeclared_scans"] and node["overlaps"], node)

    def test_a_block_on_another_channel(self):
        at = self.record.places("SCAN")[3]
        for channel in (b"RB_BLOCK_2_SCAN", b"RB_BLOCK_1_EDGE"):
            self.record.events[at] = channel, self.record.events[at][1]
            self.record.write()
            self.assertEqual(self.agrees(DAMAGED)["messages_refused"], 1)

    def test_a_block_that_no_node_may_send(self):
        at = self.record.places("SCAN")[3]
        channel, data = self.record.events[at]
        self.record.events[at] = channel, altered(data, "scan_block_t", "scans", 21)
        self.record.write()
        self.assertEqual(self.agrees(DAMAGED)["messages_refused"], 1)

    def test_no_end(self):
        self.record.without_journal()
        del self.record.events[self.record.places("END")[0]]
        self.record.write()
        self.assertFalse(self.node(self.agrees(INCOMPLETE))["ended"])

    def test_an_end_that_stands_before_the_end_of_the_scans(self):
        at = self.record.without_journal().places("END")[0]
        channel, data = self.record.events[at]
        self.record.events[at] = channel, altered(data, "end_t", "first_scan", 100)
        self.record.write()
        self.assertEqual(self.node(self.agrees(DAMAGED))["overlaps"], 1)

    def test_blocks_behind_the_end_of_their_epoch(self):
        at = self.record.without_journal().places("END")[0]
        epoch, sequence, first_scan = struct.unpack_from(">qqq", self.record.events[at][1], 12)
        crash = message("gap_t", node=1, epoch=epoch, sequence=sequence, first_scan=first_scan, cause=5)
        behind = message("gap_t", node=1, epoch=epoch, sequence=sequence + 1, first_scan=first_scan, scans=20, cause=1)
        for end in (self.record.events[at], (b"RB_BLOCK_1_GAP", crash)):
            self.record.events[at] = end
            self.record.events[at + 1:at + 1] = [(b"RB_BLOCK_1_GAP", behind)]
            self.record.write()
            for said in (self.node(self.agrees(DAMAGED)), self.node(json.loads(run(RB, "verify", self.folder, "--json").stdout))):
                self.assertTrue(any("behind the epoch's end" in line for line in said["contradictions"]), said["contradictions"])
            del self.record.events[at + 1]

    def test_totals_that_do_not_agree(self):
        at = self.record.places("END")[0]
        channel, data = self.record.events[at]
        for field in ("blocks", "scans_sealed"):
            value, = struct.unpack_from(">q", data, TYPES["end_t"].offset(field))
            self.record.events[at] = channel, altered(data, "end_t", field, value + 1)
            self.record.write()
            self.assertTrue(self.node(self.agrees(DAMAGED))["contradictions"], field)

    def replace_by_gap(self, cause, first, last, short=0):
        """Puts a gap in the place of the scan blocks first .. last; it bears the first one's number."""
        places = self.record.places("SCAN")[first:last + 1]
        header = struct.unpack_from(">iqqqqq", self.record.events[places[0]][1], 8)
        scans = sum(struct.unpack_from(">q", self.record.events[at][1], 36)[0] for at in places)
        sequence = header[2]
        if cause == 4:
            sequence = struct.unpack_from(">q", self.record.events[places[-1]][1], 20)[0]
        gap = message("gap_t", node=1, epoch=header[1], sequence=sequence, first_scan=header[3], scans=scans - short,
                      time_ns=header[5], cause=cause)
        low, high = header[2], struct.unpack_from(">q", self.record.events[places[-1]][1], 20)[0]
        kept = [each for each in self.record.events
                if not (each[0].startswith(b"RB_BLOCK_1_") and low <= struct.unpack_from(">q", each[1], 20)[0] <= high)]
        self.record.events = kept[:places[0]] + [(b"RB_BLOCK_1_GAP", gap)] + kept[places[0]:]
        self.record.write()
        return scans

    def test_a_declared_loss_at_the_node(self):
        self.record.without_journal()
        scans = self.replace_by_gap(4, 10, 14)
        self.assertEqual(self.node(self.agrees(INCOMPLETE))["samples_missing"], scans)

    def test_the_end_tells_how_many_scans_a_loss_of_unknown_length_had(self):
        self.record.without_journal()
        scans = sum(struct.unpack_from(">q", self.record.events[at][1], 36)[0] for at in self.record.places("SCAN")[10:15])
        self.replace_by_gap(4, 10, 14, short=scans)
        node = self.node(self.agrees(INCOMPLETE))
        self.assertEqual(node["samples_missing"], scans)
        self.assertEqual(self.node(json.loads(run(RB, "verify", self.folder, "--json").stdout))["samples_missing"], scans)

    def test_gaps_are_told_as_rb_verify_tells_them(self):
        self.record.without_journal()
        def number(at):
            return struct.unpack_from(">q", self.record.events[at][1], 20)[0]

        first, last = (number(self.record.places("SCAN")[place]) for place in (10, 14))
        scans = self.replace_by_gap(4, 10, 14)
        at = self.record.places("EDGE")[30]  # scans follow it
        edges, header = number(at), struct.unpack_from(">iqqqqq", self.record.events[at][1], 8)
        self.record.events[at] = b"RB_BLOCK_1_GAP", message("gap_t", node=1, epoch=header[1], sequence=edges,
                                                            first_scan=header[3], time_ns=header[5], cause=4)
        end = self.record.places("END")[0]
        epoch, sequence, first_scan = struct.unpack_from(">qqq", self.record.events[end][1], 12)
        self.record.events[end] = b"RB_BLOCK_1_GAP", message("gap_t", node=1, epoch=epoch, sequence=sequence,
                                                             first_scan=first_scan, cause=5)
        self.record.write()
        self.agrees(INCOMPLETE)
        from_scan = 20 * 10
        self.assertEqual(self.printed_gaps(), [
            f"  gap, blocks {first} to {last}, from scan {from_scan} on {scans} scans: lost_at_node",
            f"  gap, block {edges}, no scans: edges, signals or description: lost_at_node",
            f"  gap, block {sequence}, from scan {first_scan} on, how many is not known: node_crash"])

    def test_a_gap_of_one_scan_too_few(self):
        self.replace_by_gap(4, 10, 14, short=1)
        self.assertEqual(len(self.node(self.agrees(DAMAGED))["undeclared_scans"]), 1)

    def test_a_gap_that_does_not_stand_for_blocks(self):
        self.replace_by_gap(1, 10, 14)
        self.assertEqual(len(self.node(self.agrees(DAMAGED))["undeclared_blocks"]), 1)

    def test_garbage_between_events(self):
        log = (self.folder / SEGMENT).read_bytes()
        _, begin, _ = split_events(log)[0][20]
        begin -= HEADER.size + len("RB_BLOCK_1_SCAN")
        for garbage in (b"x", b"\xed\xa1\xda\x01", bytes(5000)):
            (self.folder / SEGMENT).write_bytes(log[:begin] + garbage + log[begin:])
            self.assertGreaterEqual(self.agrees(DAMAGED)["damaged_bytes"], len(garbage))

    def test_a_finished_segment_cut_short(self):
        log = (self.folder / SEGMENT).read_bytes()
        for kept in (len(log) - 1, len(log) // 2):
            (self.folder / SEGMENT).write_bytes(log[:kept])
            self.agrees(DAMAGED)

    def never_finished(self):
        """As of a recorder that was killed in it."""
        for name in ("manifest.json", "seg-000001.idx"):
            (self.folder / name).unlink(missing_ok=True)

    def test_a_torn_tail_is_declared(self):
        self.never_finished()
        log = (self.folder / SEGMENT).read_bytes()
        for kept in (len(log) - 1, len(log) - 2000, len(log) // 2):
            (self.folder / SEGMENT).write_bytes(log[:kept])
            self.assertGreater(self.agrees(INCOMPLETE)["torn_bytes"], 0)

    def continue_and_kill(self):
        """A recorder takes the record over, and is killed before it writes anything else."""
        index = self.folder / "seg-000001.idx"
        with subprocess.Popen([RB.with_name("rb-recorder"), "--record", self.folder, "--url", bus_url()]) as recorder:
            patience_ends = time.monotonic() + 60
            while not index.exists() and recorder.poll() is None and time.monotonic() < patience_ends:
                time.sleep(0.01)
            recorder.kill()
        self.assertTrue(index.exists(), "the recorder has taken nothing over")
        index.unlink()

    def test_a_commit_event_that_is_said_again_where_the_tail_was_cut(self):
        """The commit event of the last sync was torn, and the one behind it, of the close, goes with the tail."""
        def commit(durable):
            return b"RB_COMMIT", message("commit_t", bytes=durable)

        events = [each for each in self.record.events if each[0] != b"RB_COMMIT"]
        written = [*events[:1000], commit(len(segment(events[:1000]))), *events[1000:2000]]
        synced = len(segment(written))
        self.record.events = [*written, commit(synced), *events[2000:2005], commit(synced)]
        torn = len(written)
        block = next(at for at in range(1500, torn) if written[at][0].endswith(b"_SCAN"))
        for rots in (False, True):
            self.record.write()
            log = bytearray((self.folder / SEGMENT).read_bytes())
            ends = [end for _, _, end in split_events(bytes(log))[0]]
            for at in (torn, block) if rots else (torn,):
                log[ends[at] - 1] ^= 1
            (self.folder / SEGMENT).write_bytes(log)
            with self.subTest(a_block_rots=rots):
                self.continue_and_kill()
                log = (self.folder / SEGMENT).read_bytes()
                self.assertEqual(split_events(log)[0][-1][:2], (b"RB_COMMIT", synced + HEADER.size + len(b"RB_COMMIT")))
                found = self.agrees(DAMAGED if rots else INCOMPLETE)
                self.assertEqual((found["messages_refused"], found["torn_bytes"]), (int(rots), 0))
                self.assertEqual(found["altered_headers"], 0)

    def split(self, *before_the_second, behind=2001):
        """Two segments of the one, the second one with these events at its beginning."""
        (self.folder / SEGMENT).write_bytes(segment(self.record.events[:behind]))
        (self.folder / "seg-000002.lcm").write_bytes(segment([*before_the_second, *self.record.events[behind:]]))
        self.never_finished()

    def test_two_segments(self):
        self.split()
        self.agrees(COMPLETE)

    def test_a_segment_that_is_gone(self):
        self.split()
        (self.folder / "seg-000002.lcm").rename(self.folder / "seg-000003.lcm")
        self.assertEqual(self.agrees(DAMAGED)["missing_segments"], 1)

    def test_a_segment_with_more_than_it_was_finished_with(self):
        with open(self.folder / SEGMENT, "ab") as log:
            log.write(event(b"OTHER_PROGRAM", b""))
        self.assertEqual(self.agrees(DAMAGED)["missing_segments"], 1)

    def test_what_only_an_index_knows_of(self):
        (self.folder / "manifest.json").unlink()
        index, log = self.folder / "seg-000001.idx", (self.folder / SEGMENT).read_bytes()
        last_of_it = split_events(log)[0][-1][2] - split_events(log)[0][-2][2]
        (self.folder / SEGMENT).write_bytes(log[:-last_of_it])
        self.assertIn("bytes that its index says", self.agrees(DAMAGED)["damage"][0])
        (self.folder / SEGMENT).write_bytes(log)
        text = index.read_text(encoding="utf-8")
        for name, said in {index.name: text[:text.index("crc32c")] + "epoch 7 7 contiguous 1 next_scan 0 ended 1 samples 0 "
                                                                     "gaps 0 blocks 1 sum 00000000\n",
                           "seg-000002.idx": "roadbalance index 2\nsegment 2 bytes 100\n"}.items():
            (self.folder / name).write_text(f"{said}crc32c {crc(said.encode()):08x}\n", encoding="utf-8")
            self.assertEqual(self.agrees(DAMAGED)["missing_segments"], 1, name)
            index.write_text(text, encoding="utf-8")

    def test_a_manifest_of_which_a_part_cannot_be_read(self):
        size = (self.folder / SEGMENT).stat().st_size
        for entries, verdict in (([{"file": "x"}, {"file": "seg-000002.lcm", "bytes": 100}], DAMAGED),
                                 ([{"file": SEGMENT, "bytes": -1}, 7, {"file": SEGMENT, "bytes": True}], COMPLETE),
                                 ([{"file": SEGMENT, "bytes": size}, {"file": SEGMENT, "bytes": 1}], COMPLETE)):
            (self.folder / "manifest.json").write_text(json.dumps({"segments": entries}), encoding="utf-8")
            with self.subTest(entries=entries):
                self.agrees(verdict)

    def test_a_file_with_a_name_that_no_recorder_writes_is_no_segment(self):
        for name in ("seg-0000002.lcm", "seg-000000.lcm", "seg-0000002.idx"):
            shutil.copy(self.folder / SEGMENT, self.folder / name)
            self.agrees(COMPLETE)

    def test_where_a_segment_ends_is_said_at_the_beginning_of_a_later_one(self):
        note = b"RB_NOTE", message("note_t", incarnation=1, kind=5, a=1, b=1000)
        for at in (0, 500):
            self.record.events.insert(at, note)
            self.record.write()
            self.assertEqual(self.agrees(COMPLETE)["torn_bytes"], 0)
            del self.record.events[at]
        self.record.events.insert(2500, note)
        self.split()
        self.agrees(COMPLETE)

    def test_a_deletion_that_is_noted_again_is_of_one_segment(self):
        """A kill comes between the note and the deletion; the next recorder notes it again."""
        for segments in ((1, 1), (1, 1, 2)):
            deleted = [(b"RB_NOTE", message("note_t", incarnation=1, kind=11, a=number, b=5)) for number in segments]
            self.record.events[500:500] = deleted
            self.record.write()
            self.assertEqual(self.agrees(COMPLETE)["deleted_segments"], sorted(set(segments)))
            said = json.loads(run(RB, "verify", self.folder, "--json").stdout)
            self.assertEqual(said["deleted_segments"], len(set(segments)))
            del self.record.events[500:500 + len(deleted)]

    def test_a_segment_that_was_given_up_before_anything_was_promised_of_it(self):
        self.split((b"RB_NOTE", message("note_t", incarnation=1, kind=5, a=2, b=0)))
        (self.folder / "seg-000002.lcm").rename(self.folder / "seg-000003.lcm")
        self.assertEqual(self.agrees(COMPLETE)["missing_segments"], 0)

    def test_an_empty_segment_behind_the_last(self):
        (self.folder / "seg-000002.lcm").touch()
        self.agrees(INCOMPLETE)

    def test_what_lies_behind_the_end_of_an_abandoned_segment_does_not_count(self):
        end = len(segment(self.record.events[:2001]))
        note = b"RB_NOTE", message("note_t", incarnation=1, kind=5, a=1, b=end)
        self.split(note)
        first, second = self.folder / SEGMENT, self.folder / "seg-000002.lcm"
        again = second.read_bytes()[len(event(*note)):][:5000]
        for behind in (b"garbage", again):
            first.write_bytes(first.read_bytes()[:end] + behind)
            self.assertEqual(self.agrees(COMPLETE)["damaged_bytes"], 0)

    def write_index(self, blocks, change=0):
        """Of a first segment of these bytes; with a change the sums in it are wrong."""
        positions = {}
        for channel, begin, end in split_events(blocks)[0]:
            if not channel.startswith(b"RB_BLOCK_"):
                continue
            node, epoch, sequence, first_scan, scans = struct.unpack_from(">iqqqq", blocks, begin + 8)
            if sequence > 0:
                known = positions.setdefault((node, epoch), [0, 0, b"", 0])
                known[0] = sequence
                known[1] = max(known[1], first_scan + scans if channel.endswith(b"SCAN") else 0)
                known[2] += blocks[end - 4:end]
                known[3] = int(channel.endswith(b"END"))
        index = f"roadbalance index 2\nsegment 1 bytes {len(blocks)}\n" + "".join(
            f"epoch {node} {epoch} contiguous {last} next_scan {scan} ended {ended} samples {scan} gaps 0 blocks {last} "
            f"sum {crc(crcs) ^ change:08x}\n"
            for (node, epoch), (last, scan, crcs, ended) in sorted(positions.items()))
        (self.folder / "seg-000001.idx").write_text(f"{index}crc32c {crc(index.encode()):08x}\n", encoding="utf-8")

    def test_a_deleted_segment_that_no_note_tells_of(self):
        """One node's whole epoch is in it, so that its index alone names that epoch, whether or not it says how it ended."""
        is_of_second = [channel.startswith(b"RB_BLOCK_2_") for channel, _ in self.record.without_journal().events]
        self.record.events.sort(key=lambda each: not each[0].startswith(b"RB_BLOCK_2_"))
        self.split(behind=sum(is_of_second))
        self.write_index((self.folder / SEGMENT).read_bytes())
        self.agrees(COMPLETE)
        (self.folder / SEGMENT).unlink()
        index = self.folder / "seg-000001.idx"
        ended = index.read_text(encoding="utf-8")
        body = ended[:ended.index("crc32c")].replace(" ended 1 ", " ended 0 ")
        for text in (ended, f"{body}crc32c {crc(body.encode()):08x}\n"):
            index.write_text(text, encoding="utf-8")
            found = self.agrees(DAMAGED)
            self.assertEqual([epoch["node"] for epoch in found["nodes"]], [1])

    def test_a_deleted_segment_that_a_note_tells_of(self):
        self.split()
        first, second = self.folder / SEGMENT, self.folder / "seg-000002.lcm"
        blocks = first.read_bytes()
        self.write_index(blocks)
        note = event(b"RB_NOTE", message("note_t", incarnation=1, kind=11, a=1, b=len(blocks)))
        # The note comes before the deletion, which a kill may come before.
        first.write_bytes(blocks)
        kept = second.read_bytes()
        second.write_bytes(kept + note)
        self.agrees(COMPLETE)
        second.write_bytes(kept)
        first.unlink()
        second.write_bytes(second.read_bytes() + note)
        # One of two that were not as fast as each other may have ended there.
        self.assertGreater(max(epoch["samples_deleted"] for epoch in self.agrees(INCOMPLETE)["nodes"]), 0)
        self.write_index(blocks, change=1)
        contradictions = [text for epoch in self.agrees(DAMAGED)["nodes"] for text in epoch["contradictions"]]
        self.assertTrue(any("the node's sum of its blocks" in text for text in contradictions), contradictions)

    def test_a_segment_that_vanished_is_not_excused_by_later_deletions(self):
        """The manifest is written before a segment is deleted: what it lists was not."""
        self.split((b"RB_NOTE", message("note_t", incarnation=1, kind=11, a=4)))
        (self.folder / "seg-000002.lcm").rename(self.folder / "seg-000005.lcm")
        (self.folder / SEGMENT).unlink()
        listed = [{"file": f"seg-{number:06}.lcm", "bytes": 1000} for number in (2, 4)]
        (self.folder / "manifest.json").write_text(json.dumps({"segments": listed}), encoding="utf-8")
        found = self.agrees(DAMAGED)
        self.assertEqual(found["missing_segments"], 1)
        self.assertEqual(found["lost"], ["segment 1 was deleted by the retention mode",
                                         "segments 3 to 4 were deleted by the retention mode"])
        self.assertEqual(json.loads(run(RB, "verify", self.folder, "--json").stdout)["lost"], found["lost"])

    def test_a_deleted_segment_behind_which_a_number_was_given_up(self):
        """The first one here does not follow the one whose index says where the record begins."""
        self.split((b"RB_NOTE", message("note_t", incarnation=1, kind=5, a=2, b=0)),
                   (b"RB_NOTE", message("note_t", incarnation=1, kind=11, a=1)))
        (self.folder / "seg-000002.lcm").rename(self.folder / "seg-000003.lcm")
        self.write_index((self.folder / SEGMENT).read_bytes())
        (self.folder / SEGMENT).unlink()
        self.assertGreater(max(epoch["samples_deleted"] for epoch in self.agrees(INCOMPLETE)["nodes"]), 0)

    def test_a_folder_that_continues_another_one(self):
        """As a recorder leaves it whose first folder failed: in the other one its journal begins anew."""
        self.record.without_journal()
        self.split()
        (self.folder / "seg-000002.lcm").rename(self.folder / SEGMENT)
        self.agrees(DAMAGED)
        (self.folder / "continues").write_text("/first\n", encoding="utf-8")
        found = self.agrees(INCOMPLETE)
        self.assertEqual(found["elsewhere"], ["what came before is in /first"])
        product = {epoch["node"]: epoch for epoch in json.loads(run(RB, "verify", self.folder, "--json").stdout)["nodes"]}
        for epoch in found["nodes"]:
            self.assertEqual(epoch["samples_deleted"], product[epoch["node"]]["samples_deleted"])
        self.record = Record(self.folder)
        del self.record.events[max(self.record.places("SCAN", 1) + self.record.places("SCAN", 2))]
        self.record.write()
        self.agrees(DAMAGED)

    def test_a_folder_that_goes_on_in_another_one(self):
        (self.folder / "continued-in").write_text("/second\n", encoding="utf-8")
        self.assertEqual(self.agrees(INCOMPLETE)["elsewhere"], ["it goes on in /second"])

    def test_what_a_node_has_lost_when_its_recorder_begins_anew(self):
        journal = JournalCheck()
        none = {"first_sequence": 1, "last_sequence": 0, "scans": 0, "scans_missing": 0, "channel_crc": [0] * 16}
        zeros = {name: (0, 0) if name in ("encoder_faults", "device_counts") else 0 for name in OF_NODE + OF_RUN}
        journal.entry(none | zeros | {"blocks_unsent": 8, "device_counts": (0, 2), "refused": 6}, 0)
        journal.restart()
        journal.entry(none | zeros, 0)
        self.assertEqual(journal.losses, zeros | {"blocks_unsent": 8, "device_counts": (0, 2)})
        self.assertEqual(journal.contradictions, [])

    def test_an_altered_number_stamp_or_channel_of_any_event_but_the_last(self):
        log = (self.folder / SEGMENT).read_bytes()
        events = split_events(log)[0]
        self.assertEqual(events[-1][0], b"RB_COMMIT", "nothing answers for the last event, so that is no other one")
        for channel in (b"RB_BLOCK_0_META", b"RB_BLOCK_1_META", b"RB_NOTE", b"RB_COMMIT", b"RB_JOURNAL", b"RB_BLOCK_2_SCAN"):
            _, begin, _ = next(each for each in events if each[0] == channel)
            name = begin - len(channel)
            for what, place in {"number": name - 17, "stamp": name - 9, "channel": name, "channel's end": begin - 1}.items():
                (self.folder / SEGMENT).write_bytes(log[:place] + bytes([log[place] ^ 1]) + log[place + 1:])
                with self.subTest(channel=channel, altered=what):
                    found = self.agrees(DAMAGED)
                    self.assertEqual(found["altered_headers"], 1)
                    self.assertTrue(any("number, stamp or channel" in line for line in found["damage"]))

    def test_numbers_and_indexes_that_pass_31_and_32_bits(self):
        """Node 1 as it would be after months: what was before is gone, declared by one gap."""
        drive = list(self.record.without_journal().events)
        for blocks, scans in ((2**31 - 500, 2**32 - 5000), (2**32 - 500, 2**31 - 5000), (2**32, 2**32)):
            self.record.events, gap = [], None
            for channel, data in drive:
                is_block = channel.startswith(b"RB_BLOCK_1_") and struct.unpack_from(">q", data, 20)[0] > 0
                if is_block:
                    epoch, sequence, first_scan = struct.unpack_from(">qqq", data, 12)
                    data = with_crc(data[:20] + struct.pack(">qq", sequence + blocks, first_scan + scans) + data[36:])
                    if channel.endswith(b"_END"):
                        data = altered(data, "end_t", "blocks", sequence + blocks)
                        data = altered(data, "end_t", "scans_missing", scans)
                if is_block and not gap:
                    gap = message("gap_t", node=1, epoch=epoch, sequence=blocks, scans=scans, cause=4)
                    self.record.events.append((b"RB_BLOCK_1_GAP", gap))
                self.record.events.append((channel, data))
            self.record.write()
            node = self.node(self.agrees(INCOMPLETE))
            self.assertEqual((node["samples_recorded"], node["samples_missing"]), (24000, scans))
            self.assertEqual([(gap["first_block"], gap["last_block"]) for gap in node["gaps"]], [(1, blocks)])

    def test_the_record_alone_tells_how_to_read_it(self):
        code, found = check(self.folder, "--wire", "record")
        self.assertEqual((code, found), check(self.folder))
        self.assertEqual(code, COMPLETE)
        said = found["description"]
        self.assertRegex(said["program"], r"^roadbalance \d+\.\d+")
        self.assertEqual(said["types"], sorted(["scan_block_t", "edge_block_t", "gap_t", "meta_t", "end_t", "signal_block_t",
                                                "journal_t", "note_t", "commit_t", "clock_exchange_t", "clock_fit_t"]))

    def test_a_text_of_another_message_is_damage(self):
        for at, (channel, data) in enumerate(self.record.events):
            if channel == b"RB_BLOCK_0_META" and b"overload;" in data:
                self.record.events[at] = channel, with_crc(data.replace(b"overload;", b"overlord;"))
                break
        self.record.write()
        code, found = check(self.folder)
        self.assertEqual(code, DAMAGED)
        self.assertIn("the text of wire.scan_block_t is of another message", found["damage"])
        self.assertEqual(check(self.folder, "--wire", "record")[0], UNREADABLE)

    def test_an_altered_message_of_the_clocks_is_damage(self):
        for channel, name in ((b"RB_CLOCK_1", "clock_fit_t"), (b"RB_CLOCK_EXCHANGE_1", "clock_exchange_t")):
            record = Record(self.drive)
            record.folder = self.folder
            good = message(name, node=1, epoch=7)
            record.events.insert(700, (channel, good[:20] + b"x" + good[21:]))
            record.write()
            self.assertEqual(self.agrees(DAMAGED)["messages_refused"], 1)

    def test_a_message_of_the_clocks_altered_with_its_crc(self):
        good, other = (message("clock_fit_t", node=1, epoch=7, host_ns=host_ns) for host_ns in (1000, 2000))
        self.record.events.insert(700, (b"RB_CLOCK_1", good))
        self.record.write()
        self.agrees(COMPLETE)
        log = (self.folder / SEGMENT).read_bytes()
        self.assertEqual(log.count(good), 1)
        (self.folder / SEGMENT).write_bytes(log.replace(good, other))
        found = self.agrees(DAMAGED)
        self.assertEqual((found["altered_headers"], found["messages_refused"]), (1, 0))

    def test_a_record_whose_commits_cover_headers_alone(self):
        self.record.write()
        (self.folder / SEGMENT).write_bytes(segment(self.record.events, covers_contents=False))
        self.agrees(COMPLETE)

    def test_a_node_of_which_only_the_journal_knows(self):
        self.record.events = [(channel, data) for channel, data in self.record.events if not channel.startswith(b"RB_BLOCK_2_")]
        self.record.write()
        self.assertTrue(self.node(self.agrees(DAMAGED), 2)["journal_contradictions"])

    def test_what_a_recorder_held_when_it_stopped(self):
        text = b"pothole".ljust(400, b"\0")
        self.record.events.insert(500, (b"RB_NOTE", message("note_t", incarnation=1, kind=17, a=3, size=7, text=text)))
        events = list(self.record.events)
        for epochs, mark, verdict in ((2, 3, COMPLETE), (3, 3, INCOMPLETE), (2, 4, INCOMPLETE)):
            stopped = message("note_t", incarnation=1, kind=2, a=epochs, b=mark)
            self.record.events = events + [(b"RB_NOTE", stopped)]
            self.record.write()
            self.assertEqual(len(self.agrees(verdict)["lost"]), verdict != COMPLETE)

    def test_the_record_says_how_many_node_epochs_its_recorder_held(self):
        said = [TYPES["note_t"].decode(data) for channel, data in self.record.events if channel == b"RB_NOTE"]
        self.assertEqual([note["a"] for note in said if note["kind"] == 2], [2])

    def test_what_rb_recover_could_not_prove_to_be_there(self):
        text = b"pothole".ljust(400, b"\0")
        self.record.events.insert(500, (b"RB_NOTE", message("note_t", incarnation=1, kind=17, a=1, size=7, text=text)))
        self.record.write()
        log = (self.folder / SEGMENT).read_bytes()
        at = log.index(b"pothole")
        for change in (b"porthole", bytes(8)):
            (self.folder / SEGMENT).write_bytes(log[:at] + change + log[at + len(change):])
            damaged, self.folder = self.folder, self.folder.with_name(self.folder.name + "-new")
            self.assertEqual(run(RB, "recover", damaged, "-o", self.folder).returncode, INCOMPLETE)
            self.assertEqual(len(self.agrees(INCOMPLETE)["lost"]), 1)
            shutil.rmtree(self.folder)
            self.folder = damaged

    def test_an_altered_note_is_damage(self):
        note = message("note_t", incarnation=1, kind=3)
        self.record.events.insert(5, (b"RB_NOTE", note[:20] + b"x" + note[21:]))
        self.record.write()
        self.agrees(DAMAGED)

    def test_a_journal_entry_that_contradicts_the_blocks(self):
        at, (channel, data) = next((at, each) for at, each in enumerate(self.record.events) if each[0] == b"RB_JOURNAL")
        scans, = struct.unpack_from(">q", data, TYPES["journal_t"].offset("scans"))
        crcs = TYPES["journal_t"].offset("channel_crc")
        other_crc = with_crc(data[:crcs] + bytes([data[crcs] ^ 1]) + data[crcs + 1:])
        first_scan, = struct.unpack_from(">q", data, TYPES["journal_t"].offset("first_scan"))
        for changed in (altered(data, "journal_t", "scans", scans + 1), other_crc,
                        altered(data, "journal_t", "first_scan", first_scan + 1)):
            self.record.events[at] = channel, changed
            self.record.write()
            nodes = self.agrees(DAMAGED)["nodes"]
            self.assertEqual(sum(len(node["journal_contradictions"]) for node in nodes), 1)

    def test_a_journal_entry_of_no_blocks_has_no_scans(self):
        at, data = [(at, data) for at, (channel, data) in enumerate(self.record.events)
                    if channel == b"RB_JOURNAL" and struct.unpack_from(">i", data, 8)[0] == 1][-1]
        last, = struct.unpack_from(">q", data, TYPES["journal_t"].offset("last_sequence"))
        none = altered(data, "journal_t", "first_sequence", last + 1)
        crcs = TYPES["journal_t"].offset("channel_crc")
        none = with_crc(none[:crcs] + bytes(64) + none[crcs + 64:])
        for scans, verdict in ((0, COMPLETE), (20, DAMAGED)):
            counted = altered(altered(none, "journal_t", "scans", scans), "journal_t", "scans_missing", 0)
            self.record.events[at + 1:at + 1] = [(b"RB_JOURNAL", counted)]
            self.record.write()
            self.agrees(verdict)
            del self.record.events[at + 1]

    def test_a_journal_entry_that_begins_with_a_gap_of_no_scans(self):
        """How many scans were lost only the block behind the gap tells, and there its recorder saw the first one."""
        said = TYPES["journal_t"].decode(message("journal_t", first_sequence=3, last_sequence=4, first_scan=100, next_scan=120,
                                                 scans=20))
        blocks = []
        for kind, sequence, first_scan, scans in (("GAP", 3, 40, 0), ("SCAN", 4, 100, 20)):
            block = Block()
            block.kind, block.sequence, block.first_scan, block.scans = kind, sequence, first_scan, scans
            block.cause, block.channel_crc = "lost_at_node" if kind == "GAP" else None, [0] * 16
            blocks.append(block)
        journal = JournalCheck()
        for block in blocks:
            journal.append(block)
        journal.entry(said, 0)
        self.assertFalse([line for line in journal.contradictions if "first scan" in line], journal.contradictions)

    def test_an_entry_counts_on_its_own_channel_only(self):
        events = self.record.events
        loss = message("note_t", kind=4)  # neither an error nor a segment: something was lost
        for channel, verdict in ((b"RB_NOTE", INCOMPLETE), (b"RB_JOURNAL", DAMAGED), (b"RB_BLOCK_1_SCAN", DAMAGED),
                                 (b"RB_OF_A_NEWER_RELEASE", COMPLETE), (b"OTHER_PROGRAM", COMPLETE)):
            self.record.events = [*events[:500], (channel, loss), *events[500:]]
            self.record.write()
            with self.subTest(channel=channel):
                self.assertEqual(len(self.agrees(verdict)["lost"]), verdict == INCOMPLETE)

    def test_what_only_a_newer_release_can_read_is_no_damage(self):
        events = self.record.events
        unknown = with_crc(bytes.fromhex("123456789abcdef0") + bytes(20))
        for channel, data in ((b"RB_NEW", unknown), (b"RB_NOTE", unknown), (b"RB_JOURNAL", unknown),
                              (b"RB_NOTE", message("note_t", kind=99, a=-1))):
            with self.subTest(channel=channel, data=data):
                for written, verdict in ((data, COMPLETE), (data[:9] + b"x" + data[10:], DAMAGED)):
                    self.record.events = [*events[:500], (channel, written), *events[500:]]
                    self.record.write()
                    self.assertEqual(self.agrees(verdict)["messages_refused"], int(verdict == DAMAGED))

    def test_an_entry_out_of_its_bounds_is_damage(self):
        events = self.record.events
        entries = [(b"RB_NOTE", message("note_t", **fields)) for fields in (
            {"kind": 0}, {"kind": 3, "size": 401}, {"kind": 3, "host_ns": (1 << 61) + 1}, {"kind": 11, "a": -5},
            {"kind": 11, "a": 1 << 40}, {"kind": 5, "a": 1, "b": -1})]
        entries.append((b"RB_JOURNAL", message("journal_t", node=1, epoch=7, first_sequence=5, last_sequence=3)))
        for entry in entries:
            with self.subTest(entry=entry):
                self.record.events = [*events[:500], entry, *events[500:]]
                self.record.write()
                self.assertEqual(self.agrees(DAMAGED)["messages_refused"], 1)

    def test_a_sample_altered_under_a_good_crc_contradicts_the_journal(self):
        at = self.record.places("SCAN")[7]
        channel, data = self.record.events[at]
        counts = TYPES["scan_block_t"].offset("counts")
        self.record.events[at] = channel, with_crc(data[:counts] + bytes([data[counts] ^ 1]) + data[counts + 1:])
        self.record.write()
        self.assertEqual(len(self.node(self.agrees(DAMAGED))["journal_contradictions"]), 1)

    def contradicts_only_the_sum(self):
        self.record.without_journal().write()
        node = self.node(self.agrees(DAMAGED))
        self.assertEqual(len(node["contradictions"]), 1)
        self.assertIn("the node's sum of its blocks", node["contradictions"][0])
        self.assertFalse(node["undeclared_scans"] or node["undeclared_blocks"] or node["overlaps"] or node["other_repeats"])
        self.assertIn("the node's sum of its blocks", run(RB, "verify", self.folder).stdout)

    def test_a_sample_altered_under_a_good_crc_contradicts_the_end(self):
        at = self.record.places("SCAN")[7]
        channel, data = self.record.events[at]
        counts = TYPES["scan_block_t"].offset("counts")
        self.record.events[at] = channel, with_crc(data[:counts] + bytes([data[counts] ^ 1]) + data[counts + 1:])
        self.contradicts_only_the_sum()

    def test_blocks_that_changed_places_and_numbers_contradict_the_end(self):
        first, second = self.record.places("SCAN")[7:9]
        (channel, left), (_, right) = self.record.events[first], self.record.events[second]
        self.record.events[first] = channel, with_crc(left[:20] + left[20:52] + right[52:])
        self.record.events[second] = channel, with_crc(right[:20] + right[20:52] + left[52:])
        self.contradicts_only_the_sum()

    def test_an_end_that_sums_up_other_blocks(self):
        at = self.record.places("END")[0]
        channel, data = self.record.events[at]
        self.record.events[at] = channel, altered(data, "end_t", "blocks_crc32c", 0, ">I")
        self.contradicts_only_the_sum()

    def test_the_journal_counts_every_loss_and_no_count_goes_down(self):
        at, data = [(at, data) for at, (channel, data) in enumerate(self.record.events)
                    if channel == b"RB_JOURNAL" and struct.unpack_from(">i", data, 8)[0] == 1][-1]
        said = TYPES["journal_t"].decode(data)
        later = message("journal_t", node=1, epoch=said["epoch"], first_sequence=said["last_sequence"] + 1,
                        last_sequence=said["last_sequence"], first_scan=said["next_scan"], next_scan=said["next_scan"])
        self.record.events.insert(at + 1, (b"RB_JOURNAL", later))
        for name, value in said.items():  # as the entry before counted
            if name in OF_NODE + OF_RUN and not isinstance(value, tuple):
                later = altered(later, "journal_t", name, value)
        for name in ("encoder_faults", "device_counts"):
            begin = TYPES["journal_t"].offset(name)
            later = with_crc(later[:begin] + data[begin:begin + 8 * len(said[name])] + later[begin + 8 * len(said[name]):])
        def count(entry, field, change):
            before = said[field][0] if isinstance(said[field], tuple) else said[field]
            return altered(entry, "journal_t", field, before + change)

        more = later
        for field in OF_NODE + OF_RUN:
            more = count(more, field, 1)
        self.record.events[at + 1] = b"RB_JOURNAL", more
        self.record.write()
        for field, counted in self.node(self.agrees(COMPLETE))["losses"].items():
            self.assertEqual((counted[0] if isinstance(counted, list) else counted) - 1,
                             said[field][0] if isinstance(said[field], tuple) else said[field], field)
        for field in OF_NODE + OF_RUN:
            self.record.events[at + 1] = b"RB_JOURNAL", count(later, field, -1)
            self.record.write()
            lines = self.node(self.agrees(DAMAGED))["journal_contradictions"]
            self.assertEqual(len(lines), 1, lines)
            self.assertIn(field, lines[0])

    def test_texts_beside_the_segments_of_whatever_length_are_none(self):
        for name in ("seg-000001.idx", "manifest.json"):
            with (self.folder / name).open("wb") as file:
                file.truncate(4 << 40)  # without a block on the disk
        self.agrees(COMPLETE)

    def test_nothing_readable(self):
        (self.folder / SEGMENT).write_bytes(b"x" * 5000)
        self.agrees(UNREADABLE)
        (self.folder / SEGMENT).unlink()
        self.agrees(UNREADABLE)


if __name__ == "__main__":
    unittest.main()
