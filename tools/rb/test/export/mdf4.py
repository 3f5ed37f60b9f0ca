"""A strict reader of MDF 4.10, from the published structure alone (ASAM MDF 4.1.0): refuses what it does not allow."""

import pathlib
import struct
import xml.etree.ElementTree as xml

import numpy as np

NAMESPACE = "{http://www.asam.net/mdf/v4}"
#          links and bytes of data that a block has; None: any number
BLOCKS = {"HD": (6, 32), "FH": (2, 16), "DG": (4, 8), "CG": (6, 32), "CN": (8, 72), "CC": (4, 40), "EV": (5, 32),
          "AT": (4, None), "TX": (0, None), "MD": (0, None), "DT": (0, None)}


class Wrong(Exception):
    pass


def need(condition, what):
    if not condition:
        raise Wrong(what)


class Block:
    def __init__(self, data, at, kind):
        need(at % 8 == 0 and 64 <= at <= len(data) - 24, f"{kind} at {at}: no place for a block")
        name, zero, self.length, links = struct.unpack_from("<4sIQQ", data, at)
        need(name == b"##" + kind.encode() and zero == 0, f"{kind} at {at}: is {name!r}")
        need(24 + 8 * links <= self.length <= len(data) - at, f"{kind} at {at}: length {self.length}")
        count, size = BLOCKS[kind]
        need(links == count and (size is None or self.length == 24 + 8 * links + size), f"{kind} at {at}: size")
        self.at, self.links = at, struct.unpack_from(f"<{links}Q", data, at + 24)
        self.data = memoryview(data)[at + 24 + 8 * links:at + self.length]
        self.begin, self.end = at, at + (self.length + 7) // 8 * 8


class Channel:
    pass


class Group:
    pass


