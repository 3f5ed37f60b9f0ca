"""The arithmetic of the checker against published values and against the slow way."""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent))

from record_check.crc32c import Shift, crc, crc_of_each  # noqa: E402
from record_check.truth import HashedEpoch, mix  # noqa: E402


class Arithmetic(unittest.TestCase):
    def test_crc_is_the_published_one(self):
        self.assertEqual(crc(b"123456789"), 0xE3069283)  # RFC 3720, B.4 has the 32-byte ones
        self.assertEqual(crc(bytes(32)), 0x8A9136AA)
        self.assertEqual(crc(b"\xff" * 32), 0x62A8AB43)

    def test_many_at_once_are_the_same_as_one_by_one(self):
        data = bytes((37 * k * k + k) & 0xFF for k in range(50 * 13))
        self.assertEqual(crc_of_each(data, 50, 46), [crc(data[at:at + 46]) for at in range(0, len(data), 50)])

    def test_crcs_join(self):
        self.assertEqual(Shift(7)(crc(b"left")) ^ crc(b"right.."), crc(b"leftright.."))

    def test_a_blocks_hashes_are_those_of_its_samples(self):
        node, epoch, first = 3, -77, 1 << 40
        rows = HashedEpoch(node, epoch).rows(first)
        for row in (0, 1, 19):
            for channel in (0, 5, 11):
                key = mix(mix(mix(epoch & (1 << 64) - 1) ^ 9) ^ (16 * node + channel))
                bits = mix(key + (first + row) * 0x9E3779B97F4A7C15 & (1 << 64) - 1)
                self.assertEqual(rows[12 * row + channel], (bits >> 40) - (1 << 23))


if __name__ == "__main__":
    unittest.main()
