"""rb import of hdf5, uff58 and wav: what rb export wrote comes back count for count; what others wrote, and what is wrong."""

import os
import struct
import unittest

import h5py
import numpy as np

from imports import Imports
from recorded import DATA, Node


class Import(Imports):
    FORMATS = ("hdf5", "uff58", "wav")

    def test_each_export_comes_back_count_for_count(self):
        for form in self.FORMATS:
            file, _ = self.export(form, self.made, f"made.{form}", "--vehicle", self.root / f"{form}.toml")
            back, done = self.import_as(form, f"made_{form}", file, self.root / f"{form}.toml")
            self.assertEqual(done.returncode, 3, done.stderr)
            for number in (1, 2):
                first, again = Node(self.made, number), Node(back, number)
                np.testing.assert_array_equal(first.there, again.there)
                there = first.there[:, :2]
                np.testing.assert_array_equal(first.counts[:, :2][there], again.counts[:, :2][there], form)
                steps = np.diff(again.time_ns[again.there[:, 0]]) / 1e9 * self.RATE_HZ
                np.testing.assert_allclose(steps, np.rint(steps), rtol=0, atol=1e-5)

    def test_somebody_elses_measurement_comes_back_count_for_count(self):
        wobble = self.wobble()
        first = Node(wobble, 1)
        for form in self.FORMATS:
            file, _ = self.export(form, wobble, f"wobble.{form}", "--vehicle", self.root / f"w{form}.toml")
            back, done = self.import_as(form, f"wobble_{form}", file, self.root / f"w{form}.toml")
            self.assertEqual(done.returncode, 0, done.stderr)
            again = Node(back, 1)
            np.testing.assert_array_equal(first.counts, again.counts, form)
            np.testing.assert_allclose(np.diff(first.time_ns), np.diff(again.time_ns), rtol=0, atol=50)

    def test_a_drive_comes_back_with_its_pulses(self):
        drive = self.drive()
        for form in self.FORMATS:
            file, _ = self.export(form, drive, f"drive.{form}", "--pulses", self.root / f"{form}.pulses",
                                  "--vehicle", self.root / f"d{form}.toml")
            back, done = self.import_as(form, f"drive_{form}", file, self.root / f"d{form}.toml", "--pulses",
                                        self.root / f"{form}.pulses")
            self.assertEqual(done.returncode, 0, done.stderr)
            for number in (1, 2):
                first, again = Node(drive, number), Node(back, number)
                np.testing.assert_array_equal(first.counts[:, :12], again.counts[:, :12], form)
                # References are computed anew from the pulses, by the same chain at the same instants.
                known = (first.there & again.there)[:, 12:]
                self.assertGreater(known[:, 0].sum(), 5000)
                np.testing.assert_array_equal(first.counts[:, 12:][known], again.counts[:, 12:][known], form)

    MARKS = ('time_s,number,text\n-0.250000000,1,"before the first"\n1.234567890,2,"bridge, ""old"" one"\n'
             '1.234567890,3,"größer"\n99.000000000,4,""\n')

    def marked(self, name, text, form="csv"):
        marks = self.root / f"{name}.marks"
        marks.write_text(text)
        return self.import_as(form, name, DATA / "wobbletracker.csv", DATA / "wobbletracker.toml", "--marks", marks)

    def test_marks_come_back(self):
        first, done = self.marked("marked", self.MARKS)
        self.assertEqual(done.returncode, 0, done.stderr)
        start_s = Node(first, 1).time_ns[0] * 1e-9  # an export's times begin there
        shifted = self.root / "shifted.marks"
        for form in ("csv", *self.FORMATS):
            file, said = self.export(form, first, f"marked.{form}", "--marks", self.root / f"{form}.marks",
                                     "--vehicle", self.root / f"m{form}.toml")
            back, done = self.import_as(form, f"marked_{form}", file, self.root / f"m{form}.toml", "--marks",
                                        self.root / f"{form}.marks")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual([m["text"] for m in said["marks"]], ["before the first", 'bridge, "old" one', "größer", ""])
            for mark, time_s in zip(said["marks"], (-0.25, 1.23456789, 1.23456789, 99.0)):
                self.assertAlmostEqual(mark["time_s"], time_s - start_s, delta=2e-9)
            again, _ = self.export(form, back, f"again.{form}", "--marks", shifted)
            self.assertEqual(shifted.read_text(), (self.root / f"{form}.marks").read_text(), form)
            shifted.unlink()

    def test_says_what_is_wrong_with_marks(self):
        for k, (row, words) in enumerate((("1.0,0,x", "number"), ("1.0,1.5,x", "number"), ("x,1,x", "time_s"),
                                          ("1.0,1", "row"), ("1e30,1,x", "too far off"), ('1.0,1,"x', "quote"), ('1.0,1,"x" y', "quote"),
                                          ("1.0,1," + "x" * 401, "401 bytes"), ("2.0,1,a\n1.0,2,b", "goes back"),
                                          ("1.0,1,a\n2.0,1,b", "stands above"))):
            folder, done = self.marked(f"marks{k}", "time_s,number,text\n" + row + "\n")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(f"marks{k}.marks:", done.stderr)
            self.assertIn(words, done.stderr)
            self.assertFalse(folder.exists())

    def test_a_universal_file_keeps_the_instant_of_its_first_sample(self):
        """Record 7 has room for 6 digits of it."""
        folder = self.import_of("wobble_late", DATA / "wobbletracker.csv", DATA / "wobbletracker.toml")
        time_s = (Node(folder, 1).time_ns - Node(folder, 1).time_ns[0]) * 1e-9
        expected = time_s[time_s >= 3.0012][0]
        self.assertGreater(abs(float(f"{expected:.5E}") - expected), 1e-7)
        file, _ = self.export("uff58", folder, "late.uff58", "--from", 3.0012, "--vehicle", self.root / "late.toml")
        back, done = self.import_as("uff58", "late", file, self.root / "late.toml")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertAlmostEqual(Node(back, 1).time_ns[0] * 1e-9, expected, delta=3e-9)

    # libsndfile by itself reads on for ever in a list of a kind it does not know, before and behind the samples.
    def test_takes_a_wav_file_whose_lists_somebody_else_added(self):
        file, _ = self.export("wav", self.made, "lists.wav", "--vehicle", self.root / "lists.toml")
        good = file.read_bytes()
        added = b"LIST" + struct.pack("<I", 24) + b"\0\0\0\xff\xf8\xff\xff\xff" + bytes(16)
        counts = []
        lists = good[12:] + added
        at = lists.index(b"data") + 4
        ds64 = b"ds64" + struct.pack("<IQQQI", 28, 0, *struct.unpack_from("<I", lists, at), 0, 0)
        rf64 = b"RF64\xff\xff\xff\xffWAVE" + ds64 + lists[:at] + b"\xff\xff\xff\xff" + lists[at + 4:]
        for name, data in (("plain", good), ("lists", good[:12] + added + lists), ("rf64", rf64)):
            file.write_bytes(data)
            back, done = self.import_as("wav", name, file, self.root / "lists.toml")
            self.assertEqual(done.returncode, 3, done.stderr)
            counts.append(Node(back, 2).counts)
        for read in counts[1:]:
            np.testing.assert_array_equal(counts[0], read)

    def test_takes_an_hdf5_file_that_h5py_wrote(self):
        time_s = np.arange(1000) / self.RATE_HZ
        value = np.where(np.arange(1000) % 100 == 7, np.nan, np.sin(time_s))
        made = self.write_hdf5("mine.h5", time_s, front_up=(value, "g"), front_side=(value.astype("f4"), "m/s^2"),
                               rear_up=(np.arange(1000, dtype="i2") - 500, "m/s2"), rear_side=(value * 0, "m/s^2"))
        back, done = self.import_as("hdf5", "mine", made, self.root / "made.toml")
        self.assertEqual(done.returncode, 2, done.stderr)  # rear_side is missing where rear_up is not
        self.assertIn("rear_side: is empty", done.stderr)
        made = self.write_hdf5("mine2.h5", time_s, front_up=(value, "g"), front_side=(value.astype("f4"), "m/s^2"),
                               rear_up=((np.arange(1000, dtype="i2") - 500) // 50, "m/s2"), rear_side=(time_s, "m/s^2"))
        back, done = self.import_as("hdf5", "mine2", made, self.root / "made.toml")
        self.assertEqual(done.returncode, 3, done.stderr)
        front, rear = Node(back, 1), Node(back, 2)
        there = ~np.isnan(value)
        np.testing.assert_array_equal(front.there[:, 0], there)
        np.testing.assert_array_equal(front.counts[there, 0], np.rint(value[there] * 9.80665 * 2**23 / 50))
        np.testing.assert_array_equal(rear.counts[:, 0], np.rint((np.arange(1000) - 500) // 50 * 2**23 / 50))

    def test_an_hdf5_file_from_which_the_library_does_not_return(self):
        time_s = np.arange(300) / self.RATE_HZ
        made = self.write_hdf5("held.h5", time_s, front_up=(time_s, "g"), front_side=(time_s, "m/s^2"),
                               rear_up=(time_s, "m/s^2"), rear_side=(time_s, "m/s^2"))
        data = bytearray(made.read_bytes())
        # The units stand in a global heap: objects of 16 bytes (index, size) and their data, up to index 0, which is
        # what is free.  HDF5 1.10 steps on by its size.
        at = data.index(b"GCOL") + 16
        while struct.unpack_from("<H", data, at)[0] != 0:
            at += 16 + (struct.unpack_from("<Q", data, at + 8)[0] + 7) // 8 * 8
        struct.pack_into("<Q", data, at + 8, 0)
        made.write_bytes(data)
        folder, done = self.import_as("hdf5", "held", made, self.root / "made.toml")
        self.assertIn(done.returncode, (2, 4), done.stderr)  # 4: a library that has it mended refuses the file
        self.assertIn("held.h5", done.stderr)
        self.assertFalse(folder.exists())

    def test_an_hdf5_file_with_damage_is_refused_and_named(self):
        time_s = np.arange(300) / self.RATE_HZ
        made = self.write_hdf5("torn.h5", time_s, front_up=(time_s, "g"), front_side=(time_s, "m/s^2"),
                               rear_up=(time_s, "m/s^2"), rear_side=(time_s, "m/s^2"))
        with h5py.File(made, "a") as file:
            file["mine"]["rear_up"].attrs["scale_factor"] = 2.0
        good = made.read_bytes()
        scale = good.index(b"scale_factor\0")
        cases = {"what a group lists": (good.replace(b"SNOD", b"XNOD"), "cannot be listed"),
                 # The library gives the same channel for both.
                 "a name": (good.replace(b"front_side\0", b"front_up\0\0\0"), "front_up: stands twice"),
                 "size of an attribute": (good[:scale - 20] + b"\xff" * 4 + good[scale - 16:], ""),  # 1.10.8: SIGSEGV
                 "type of an attribute": (good[:scale + 16] + b"\xff" * 8 + good[scale + 24:], "scale_factor")}
        for what, (data, words) in cases.items():
            with self.subTest(what):
                made.write_bytes(data)
                folder, done = self.import_as("hdf5", "torn", made, self.root / "made.toml")
                self.assertIn(done.returncode, (2, 4), done.stderr)
                self.assertIn("torn.h5", done.stderr)
                self.assertIn(words, done.stderr)
                self.assertFalse(folder.exists())

    def test_says_what_is_wrong_with_a_file(self):
        good = {form: self.export(form, self.made, f"good.{form}")[0].read_bytes() for form in self.FORMATS}
        text = good["uff58"].decode()
        lines = text.split("\n")
        record_7 = next(k for k, line in enumerate(lines) if line == "    58") + 7
        number = record_7 + 6
        altered = lambda k, line: "\n".join([*lines[:k], line, *lines[k + 1:]]).encode()
        cases = [(form, data, words) for form in self.FORMATS for data, words in (
            (b"", ""), (b"neither this nor that\n" * 10, ""), (good[form][:len(good[form]) // 2], ""))]
        cases += [
            ("uff58", altered(number, lines[number][:20] + "                 x.5" + lines[number][40:]),
             f"{number + 1}: front_up: \"x.5\" in columns 21 to 40"),
            ("uff58", altered(record_7, lines[record_7][:10] + "99999999999"[:10] + lines[record_7][20:]), "allowed"),
            ("uff58", altered(record_7, lines[record_7][:29] + "0" + lines[record_7][30:]), "uneven"),
            ("uff58", altered(record_7, "         5" + lines[record_7][10:]), "ordinate data type 5"),
            ("uff58", text.replace("\n  1.000000", "\n -1.000000", 1).encode(), "length factor"),
            ("uff58", text.replace("rear_up", "front_up").encode(), "stands twice"),
            ("wav", good["wav"].replace(b'"scale"', b'"scaly"'), "scale"),
            ("wav", good["wav"].replace(b"ICMT", b"IXXX"), "comment"),
            ("wav", b"RIFX" + good["wav"][4:], "byte 0: is no WAV file"),
            *(("wav", good["wav"][:at + 4] + b"\xff\xff\xff\xff" + good["wav"][at + 8:],
               f"byte {at}: chunk {chunk.decode()} tells 4294967295 bytes; its {whole} ends at byte ")
              for chunk, whole in ((b"LIST", "file"), (b"ISFT", "list"), (b"ICMT", "list"))
              for at in (good["wav"].index(chunk),)),
            ("hdf5", good["hdf5"][:-100], f"eof = {len(good['hdf5']) - 100}"),
            ("wav", good["wav"][:-160], f"ends at byte {len(good['wav']) - 160} after 9990 of 10000"),
        ]
        for k, (form, data, words) in enumerate(cases):
            file = self.root / f"bad{k}.{form}"
            file.write_bytes(data)
            folder, done = self.import_as(form, f"bad{k}", file, self.root / "made.toml")
            self.assertIn(done.returncode, (2, 4) if form == "hdf5" else (2,), f"{form} {data[:40]}: {done.stderr}")
            self.assertIn(f"bad{k}.{form}", done.stderr)
            self.assertIn(words, done.stderr)
            self.assertFalse(folder.exists())
        for form in self.FORMATS:
            self.assertEqual(self.import_as(form, "none", self.root / "none", self.root / "made.toml")[1].returncode, 4)
        for change, words in ((lambda g: g["rear_up"].attrs.__setitem__("units", "furlong"), "furlong"),
                              (lambda g: g.__delitem__("time_s"), "time_s"),
                              (lambda g: g["time_s"].__setitem__(5, 1e9), "time_s"),
                              (lambda g: g.create_dataset("more", data=[1, 2]), "more: 2 samples"),
                              (lambda g: g.create_dataset("square", data=np.zeros((3, 3))), "square"),
                              (lambda g: g.create_group("inner"), "inner"),
                              # No byte of these is in the file, nor in memory.
                              (lambda g: g.create_dataset("huge", (2**40,), chunks=(4096,)), "huge"),
                              (lambda g: g.create_dataset("long", (2**28,), chunks=(4096,)), "long: 268435456 samples"),
                              (lambda g: g.create_dataset("never", (self.ROWS,), chunks=(4096,)), "never: 10000 numbers, but none")):
            file = self.root / "altered.h5"
            file.write_bytes(good["hdf5"])
            with h5py.File(file, "r+") as data:
                change(data["all"])
            _, done = self.import_as("hdf5", "altered", file, self.root / "made.toml")
            self.assertIn(done.returncode, (2, 4), done.stderr)
            self.assertIn(words, done.stderr)

    def test_says_at_which_byte_an_hdf5_file_is_damaged(self):
        good = self.export("hdf5", self.made, "sound.h5")[0].read_bytes()
        with h5py.File(self.root / "sound.h5", "r") as file:
            chunk = file["all/rear_up"].id.get_chunk_info(0)
            is_packed = file["all/rear_up"].compression is not None
        file = self.root / "holed.h5"
        if is_packed:
            file.write_bytes(good[:chunk.byte_offset] + b"\xff" * chunk.size + good[chunk.byte_offset + chunk.size:])
            _, done = self.import_as("hdf5", "holed", file, self.root / "made.toml")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(f"rear_up: row 0 cannot be read, its part of the file from byte {chunk.byte_offset} on is damaged",
                          done.stderr)
        # The description of a data set, by its signature or, in files of old, found through the library.
        with h5py.File(self.root / "sound.h5", "r") as data:
            at = h5py.h5o.get_info(data["all/rear_up"].id).addr
        file.write_bytes(good[:at] + b"\xff" * 16 + good[at + 16:])
        _, done = self.import_as("hdf5", "headless", file, self.root / "made.toml")
        self.assertIn(done.returncode, (2, 4), done.stderr)
        self.assertIn(f"rear_up, described at byte {at}", done.stderr)

    def test_refuses_what_cannot_be_read_twice(self):
        pipe = self.root / "pipe"
        os.mkfifo(pipe)
        for form in ("csv", *self.FORMATS):
            _, done = self.import_as(form, "piped", pipe, self.root / "made.toml")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("pipe: is no file", done.stderr)


if __name__ == "__main__":
    unittest.main()
