"""What a record's nodes have measured, in the units of their vehicle.toml: read without any of the product's code.

Of a record that check_record.py calls complete; of another it says what keeps it from being one run of samples.
"""

import pathlib
import tomllib

from record_check.blocks import CHANNELS
from record_check.event_log import split_events
from record_check.wire_types import read_wire_types

VEHICLE_TOML = 1  # MetaKind
FULL_SCALE_COUNTS = 1 << 23


class Node:
    """One node of a record: rate_hz, and channel(name)."""

    def __init__(self, described, blocks, period_ps):
        self.name = described["name"]
        self.rate_hz = 1e12 / period_ps
        self._blocks = blocks
        self._channels = {channel["name"]: (number, channel) for number, channel in enumerate(described["channel"])}

    def channels(self):
        return list(self._channels)

    def channel(self, name):
        """[scan] samples in m/s^2.  @raises ValueError if it left its range: such scans are none to compute with"""
        number, described = self._channels[name]
        samples = []
        for block in self._blocks:
            if block["overload"] >> number & 1:
                raise ValueError(f"{self.name}.{name} left its range at scan {block['first_scan']}")
            samples.extend(block["counts"][number:CHANNELS * block["scans"]:CHANNELS])
        calibration = described.get("calibration", {"scale_m_s2_per_count": described["range_m_s2"] / FULL_SCALE_COUNTS})
        scale, offset = calibration["scale_m_s2_per_count"], calibration.get("offset_counts", 0)
        return [(count - offset) * scale for count in samples]


def read_nodes(folder, wire):
    """{name: Node} of the record.  @param wire  folder of the .lcm files"""
    types = {kind.name: kind for kind in read_wire_types(wire).values()}
    scans, texts = {}, {}
    for path in sorted(pathlib.Path(folder).glob("seg-*.lcm")):
        log = path.read_bytes()
        for channel, begin, end in split_events(log)[0]:
            if channel.endswith(b"_SCAN"):
                block = types["scan_block_t"].decode(log[begin:end])
                if block["sequence"] > 0:
                    scans.setdefault(block["node"], []).append(block)
            elif channel.endswith(b"_META"):
                meta = types["meta_t"].decode(log[begin:end])
                if meta["kind"] == VEHICLE_TOML:
                    texts[meta["part"]] = meta["text"][:meta["size"]]
    vehicle = tomllib.loads(b"".join(texts[part] for part in sorted(texts)).decode())
    return {node["name"]: Node(node, one_run(node["name"], scans[node["id"]]), scans[node["id"]][0]["period_ps"])
            for node in vehicle["node"]}


def one_run(name, blocks):
    """The blocks in order.  @raises ValueError if scans are missing among them"""
    blocks.sort(key=lambda block: block["first_scan"])
    for block, following in zip(blocks, blocks[1:]):
        if following["first_scan"] != block["first_scan"] + block["scans"] or following["epoch"] != block["epoch"]:
            raise ValueError(f"node {name}: scans are missing after {block['first_scan']}")
    return blocks
