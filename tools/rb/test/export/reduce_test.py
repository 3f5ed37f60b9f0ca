"""rb reduce against SciPy: the filter designed and applied by it to the samples of an independent reader."""

import json
import shutil
import unittest

import numpy as np
from scipy import signal

from recorded import Exports, Node, rb
from select_test import gaps, notes

HALF = 34  # new samples that the filter reaches to each side


def taps(factor):
    return signal.firwin(2 * HALF * factor + 1, 0.45 / factor, window=("kaiser", 10.1), fs=1.0)


def reduced(counts, factor):
    """Every factor-th of a run of rows [row, channel], as far as the filter has all it reaches."""
    whole = np.apply_along_axis(lambda column: np.convolve(column, taps(factor), "valid"), 0, counts.astype(float))
    return np.rint(whole[::factor])


class Reduce(Exports):
    @classmethod
    def make(cls):
        super().make()
        toml = (cls.root / "made.toml").read_text() + "[filter]\ncutoff_hz = 40\n"
        (cls.root / "made.toml").write_text(toml)
        shutil.rmtree(cls.made)
        done = rb("import", "csv", "--samples", cls.root / "made.csv", "--vehicle", cls.root / "made.toml", "-o", cls.made)
        assert done.returncode == 3, done.stderr

    def reduce(self, source, *options, code=0):
        folder = self.root / "fewer"
        shutil.rmtree(folder, ignore_errors=True)
        done = rb("reduce", source, "-o", folder, "--json", *options)
        self.assertEqual(done.returncode, code, done.stderr)
        return folder, json.loads(done.stdout) if done.stdout else done.stderr

    def test_counts_are_those_of_the_filter_and_gaps_are_never_filtered_across(self):
        folder, _ = self.reduce(self.made, "--factor", 5, code=3)
        self.assertEqual(rb("verify", folder).returncode, 3)
        for number, channels in ((1, slice(0, 2)), (2, slice(2, 4))):
            part = Node(folder, number)
            there = self.there[:, channels][:, 0]
            expected = np.zeros((self.ROWS // 5, 2))
            known = np.zeros(self.ROWS // 5, bool)
            runs = np.flatnonzero(np.diff(np.concatenate(([0], there.astype(int), [0]))))
            for begin, end in zip(runs[::2], runs[1::2]):
                # Kept are the rows that are multiples of 5 and have HALF * 5 rows on each side in their run.
                first = -(-(begin + HALF * 5) // 5) * 5
                last = (end - 1 - HALF * 5) // 5 * 5
                if last < first:
                    continue
                rows = reduced(self.counts[first - HALF * 5:last + HALF * 5 + 1, channels], 5)
                expected[first // 5:last // 5 + 1] = rows
                known[first // 5:last // 5 + 1] = True
            begin = np.flatnonzero(known)[0]
            end = np.flatnonzero(known)[-1] + 1
            self.assertEqual(len(part.there), end - begin)
            np.testing.assert_array_equal(part.there[:, 0], known[begin:end])
            # Halves may round either way: sums come in another order.
            kept = part.there[:, 0]
            np.testing.assert_allclose(part.counts[kept, :2], expected[begin:end][kept], rtol=0, atol=1)
            self.assertGreater(np.mean(part.counts[kept, :2] == expected[begin:end][kept]), 0.999)
            np.testing.assert_array_equal(part.time_ns[kept], Node(self.made, number).time_ns[::5][begin:end][kept])
        self.assertEqual({cause for _, _, cause in gaps(folder, 2)}, {6})
        self.assertIn("every 5th sample of made", " ".join(note[3] for note in notes(folder)))

    def test_what_the_new_rate_carries_passes_and_what_would_fold_does_not(self):
        """Sines of known amplitude, near all of full scale, at frequencies on both sides of what is promised."""
        rate_hz, factor, rows = 500, 4, 20_000
        time_s = np.arange(rows) / rate_hz
        new_hz = rate_hz / factor
        for hz, passes in ((1.0, True), (0.25 * new_hz, True), (0.4 * new_hz, True), (0.5 * new_hz, False),
                           (0.75 * new_hz, False), (1.0 * new_hz, False), (1.9 * new_hz, False)):
            lines = ["time_s," + ",".join(self.CHANNELS), "s,m/s^2,m/s^2,m/s^2,m/s^2"]
            amplitude = 45.0
            values = amplitude * np.sin(2 * np.pi * hz * time_s + 0.3)
            lines += [f"{t:.9f},{v:.9f},1,{v:.9f},2" for t, v in zip(time_s, values)]
            (self.root / "sine.csv").write_text("\n".join(lines) + "\n")
            source = self.import_of(f"sine{hz}", self.root / "sine.csv", self.root / "made.toml")
            folder, _ = self.reduce(source, "--rate", new_hz)
            part = Node(folder, 1)
            found = (part.counts[:, 0] - self.OFFSET[0]) * self.SCALE[0]
            at_s = part.time_ns * 1e-9 - Node(source, 1).time_ns[0] * 1e-9
            expected = amplitude * np.sin(2 * np.pi * hz * at_s + 0.3) if passes else 0
            # 1.2e-5 of the amplitude is promised, and half a count by rounding.
            self.assertLess(np.abs(found - expected).max(), 1.2e-5 * amplitude + 0.51 * self.SCALE[0], hz)
            side = (part.counts[:, 1] - self.OFFSET[1]) * self.SCALE[1]
            np.testing.assert_allclose(side, 1.0, rtol=0, atol=1.01 * self.SCALE[1])  # gain at rest, with its offset
            shutil.rmtree(source)

    def test_the_description_tells_the_new_rate_and_a_drive_still_its_orders(self):
        drive = self.drive()
        folder, said = self.reduce(drive, "--rate", 500)
        self.assertEqual(rb("verify", folder).returncode, 0)
        told = json.loads(rb("info", folder, "--json").stdout)
        self.assertEqual({rate["rate_hz"] for rate in told["rates"]}, {500.0})
        for number in (1, 2):
            whole, part = Node(drive, number), Node(folder, number)
            shown = np.convolve(whole.counts[:, 12], taps(4), "valid")[::4]
            known = whole.there[:, 12]
            support = np.convolve(known, np.ones(len(taps(4))), "valid")[::4] == len(taps(4))
            np.testing.assert_array_equal(part.there[:, 12], support)
            np.testing.assert_allclose(part.counts[support, 12], shown[support], rtol=0, atol=1)
            # One turn is one turn: what is left of the references lies on the circle to the filter's ripple.
            length = np.hypot(*part.counts[support, 12:14].T) / 2**23
            np.testing.assert_allclose(length, np.hypot(*whole.counts[known, 12:14].T).mean() / 2**23, rtol=5e-3)
        wheels = {}
        for name, source in (("whole", drive), ("part", folder)):
            wheels[name] = json.loads(rb("levels", source, "--json").stdout)["wheels"]
        for one, other in zip(wheels["whole"], wheels["part"]):
            self.assertAlmostEqual(one["turns"] / one["seconds"], other["turns"] / other["seconds"], places=1)
        shutil.rmtree(drive)

    def test_rates_and_factors_that_cannot_be_are_refused(self):
        for options, words in ((("--rate", 300), "divided by 2, 3, 4"), (("--rate", 500), "divided by"),
                               (("--factor", 1), "--factor"), ((), "--factor or --rate"),
                               (("--factor", 2, "--rate", 250), "--rate"), (("--factor", 7), "twice the 40 Hz"), (("--factor", 800), "twice")):
            _, said = self.reduce(self.made, *options, code=2)
            self.assertIn(words, said)
        drive = self.drive()
        _, said = self.reduce(drive, "--factor", 8, code=2)
        self.assertIn("cutoff_hz", said)
        shutil.rmtree(drive)


if __name__ == "__main__":
    unittest.main()
