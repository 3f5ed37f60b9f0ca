"""rb export and rb import that are stopped or have no room leave nothing; memory."""

import os
import resource
import shutil
import signal
import subprocess
import sys
import unittest

from recorded import RB, Exports, run

# Memory may differ by so much.  The thread sanitizer keeps four bytes of its own beside each.
FLAT_kB = 4_000 * (5 if os.environ["RB_SANITIZE"] == "thread" else 1)


class Stop(Exports):
    def test_ctrl_c_leaves_nothing_under_the_name_or_beside_it(self):
        drive = self.drive()
        for form in ("csv", "hdf5", "mat", "mcap", "mdf4", "uff58", "wav"):
            target = self.root / f"stopped.{form}"
            process = subprocess.Popen([RB, "export", "--format", form, drive, "-o", target], stderr=subprocess.PIPE)
            part = target.with_name(target.name + ".part")
            while process.poll() is None and not part.exists():
                pass
            process.send_signal(signal.SIGINT)
            said = process.communicate()[1].decode()
            if process.returncode == 4:  # it may have been done before it was told
                self.assertIn("stopped", said)
                self.assertFalse(target.exists())
            else:
                self.assertIn(process.returncode, (0, 3), said)
            self.assertFalse(part.exists())

    def test_a_disk_without_room_is_an_error_that_names_the_file(self):
        limit = lambda: (signal.signal(signal.SIGXFSZ, signal.SIG_IGN),
                         resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000)))
        for form in ("csv", "hdf5", "mat", "mcap", "mdf4", "uff58", "wav"):
            target = self.root / f"full.{form}"
            done = subprocess.run([RB, "export", "--format", form, self.made, "-o", target], capture_output=True,
                                  text=True, preexec_fn=limit)
            self.assertEqual(done.returncode, 4, f"{form}: {done.stderr}")
            self.assertIn(str(target), done.stderr)
            self.assertFalse(target.exists())
            self.assertFalse(target.with_name(target.name + ".part").exists())

    def test_memory_does_not_grow_with_the_recording(self):
        """Rows are gone through, never held: the counts of the longer one alone would take 9.6 MB."""
        long = self.longer(60)
        for form in ("csv", "hdf5", "mat", "mcap", "mdf4", "uff58", "wav"):
            peaks = []
            for folder in (self.made, long):
                target = self.root / f"memory-{folder.name}.{form}"
                peaks.append(self.peak_kB(3, "export", "--format", form, folder, "-o", target))  # 3: the holes of `made`
                target.unlink()
            self.assertLess(peaks[1] - peaks[0], FLAT_kB, form)

    def test_an_import_takes_no_more_memory_for_more_rows(self):
        """Rows are gone through, never held: the cells of the longer one alone would take 19 MB."""
        vehicle, long = self.root / "made.toml", self.longer(60)
        dbc = self.root / "memory.dbc"
        for form in ("csv", "hdf5", "uff58", "wav", "candump"):
            more = ("--dbc", dbc) if form == "candump" else ()
            peaks = []
            for folder in (self.made, long):
                dbc.unlink(missing_ok=True)
                file, back = self.root / f"{folder.name}.{form}.in", self.root / f"{folder.name}-{form}"
                self.assertEqual(run(RB, "export", "--format", form, folder, "-o", file, *more).returncode, 3)
                peaks.append(self.peak_kB(3, "import", form, "--samples", file, "--vehicle", vehicle, "-o", back, *more))
                file.unlink()
            self.assertLess(peaks[1] - peaks[0], FLAT_kB, form)

    def test_ctrl_c_leaves_nothing_of_an_import(self):
        long, target = self.longer(60), self.root / "stopped"
        part = target.with_name("stopped.part")
        file = self.root / "long.in"
        self.assertEqual(run(RB, "export", "--format", "csv", long, "-o", file).returncode, 3)
        stopped = 0
        for seconds in (0.0, 0.2, 0.4, 0.8):
            process = subprocess.Popen([RB, "import", "csv", "--samples", file, "--vehicle", self.root / "made.toml", "-o", target],
                                       stderr=subprocess.PIPE)
            while seconds > 0.4 and process.poll() is None and not part.exists():
                pass
            try:
                process.wait(seconds)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)
            said = process.communicate()[1].decode()
            if process.returncode == 4:
                self.assertIn("stopped; nothing is left", said)
                stopped += 1
            if target.exists():
                shutil.rmtree(target)
            elif process.returncode != -signal.SIGINT:  # told before it listened
                self.assertEqual(process.returncode, 4, said)
            self.assertFalse(part.exists())
        self.assertGreater(stopped, 0)

    def longer(self, times):
        """`made` again and again without a hole between, as one CSV."""
        if (self.root / "long").exists():
            return self.root / "long"
        lines = (self.root / "made.csv").read_text().splitlines()
        seconds = self.ROWS / self.RATE_HZ
        text = lines[:2] + [f"{float(line.split(',', 1)[0]) + k * seconds:.9f},{line.split(',', 1)[1]}"
                            for k in range(times) for line in lines[2:]]
        (self.root / "long.csv").write_text("\n".join(text) + "\n")
        return self.import_of("long", self.root / "long.csv", self.root / "made.toml")

    def peak_kB(self, code, *arguments):
        """Measured by a small process: what a child takes before it becomes another program counts, too."""
        measure = ("import resource, subprocess, sys; code = subprocess.run(sys.argv[1:], stderr=subprocess.DEVNULL).returncode; "
                   "print(code, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
        ended, peak_kB = run(sys.executable, "-c", measure, RB, *arguments).stdout.split()
        self.assertEqual(int(ended), code)
        return int(peak_kB)


if __name__ == "__main__":
    unittest.main()
