"""The bytes of a segment, as far as its disk gives them back."""

import errno
import os

PAGE_BYTES = 4096  # where a sector is bad all of its page is missing


def read_segment(path):
    """(bytes, [(offset, count)] of those that cannot be read, in whose place are zeros)."""
    try:
        return path.read_bytes(), []
    except OSError as error:
        _expect_bad_sector(error)
    with path.open("rb", buffering=0) as file:
        size = os.fstat(file.fileno()).st_size
        log, unreadable = bytearray(size), []
        for offset in range(0, size, PAGE_BYTES):
            count = min(PAGE_BYTES, size - offset)
            try:
                page = os.pread(file.fileno(), count, offset)
                log[offset:offset + len(page)] = page
            except OSError as error:
                _expect_bad_sector(error)
                unreadable.append((offset, count))
    return bytes(log), unreadable


def _expect_bad_sector(error):
    if error.errno != errno.EIO:
        raise error
