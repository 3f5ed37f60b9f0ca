"""A recorder keeps its computer awake while it records: by logind as python3-dbusmock has it, on a bus of its own.

Needs $RB_BIN and $RB_SOURCE.
"""

import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import dbus
import dbusmock

sys.path.insert(0, str(pathlib.Path(os.environ["RB_SOURCE"], "common/test")))
from bus_url import bus_url  # noqa: E402

RECORDER = pathlib.Path(os.environ["RB_BIN"], "rb-recorder")
RB = pathlib.Path(os.environ["RB_BIN"], "rb")
PATIENCE_S = 60


def wait_until(is_so):
    until = time.monotonic() + PATIENCE_S
    while not is_so():
        if time.monotonic() > until:
            raise AssertionError("that did not come")
        time.sleep(0.05)


class StaysAwake(dbusmock.DBusTestCase):
    @classmethod
    def setUpClass(cls):
        cls.start_system_bus()
        cls.bus = cls.get_dbus(system_bus=True)

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.logind = None

    def tearDown(self):
        if self.logind:
            self.logind.terminate()
            self.logind.wait()

    def start_logind(self):
        self.logind, self.manager = self.spawn_server_template("logind", {}, stdout=subprocess.DEVNULL)

    def locks(self):
        manager = dbus.Interface(self.manager, "org.freedesktop.login1.Manager")
        return [tuple(str(part) for part in lock[:4]) for lock in manager.ListInhibitors()]

    def is_heard(self):
        said = subprocess.run([RB, "watch", "--url", bus_url(), "--json", "--seconds", "1.5"], stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True, check=False, timeout=PATIENCE_S).stdout
        return any(json.loads(line)["recorders"] for line in said.splitlines())

    def recorder(self, *options):
        recorder = subprocess.Popen([RECORDER, "--url", bus_url(), *options], stderr=subprocess.PIPE, text=True)
        self.addCleanup(recorder.kill)
        return recorder

    def end(self, recorder):
        recorder.send_signal(signal.SIGTERM)
        _, said = recorder.communicate(timeout=PATIENCE_S)
        self.assertEqual(recorder.returncode, 0, said)
        return said

    def test_as_long_as_it_records(self):
        self.start_logind()
        recorder = self.recorder("--record", pathlib.Path(self.folder.name, "drive"))
        wait_until(self.locks)
        self.assertEqual(self.locks(), [("sleep:idle:handle-lid-switch", "roadbalance", "a recording is under way", "block")])
        self.assertEqual(self.end(recorder), "")
        wait_until(lambda: not self.locks())

    def test_not_while_it_only_waits_for_a_start(self):
        self.start_logind()
        recorder = self.recorder("--recordings", self.folder.name)
        wait_until(self.is_heard)
        self.assertEqual(self.locks(), [])
        self.end(recorder)

    def test_it_says_when_it_cannot(self):
        recorder = self.recorder("--record", pathlib.Path(self.folder.name, "drive"))
        said = recorder.stderr.readline()
        self.assertIn("may fall asleep while it records: logind: ", said)
        self.end(recorder)


if __name__ == "__main__":
    unittest.main()
