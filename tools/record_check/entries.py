"""What recorders write between the blocks: which of it counts, and what is altered.

An event on a channel of ours must end with its own CRC.  On the channel of an entry it must be that entry, with fields
in their bounds, unless only a newer release can read it: a message of a type, or a note of a kind, not known here.
"""

from record_check.blocks import CLOCK_LIMIT_NS, INDEX_LIMIT, KINDS, LAST_NODE
from record_check.event_log import ends_with_its_crc

ENTRIES = {b"RB_JOURNAL": "journal_t", b"RB_NOTE": "note_t", b"RB_COMMIT": "commit_t"}
RECORDED = {*KINDS, *ENTRIES.values(), "clock_exchange_t", "clock_fit_t"}
SEGMENT_ABANDONED, SEGMENT_DELETED, LAST_KIND = 5, 11, 28  # kinds of notes
UTC_LIMIT_US = 4_100_000_000_000_000
LAST_SEGMENT = (1 << 31) - 1
TEXT_BYTES = 400
INDEXES_OF_JOURNAL = ("first_sequence", "last_sequence", "first_scan", "next_scan", "scans", "scans_missing")


def _is_good_journal(entry):
    return (1 <= entry["node"] <= LAST_NODE and entry["last_sequence"] >= entry["first_sequence"] - 1 and
            all(0 <= entry[name] <= INDEX_LIMIT for name in INDEXES_OF_JOURNAL))


def _is_good_note(note):
    names_segment = note["kind"] in (SEGMENT_ABANDONED, SEGMENT_DELETED)
    return (1 <= note["kind"] <= LAST_KIND and 0 <= note["size"] <= TEXT_BYTES and abs(note["time_us"]) <= UTC_LIMIT_US and
            abs(note["host_ns"]) <= CLOCK_LIMIT_NS and
            (not names_segment or (1 <= note["a"] <= LAST_SEGMENT and note["b"] >= 0)))


def _is_good_commit(commit):
    return commit["bytes"] >= 0 and commit["headers_from"] >= 0


IS_GOOD = {"journal_t": _is_good_journal, "note_t": _is_good_note, "commit_t": _is_good_commit}


class EntryDecoder:
    """Takes the data of events on the channels of entries."""

    def __init__(self, types):
        self._types = {kind.fingerprint: kind for kind in types.values() if kind.name in RECORDED}

    def _type_of(self, data):
        return self._types.get(int.from_bytes(data[:8], "big"))

    def decode(self, channel, data, crc_is_good=False):
        """Fields of the good entry that this is, or None."""
        kind = self._type_of(data)
        if kind is None or kind.name != ENTRIES.get(channel) or len(data) != kind.size:
            return None
        if not crc_is_good and not ends_with_its_crc(data):
            return None
        fields = kind.decode(data)
        return fields if IS_GOOD[kind.name](fields) else None

    def is_altered(self, channel, data):
        """What decode() does not take, and is no block."""
        if not channel.startswith(b"RB_"):
            return False
        if not ends_with_its_crc(data):
            return True
        return channel in ENTRIES and not self._is_of_newer_release(data)

    def _is_of_newer_release(self, data):
        kind = self._type_of(data)
        if kind is not None and kind.name == "note_t" and len(data) == kind.size:
            return kind.decode(data)["kind"] > LAST_KIND
        return kind is None and len(data) >= 12
