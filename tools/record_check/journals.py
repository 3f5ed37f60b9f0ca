"""The journal: once a second the recorder says what it has appended.  Held against the blocks themselves."""

from record_check.crc32c import Shift, crc

CHANNELS = 16
OF_NODE = ("repaired", "spool_failures", "scans_refused", "blocks_unsent", "acks_refused", "encoder_faults",
           "unreferenced_blocks", "device_counts")
OF_RUN = ("refused", "rivals", "unsent", "disk_failures")


class JournalCheck:
    """Of one node epoch: the blocks since the last entry, until an entry takes them."""

    def __init__(self):
        self.appended = []  # since the last entry, as they lie in the record
        self.entries = 0
        self.losses = {}  # counters by name: of the node's epoch by all entries, of the recorder's last run
        self.counted = {}  # the same as this run's last entry says
        self.contradictions = []

    def append(self, block):
        self.appended.append(block)

    def restart(self):
        """Another run of the recorder knows nothing of what the one before had not written down yet."""
        self.appended.clear()
        self.counted = {}

    def entry(self, journal, first_kept):
        """@param first_kept  blocks before this number may have been deleted with their segment"""
        self.entries += 1
        self._count_losses(journal)
        first, last = journal["first_sequence"], journal["last_sequence"]
        blocks, self.appended = self.appended, []
        if first <= last and first < first_kept:
            return
        for what, said, here in self._compare(journal, blocks):
            if said != here:
                self.contradictions.append(f"the journal's entry for blocks {first} to {last} says {what} {said}; "
                                           f"here: {here}")

    def _count_losses(self, journal):
        said = {name: journal[name] for name in OF_NODE + OF_RUN}
        for name, value in said.items():
            values, before = (each if isinstance(each, tuple) else (each,) for each in (value, self.counted.get(name, 0)))
            if any(new < old for new, old in zip(values, before)) or min(values) < 0:
                self.contradictions.append(f"the journal's count of {name} goes down, from {before} to {values}")
        self.counted = said
        heard = {name: _larger(said[name], self.losses.get(name, said[name])) for name in OF_NODE}
        self.losses = said | heard  # a recorder that began anew may not have heard the node since

    @staticmethod
    def _compare(journal, blocks):
        # Gaps of no scans state where they are, as far as their node could, and not where scans are.
        with_scans = [block for block in blocks if block.scans > 0]
        placed = [block for block in blocks if block.kind in ("SCAN", "GAP")]
        first, last = journal["first_sequence"], journal["last_sequence"]
        if blocks:
            yield "last block", last, blocks[-1].sequence
        if not blocks or not blocks[0].covers_numbers_before():
            yield "first block", first, blocks[0].sequence if blocks else last + 1
        yield "scans", journal["scans"], sum(block.scans for block in blocks if block.kind == "SCAN")
        yield "scans missing", journal["scans_missing"], sum(block.scans for block in blocks if block.kind == "GAP")
        if with_scans:
            yield "first scan", journal["first_scan"], with_scans[0].first_scan
            yield "next scan", journal["next_scan"], placed[-1].first_scan + placed[-1].scans
        yield "channel CRCs", [value & 0xFFFFFFFF for value in journal["channel_crc"]], _channel_crcs(blocks)


def _larger(one, other):
    return tuple(map(max, one, other)) if isinstance(one, tuple) else max(one, other)


def _channel_crcs(blocks):
    total = [crc(b"")] * CHANNELS
    for block in blocks:
        if block.kind == "SCAN":
            shift = Shift(4 * block.scans)
            total = [shift(before) ^ own for before, own in zip(total, block.channel_crc)]
    return total


def channel_crcs_of_one(data, counts_at, scans):
    """[channel] CRC of the big-endian counts of the first `scans` rows."""
    rows = data[counts_at:counts_at + 4 * CHANNELS * scans]
    return [crc(b"".join(rows[at:at + 4] for at in range(4 * channel, len(rows), 4 * CHANNELS)))
            for channel in range(CHANNELS)]
