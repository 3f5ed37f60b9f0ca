"""Numbers, stamps and channels of events: no CRC of their own covers them, so each commit event says their sum.

A commit's headers_crc32c goes over the header (28 bytes) and channel name of each event from the commit before on, that
one included, up to itself, and over the data of those that are no blocks of a node; up to format 3 over no data.  What lies behind
the last commit of a segment is not covered.
"""

from record_check.crc32c import crc
from record_check.event_log import HEADER


def is_of_a_node(channel):
    """Node 0 is the recorder itself."""
    return channel.startswith(b"RB_BLOCK_") and not channel.startswith(b"RB_BLOCK_0_")


def altered_headers(log, events, commits):
    """(from, to) of each stretch with a header, or contents other than blocks, that are not as they were written.

    @param commits  {index: fields} of the good commit events
    """
    begin, headers, covered, whole, behind = 0, [], [], True, 0
    for at, (channel, data_begin, data_end) in enumerate(events):
        offset = data_begin - len(channel) - HEADER.size
        whole = whole and offset == behind  # what is damaged between is listed as that
        behind = data_end
        if channel == b"RB_COMMIT":
            commit = commits.get(at)
            if commit and whole:
                said = commit["headers_crc32c"] & 0xFFFFFFFF
                if commit["headers_from"] != begin or said not in (crc(b"".join(covered)), crc(b"".join(headers))):
                    yield begin, offset
            begin, headers, covered, whole = offset, [], [], commit is not None
        if channel.startswith(b"RB_") and not is_of_a_node(channel):
            data = log[data_begin:data_end]
            whole = whole and data[-4:] == crc(data[:-4]).to_bytes(4, "big")  # else it is listed as that
        headers.append(log[offset:data_begin])
        covered.append(log[offset:data_begin if is_of_a_node(channel) else data_end])
