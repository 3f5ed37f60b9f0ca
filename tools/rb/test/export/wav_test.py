"""rb export --format wav, read back by SciPy and sox."""

import json
import unittest
import warnings

import numpy as np
import scipy.io.wavfile

from recorded import Exports, Node, run


def comment(file):
    """The JSON in INFO ICMT, by the structure of RIFF: name, size, data, padded to even."""
    data = file.read_bytes()
    at = 12
    while at < len(data):
        name, size = data[at:at + 4], int.from_bytes(data[at + 4:at + 8], "little")
        if name == b"LIST" and data[at + 8:at + 12] == b"INFO":
            inner = at + 12
            while inner < at + 8 + size:
                length = int.from_bytes(data[inner + 4:inner + 8], "little")
                if data[inner:inner + 4] == b"ICMT":
                    return json.loads(data[inner + 8:inner + 8 + length].rstrip(b"\0"))
                inner += 8 + length + length % 2
        at += 8 + size + size % 2
    return None


class Wav(Exports):
    def test_scipy_reads_every_count_and_the_comment_tells_what_it_is(self):
        file, _ = self.export("wav", self.made, "made.wav", code=[3])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", scipy.io.wavfile.WavFileWarning)
            rate, samples = scipy.io.wavfile.read(file)
        self.assertEqual((rate, samples.shape), (self.RATE_HZ, (self.ROWS, 4)))
        np.testing.assert_array_equal(samples[self.there] // 128, self.counts[self.there])
        channels = comment(file)["groups"][0]["channels"]
        for c, channel in enumerate(channels):
            value = (samples[:, c] / 128 - channel["offset_counts"]) * channel["scale"]
            there = self.there[:, c]
            np.testing.assert_allclose(value[there], self.values[there, c], rtol=1e-14, atol=1e-14)
            self.assertTrue((samples[there, c] % 128 == 0).all())
            self.assertTrue((samples[~there, c] % 128 == 1).all())  # no sample, and all but silent
            self.assertLess(np.abs(value[~there]).max(), channel["scale"])
            self.assertEqual(channel["name"], self.CHANNELS[c])

    def test_sox_reads_every_count(self):
        file, _ = self.export("wav", self.drive(), "drive.wav", "--channels", "front")
        said = run("sox", "--info", file).stdout
        self.assertIn("Sample Rate    : 2000", said)
        raw = self.root / "drive.raw"
        done = run("sox", "-D", file, "-t", "raw", "-e", "signed", "-b", "32", "-L", raw)
        self.assertEqual(done.returncode, 0, done.stderr)
        node = Node(self.root / "drive", 1)
        channels = len(comment(file)["groups"][0]["channels"])
        samples = np.fromfile(raw, "<i4").reshape(-1, channels)
        for c in range(channels - 4):
            np.testing.assert_array_equal(samples[:, c] // 128, node.counts[:, c])
        there = node.there[:, 12]
        np.testing.assert_array_equal(samples[there, channels - 4] // 128, node.counts[there, 12])

    def test_a_rate_that_is_no_whole_number_is_in_the_comment(self):
        file, said = self.export("wav", self.wobble(), "wobble.wav")
        rate, samples = scipy.io.wavfile.read(file)
        self.assertEqual(rate, round(said["groups"][0]["rate_hz"]))
        self.assertEqual(comment(file)["groups"][0]["rate_hz"], said["groups"][0]["rate_hz"])
        np.testing.assert_array_equal(samples[:, :12] // 128, Node(self.root / "wobble", 1).counts[:, :12])


if __name__ == "__main__":
    unittest.main()
