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


def cpu_s(started):
    """User and system time of a program, once it has ended."""
    _, status, used = os.wait4(started.pid, 0)
    started.returncode = os.waitstatus_to_exitcode(status)
    if started.returncode not in (0, 3):
        raise RuntimeError(f"{pathlib.Path(started.args[0]).name} ends with {started.returncode}")
    return used.ru_utime + used.ru_stime


def chain_of_programs(folder, seconds):
    """CPU seconds a second of driving of every program of the chain, four nodes of 16 x 2 kHz: the nodes play a
    recorded drive from their devices on, so that what the simulated car takes is not in it."""
    vehicle, drive, again = folder / "vehicle.toml", folder / "drive", folder / "again"
    vehicle.write_text(four_nodes())
    demo(seconds, vehicle, "--record", drive)
    url = f"udpm://239.255.76.67:{20000 + os.getpid() % 20000}?ttl=0&recv_buf_size=4194304"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    analyser = subprocess.Popen([BIN / "rb-analyser", "--url", url, "--record", again, "--exit-at-end"], **quiet)
    recorder = subprocess.Popen([BIN / "rb-recorder", "--url", url, "--record", again, "--nodes", "1", "2", "3", "4",
                                 "--end-with-nodes"], **quiet)
    time.sleep(0.5)
    nodes = [subprocess.Popen([BIN / "rb-node", "--url", url, "--vehicle", vehicle, "--node", name, "--front-end",
                               f"replay:{drive}?rate=max"], **quiet) for name in ("front", "rear", "cabin", "boot")]
    took = {"rb-node x 4": sum(cpu_s(node) for node in nodes), "rb-recorder": cpu_s(recorder),
            "rb-analyser": cpu_s(analyser)}
    verified = subprocess.run([BIN / "rb", "verify", again], **quiet, check=False)
    if verified.returncode != 0:
        raise RuntimeError("what was recorded is not complete")
    return {name: used / seconds for name, used in took.items()}


def chain(wanted):
    """Rows of the whole chain; what is asked is so many times real time on one core."""
    name = "chain, 4 x 16 x 2 kHz"
    if not wanted(name):
        return
    with tempfile.TemporaryDirectory() as folder:
        took = chain_of_programs(pathlib.Path(folder), 120.0)
    for part, share in took.items():
        yield Row(f"{name}: {part}"[:40], 1e3 * share, "ms/s", "of a core's second", 1e3, 1 / share)
    everything = sum(took.values())
    yield Row(name, 1e3 * everything, "ms/s", "of a core's second", 1e3, 1 / everything, ">=", 40.0)
