"""Spectra, transfer functions and levels that rb makes of a record are SciPy's of the same samples.

The samples are read by record_check.samples, which shares no code with the product.
"""

import json
import pathlib
import shutil
import tempfile
import unittest

import numpy
import scipy.signal
import scipy.stats

from records import COMPLETE, RB, TOOLS, check, record_a_drive, run
from record_check.samples import read_nodes

# Relative, of each bin by itself.
TOLERANCE = 1e-9
PASSED_HZ = 200  # by the demonstration's anti-aliasing filter: nothing but its skirt is above
# HFT95 of Heinzel, Ruediger, Schilling, appendix D; SciPy's own flattop is another one.
FLAT_TOP = [1.0, 1.9383379, 1.3045202, 0.4028270, 0.0350665]


def window(name, size):
    if name == "flat-top":
        return scipy.signal.windows.general_cosine(size, FLAT_TOP, sym=False)
    return scipy.signal.get_window({"hann": "hann", "rectangular": "boxcar"}[name], size)


def rounding(density, size):
    """What each line of a transform may be off by, of that line: a share of the strongest one, which is as much as
    the whole of a line far below it.  Source: N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed.,
    theorem 24.2."""
    return numpy.finfo(float).eps * numpy.log2(size) * numpy.sqrt(numpy.max(density) / density)


def independent_averages(taper, hop, averages):
    """Welch (1967): the variance of an average of segments that overlap, over that of one segment."""
    squares = numpy.sum(taper**2)
    shifts = [k for k in range(1, averages) if k * hop < taper.size]
    common = [(numpy.sum(taper[k * hop:] * taper[:-k * hop]) / squares)**2 for k in shifts]
    return averages / (1 + 2 * sum((1 - k / averages) * rho for k, rho in zip(shifts, common)))


def calibrated(vehicle, name):
    """vehicle.toml in which this channel has been calibrated on a turnover."""
    before, behind = vehicle.split(f'name = "{name}"', 1)
    channel, rest = behind.split("[[node.channel]]", 1)
    return (f'{before}name = "{name}"{channel}[node.channel.calibration]\nscale_m_s2_per_count = 2.3e-5\n'
            f"offset_counts = -4321.5\n[[node.channel]]{rest}")


