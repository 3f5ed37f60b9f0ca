"""rb export that is stopped or has no room leaves nothing; memory."""

import os
import resource
import signal
import subprocess
import unittest

from recorded import RB, Exports


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

    def test_takes_little_memory(self):
        for form in ("csv", "hdf5", "mat", "mcap", "mdf4", "uff58", "wav"):
            target = self.root / f"memory.{form}"
            process = subprocess.Popen([RB, "export", "--format", form, self.made, "-o", target],
                                       stderr=subprocess.DEVNULL)
            _, _, usage = os.wait4(process.pid, 0)
            process.returncode = 0
            self.assertLess(usage.ru_maxrss, 200_000, form)  # kB


if __name__ == "__main__":
    unittest.main()
