"""What a record holds of one node epoch, proven twice: by block numbers and by scan indices."""

from array import array


class Epoch:
    """Takes the blocks of one node epoch in any order; memory grows by 4 bytes a block."""

    def __init__(self, node, epoch, begins_late):
        self.node, self.epoch = node, epoch
        self.begins_late = begins_late  # its beginning may have been deleted by the retention mode
        self.blocks = self.samples = self.samples_missing = 0
        self.last_sequence = 0
        self.next_scan = 0  # None: behind a declared loss of unknown length
        self.deleted_scans = None
        self.gaps = []  # (cause, first scan, scans)
        self.undeclared_blocks, self.undeclared_scans = [], []  # (first, last)
        self.identical_repeats = self.other_repeats = self.overlaps = 0
        self.contradictions = []
        self.end = None
        self.crashed = False
        self._waiting = {}
        self._first = None
        self._crcs = array("I")  # [sequence - first]; 0 where no block of that number was seen

    def add(self, block):
        if self._first is None:
            self._begin(block)
        if block.sequence <= self.last_sequence or block.sequence in self._waiting:
            self._repeat(block)
        elif block.sequence == self.last_sequence + 1 or block.covers_numbers_before():
            self._take(block)
            while self.last_sequence + 1 in self._waiting:
                self._take(self._waiting.pop(self.last_sequence + 1))
        else:
            self._waiting[block.sequence] = block

    def first_sequence(self):
        """Of the first block here; blocks before it were deleted with their segment."""
        return 1 if self._first is None else self._first

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

    def _begin(self, block):
        self._first = 1
        if self.begins_late and block.sequence > 1:
            self._first = block.sequence
            self.last_sequence = block.sequence - 1
            self.next_scan = None

    def _repeat(self, block):
        waiting = self._waiting.get(block.sequence)
        at = block.sequence - self._first
        known = waiting.crc if waiting else self._crcs[at] if 0 <= at < len(self._crcs) else 0
        if known == block.crc:
            self.identical_repeats += 1
        else:
            self.other_repeats += 1

    def _take(self, block):
        if self.crashed or self.end:
            self.contradictions.append(f"block {block.sequence} comes behind the epoch's end")
        self._crcs.extend(0 for _ in range(block.sequence - self._first - len(self._crcs)))
        self._crcs.append(block.crc)
        self.last_sequence = block.sequence
        self.blocks += 1
        self._check_scans(block)
        if block.kind == "SCAN":
            self.samples += block.scans
        elif block.kind == "GAP":
            self.samples_missing += block.scans
            self.gaps.append((block.cause, block.first_scan, block.scans))
            self.crashed = block.cause == "node_crash"
        elif block.kind == "END":
            self.end = block

    def _check_scans(self, block):
        if block.kind not in ("SCAN", "GAP", "END"):
            return
        if self.deleted_scans is None:
            self.deleted_scans = block.first_scan if self.next_scan is None else 0
        if self.next_scan is not None:
            if block.first_scan > self.next_scan:
                self.undeclared_scans.append((self.next_scan, block.first_scan - 1))
            if block.first_scan < self.next_scan and (block.scans > 0 or block.kind == "END"):
                self.overlaps += 1
        self.next_scan = max(self.next_scan or 0, block.first_scan + block.scans)
        if block.covers_numbers_before() and block.scans == 0:
            self.next_scan = None

    def _check_totals(self):
        if not self.end:
            return
        blocks, sealed, missing = self.end.totals
        if not blocks == self.end.sequence == self.last_sequence:
            self.contradictions.append(f"the end is block {self.end.sequence} of {blocks}, the last one here is block "
                                       f"{self.last_sequence}")
        here = self.samples + self.samples_missing + (self.deleted_scans or 0)
        if sealed + missing != here:
            self.contradictions.append(f"the node took {sealed + missing} scans, {here} are recorded, declared missing "
                                       "or declared deleted")

    def is_damaged(self):
        return bool(self.undeclared_blocks or self.undeclared_scans or self.identical_repeats or self.other_repeats or
                    self.overlaps or self.contradictions)

    def is_complete(self):
        return not self.is_damaged() and self.end is not None and not self.gaps and self._first == 1

    def report(self):
        return {"node": self.node, "epoch": self.epoch, "complete": self.is_complete(), "ended": self.end is not None,
                "crashed": self.crashed, "blocks": self.blocks, "samples_recorded": self.samples,
                "samples_missing": self.samples_missing,
                "gaps": [{"cause": cause, "first_scan": first, "scans": scans} for cause, first, scans in self.gaps],
                "undeclared_blocks": self.undeclared_blocks, "undeclared_scans": self.undeclared_scans,
                "identical_repeats": self.identical_repeats, "other_repeats": self.other_repeats,
                "overlaps": self.overlaps, "contradictions": self.contradictions}
