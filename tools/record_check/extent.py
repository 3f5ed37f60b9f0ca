"""How far a segment can be believed that was being written when its writer was killed or the power went.

Each commit event says how much of its segment was on the disk by then.  What is not as it was written before that is
damage; the first such thing behind it is where the segment was torn, and nothing from there on counts.
"""

import re

from record_check.crc32c import crc
from record_check.event_log import HEADER, ends_with_its_crc, split_events
from record_check.small_file import read_small_file

EPOCH = re.compile(rb"^epoch (\d+) (-?\d+) contiguous (\d+) next_scan (\d+) ended (\d) [^\n]* sum ([0-9a-f]{8}|none)$", re.MULTILINE)
INDEX = re.compile(rb"^roadbalance index 2\nsegment (\d+) bytes (\d+)\n(?:epoch [^\n]*\n)*crc32c ([0-9a-f]{8})\n$")


def torn_from(log, entries):
    """Offset from which on the bytes of an unfinished segment do not count.  @param entries  EntryDecoder"""
    events, damage = split_events(log)
    durable = end = 0
    bad = [offset for offset, _ in damage]
    for name, begin, behind in events:
        offset, data, end = begin - len(name) - HEADER.size, log[begin:behind], behind
        if not name.startswith(b"RB_"):
            continue
        if not ends_with_its_crc(data):
            bad.append(offset)
        elif name == b"RB_COMMIT" and (commit := entries.decode(name, data, crc_is_good=True)):
            durable = max(durable, commit["bytes"] if commit["bytes"] <= offset else 0)
    return min([end] + [offset for offset in bad if offset >= durable])


def read_index(segment, number):
    """(bytes of the segment, {(node, epoch): (last sequence, next scan, sum, over)} at its end) by its index, or None.

    sum: of the blocks so far (epochs.py), None if one is not the node's own; over: by an end or a crash.
    """
    text = read_small_file(segment.with_suffix(".idx"))
    found = INDEX.match(text)
    if not found or int(found[1]) != number or int(found[3], 16) != crc(text[:text.rindex(b"crc32c ")]):
        return None
    positions = {(int(node), int(epoch)): (int(contiguous), int(next_scan), None if blocks == b"none" else int(blocks, 16),
                                                 ended != b"0")
                 for node, epoch, contiguous, next_scan, ended, blocks in EPOCH.findall(text)}
    return int(found[2]), positions


def is_finished(segment, number):
    """True if an index says so: it is written when a segment is closed."""
    index = read_index(segment, number)
    return index is not None and index[0] == segment.stat().st_size
