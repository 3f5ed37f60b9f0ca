"""What the tests of the checker share: records to damage by hand, and messages to put in."""

import json
import math
import os
import pathlib
import struct
import subprocess
import sys

TOOLS = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path[:0] = [str(TOOLS), str(TOOLS.parent / "common" / "test")]

from record_check.crc32c import crc  # noqa: E402
from record_check.event_log import HEADER, split_events  # noqa: E402
from record_check.headers import is_of_a_node  # noqa: E402
from record_check.wire_types import read_wire_types  # noqa: E402

RB = pathlib.Path(os.environ["RB_BIN"], "rb")
TYPES = {kind.name: kind for kind in read_wire_types(TOOLS.parent / "common" / "wire").values()}
COMPLETE, DAMAGED, INCOMPLETE, UNREADABLE = 0, 1, 3, 4
SEGMENT = "seg-000001.lcm"


def run(*command):
    return subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)


def check(folder, *options):
    """Exit code and report of the checker."""
    done = run(sys.executable, TOOLS / "check_record.py", folder, "--json", *options)
    return done.returncode, json.loads(done.stdout) if done.stdout else {"error": done.stderr}


def event(channel, data, number=0):
    return HEADER.pack(0xEDA1DA01, number, 0, len(channel), len(data)) + channel + data


def message(name, **fields):
    """A message of this type with a good CRC; fields not given are 0."""
    kind = TYPES[name]
    values = [kind.fingerprint - (1 << 64) if kind.fingerprint >> 63 else kind.fingerprint]
    for field, lcm_type, extents in kind.fields:
        value = fields.pop(field, None)
        if lcm_type == "byte":
            values.append(value or b"")
        elif extents:
            values.extend(value or [0] * math.prod(extents))
        else:
            values.append(value or 0)
    assert not fields, fields
    return with_crc(kind.format.pack(*values))


def with_crc(data):
    return data[:-4] + struct.pack(">I", crc(data[:-4]))


def altered(data, name, field, value, code=">q"):
    """The message with another value in a field, and a good CRC."""
    at = TYPES[name].offset(field)
    return with_crc(data[:at] + struct.pack(code, value) + data[at + struct.calcsize(code):])


def segment(events, covers_contents=True):
    """The bytes of a segment of these events; each commit among them says what is true of the events before it.

    @param covers_contents  false: of headers alone, as in format 3
    """
    log, begin, covered = bytearray(), 0, b""
    for number, (channel, data) in enumerate(events):
        is_commit = channel == b"RB_COMMIT"
        if is_commit:
            data = altered(data, "commit_t", "headers_from", begin)
            data = altered(data, "commit_t", "headers_crc32c", crc(covered), ">I")
            begin, covered = len(log), b""
        made = event(channel, data, number)
        covered += made[:HEADER.size + len(channel)] if is_of_a_node(channel) or not covers_contents else made
        log += made
    return bytes(log)


class Record:
    """The events of a record's only segment, to be changed and written back."""

    def __init__(self, folder):
        self.folder = folder
        log = (folder / SEGMENT).read_bytes()
        events, _ = split_events(log)
        self.events = [(channel, log[begin:end]) for channel, begin, end in events]

    def without_journal(self):
        """The same of a recorder that kept none: what contradicts the blocks in it is not there to be found."""
        self.events = [each for each in self.events if each[0] != b"RB_JOURNAL"]
        return self

    def with_true_sums(self):
        """The same of nodes that sealed the blocks as they are now: their ends say so."""
        crcs = {}
        for at, (channel, data) in enumerate(self.events):
            if not channel.startswith(b"RB_BLOCK_") or struct.unpack_from(">q", data, 20)[0] == 0:
                continue
            key = struct.unpack_from(">iq", data, 8)
            if channel.endswith(b"_END"):
                self.events[at] = channel, altered(data, "end_t", "blocks_crc32c", crc(crcs.get(key, b"")), ">I")
            crcs[key] = crcs.get(key, b"") + data[-4:]
        return self

    def places(self, kind, node=1):
        """Indices of this node's blocks of a kind; those of the preamble left out."""
        return [at for at, (channel, data) in enumerate(self.events)
                if channel == f"RB_BLOCK_{node}_{kind}".encode() and struct.unpack_from(">q", data, 20)[0] > 0]

    def write(self):
        (self.folder / SEGMENT).write_bytes(segment(self.events))
        for name in ("manifest.json", "seg-000001.idx"):  # which knew the bytes before
            (self.folder / name).unlink(missing_ok=True)


def record_a_drive(folder, *options, seconds=12):
    """The demonstration's two nodes, recorded by the programs; what identification makes of it is not asked."""
    run(RB, "demo", "--headless", "--json", "--rate", "max", "--seed", 3, "--drive-seconds", seconds, "--record", folder,
        *options)
    assert (folder / SEGMENT).exists(), "rb demo has recorded nothing"
