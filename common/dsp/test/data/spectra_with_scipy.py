"""Writes spectra_scipy.json: cross spectra, coherence and transfer functions by SciPy of the signals that
cross_spectra_test.cpp makes as well.  python3 spectra_with_scipy.py > spectra_scipy.json"""
import json

import numpy
import scipy
import scipy.signal

RATE, SAMPLES = 1000.0, 3000


def noise(seed):
    """Lehmer's generator: exact in integers, so that it is the same everywhere."""
    state, values = seed, []
    for _ in range(SAMPLES):
        state = state * 48271 % 2147483647
        values.append(state / 2147483647 - 0.5)
    return values


def signals():
    first, second, third = noise(1), noise(2), noise(3)
    out, last, before = [], 0.0, 0.0
    for u, v in zip(first, third):
        now = u + 1.2 * last - 0.7 * before
        out.append(now + 0.3 * v)
        last, before = now, last
    return numpy.array([first, out, second])


def windows(n):
    a = [1.0, 1.9383379, 1.3045202, 0.4028270, 0.0350665]  # HFT95
    k = 2.0 * numpy.pi * numpy.arange(n) / n
    return {
        "rectangular": numpy.ones(n),
        "hann": scipy.signal.get_window("hann", n),
        "flat_top": sum((-1) ** i * c * numpy.cos(i * k) for i, c in enumerate(a)),
    }


cases = []
x = signals()
for name, segment, overlap in [("hann", 128, 0.5), ("hann", 128, 0.75), ("flat_top", 125, 0.6), ("rectangular", 100, 0.0)]:
    keys = dict(fs=RATE, window=windows(segment)[name], nperseg=segment, noverlap=round(overlap * segment), detrend=False)
    case = {"window": name, "segment": segment, "overlap": overlap, "density": [], "cross": [], "coherence": []}
    for a in range(3):
        case["density"].append(list(scipy.signal.welch(x[a], **keys)[1]))
    for a, b in [(0, 1), (0, 2), (2, 1)]:
        g = scipy.signal.csd(x[a], x[b], **keys)[1]
        case["cross"].append({"a": a, "b": b, "re": list(g.real), "im": list(g.imag)})
        case["coherence"].append(list(scipy.signal.coherence(x[a], x[b], **keys)[1]))
    cases.append(case)
print(json.dumps({"source": f"spectra_with_scipy.py, SciPy {scipy.__version__}", "cases": cases}))
