"""Reads a whole record and says what it proves."""

import errno
import os

from record_check.blocks import CHANNELS, SCANS_PER_BLOCK, BlockDecoder
from record_check.crc32c import crc_of_columns, crc_of_each
from record_check.description import Description
from record_check.entries import EntryDecoder
from record_check.epochs import IN_OTHER_FOLDER, NOTHING_DELETED, Epoch
from record_check.headers import altered_headers
from record_check.journals import JournalCheck, channel_crcs_of_one
from record_check.segments import Segments

COMPLETE, DAMAGED, INCOMPLETE, UNREADABLE = 0, 1, 3, 4
WORDS = {COMPLETE: "complete", DAMAGED: "damaged", INCOMPLETE: "incomplete, but declared", UNREADABLE: "unreadable"}
STARTED, STOPPED, DISK_FAILED, MARK, NODE_MISSING, NODE_THERE = 1, 2, 4, 17, 24, 25  # kinds of notes
NOT_HEARD = 5  # cause of an absence
MOST_TOGETHER = 1024  # messages in one CRC pass: they stay in the cache


class Checker:
    """check() once; then verdict() and what it found."""

    def __init__(self, folder, types, truth=None):
        self.types = types
        self.truth = truth
        self.decoder = BlockDecoder(types)
        self.entries = EntryDecoder(types)
        scan = next(kind for kind in types.values() if kind.name == "scan_block_t")
        self.counts_at = scan.offset("counts")
        self.segments = Segments(folder, types)
        self.deleted = self.segments.deleted_positions()
        self.epochs, self.journals = {}, {}
        for key, (*_, is_over) in self.deleted.items():
            if not is_over:
                self._epoch(*key)
        self.description = Description()
        self.missing = {}  # node: why it does not measure
        self.damage, self.lost = [], []  # lost: declared, but by no gap
        self.elsewhere = list(self.segments.elsewhere())
        self.epochs_said = self.marks_said = self.last_mark = 0  # what recorders say that stopped, and the marks here
        self.keys = set(self.deleted)  # epochs of which a block was here
        self.events = self.other_events = self.refused = self.damaged_bytes = self.torn_bytes = 0
        self.missing_segments = self.bytes = self.notes = self.altered_headers = 0

    def check(self):
        for number in self.segments.numbers:
            log, events, damage = self.segments.read(number)
            self.bytes += len(log)
            self._check_events(number, log, events)
            self._list_damage(number, damage, len(log))
            self._check_index(number)
        self.damage += self.description.contradictions
        for line in self.segments.missing():
            self.missing_segments += 1
            self.damage.append(line)
        for key, journal in self.journals.items():
            if journal.contradictions:
                self._epoch(*key)  # all its blocks may be gone
        for epoch in self.epochs.values():
            epoch.finish()
        self._list_lost()
        if self.truth:
            for node, number, why in self.truth.contradictions(self.epochs):
                self._epoch(node, number).contradictions.append(why)
        if not self.events:
            raise ValueError(f"{self.segments.folder}: no event in it can be read")

    def verdict(self):
        journals = any(journal.contradictions for journal in self.journals.values())
        if (self.refused or self.damaged_bytes or self.altered_headers or self.description.contradictions or self.missing_segments or journals or
                any(epoch.is_damaged() for epoch in self.epochs.values())):
            return DAMAGED
        whole = not self.damage and not self.lost and not self.elsewhere and self.epochs
        return COMPLETE if whole and all(epoch.is_complete() for epoch in self.epochs.values()) else INCOMPLETE

    def _check_events(self, number, log, events):
        good, channel_crcs = self._check_crcs(log, events)
        commits = self._commits(log, events, good)
        for begin, end in altered_headers(log, events, commits):
            self.altered_headers += 1
            self.damage.append(f"{self.segments.paths[number].name}: {end - begin} bytes from {begin} on are events of "
                               "which one is altered: number, stamp or channel, or contents with their CRC")
        for at, (channel, begin, end) in enumerate(events):
            self.events += 1
            if channel.startswith(b"RB_BLOCK_"):
                self._take_block(channel, good.get(at), log[begin:end], channel_crcs.get(at), number, begin)
            elif at not in commits:
                self._take_other(channel, log[begin:end], at in good, number, begin)

    def _commits(self, log, events, good):
        """{index: fields} of the good ones."""
        of_channel = {at: self.entries.decode(channel, log[begin:end], at in good)
                      for at, (channel, begin, end) in enumerate(events) if channel == b"RB_COMMIT"}
        return {at: commit for at, commit in of_channel.items() if commit}

    def _check_crcs(self, log, events):
        """({index: type} of the events that are messages with a good CRC, {index: CRC of each channel} of the scans)."""
        of_type = {}
        for at, (_, begin, end) in enumerate(events):
            kind = self.types.get(int.from_bytes(log[begin:begin + 8], "big"))
            if kind and kind.size == end - begin and kind.fields[-1][0] == "crc32c":
                of_type.setdefault(kind.fingerprint, []).append(at)
        good, channel_crcs = {}, {}
        for fingerprint, members in of_type.items():
            kind = self.types[fingerprint]
            for first in range(0, len(members), MOST_TOGETHER):
                part = members[first:first + MOST_TOGETHER]
                joined = b"".join(log[events[at][1]:events[at][2]] for at in part)
                right = crc_of_each(joined, kind.size, kind.size - 4)
                good.update((at, kind) for at, value, end in zip(part, right, range(kind.size, len(joined) + 1, kind.size))
                            if joined[end - 4:end] == value.to_bytes(4, "big"))
                if kind.name == "scan_block_t":
                    channel_crcs.update(zip(part, self._channel_crcs(joined, kind.size)))
        return good, channel_crcs

    def _channel_crcs(self, joined, size):
        """For each block the CRC of each channel's counts, as if all rows counted."""
        count = len(joined) // size
        of_channel = [crc_of_columns((joined[self.counts_at + 4 * (CHANNELS * row + channel) + byte::size]
                                      for row in range(SCANS_PER_BLOCK) for byte in range(4)), count)
                      for channel in range(CHANNELS)]
        return zip(*of_channel)

    def _take_other(self, channel, data, crc_is_good, number, begin):
        entry = self.entries.decode(channel, data, crc_is_good)
        if entry and channel == b"RB_JOURNAL":
            self._take_journal(entry)
        elif entry:
            self._take_note(entry)
        elif self.entries.is_altered(channel, data):
            self._refuse(number, begin, len(data))
        else:
            self.other_events += 1

    def _refuse(self, number, begin, count):
        self.refused += 1
        self.damage.append(f"{self.segments.paths[number].name}: {count} bytes from {begin} on are an altered message")

    def _take_block(self, channel, kind, data, channel_crc, number, begin):
        block = self.decoder.decode(kind.fingerprint, data) if kind and kind.fingerprint in self.decoder.kinds else None
        if block is None or channel != f"RB_BLOCK_{block.node}_{block.kind}".encode():
            self._refuse(number, begin, len(data))
            return
        if block.sequence == 0:
            if block.kind == "META" and block.node == 0:
                self.description.take(kind.decode(data))
            return
        epoch = self._epoch(block.node, block.epoch)
        self.keys.add((block.node, block.epoch))
        if block.kind == "SCAN":
            whole = block.scans == SCANS_PER_BLOCK
            block.channel_crc = channel_crc if whole else channel_crcs_of_one(data, self.counts_at, block.scans)
            wrong = self.truth and self.truth.wrong_sample(block, kind.decode(data)["counts"])
            if wrong:
                epoch.contradictions.append(wrong)
        epoch.add(block)
        self._journal(block.node, block.epoch).append(block)

    def _take_journal(self, entry):
        deleted_through = self.deleted.get((entry["node"], entry["epoch"]), NOTHING_DELETED)[0]
        self._journal(entry["node"], entry["epoch"]).entry(entry, deleted_through + 1)

    def _take_note(self, note):
        self.notes += 1
        if note["kind"] == STARTED:
            for journal in self.journals.values():
                journal.restart()
        elif note["kind"] == STOPPED:
            self.epochs_said = max(self.epochs_said, note["a"])
            self.marks_said = max(self.marks_said, note["b"])
        elif note["kind"] == MARK:
            self.last_mark = max(self.last_mark, note["a"])
        elif note["kind"] == NODE_MISSING:
            if self.missing.get(note["a"], NOT_HEARD) == NOT_HEARD:  # what happened replaces that it is not heard
                self.missing[note["a"]] = note["b"]
        elif note["kind"] == NODE_THERE and note["a"] in self.missing:
            del self.missing[note["a"]]
            if note["b"]:
                self.lost.append(f"node {note['a']} did not measure for a time")
        elif note["kind"] == DISK_FAILED and note["a"] == note["b"] == 0:
            text = note["text"][:note["size"]].decode("utf-8", "replace")
            self.lost.append(f"lost from the recording that this one was made of: {text}")

    def _list_lost(self):
        last = {epoch.node: epoch for epoch in self.epochs.values()}
        for node, cause in self.missing.items():
            was_cut_off = cause == NOT_HEARD and node in last and last[node].end is not None
            if not was_cut_off:
                self.lost.append(f"node {node} did not measure to the end")
        for first, last in self.segments.deleted_and_gone():
            which = f"segment {first} was" if first == last else f"segments {first} to {last} were"
            self.lost.append(f"{which} deleted by the retention mode")
        if self.segments.are_all() and self.epochs_said > len(self.keys):
            self.lost.append(f"the recorder stopped with {self.epochs_said} node epochs; here are {len(self.keys)}")
        if self.segments.are_all() and self.marks_said > self.last_mark:
            self.lost.append(f"the recorder stopped with mark {self.marks_said} set; the last one here is {self.last_mark}")

    def _check_index(self, number):
        """An index may say less than is there, but cannot name an epoch of which nothing is."""
        index = self.segments.index(number)
        for node, epoch in sorted(index[1].keys() - self.keys) if index and self.segments.are_all() else ():
            self.missing_segments += 1
            self.damage.append(f"{self.segments.paths[number].name}: node {node} epoch {epoch} is not here; its index names it")

    def _epoch(self, node, epoch):
        key = (node, epoch)
        if key not in self.epochs:
            unknown = IN_OTHER_FOLDER if self.segments.begins_anywhere() else NOTHING_DELETED
            self.epochs[key] = Epoch(node, epoch, self.deleted.get(key, unknown))
        return self.epochs[key]

    def _journal(self, node, epoch):
        return self.journals.setdefault((node, epoch), JournalCheck())

    def _list_damage(self, number, damage, size):
        pieces = [(offset, count, False) for offset, count in damage]
        if number in self.segments.torn:
            pieces.append((*self.segments.torn[number], not self.segments.is_listed_as_finished(number)))
        for offset, count, torn in pieces:
            if torn:
                self.torn_bytes += count
            else:
                self.damaged_bytes += count
            what = "a torn tail" if torn else "no event of an LCM log"
            self.damage.append(f"{self.segments.paths[number].name}: {count} bytes from {offset} on are {what}")
        for offset, count in self.segments.unreadable[number]:
            self.damaged_bytes += count
            self.damage.append(f"{self.segments.paths[number].name}: {count} bytes from {offset} on cannot be read: "
                               f"{os.strerror(errno.EIO)}")
        if size == 0 and number == self.segments.numbers[-1]:
            self.damage.append(f"{self.segments.paths[number].name}: is empty: its recorder was killed when it began it")
