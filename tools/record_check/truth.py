"""Test mode: each acceleration sample is a hash of where it belongs, so that a single one lost, swapped, doubled or
altered shows without a copy.

With all arithmetic modulo 2^64 and >> without sign,

    mix(x):  x ^= x >> 30;  x *= 0xBF58476D1CE4E5B9;  x ^= x >> 27;  x *= 0x94D049BB133111EB;  x ^= x >> 31
    key    = mix(mix(mix(epoch) ^ 9) ^ (16 node + channel))      channel 0 .. 11
    sample = (mix(key + index 0x9E3779B97F4A7C15) >> 40) - 2^23  index: of the scan in its epoch, from 0

Source of mix: G. Steele, D. Lea, C. Flood, Fast splittable pseudorandom number generators, OOPSLA 2014 (SplitMix64).
A block's samples are computed together: each in a lane of 128 bits of one big integer, so that no product of two
64-bit numbers reaches the next lane.
"""

import json
import struct
from itertools import chain

from record_check.promises import broken_promises

MASK = (1 << 64) - 1
STEP = 0x9E3779B97F4A7C15
ACCELERATIONS = 12
CHANNELS = 16
ROWS = 20
LANES = ROWS * ACCELERATIONS
LANE_BITS = 128
EACH = sum(1 << (LANE_BITS * lane) for lane in range(LANES))
LOW_HALVES = EACH * MASK


def mix(x):
    x = ((x ^ x >> 30) * 0xBF58476D1CE4E5B9) & MASK
    x = ((x ^ x >> 27) * 0x94D049BB133111EB) & MASK
    return x ^ x >> 31


def _mix_lanes(lanes):
    lanes = ((lanes ^ lanes >> 30 & LOW_HALVES) * 0xBF58476D1CE4E5B9) & LOW_HALVES
    lanes = ((lanes ^ lanes >> 27 & LOW_HALVES) * 0x94D049BB133111EB) & LOW_HALVES
    return lanes ^ lanes >> 31 & LOW_HALVES


class HashedEpoch:
    """The samples that one node epoch must have."""

    def __init__(self, node, epoch):
        seed = mix(mix(epoch & MASK) ^ 9)
        keys = [mix(seed ^ 16 * node + channel) for channel in range(ACCELERATIONS)]
        # Lane: row first, then channel, as in a block.
        self._begin = sum(((keys[lane % ACCELERATIONS] + lane // ACCELERATIONS * STEP) & MASK) << (LANE_BITS * lane)
                          for lane in range(LANES))

    def rows(self, first_scan):
        """The accelerations of ROWS scans from here on, as they lie in a block without its references."""
        lanes = _mix_lanes((self._begin + EACH * (first_scan * STEP & MASK)) & LOW_HALVES)
        values = struct.unpack(f"<{2 * LANES}Q", lanes.to_bytes(16 * LANES, "little"))[::2]
        return [(value >> 40) - (1 << 23) for value in values]


def first_wrong_sample(expected, counts, scans):
    """(row, channel) of the first sample of a block that is not the expected one, or None."""
    for row in range(scans):
        here = counts[CHANNELS * row:CHANNELS * row + ACCELERATIONS]
        want = tuple(expected[ACCELERATIONS * row:ACCELERATIONS * (row + 1)])
        if here != want:
            return row, next(channel for channel in range(ACCELERATIONS) if here[channel] != want[channel])
    return None


class Truth:
    """truth.json: {"hashed": true, "epochs": [{"node", "epoch", "scans", "ended", "killed", and as promises.py says}]}."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            text = json.load(file)
        if text.get("hashed") is not True:
            raise ValueError(f'{path}: "hashed": true is missing')
        self.epochs = {}
        for entry in text["epochs"]:
            key = (int(entry["node"]), int(entry["epoch"]))
            if key in self.epochs:
                raise ValueError(f"{path}: node {key[0]} epoch {key[1]} is there twice")
            self.epochs[key] = entry
        self._hashed = {}

    def wrong_sample(self, block, counts):
        """Why the samples of this block are not the ones that belong there, or None."""
        key = (block.node, block.epoch)
        if key not in self._hashed:
            self._hashed[key] = HashedEpoch(*key)
        wrong = first_wrong_sample(self._hashed[key].rows(block.first_scan), counts, block.scans)
        if wrong is None:
            return None
        return f"block {block.sequence}: channel {wrong[1] + 1} of scan {block.first_scan + wrong[0]} is not its sample"

    def contradictions(self, epochs):
        """Where the record does not hold what was produced: (node, epoch, why).  @param epochs  Epoch by key"""
        for key in epochs.keys() - self.epochs.keys():
            yield *key, "no such epoch was produced"
        for key, true in self.epochs.items():
            epoch = epochs.get(key)
            yield from ((*key, why) for why in chain(self._against(true, epoch), broken_promises(true, epoch)))

    @staticmethod
    def _against(true, epoch):
        scans = int(true["scans"])
        if epoch is None:
            if true["ended"]:
                yield f"an epoch of {scans} scans with an end is not here"
            return
        reached = epoch.next_scan
        if reached is not None and reached > scans:
            yield f"{reached} scans are recorded or declared; {scans} were produced"
        if true["ended"] and not epoch.end and not epoch.crashed:
            yield "the node's end is not here, and no crash is declared"
        if true["ended"] and epoch.end and reached is not None and reached < scans:
            yield f"scans {reached} to {scans - 1} are missing, undeclared"
        if true["killed"] and not true["ended"] and not epoch.crashed:
            yield "the node was killed, and no crash is declared"