class Figures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="rb-figures-"))
        cls.addClassCleanup(shutil.rmtree, cls.root)
        cls.drive = cls.root / "drive"
        vehicle = (TOOLS.parent / "sim" / "demo" / "vehicle.toml").read_text(encoding="utf-8")
        (cls.root / "vehicle.toml").write_text(calibrated(vehicle, "fl_carrier_z"), encoding="utf-8")
        record_a_drive(cls.drive, "--vehicle", cls.root / "vehicle.toml", seconds=12)
        cls.nodes = read_nodes(cls.drive, TOOLS.parent / "common" / "wire")
        cls.samples = {name: numpy.array(node.channel(name)) for node in cls.nodes.values() for name in node.channels()}
        cls.node_of = {name: node for node in cls.nodes.values() for name in node.channels()}

    def said(self, command, *options):
        done = run(RB, command, self.drive, "--json", *options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def agrees(self, what, said, expected, tolerance=TOLERANCE):
        said, expected = numpy.asarray(said), numpy.asarray(expected)
        self.assertEqual(said.shape, expected.shape, what)
        self.assertTrue(numpy.all(numpy.isfinite(said)), what)
        off = numpy.abs(said - expected) / numpy.abs(expected) / tolerance
        worst = int(numpy.argmax(off))
        self.assertLess(off.flat[worst], 1, f"{what}: at {worst} {said.flat[worst]}, SciPy {expected.flat[worst]}")

    def tolerance(self, frequency, off, coherence=1):
        """1e-9, but where rounding alone is more: of an average in which unrelated lines cancel, and of lines that the
        anti-aliasing filter stops.  @param off  rounding of a product of two lines"""
        self.assertLess(numpy.max(off[frequency <= PASSED_HZ]), TOLERANCE)
        return numpy.maximum(TOLERANCE, off / numpy.sqrt(coherence))

    def test_the_record_is_whole_and_moves(self):
        self.assertEqual(check(self.drive)[0], COMPLETE)
        for name, samples in self.samples.items():
            self.assertEqual(samples.size, round(12 * self.node_of[name].rate_hz), name)
            self.assertGreater(numpy.std(samples), 0.01, name)

    def test_levels(self):
        said = {level["channel"]: level for level in self.said("levels")["channels"]}
        self.assertEqual(set(said), set(self.samples))
        for name, samples in self.samples.items():
            mean = numpy.mean(samples)
            self.agrees(f"level of {name}", [said[name][key] for key in ("mean", "rms", "peak", "seconds")],
                        [mean, scipy.stats.tstd(samples, ddof=0), numpy.max(numpy.abs(samples - mean)),
                         samples.size / self.node_of[name].rate_hz])

    def test_power_spectral_density_of_each_channel(self):
        for name, samples in self.samples.items():
            rate_hz = self.node_of[name].rate_hz
            for segment_s in (0.25, 4.0):
                said = self.said("spectrum", "--channel", name, "--segment-s", segment_s)
                size = round(segment_s * rate_hz)
                frequency, density = scipy.signal.welch(samples, rate_hz, window("hann", size), noverlap=size // 2, detrend=False)
                self.assertEqual(said["averages"], (samples.size - size) // (size - size // 2) + 1)
                self.agrees(f"frequencies of {name}", said["frequency_hz"][1:], frequency[1:])
                self.agrees(f"density of {name}, {segment_s} s", said["density"], density,
                            self.tolerance(frequency, 2 * rounding(density, size)))

    def test_transfer_function_and_coherence(self):
        for node in self.nodes.values():
            names = node.channels()
            for pair in ((names[0], names[1]), (names[3], names[0])):
                for taper in ("hann", "flat-top", "rectangular"):
                    for segment_s, overlap in ((1.0, 50), (0.5, 75), (0.25, 0)):
                        self.compare_transfer(node.rate_hz, pair, taper, segment_s, overlap)

    def compare_transfer(self, rate_hz, pair, taper, segment_s, overlap):
        what = f"{pair[1]} / {pair[0]}, {taper}, {segment_s} s, {overlap} %"
        said = self.said("response", "--input", pair[0], "--output", pair[1], "--window", taper, "--segment-s", segment_s,
                         "--overlap", overlap)
        x, y = (self.samples[name] for name in pair)
        size = round(segment_s * rate_hz)
        taken = window(taper, size)
        hop = size - size * overlap // 100
        keys = {"fs": rate_hz, "window": taken, "noverlap": size - hop, "detrend": False}
        frequency, cross = scipy.signal.csd(x, y, **keys)
        input_density, output_density = (scipy.signal.welch(signal, **keys)[1] for signal in (x, y))
        coherence = scipy.signal.coherence(x, y, **keys)[1]
        averages = (x.size - size) // hop + 1
        self.assertEqual(said["averages"], averages, what)
        n = independent_averages(taken, hop, averages)
        self.agrees(f"independent averages, {what}", said["independent_averages"], n)
        self.agrees(f"noise bandwidth, {what}", said["enbw_hz"],
                    rate_hz * numpy.sum(taken**2) / numpy.sum(taken)**2)
        lines = rounding(input_density, size) + rounding(output_density, size)
        tolerance = self.tolerance(frequency, 2 * lines, coherence)
        figure = lambda key: [bin_[key] for bin_ in said["bins"]]
        complex_figure = lambda key: [complex(*bin_[key]) for bin_ in said["bins"]]
        self.agrees(f"frequencies, {what}", figure("frequency_hz")[1:], frequency[1:])
        self.agrees(f"H1, {what}", complex_figure("h1"), cross / input_density, tolerance)
        self.agrees(f"H2, {what}", complex_figure("h2"), output_density / numpy.conj(cross), tolerance)
        self.agrees(f"Hv, {what}", complex_figure("hv"),
                    numpy.sqrt(output_density / input_density) * cross / numpy.abs(cross), tolerance)
        self.agrees(f"coherence, {what}", figure("coherence"), coherence, tolerance)
        self.agrees(f"coherence by chance, {what}", said["coherence_by_chance"], 1 - 0.05**(1 / (n - 1)))
        # 1 - coherence loses digits where it is near 1: the square of the radius is as exact as H1's.
        quantile = scipy.stats.f.ppf(0.95, 2, 2 * n - 2)
        squares = quantile / (n - 1) * (1 - coherence) * output_density / input_density
        reach = tolerance * quantile / (n - 1) * output_density / input_density
        self.assertTrue(numpy.all(numpy.abs(numpy.square(figure("radius_95")) - squares) <= reach), f"95 % radius, {what}")


if __name__ == "__main__":
    unittest.main()
