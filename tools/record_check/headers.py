"""Numbers, stamps and channels of events: no CRC of their own covers them, so each commit event says their sum.

A commit's headers_crc32c goes over the header (28 bytes) and channel name of each event from the commit before on, that
one included, up to itself.  What lies behind the last commit of a segment is not covered.
"""

from record_check.crc32c import crc
from record_check.event_log import HEADER


def altered_headers(log, events, commits):
    """(from, to) of each stretch with a header that is not as it was written.

    @param commits  {index: fields} of the good commit events
    """
    begin, covered, whole, behind = 0, [], True, 0
    for at, (channel, data_begin, data_end) in enumerate(events):
        offset = data_begin - len(channel) - HEADER.size
        whole = whole and offset == behind  # what is damaged between is listed as that
        behind = data_end
        if channel == b"RB_COMMIT":
            commit = commits.get(at)
            if commit and whole:
                said = commit["headers_from"], commit["headers_crc32c"] & 0xFFFFFFFF
                if said != (begin, crc(b"".join(covered))):
                    yield begin, offset
            begin, covered, whole = offset, [], commit is not None
        covered.append(log[offset:data_begin])
