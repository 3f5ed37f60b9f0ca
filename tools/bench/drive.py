"""Drives that are recorded, and played again into recorder and analyser."""

import contextlib
import functools
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

from row import BIN, ROOT
from taken import ONE_CORE, OTHER_CORES, QUIET, Taken, measured, only_on, running, taken

sys.path.insert(0, str(ROOT / "common/test"))
from bus_url import bus_url  # noqa: E402


def demo(seconds, car, *more):
    told = subprocess.run(
        [BIN / "rb", "demo", "--headless", "--json", "--seed", "1", "--drive-seconds", str(seconds), "--rate", "max",
         "--vehicle", ROOT / car, *more], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
    if told.returncode not in (0, 1):  # 1: no wheel was identified, on a short drive
        raise RuntimeError(f"rb demo ends with {told.returncode}")
    return json.loads(told.stdout)


def vehicle(nodes, rate_hz, channels=12):
    """The car with three nodes, with more in the cabin or fewer; cabins of so many channels, from the first on."""
    text = (ROOT / "sim/demo/vehicle-3-nodes.toml").read_text().replace("\nrate_hz = 2000", f"\nrate_hz = {rate_hz}")
    front, rear, cabin = (part.rstrip() + "\n\n" for part in text.split("[[node]]\n")[1:])
    named, *each = cabin.split("[[node.channel]]\n")
    cabin = "[[node.channel]]\n".join([named, *each[:channels]])
    cabins = [cabin.replace('name = "', f'name = "n{number}_').replace("id = 3", f"id = {number}")
              for number in range(3, nodes + 1)]
    return text.split("[[node]]\n")[0] + "".join("[[node]]\n" + node for node in [front, rear, *cabins])


def cpu_so_far_s(running):
    """Of all threads of a program that has not ended."""
    threads = pathlib.Path(f"/proc/{running.pid}/task").glob("*/schedstat")
    return 1e-9 * sum(int(thread.read_text().split()[0]) for thread in threads)


def calls_between(log, from_s, to_s):
    """System calls that a file of `strace -f -ttt` has begun in that time: number of the thread, time, call."""
    count = 0
    with open(log, errors="replace") as lines:
        for line in lines:
            parts = line.split(None, 2)
            if len(parts) == 3 and not parts[2].startswith(("<...", "---", "+++")):
                count += from_s <= float(parts[1]) < to_s
    return count


class Drive:
    """A recorded drive of nodes of 16 channels: accelerations, and references of two wheels; brief: each is run once."""

    def __init__(self, folder, rate_hz, seconds, nodes=4, channels=12, brief=False):
        folder.mkdir()
        self.folder, self.seconds, self.rate_hz, self.brief = folder, seconds, rate_hz, brief
        self.nodes = ["front", "rear", *(f"n{number}_cabin" for number in range(3, nodes + 1))]
        self.vehicle, self.record = folder / "vehicle.toml", folder / "drive"
        self.vehicle.write_text(vehicle(nodes, rate_hz, channels))
        demo(seconds, self.vehicle, "--record", self.record)
        # A node that looked for its own part in that of all would read what no device ever gives it.
        for name in self.nodes:
            measured(BIN / "rb", "select", self.record, "-o", folder / name, "--nodes", name)

    def node(self, name, rate, *under):
        return running(*under, BIN / "rb-node", "--url", bus_url(), "--vehicle", self.vehicle, "--node", name, "--front-end",
                       f"replay:{self.folder / name}?rate={rate}")

    def recorder(self, into, *nodes, under=()):
        return running(*under, BIN / "rb-recorder", "--url", bus_url(), "--record", into, "--nodes", *nodes,
                       "--end-with-nodes")

    def analyser(self, record, under=()):
        return running(*under, BIN / "rb-analyser", "--url", bus_url(), "--record", record, "--exit-at-end")

    def numbers(self):
        return [str(number + 1) for number in range(len(self.nodes))]

    def chain(self, after=lambda record: None, watched=False, rate="max"):
        """What every program takes: the nodes play the drive from their devices on, so that what the simulated car
        takes is not in it, as fast as they go or at a rate, all on one core; the wall's time is that from the start
        of the nodes to the end of all. `after` is called with what was recorded, complete. If it is watched, the
        analyser makes the cross spectra of all pairs of each node for somebody, who has another core."""
        with tempfile.TemporaryDirectory(dir=self.folder) as again, contextlib.ExitStack() as programs:
            with only_on(OTHER_CORES):
                viewer = watched and programs.enter_context(running(
                    BIN / "bench-viewer", "--url", bus_url(), "--nodes", *self.numbers(), stdout=subprocess.PIPE))
            with only_on(ONE_CORE):
                analyser = programs.enter_context(self.analyser(again))
                recorder = programs.enter_context(self.recorder(again, *self.numbers()))
                time.sleep(0.5)
                begin = time.monotonic()
                nodes = [programs.enter_context(self.node(name, rate)) for name in self.nodes]
            took = {"rb-node": functools.reduce(Taken.plus, map(taken, nodes)), "rb-recorder": taken(recorder),
                    "rb-analyser": taken(analyser)}
            took = {name: each._replace(wall_s=time.monotonic() - begin) for name, each in took.items()}
            if watched:
                viewer.terminate()
                self.require_views(json.loads(viewer.stdout.read()))
            if subprocess.run([BIN / "rb", "verify", again], **QUIET, check=False).returncode != 0:
                raise RuntimeError("what was recorded is not complete")
            after(pathlib.Path(again))
        return took

    def require_views(self, shown):
        """It is played faster than the views of it are asked for, which takes some of each drive's beginning."""
        most, averages = self.seconds * self.rate_hz / shown["hop"], dict(shown["averages"])
        for node in map(int, self.numbers()):
            if averages.get(node, 0) < most / 4 and not self.brief:
                raise RuntimeError(f"of node {node} {averages.get(node, 0):.0f} averages were shown, of {most:.0f}")

    def one_node(self):
        """CPU seconds a second of the node with two encoders, played at the speed of the drive, once it runs: from its
        fifth second to its last but one."""
        with tempfile.TemporaryDirectory(dir=self.folder) as again, self.recorder(again, "1") as recorder:
            time.sleep(0.5)
            with self.node("front", "1") as node:
                time.sleep(5.0)
                begin, before_s = time.monotonic(), cpu_so_far_s(node)
                time.sleep(self.seconds - 7.0)
                share = (cpu_so_far_s(node) - before_s) / (time.monotonic() - begin)
                taken(node)
                taken(recorder)
        return share

    def durable(self):
        """How long blocks of all nodes, played at the speed of the drive, wait until they are on the disk."""
        with tempfile.TemporaryDirectory(dir=self.folder) as again, contextlib.ExitStack() as programs:
            listener = programs.enter_context(running(BIN / "bench-durable", "--url", bus_url(), stdout=subprocess.PIPE))
            recorder = programs.enter_context(self.recorder(again, *self.numbers()))
            time.sleep(0.5)
            for node in [programs.enter_context(self.node(name, "1")) for name in self.nodes]:
                taken(node)
            taken(recorder)
            time.sleep(0.5)  # what was said last is heard
            listener.terminate()
            waited = json.loads(listener.stdout.read())
        if waited["blocks"] == 0 or waited["not_durable"] > 0:
            raise RuntimeError(f"of blocks heard {waited['not_durable']} were not called durable, "
                               f"{waited['blocks']} were")
        return waited

    def system_calls_a_second(self):
        """{program: calls} where nodes play at the speed of the drive, once all run: from its third second to its last but
        one. They are counted by strace, whose own time does not matter at this speed."""
        with tempfile.TemporaryDirectory(dir=self.folder) as logs, contextlib.ExitStack() as programs:
            record = pathlib.Path(logs, "record")

            def traced(name):
                return "strace", "-f", "-q", "-ttt", "-o", pathlib.Path(logs, name)

            others = [programs.enter_context(self.analyser(record, traced("rb-analyser"))),
                      programs.enter_context(self.recorder(record, *self.numbers(), under=traced("rb-recorder")))]
            time.sleep(1.5)
            begin_s = time.time()
            nodes = [programs.enter_context(self.node(name, "1", *traced(f"rb-node {name}"))) for name in self.nodes]
            for started in nodes + others:
                taken(started)
            span = begin_s + 3.0, begin_s + self.seconds - 1.0
            calls = {}
            for log in pathlib.Path(logs).glob("rb-*"):
                program = log.name.split()[0]
                calls[program] = calls.get(program, 0) + calls_between(log, *span) / (span[1] - span[0])
        return calls

    def files(self):
        return sorted(self.record.iterdir())

    def forget(self):
        """Takes the recording out of the page cache."""
        for file in self.files():
            descriptor = os.open(file, os.O_RDONLY)
            os.fsync(descriptor)
            os.posix_fadvise(descriptor, 0, 0, os.POSIX_FADV_DONTNEED)
            os.close(descriptor)

    def megabytes(self):
        return 1e-6 * sum(file.stat().st_size for file in self.files())


def least_of(rounds, drive, **how):
    """The least times that each program took in some rounds: what else the machine does can only add to them; and
    the most memory."""
    took = [drive.chain(**how) for _ in range(rounds)]
    return {name: Taken(*(best(one[name][k] for one in took) for k, best in enumerate((min, max, min))))
            for name in took[0]}
