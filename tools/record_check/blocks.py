"""Blocks as the nodes sealed them: which bytes are a good one, and what its header says."""

import math
import struct

KINDS = {"scan_block_t": "SCAN", "edge_block_t": "EDGE", "gap_t": "GAP", "meta_t": "META", "end_t": "END",
         "signal_block_t": "SIGNAL"}
CAUSES = {1: "ring_full", 2: "device_overrun", 4: "lost_at_node", 5: "node_crash", 6: "source_gap",
          7: "lost_in_record", 8: "device_gone", 9: "started_late", 10: "slept"}
HEADER = struct.Struct(">qiqqqqq")
HEADER_FIELDS = ["node", "epoch", "sequence", "first_scan", "scans", "time_ns"]
INDEX_LIMIT = 1 << 48
CLOCK_LIMIT_NS = 1 << 61
LAST_NODE = 9999
SCANS_PER_BLOCK = 20
CHANNELS = 16
SAMPLES_PER_BLOCK = 64
EDGE_BYTES_PER_BLOCK = 1200
TOOTH = 0
TEETH = (TOOTH, 2)  # of EdgeKind: forward and backward
SIGNALS = 256


class Block:
    """One good block.  `crc` is the one it carries."""

    __slots__ = ("kind", "node", "epoch", "sequence", "first_scan", "scans", "cause", "totals", "sum", "crc", "channel_crc")

    def covers_numbers_before(self):
        """A loss at the node stands for every block since the one before and bears the number of the last."""
        return self.cause in ("lost_at_node", "lost_in_record")

    def is_declared_by_host(self):
        """Every other block is one that its node sealed."""
        return self.covers_numbers_before() or self.cause == "node_crash"


def _good_header(kind, node, sequence, first_scan, scans, time_ns):
    lowest = 0 if kind == "META" else 1
    return (lowest <= node <= LAST_NODE and 0 <= sequence <= INDEX_LIMIT and 0 <= first_scan <= INDEX_LIMIT and
            0 <= scans <= INDEX_LIMIT - first_scan and abs(time_ns) <= CLOCK_LIMIT_NS and
            (scans == 0 or kind in ("SCAN", "GAP")))


def count_edges(begin_ns, codes):
    """How many edges the codes of an edge_block_t hold (common/types/edge_code.hpp); None if one is no good."""
    lines = [[begin_ns, 0, 0], [begin_ns, 0, 0]]  # time of the tooth before, period, teeth so far
    last_ns, count, at = begin_ns, 0, 0
    while at < len(codes):
        begin, code = at, 0
        while True:
            if at == len(codes) or at == begin + 5 or (at > begin and codes[at] == 0):
                return None
            code |= (codes[at] & 0x7F) << 7 * (at - begin)
            at += 1
            if codes[at - 1] < 0x80:
                break
        line, kind = lines[code & 1], code >> 2 & 3 if code & 2 else TOOTH
        is_tooth = kind in TEETH
        folded = code >> (4 if code & 2 else 2)
        time_ns = line[0] + (line[1] if is_tooth else 0) + (-(folded >> 1) - 1 if folded & 1 else folded >> 1)
        if time_ns < last_ns or (code & 2 and kind == TOOTH):
            return None
        if is_tooth:
            interval_ns = time_ns - line[0]
            line[1] = (0, interval_ns, line[1] + (interval_ns - line[1] >> 3))[line[2]]
            line[0], line[2] = time_ns, min(2, line[2] + 1)
        last_ns = time_ns
        count += 1
    return count


class BlockDecoder:
    """Takes what has the type of a block and a good CRC; refuses (None) what the wire format does not allow."""

    def __init__(self, types):
        self.kinds = {kind.fingerprint: (KINDS[kind.name], kind) for kind in types.values() if kind.name in KINDS}
        for _, kind in self.kinds.values():
            if [field[0] for field in kind.fields[:6]] != HEADER_FIELDS:
                raise ValueError(f"{kind.name} does not begin with the header of a block")

    def decode(self, fingerprint, data):
        name, kind = self.kinds[fingerprint]
        block = Block()
        block.kind = name
        _, block.node, block.epoch, block.sequence, block.first_scan, block.scans, time_ns = HEADER.unpack_from(data)
        block.crc = int.from_bytes(data[-4:], "big")
        block.cause = block.totals = block.sum = block.channel_crc = None
        if not _good_header(name, block.node, block.sequence, block.first_scan, block.scans, time_ns):
            return None
        return block if getattr(self, "_" + name.lower())(block, kind, data) else None

    @staticmethod
    def _scan(block, kind, data):
        period_ps, = struct.unpack_from(">q", data, HEADER.size)
        overload, quality = struct.unpack_from(">ii", data, len(data) - 12)
        return (1 <= block.scans <= SCANS_PER_BLOCK and 1 <= period_ps <= 10**12 and 0 <= overload < 1 << CHANNELS and
                0 <= quality < 1 << 16)

    @staticmethod
    def _edge(block, kind, data):
        edges, size = struct.unpack_from(">ii", data, HEADER.size)
        begin_ns, = struct.unpack_from(">q", data, HEADER.size - 8)
        return 0 <= size <= EDGE_BYTES_PER_BLOCK and edges == count_edges(begin_ns, data[HEADER.size + 8:][:size])

    @staticmethod
    def _signal(block, kind, data):
        signals = kind.decode(data)
        samples = signals["samples"]
        return (0 <= samples <= SAMPLES_PER_BLOCK and
                all(abs(time_ns) <= CLOCK_LIMIT_NS for time_ns in signals["sample_ns"][:samples]) and
                all(math.isfinite(value) for value in signals["value"][:samples]) and
                all(0 <= number < SIGNALS for number in signals["signal"][:samples]))

    @staticmethod
    def _gap(block, kind, data):
        block.cause = CAUSES.get(kind.decode(data)["cause"])
        return block.cause is not None

    @staticmethod
    def _meta(block, kind, data):
        kind_number, part, parts, size = struct.unpack_from(">iiii", data, HEADER.size)
        return kind_number in (1, 2) and 1 <= parts <= 10000 and 0 <= part < parts and 0 <= size <= 1200

    @staticmethod
    def _end(block, kind, data):
        end = kind.decode(data)
        block.sum = end["blocks_crc32c"] & 0xFFFFFFFF
        block.totals = (end["blocks"], end["scans_sealed"], end["scans_missing"])
        return all(0 <= total <= INDEX_LIMIT for total in block.totals)
