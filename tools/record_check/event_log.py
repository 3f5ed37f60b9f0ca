"""Events of an LCM event log: sync word, number, microseconds, two lengths (all big endian), channel, data.

Source: LCM 1.3.1, lcm/eventlog.c.  An event counts if its lengths are in bounds, its channel is printable, and
behind it lies the next sync word or the end, or if its data ends with its own CRC-32C.
"""

import struct

from record_check.crc32c import crc

SYNC = bytes.fromhex("EDA1DA01")
HEADER = struct.Struct(">IqqII")
MOST_CHANNEL_BYTES = 63
MOST_DATA_BYTES = 1 << 16


def ends_with_its_crc(data):
    return len(data) >= 4 and crc(data[:-4]) == int.from_bytes(data[-4:], "big")


def _event_at(log, at, end):
    """(channel, begin and end of the data) of the event that counts here, or None."""
    if end - at < HEADER.size:
        return None
    sync, _, _, name_size, data_size = HEADER.unpack_from(log, at)
    if sync != 0xEDA1DA01 or not 1 <= name_size <= MOST_CHANNEL_BYTES or data_size > MOST_DATA_BYTES:
        return None
    begin = at + HEADER.size + name_size
    behind = begin + data_size
    if behind > end:
        return None
    name = log[at + HEADER.size:begin]
    if not all(0x20 < character < 0x7F for character in name):
        return None
    follows = log[behind:min(behind + 4, end)]
    if follows != SYNC[:len(follows)] and not ends_with_its_crc(log[begin:behind]):
        return None
    return name, begin, behind


def split_events(log, end=None):
    """Events [(channel, begin, end of data)] of the bytes before `end`, and what is no event [(offset, bytes)]."""
    end = len(log) if end is None else min(end, len(log))
    events, damage = [], []
    at = accounted = 0
    while 0 <= at < end:
        event = _event_at(log, at, end)
        if event is None:
            at = log.find(SYNC, at + 1, end)
            continue
        if at > accounted:
            damage.append((accounted, at - accounted))
        events.append(event)
        at = accounted = event[2]
    if accounted < end:
        damage.append((accounted, end - accounted))
    return events, damage