class File:
    """groups: name, channels with name, unit, raw, valid, values; master first.  events: (seconds, name)."""

    def __init__(self, path):
        self.bytes = pathlib.Path(path).read_bytes()
        self.seen, self.extents = {}, {}  # kind and end of each block by its begin
        need(self.bytes[:8] == b"MDF     " and self.bytes[8:16] == b"4.10    ", "identification")
        need(len(self.bytes[16:24].strip()) > 0, "program identifier")
        need(struct.unpack_from("<4sH30sHH", self.bytes, 24) == (bytes(4), 410, bytes(30), 0, 0), "not finalised")
        head = self.block(64, "HD")
        self.start_ns, zone, summer, flags, kind = struct.unpack_from("<QhhBB", head.data)
        need((zone, summer) == (0, 0) and flags in (0, 2) and kind in (0, 10, 16), "HD: time")
        self.comment = self.xml(head.links[5], "HDcomment")
        self.history(head.links[1])
        self.attachments = self.attachment(head.links[3])
        self.events = list(self.event(head.links[4]))
        self.groups = [self.data_group(block) for block in self.chain(head.links[0], "DG")]
        need(head.links[2] == 0, "no channel hierarchy expected")
        self.whole()

    def block(self, at, kind):
        block = Block(self.bytes, at, kind)
        need(self.seen.setdefault(at, kind) == kind, f"{kind} at {at} is a {self.seen[at]} as well")
        self.extents[block.begin] = block.end
        return block

    def chain(self, at, kind):
        before = set()
        while at:
            need(at not in before, f"{kind}: a ring")
            before.add(at)
            block = self.block(at, kind)
            yield block
            at = block.links[0]

    def text(self, at, kind="TX"):
        data = bytes(self.block(at, kind).data)
        need(b"\0" in data, f"{kind} at {at}: does not end with 0")
        text, rest = data.split(b"\0", 1)
        need(not rest.strip(b"\0") and len(rest) < 8, f"{kind} at {at}: more behind its end")
        return text.decode("utf-8")

    def xml(self, at, root):
        tree = xml.fromstring(self.text(at, "MD"))
        need(tree.tag == NAMESPACE + root, f"{tree.tag} in place of {root}")
        return tree

    def history(self, at):
        entries = list(self.chain(at, "FH"))
        need(entries, "no file history")
        for entry in entries:
            comment = self.xml(entry.links[1], "FHcomment")
            for tag in ("TX", "tool_id", "tool_vendor", "tool_version"):
                need(comment.findtext(NAMESPACE + tag), f"FH: no {tag}")
            need(bytes(entry.data[13:16]) == bytes(3), "FH: reserved")

    def attachment(self, at):
        found = {}
        for block in self.chain(at, "AT"):
            flags, _, _, _, original, embedded = struct.unpack_from("<HHI16sQQ", block.data)
            need(flags == 1 and original == embedded and len(block.data) >= 40 + embedded, "AT: embedded data")
            self.text(block.links[2])
            found[self.text(block.links[1])] = bytes(block.data[40:40 + embedded])
        return found

    def event(self, at):
        for block in self.chain(at, "EV"):
            kind, sync, span, cause, flags, scopes, attached, creator, base, factor = struct.unpack_from(
                "<BBBBB3xIHHqd", block.data)
            need((kind, sync, span) == (6, 1, 0) and cause <= 4 and flags == 0 and scopes == attached == 0, "EV")
            yield base * factor, self.text(block.links[3])

    def data_group(self, block):
        need(block.data[0] == 0 and bytes(block.data[1:]) == bytes(7), "DG: sorted groups have no record id")
        channel_groups = list(self.chain(block.links[1], "CG"))
        need(len(channel_groups) == 1, "DG: not sorted")
        group = self.channel_group(channel_groups[0])
        data = self.block(block.links[2], "DT")
        size = group.record + group.invalid
        need(len(data.data) == group.cycles * size, f"DT: {len(data.data)} bytes for {group.cycles} records of {size}")
        rows = np.frombuffer(data.data, np.uint8).reshape(group.cycles, size)
        for channel in group.channels:
            self.read(channel, group, rows)
        master = [c for c in group.channels if c.type == 2]
        need(len(master) == 1 and group.channels[0] is master[0] and master[0].unit == "s", "one master, time, first")
        need((np.diff(master[0].values) > 0).all(), "the master does not rise")
        return group

    def channel_group(self, block):
        group = Group()
        number, group.cycles, flags, separator, zero, group.record, group.invalid = struct.unpack("<QQHHIII", block.data)
        need((number, flags, separator, zero) == (0, 0, 0, 0) and block.links[4] == 0, "CG")
        group.name = self.text(block.links[2])
        group.channels = [self.channel(cn, group) for cn in self.chain(block.links[1], "CN")]
        names = [channel.name for channel in group.channels]
        need(len(set(names)) == len(names), "CN: a name twice")
        used = sorted((c.byte, c.byte + c.bits // 8) for c in group.channels)
        need(all(a[1] <= b[0] for a, b in zip(used, used[1:])), "CN: overlap")
        return group

    def channel(self, block, group):
        channel = Channel()
        (channel.type, sync, channel.data_type, bit, channel.byte, channel.bits, channel.flags, channel.invalid_bit,
         _, zero, attached) = struct.unpack_from("<BBBBIIIIBBH", block.data)
        need((channel.type, sync) in ((0, 0), (2, 1)) and bit == zero == attached == 0, "CN: type")
        need(channel.data_type in (2, 4) and channel.bits in (32, 64), "CN: data type")
        need(channel.byte + channel.bits // 8 <= group.record, "CN: outside of its record")
        need(channel.flags in (0, 2) and (channel.type, channel.flags) != (2, 2), "CN: flags")
        need(channel.flags == 0 or channel.invalid_bit < 8 * group.invalid, "CN: outside of the invalidation bits")
        channel.name, channel.unit = self.text(block.links[2]), self.text(block.links[6])
        channel.comment = block.links[7] and self.xml(block.links[7], "CNcomment").findtext(NAMESPACE + "TX")
        channel.linear = (0.0, 1.0)
        if block.links[4]:
            conversion = self.block(block.links[4], "CC")
            kind, _, flags, references, numbers, _, _, first, second = struct.unpack("<BBHHHdddd", conversion.data)
            need((kind, flags, references, numbers) == (1, 0, 0, 2), "CC: linear")
            channel.linear = first, second
        return channel

    @staticmethod
    def read(channel, group, rows):
        kind = {(2, 32): "<i4", (4, 64): "<f8"}[channel.data_type, channel.bits]
        channel.raw = np.ascontiguousarray(rows[:, channel.byte:channel.byte + channel.bits // 8]).view(kind)[:, 0]
        bit = group.record + channel.invalid_bit // 8
        channel.valid = (rows[:, bit] >> channel.invalid_bit % 8 & 1) == 0 if channel.flags else np.ones(len(rows), bool)
        channel.values = np.where(channel.valid, channel.linear[0] + channel.linear[1] * channel.raw, np.nan)

    def whole(self):
        """Blocks do not overlap and leave nothing between them."""
        at = 64
        for begin in sorted(self.extents):
            need(begin == at, f"bytes {at} to {begin} belong to no block")
            at = self.extents[begin]
        need(at - 8 < len(self.bytes) <= at, "bytes behind the last block")
