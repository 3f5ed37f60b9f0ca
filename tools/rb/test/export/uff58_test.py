"""rb export --format uff58, read back by a parser written from the description of universal files (SDRC, type 58)."""

import unittest

import numpy as np

from recorded import Exports, Node


class Wrong(Exception):
    pass


def need(condition, what):
    if not condition:
        raise Wrong(what)


def data_sets(path):
    """(type, lines) of each: between lines of -1 in columns 1 to 6."""
    lines = path.read_text("ascii").split("\n")
    need(lines.pop() == "", "the last line does not end")
    need(all(len(line) <= 80 for line in lines), "more than 80 columns")
    at = 0
    while at < len(lines):
        need(lines[at] == "    -1", f"line {at + 1}: no data set begins")
        end = lines.index("    -1", at + 1)
        yield int(lines[at + 1]), lines[at + 2:end]
        at = end + 1


def fields(line, *widths):
    at = 0
    for width in widths:
        yield line[at:at + width]
        at += width
    need(line[at:].strip() == "", f"more in: {line}")


class Function:
    """Of type 58: name, function type, start, step, ordinate type and unit, values."""

    def __init__(self, lines):
        self.name, _, self.date, self.rate, self.remark = (line.strip() for line in lines[:5])
        kind, number, _, _, _, entity, node, direction, _, reference, _, _ = fields(
            lines[5], 5, 10, 5, 10, 1, 10, 10, 4, 1, 10, 10, 4)
        self.kind, self.number, self.node = int(kind), int(number), entity.strip()
        need(reference.strip() == "NONE" and int(node) == self.number, lines[5])
        self.direction = int(direction)
        form, count, spacing, start, step, z = fields(lines[6], 10, 10, 10, 13, 13, 13)
        need((int(form), int(spacing), float(z)) == (4, 1, 0), lines[6])
        self.start, self.step = float(start), float(step)
        axes = [self.axis(line) for line in lines[7:11]]
        need(axes[0] == (17, 0, "Time", "s") and axes[2][0] == axes[3][0] == 0, "axes")
        self.ordinate = axes[1]
        count = int(count)
        need(len(lines) == 11 + (count + 3) // 4, f"{len(lines) - 11} lines of numbers for {count}")
        text = [line[i:i + 20] for line in lines[11:] for i in range(0, len(line), 20)]
        need(len(text) == count and all(len(number) == 20 for number in text), "numbers of 20 columns")
        self.values = np.array([float(number) for number in text])

    @staticmethod
    def axis(line):
        kind, length, force, temperature, _, label, _, unit = fields(line, 10, 5, 5, 5, 1, 20, 1, 20)
        need(int(force) == int(temperature) == 0, line)
        return int(kind), int(length), label.strip(), unit.strip()


def read(path):
    sets = list(data_sets(path))
    need([kind for kind, _ in sets[:2]] == [151, 164], "header and units first")
    units = sets[1][1]
    need(int(units[0][:10]) == 1 and int(units[0][30:40]) == 2 and len(units) == 3, "units are SI")
    need(all(kind == 58 for kind, _ in sets[2:]), "then functions")
    return [Function(lines) for _, lines in sets[2:]]


class Uff58(Exports):
    def test_has_a_time_response_for_each_channel(self):
        path, _ = self.export("uff58", self.made, "made.uff", code=[3])
        functions = read(path)
        self.assertEqual([f.name for f in functions], list(self.CHANNELS))
        for c, function in enumerate(functions):
            self.assertEqual((function.kind, function.start, function.step), (1, 0.0, 0.002))
            self.assertEqual(function.ordinate, (12, 1, "Acceleration", "m/s^2"))
            there = self.there[:, c]
            np.testing.assert_array_equal(np.isnan(function.values), ~there)
            np.testing.assert_allclose(function.values[there], self.values[there, c], rtol=1e-12, atol=0)
            np.testing.assert_array_equal(np.rint(function.values[there] / self.SCALE[c] + self.OFFSET[c]),
                                          self.counts[there, c])
        self.assertEqual([f.direction for f in functions], [3, 2, 3, 2])
        self.assertEqual([f.node for f in functions], ["front", "front", "rear", "rear"])

    def test_a_length_that_is_no_multiple_of_four_and_a_drive(self):
        path, _ = self.export("uff58", self.drive(), "drive.uff", "--from", 1, "--to", 1.0515, "--channels", "rear")
        functions = {f.name: f for f in read(path)}
        node = Node(self.root / "drive", 2)
        sine = functions["rear_left_angle_sin"]
        self.assertEqual((len(sine.values), sine.start, sine.ordinate[0]), (103, 1.0, 0))
        there = node.there[2000:2103, 12]
        np.testing.assert_array_equal(np.rint(sine.values[there] * 2**23), node.counts[2000:2103, 12][there])

    def test_the_rate_is_told_in_full(self):
        path, said = self.export("uff58", self.wobble(), "wobble.uff")
        function = read(path)[0]
        self.assertAlmostEqual(float(function.rate.split()[1]) / said["groups"][0]["rate_hz"], 1, delta=1e-14)
        node = Node(self.root / "wobble", 1)
        scale = said["groups"][0]["channels"][0]["scale"]
        np.testing.assert_array_equal(np.rint(function.values / scale), node.counts[:, 0])


if __name__ == "__main__":
    unittest.main()
