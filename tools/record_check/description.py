"""What a record says of itself: the program that wrote it, and the text of each message type in it.

It stands in the meta blocks of node 0 at the beginning of each segment.  Fingerprints are computed from the texts, so
that a text that is not the one of the messages shows.
"""

import json

from record_check.wire_types import WireType

RECORD_JSON = 2  # MetaKind


class Description:
    """take() the meta blocks of node 0 as they come; then program, format_version, types."""

    def __init__(self):
        self.program, self.format_version = None, 0
        self.types = {}  # by fingerprint, as read_wire_types() gives them
        self.contradictions = []
        self._parts = {}

    def take(self, meta):
        """@param meta  fields of a good meta block"""
        if meta["kind"] != RECORD_JSON or self.program is not None:
            return
        self._parts[meta["part"]] = meta["text"][:meta["size"]]
        if len(self._parts) == meta["parts"]:
            self._read(b"".join(self._parts[part] for part in sorted(self._parts)))

    def _read(self, text):
        try:
            said = json.loads(text)
            self.program, self.format_version = str(said["program"]), int(said["format_version"])
            for entry in said["types"]:
                kind = WireType(entry["name"].split(".")[-1], entry["lcm"])
                self.types[kind.fingerprint] = kind
                if (f"{kind.fingerprint:016x}", kind.size) != (entry["fingerprint"], entry["bytes"]):
                    self.contradictions.append(f'the text of {entry["name"]} is of another message')
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            self.contradictions.append(f"its description of itself cannot be read: {error!r}")

    def report(self):
        return {"program": self.program, "format_version": self.format_version,
                "types": sorted(kind.name for kind in self.types.values())}


def read_recorded_types(segments):
    """All types that the record describes, from its bytes alone.  @param segments  logs as (bytes, events)"""
    # The layout of meta_t, which no text can give before it is read: fingerprint, the header, these, text.
    at = 8 + 4 + 5 * 8
    for log, events in segments:
        description = Description()
        for channel, begin, end in events:
            if channel != b"RB_BLOCK_0_META" or end - begin < at + 16:
                continue
            kind, part, parts, size = (int.from_bytes(log[begin + at + 4 * k:begin + at + 4 * k + 4], "big") for k in range(4))
            text = log[begin + at + 16:begin + at + 16 + size]
            description.take({"kind": kind, "part": part, "parts": parts, "size": size, "text": text})
        if description.types and not description.contradictions:
            return description.types
    raise ValueError("the record does not describe its messages; name the folder of the .lcm files with --wire")
