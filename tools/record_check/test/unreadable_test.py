"""A segment with a sector that cannot be read: the rest of it is checked, and the record is damaged."""

import errno
import os
import pathlib
import tempfile
import unittest
from unittest import mock

from records import DAMAGED, SEGMENT, TOOLS, event, message, segment

from record_check.record import Checker
from record_check.wire_types import read_wire_types

PAGE, NOTES = 4096, 100


class Unreadable(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="rb-unreadable-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        note = message("note_t", kind=17)
        self.note_bytes = len(event(b"RB_NOTE", note))
        durable = message("commit_t", bytes=NOTES * self.note_bytes)  # so that nothing before it is torn
        (self.folder / SEGMENT).write_bytes(segment([(b"RB_NOTE", note)] * NOTES + [(b"RB_COMMIT", durable)]))

    def check(self, bad_page, error=errno.EIO):
        """What the checker finds on a disk of which this page of the segment gives an error."""
        pread = os.pread

        def read_page(file, count, offset):
            if offset == bad_page * PAGE:
                raise OSError(error, os.strerror(error))
            return pread(file, count, offset)

        with mock.patch("pathlib.Path.read_bytes", side_effect=OSError(error, os.strerror(error))), \
                mock.patch("os.pread", read_page):
            checker = Checker(self.folder, read_wire_types(TOOLS.parent / "common" / "wire"))
            checker.check()
        return checker

    def test_a_bad_sector_is_listed_with_its_reason_and_the_rest_is_read(self):
        checker = self.check(1)
        self.assertEqual(checker.verdict(), DAMAGED)
        self.assertIn(f"{SEGMENT}: {PAGE} bytes from {PAGE} on cannot be read: Input/output error", checker.damage)
        self.assertGreaterEqual(checker.damaged_bytes, PAGE)
        touched = 2 * PAGE // self.note_bytes - PAGE // self.note_bytes + 1  # from the first to the last with a byte in it
        self.assertGreaterEqual(checker.notes, NOTES - touched)
        self.assertLess(checker.notes, NOTES)

    def test_another_error_is_no_bad_sector(self):
        with self.assertRaises(PermissionError):
            self.check(1, errno.EACCES)


if __name__ == "__main__":
    unittest.main()
