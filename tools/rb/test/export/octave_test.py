"""rb export --format mat, hdf5 and wav, read back by GNU Octave with what it has of its own: load and audioread."""

import unittest

import numpy as np

from recorded import Exports, run


class Octave(Exports):
    def column(self, script, name):
        """Runs the script, which leaves a vector x: as doubles, bit for bit."""
        raw = self.root / f"{name}.raw"
        text = f'{script}; f = fopen("{raw}", "w", "ieee-le"); fwrite(f, double(x), "double"); fclose(f);'
        done = run("octave-cli", "--no-init-file", "--no-window-system", "--eval", text)
        self.assertEqual(done.returncode, 0, done.stderr)
        return np.fromfile(raw, "<f8")

    def test_reads_every_value_of_a_mat_file(self):
        file, _ = self.export("mat", self.made, "octave.mat", code=[3])
        fields = "; ".join(f'd.("{name}")' for name in ("all_time_s", *self.CHANNELS))
        found = self.column(f'd = load("{file}"); x = [{fields}]', "mat").reshape(5, self.ROWS)
        np.testing.assert_allclose(found[0], self.time_s - self.time_s[0], rtol=0, atol=2e-9)
        for c in range(4):
            np.testing.assert_array_equal(np.isnan(found[1 + c]), ~self.there[:, c])
            np.testing.assert_allclose(found[1 + c], self.values[:, c], rtol=1e-14, atol=1e-14)

    def test_reads_every_count_of_an_hdf5_file(self):
        file, _ = self.export("hdf5", self.made, "octave.h5", code=[3])
        fields = "; ".join(f'double(d.all.("{name}")(:))' for name in ("time_s", *self.CHANNELS))
        found = self.column(f'd = load("-hdf5", "{file}"); x = [{fields}]', "hdf5").reshape(5, self.ROWS)
        np.testing.assert_allclose(found[0], self.time_s - self.time_s[0], rtol=0, atol=2e-9)
        for c in range(4):
            there = self.there[:, c]
            np.testing.assert_array_equal(found[1 + c][there], self.counts[there, c])

    def test_reads_every_count_of_a_wav_file(self):
        file, _ = self.export("wav", self.made, "octave.wav", code=[3])
        found = self.column(f'[y, rate] = audioread("{file}", "native"); x = [rate; double(y(:))]', "wav")
        self.assertEqual(found[0], self.RATE_HZ)
        counts = found[1:].reshape(4, self.ROWS).T / 128
        np.testing.assert_array_equal(counts[self.there], self.counts[self.there])


if __name__ == "__main__":
    unittest.main()
