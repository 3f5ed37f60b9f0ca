"""Which segments a record should have, and what is left of them."""

import json
import pathlib
import re

from record_check.entries import LAST_SEGMENT, SEGMENT_ABANDONED, SEGMENT_DELETED, EntryDecoder
from record_check.event_log import split_events
from record_check.extent import is_finished, read_index, torn_from
from record_check.segment_file import read_segment
from record_check.small_file import read_small_file

LONGEST_SEGMENT = (1 << 64) - 1


def number_of(name, ending):
    """Of the segment that a file belongs to, by a name as a recorder writes it; else None."""
    found = re.fullmatch(r"seg-([0-9]{6,10})" + re.escape(ending), name)
    number = int(found[1]) if found else 0
    return number if 1 <= number <= LAST_SEGMENT and name == f"seg-{number:06}{ending}" else None


class Segments:
    """The segment files of a folder, in order; notes of the recorder say where one ends early or was deleted."""

    def __init__(self, folder, types):
        self.folder = pathlib.Path(folder)
        if not self.folder.is_dir():
            raise FileNotFoundError(f"recording {folder}: no such folder")
        self.paths = {number: path for path in self.folder.iterdir() if (number := number_of(path.name, ".lcm"))}
        if not self.paths:
            raise FileNotFoundError(f"recording {folder} holds no segment (seg-000001.lcm)")
        self.numbers = sorted(self.paths)
        # The number of the segment deleted last: those behind it may have been given up.
        indexes = (number_of(path.name, ".idx") or 0 for path in self.folder.iterdir())
        self.before = max((number for number in indexes if number < self.numbers[0]), default=0)
        self.finished = self._read_manifest()
        self._entries = EntryDecoder(types)
        self.unreadable = {}  # number -> [(offset, bytes)]
        self.ends, self.given_up, self.deleted = {}, {}, set()  # given_up: without the torn ones
        deletions = [deletion for number in self.numbers for deletion in self._read_notes(number)]
        self.torn = {}  # number -> (offset, bytes): what a kill or a power cut leaves at the end of a record
        self._find_torn()
        self.deleted.update(gone for number, end, gone in deletions if end <= self.ends.get(number, end))

    def deleted_positions(self):
        """{(node, epoch): (last sequence, next scan, sum, over)} at the end of what the retention mode deleted, and said so."""
        index = self.index(self.before)
        return index[1] if index and self.before in self.deleted else {}

    def begins_anywhere(self):
        """What comes before the first block of each epoch is in another folder, and how far is not known here."""
        return (self.folder / "continues").exists() and not self.index(self.before)

    def elsewhere(self):
        """Lines of which folders have what came before, or what comes behind."""
        for name, what in (("continues", "what came before is in"), ("continued-in", "it goes on in")):
            path = self.folder / name
            for line in path.read_text(encoding="utf-8", errors="replace").splitlines() if path.exists() else ():
                yield f"{what} {line}"

    def are_all(self):
        """Of the recording: another folder holds nothing of it that comes before, and no segment was deleted."""
        return self.numbers[0] == 1 and not (self.folder / "continues").exists()

    def deleted_and_gone(self):
        """Yields (first, last) of those before the first one here that the retention mode took.

        The notes on the first of them went with their segments; but what the manifest lists had not been taken.
        """
        end = min(self.numbers[0], max(self.deleted, default=0) + 1)
        listed = {number_of(name, ".lcm") or 0 for name in self.finished} - self.deleted
        first = 1
        for number in sorted(number for number in listed | {end} if 0 < number <= end):
            if first < number:
                yield first, number - 1
            first = number + 1

    def index(self, number):
        """What the index of a segment says, as read_index() gives it, or None."""
        return read_index(self.folder / f"seg-{number:06}.lcm", number)

    def missing(self):
        """Lines of what should be here and is not."""
        for name, size in self.finished.items():
            number = number_of(name, ".lcm")
            path = self.folder / name
            size = min(size, self.given_up.get(number, size))
            if not path.exists() and size > 0 and number not in self.deleted:
                yield f"{name}: is missing; manifest.json lists it as finished"
            elif path.exists() and path.stat().st_size < size:
                yield f"{name}: has {path.stat().st_size} of the {size} bytes it was finished with"
            elif path.exists() and path.stat().st_size > size and number not in self.given_up:
                yield f"{name}: has {path.stat().st_size} bytes; it was finished with {size}"
        yield from self._missing_by_indexes()
        before = max(self.deleted, default=0)
        for number in self.numbers:
            name = self.paths[number].name
            while before + 1 < number and self.given_up.get(before + 1) == 0:
                before += 1  # given up before anything was promised of it: a power cut may have taken its name
            if number > before + 1:
                yield f"{name}: does not follow segment {before}" if before else f"{name}: is the first one here"
            before = max(before, number)
            is_empty = self.paths[number].stat().st_size == 0
            if is_empty and number != self.numbers[-1] and name not in self.finished and number not in self.given_up:
                yield f"{name}: is empty"

    def _missing_by_indexes(self):
        """Of segments that the manifest does not list; the index of the one deleted last stays."""
        for name in sorted(path.name for path in self.folder.iterdir()):
            number = number_of(name, ".idx") or 0
            path = self.folder / f"seg-{number:06}.lcm"
            if number <= max(self.deleted, default=0) or path.name in self.finished:
                continue
            if not path.exists():
                if self.given_up.get(number) != 0:
                    yield f"{path.name}: is missing; its index is here"
            elif index := self.index(number):
                size = min(index[0], self.given_up.get(number, index[0]))
                if path.stat().st_size < size:
                    yield f"{path.name}: has {path.stat().st_size} of the {size} bytes that its index says"

    def read(self, number):
        """(bytes, events, damage) of a segment up to where it ends."""
        log = self._log(number)
        return log, *split_events(log, self.ends.get(number))

    def is_listed_as_finished(self, number):
        return self.paths[number].name in self.finished

    def _log(self, number):
        log, unreadable = read_segment(self.paths[number])
        self.unreadable[number] = unreadable
        return log

    def _find_torn(self):
        for number in reversed(self.numbers):
            if is_finished(self.paths[number], number):
                return
            log = self._log(number)
            end = torn_from(log, self._entries)
            if end < len(log):
                self.torn[number] = end, len(log) - end
                self.ends[number] = min(end, self.ends.get(number, end))
            if end > 0:
                return

    def _read_notes(self, number):
        """Yields (segment, where the note ends in it, segment deleted) of each note of a deletion.

        Where segments before it end that were given up, a segment says in the first events of it.
        """
        log = self._log(number)
        told, at_beginning = {}, True
        for channel, begin, end in split_events(log)[0]:
            note = self._entries.decode(channel, log[begin:end]) if channel == b"RB_NOTE" else None
            at_beginning = at_beginning and note is not None and note["kind"] == SEGMENT_ABANDONED
            if at_beginning and note["a"] < number:
                told[note["a"]] = note["b"]
            elif note and note["kind"] == SEGMENT_DELETED:
                yield number, end, note["a"]
        self.given_up = told | self.given_up
        for before in reversed(self.numbers[:self.numbers.index(number)] if log else []):
            if before in told:
                self.ends[before] = told[before]
            if self.paths[before].stat().st_size > 0:
                break  # of those before it, it was the one to tell

    def _read_manifest(self):
        """Sizes of the finished segments by name; what of a manifest cannot be read says nothing."""
        try:
            entries = json.loads(read_small_file(self.folder / "manifest.json"))["segments"]
        except (ValueError, KeyError, TypeError):
            return {}
        sizes = {}
        for entry in entries if isinstance(entries, list) else ():
            name, size = (entry.get("file"), entry.get("bytes")) if isinstance(entry, dict) else (None, None)
            if isinstance(name, str) and type(size) is int and 0 <= size <= LONGEST_SEGMENT:
                sizes.setdefault(name, size)
        return sizes
