"""rb export that is stopped or has no room leaves nothing; memory."""

import resource
import signal
import subprocess
import sys
import unittest

from recorded import RB, Exports, run


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
            short_kB, long_kB = (self.peak_kB(form, folder) for folder in (self.made, long))
            self.assertLess(long_kB - short_kB, 4_000, form)

    def longer(self, times):
        """`made` again and again without a hole between, as one CSV."""
        lines = (self.root / "made.csv").read_text().splitlines()
        seconds = self.ROWS / self.RATE_HZ
        text = lines[:2] + [f"{float(line.split(',', 1)[0]) + k * seconds:.9f},{line.split(',', 1)[1]}"
                            for k in range(times) for line in lines[2:]]
        (self.root / "long.csv").write_text("\n".join(text) + "\n")
        return self.import_of("long", self.root / "long.csv", self.root / "made.toml")

    def peak_kB(self, form, folder):
        """Measured by a small process: what a child takes before it becomes another program counts, too."""
        target = self.root / f"memory-{folder.name}.{form}"
        measure = ("import resource, subprocess, sys; code = subprocess.run(sys.argv[1:], stderr=subprocess.DEVNULL).returncode; "
                   "print(code, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
        code, peak_kB = run(sys.executable, "-c", measure, RB, "export", "--format", form, folder, "-o", target).stdout.split()
        self.assertEqual(code, "3")  # whole, with the holes of `made`
        target.unlink()
        return int(peak_kB)


if __name__ == "__main__":
    unittest.main()
