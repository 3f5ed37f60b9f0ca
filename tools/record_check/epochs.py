"""What a record holds of one node epoch, proven twice: by block numbers and by scan indices."""

import sys
from array import array
from bisect import bisect_right

from record_check.crc32c import crc

NOTHING_DELETED = (0, 0, 0, False)
IN_OTHER_FOLDER = None  # what comes before the first block: nobody here knows where it stood


class Epoch:
    """Takes the blocks of one node epoch in any order; memory grows by 4 bytes a block."""

    def __init__(self, node, epoch, deleted=NOTHING_DELETED):
        """@param deleted  (last sequence, next scan, sum, over) of what the retention mode has deleted of it"""
        self.node, self.epoch = node, epoch
        self._begins_anywhere, deleted = deleted is IN_OTHER_FOLDER, deleted or NOTHING_DELETED
        self.blocks = self.samples = self.samples_missing = 0
        self.last_sequence, self.next_scan = deleted[:2]  # next_scan None: behind a declared loss of unknown length
        self.first_sequence, self.deleted_scans = deleted[0] + 1, deleted[1]
        self.gaps = []  # as report() gives them
        self.undeclared_blocks, self.undeclared_scans = [], []  # (first, last)
        self.identical_repeats = self.other_repeats = self.overlaps = 0
        self.contradictions = []
        self.end = None
        self.crashed, self._was_over = False, deleted[3]  # before the first block here
        # CRC-32C over the CRCs of the blocks, big endian, in their order: the node's end has it of those before.
        self._sum_before, self._only_of_node = deleted[2], True
        self._waiting = {}
        self._runs, self._crcs = [], []  # first number of each run of blocks; their CRCs

    def add(self, block):
        if self._begins_anywhere and not self._runs and block.sequence > 1:
            self.last_sequence, self.first_sequence = block.sequence - 1, block.sequence
            self.next_scan = self._sum_before = None
        if block.sequence <= self.last_sequence or block.sequence in self._waiting:
            self._repeat(block)
        elif block.sequence == self.last_sequence + 1 or block.covers_numbers_before():
            self._take(block)
            while self.last_sequence + 1 in self._waiting:
                self._take(self._waiting.pop(self.last_sequence + 1))
        else:
            self._waiting[block.sequence] = block

    def finish(self):
        """No more will come: what is still waited for is missing."""
        for sequence in sorted(self._waiting):
            block = self._waiting[sequence]
            if sequence <= self.last_sequence:
                self._repeat(block)
                continue
            if sequence > self.last_sequence + 1:
                self.undeclared_blocks.append((self.last_sequence + 1, sequence - 1))
            self._take(block)
        self._waiting.clear()
        self._check_totals()

    def _repeat(self, block):
        waiting = self._waiting.get(block.sequence)
        known = waiting.crc if waiting else self._known_crc(block.sequence)
        if known == block.crc:
            self.identical_repeats += 1
        else:
            self.other_repeats += 1

    def _known_crc(self, sequence):
        run = bisect_right(self._runs, sequence) - 1
        at = sequence - self._runs[run] if run >= 0 else 0
        return self._crcs[run][at] if run >= 0 and at < len(self._crcs[run]) else None

    def _take(self, block):
        if self.crashed or self.end or self._was_over:
            self.contradictions.append(f"block {block.sequence} comes behind the epoch's end")
        first_block = self.last_sequence + 1 if block.covers_numbers_before() else block.sequence
        if block.sequence != self.last_sequence + 1 or not self._runs:
            self._runs.append(block.sequence)
            self._crcs.append(array("I"))
        self._crcs[-1].append(block.crc)
        self.last_sequence = block.sequence
        self.blocks += 1
        self._only_of_node = self._only_of_node and not block.is_declared_by_host()
        self._check_scans(block)
        self._prove_without_scans(block)
        if block.kind == "SCAN":
            self.samples += block.scans
        elif block.kind == "GAP":
            self.samples_missing += block.scans
            self.gaps.append({"cause": block.cause, "first_block": first_block, "last_block": block.sequence,
                              "first_scan": block.first_scan, "scans": block.scans, "scans_known": block.scans > 0})
            self.crashed = block.cause == "node_crash"
        elif block.kind == "END":
            self.end = block

    def _check_scans(self, block):
        if block.kind not in ("SCAN", "GAP", "END"):
            return
        if self.first_sequence > 1 and self._begins_anywhere:
            self._begins_anywhere, self.deleted_scans = False, block.first_scan
        elif self.next_scan is not None:
            if block.first_scan > self.next_scan:
                self.undeclared_scans.append((self.next_scan, block.first_scan - 1))
            if block.first_scan < self.next_scan and (block.scans > 0 or block.kind == "END"):
                self.overlaps += 1
        self.next_scan = max(self.next_scan or 0, block.first_scan + block.scans)
        if block.covers_numbers_before() and block.scans == 0:
            self.next_scan = None

    def _prove_without_scans(self, block):
        """Gaps of no scans, if scans go on where they begin: only edges, signals or descriptions are missing there."""
        if block.kind not in ("SCAN", "END"):
            return
        for gap in reversed(self.gaps):
            if gap["scans_known"] or gap["cause"] == "node_crash" or gap["first_scan"] != block.first_scan:
                return
            gap["scans_known"] = True

    def _check_totals(self):
        if not self.end:
            return
        blocks, sealed, missing = self.end.totals
        if not blocks == self.end.sequence == self.last_sequence:
            self.contradictions.append(f"the end is block {self.end.sequence} of {blocks}, the last one here is block "
                                       f"{self.last_sequence}")
        here = self.samples + self.samples_missing + self.deleted_scans
        # The end shows how many are missing in a declared loss that does not state it.
        if sealed + missing > here and any(gap["cause"] in ("lost_at_node", "lost_in_record") and not gap["scans_known"]
                                           for gap in self.gaps):
            self.samples_missing += sealed + missing - here
            here = sealed + missing
        if sealed + missing != here:
            self.contradictions.append(f"the node took {sealed + missing} scans, {here} are recorded, declared missing "
                                       "or declared deleted")

        self._check_sum()

    def _check_sum(self):
        """Of blocks that are all here, once and as the node sealed them, if it is so."""
        if self._sum_before is None or not self._only_of_node or self.undeclared_blocks or self.other_repeats:
            return
        crcs = array("I", [value for run in self._crcs for value in run][:-1])  # without the end's
        if sys.byteorder == "little":
            crcs.byteswap()
        here = crc(crcs.tobytes(), self._sum_before)
        if here != self.end.sum:
            self.contradictions.append(f"the node's sum of its blocks is {self.end.sum:08x}, that of those here is {here:08x}")

    def is_damaged(self):
        return bool(self.undeclared_blocks or self.undeclared_scans or self.identical_repeats or self.other_repeats or
                    self.overlaps or self.contradictions)

    def is_complete(self):
        return not self.is_damaged() and self.end is not None and not self.gaps and self.first_sequence == 1

    def report(self):
        return {"node": self.node, "epoch": self.epoch, "complete": self.is_complete(), "ended": self.end is not None,
                "crashed": self.crashed, "blocks": self.blocks, "samples_recorded": self.samples,
                "samples_missing": self.samples_missing, "samples_deleted": self.deleted_scans,
                "gaps": self.gaps,
                "undeclared_blocks": self.undeclared_blocks, "undeclared_scans": self.undeclared_scans,
                "identical_repeats": self.identical_repeats, "other_repeats": self.other_repeats,
                "overlaps": self.overlaps, "contradictions": self.contradictions}
