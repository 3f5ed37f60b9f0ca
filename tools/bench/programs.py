"""Whole programs that tools/bench/run measures."""

import json
import os
import pathlib
import subprocess
import tempfile
import time

from row import BIN, ROOT, Row


def demo(seconds, vehicle, *more):
    told = subprocess.run(
        [BIN / "rb", "demo", "--headless", "--json", "--seed", "1", "--drive-seconds", str(seconds), "--rate", "max",
         "--vehicle", ROOT / vehicle, *more], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
    if told.returncode not in (0, 1):  # 1: no wheel was identified, on a short drive
        raise RuntimeError(f"rb demo ends with {told.returncode}")
    return json.loads(told.stdout)


def four_nodes():
    """The car with three nodes, and a second one in the cabin."""
    text = (ROOT / "sim/demo/vehicle-3-nodes.toml").read_text()
    begin = text.index('[[node]]\nname = "cabin"')
    end = text.find("\n[[wheel]]", begin)
    cabin = text[begin:end if end > 0 else len(text)].rstrip() + "\n\n"
    boot = cabin.replace('"cabin"', '"boot"').replace("id = 3", "id = 4").replace('name = "', 'name = "boot_')
    return text[:begin] + cabin + boot.replace('"boot_boot"', '"boot"') + text[begin + len(cabin):].lstrip("\n")


QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
NODES = ("front", "rear", "cabin", "boot")


def cpu_s(started):
    """User and system time of a program, once it has ended."""
    _, status, used = os.wait4(started.pid, 0)
    started.returncode = os.waitstatus_to_exitcode(status)
    if started.returncode not in (0, 3):
        raise RuntimeError(f"{pathlib.Path(started.args[0]).name} ends with {started.returncode}")
    return used.ru_utime + used.ru_stime


def cpu_so_far_s(running):
    """Of all threads of a program that has not ended."""
    threads = pathlib.Path(f"/proc/{running.pid}/task").glob("*/schedstat")
    return 1e-9 * sum(int(thread.read_text().split()[0]) for thread in threads)


class Drive:
    """A recorded drive of four nodes of 16 channels."""

    def __init__(self, folder, rate_hz, seconds):
        folder.mkdir()
        self.folder, self.seconds, self.rate_hz = folder, seconds, rate_hz
        self.vehicle, self.record = folder / "vehicle.toml", folder / "drive"
        self.vehicle.write_text(four_nodes().replace("\nrate_hz = 2000", f"\nrate_hz = {rate_hz}"))
        demo(seconds, self.vehicle, "--record", self.record)

    def url(self):
        return f"udpm://239.255.76.67:{12_000 + os.getpid() % 20000}?ttl=0&recv_buf_size=4194304"

    def node(self, name, rate):
        return subprocess.Popen([BIN / "rb-node", "--url", self.url(), "--vehicle", self.vehicle, "--node", name,
                                 "--front-end", f"replay:{self.record}?rate={rate}"], **QUIET)

    def recorder(self, into, *nodes):
        return subprocess.Popen([BIN / "rb-recorder", "--url", self.url(), "--record", into, "--nodes", *nodes,
                                 "--end-with-nodes"], **QUIET)

    def chain(self):
        """CPU seconds a second of driving of every program: the nodes play the drive from their devices on, so that
        what the simulated car takes is not in it, as fast as they go."""
        with tempfile.TemporaryDirectory(dir=self.folder) as again:
            analyser = subprocess.Popen([BIN / "rb-analyser", "--url", self.url(), "--record", again, "--exit-at-end"],
                                        **QUIET)
            recorder = self.recorder(again, "1", "2", "3", "4")
            time.sleep(0.5)
            nodes = [self.node(name, "max") for name in NODES]
            took = {"rb-node x 4": sum(cpu_s(node) for node in nodes), "rb-recorder": cpu_s(recorder),
                    "rb-analyser": cpu_s(analyser)}
            verified = subprocess.run([BIN / "rb", "verify", again], **QUIET, check=False)
            if verified.returncode != 0:
                raise RuntimeError("what was recorded is not complete")
        return {name: used / self.seconds for name, used in took.items()}

    def one_node(self):
        """CPU seconds a second of the node with two encoders, played at the speed of the drive, once it runs: from its
        fifth second to its last but one."""
        with tempfile.TemporaryDirectory(dir=self.folder) as again:
            recorder = self.recorder(again, "1")
            time.sleep(0.5)
            node = self.node("front", "1")
            time.sleep(5.0)
            begin, used = time.monotonic(), cpu_so_far_s(node)
            time.sleep(self.seconds - 7.0)
            share = (cpu_so_far_s(node) - used) / (time.monotonic() - begin)
            cpu_s(node)
            cpu_s(recorder)
        return share

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


def wall_s(command):
    begin = time.monotonic()
    subprocess.run(command, **QUIET, check=True)
    return time.monotonic() - begin


def least_of(rounds, drive):
    """The least that each program took in some rounds: what else the machine does can only add to it."""
    took = [drive.chain() for _ in range(rounds)]
    return {name: min(one[name] for one in took) for name in took[0]}


def chain(drive):
    name = "chain, 4 x 16 x 2 kHz"
    took = least_of(3, drive)
    for part, share in took.items():
        yield Row(f"{name}: {part}", 1e3 * share, "ms/s", "of a core's second", 1e3, 1 / share)
    everything = sum(took.values())
    yield Row(name, 1e3 * everything, "ms/s", "of a core's second", 1e3, 1 / everything, ">=", 40.0)


def saturation(drive):
    """How much of the work of 4 x 2 kHz a core does where samples, not wake-ups and datagrams, are the load."""
    everything = sum(least_of(2, drive).values())
    yield Row("saturation, 4 x 16 x 10 kHz", 1e3 * everything, "ms/s", "times the work of 4 x 2 kHz",
              drive.rate_hz / 2000, drive.rate_hz / 2000 / everything, ">=", 100.0)


def live_node(drive):
    share = drive.one_node()
    yield Row("rb-node, 16 x 2 kHz, live", 1e2 * share, "% of a core", "asked", 2.0, share / 0.02, "<=", 1.0)


def verify(drive):
    """Of five turns each the best."""
    logs = [file for file in drive.files() if file.suffix == ".lcm"]
    megabytes = drive.megabytes()
    for where, bound in (("disk", 0.5), ("memory", None)):
        best = {"ours": 1e9, "cat": 1e9}
        for _ in range(5):
            for who, command in (("cat", ["cat", *logs]), ("ours", [BIN / "rb", "verify", drive.record])):
                if where == "disk":
                    drive.forget()
                best[who] = min(best[who], wall_s(command))
        yield Row(f"verify, from {where}", megabytes / best["ours"], "MB/s", "cat of the same files",
                  megabytes / best["cat"], best["cat"] / best["ours"], ">=" if bound else None, bound)


def rows(wanted):
    """Rows of whole programs on a recorded drive."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for rate_hz, seconds, parts in ((2000, 120.0, {"chain, 4 x 16 x 2 kHz": chain, "verify": verify}),
                                        (10000, 30.0, {"saturation, 4 x 16 x 10 kHz": saturation}),
                                        (2000, 20.0, {"rb-node, 16 x 2 kHz, live": live_node})):
            parts = [part for name, part in parts.items() if wanted(name)]
            if not parts:
                continue
            drive = Drive(folder / f"{rate_hz}-{seconds:.0f}", rate_hz, seconds)
            for part in parts:
                yield from part(drive)
