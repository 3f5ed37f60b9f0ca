"""Rows of whole programs, on a drive that is recorded for them."""

import functools
import json
import os
import pathlib
import struct
import subprocess
import tempfile

import export_rows
from drive import Drive, bus_url, least_of
from row import BIN, Row
from taken import measured, running

# The goals of costs over their floors, and of system calls a block.
CHAIN_OVER_FLOOR, SATURATION_OVER_FLOOR, MOST_CALLS = 10.0, 7.0, 28.0


def name_of(drive):
    return f"chain, {len(drive.nodes)} x 16 x {drive.rate_hz / 1000:g} kHz"


def share_of_core(took, drive):
    """From the first of its samples to the end of the last program."""
    return max(each.wall_s for each in took.values()) / drive.seconds


def rounds(drive, most):
    return 1 if drive.brief else most


def over_floor(name, drive, took, bound):
    """CPU time of all programs over that of what none can do without: the same datagrams by bare UDP, the same bytes by
    `dd`, the transforms of all pairs by FFTW; taken one right behind the other."""
    hops = len(drive.nodes) * 16 * drive.rate_hz * drive.seconds / 2048
    load = [drive.folder / "floor", *map(str, map(int, (blocks_of(drive), 1e6 * drive.megabytes(), hops)))]
    floors = [json.loads(subprocess.run([BIN / "bench-floor", *load], stdout=subprocess.PIPE, check=True).stdout)
              for _ in range(5)]
    ours, floor = sum(each.cpu_s for each in took.values()), sum(min(one[part] for one in floors) for part in floors[0])
    yield Row(f"{name}, of its floor", 1e3 * ours / drive.seconds, "ms/s", "bare UDP, dd, FFTW of the same",
              1e3 * floor / drive.seconds, ours / floor, "<=", bound)


def chain(drive):
    name = name_of(drive)
    took, watched = least_of(rounds(drive, 3), drive), least_of(rounds(drive, 3), drive, watched=True)
    for part, each in took.items():
        share = each.cpu_s / drive.seconds
        yield Row(f"{name}: {part}", 1e3 * share, "ms/s", "of a core's second", 1e3, 1 / share)
    for what, how in ((name, took), (f"{name}, all pairs shown", watched)):
        share = share_of_core(how, drive)
        yield Row(what, 1e3 * share, "ms/s", "of a core's second", 1e3, 1 / share, ">=", 40.0)
    yield from over_floor(name, drive, watched, CHAIN_OVER_FLOOR)


@functools.cache
def share_of_core_at_best(drive):
    return share_of_core(least_of(rounds(drive, 5), drive), drive)


def fast(drive):
    share = share_of_core_at_best(drive)
    yield Row(name_of(drive), 1e3 * share, "ms/s", "of a core's second", 1e3, 1 / share)


def saturation(drive):
    """How much of the work of 4 x 2 kHz a core does where samples, not wake-ups and datagrams, are the load."""
    share = share_of_core_at_best(drive)
    yield Row("saturation, 4 x 16 x 10 kHz", 1e3 * share, "ms/s", "times the work of 4 x 2 kHz",
              drive.rate_hz / 2000, drive.rate_hz / 2000 / share, ">=", 100.0)
    watched = least_of(rounds(drive, 3), drive, watched=True)
    yield from over_floor("saturation", drive, watched, SATURATION_OVER_FLOOR)


def blocks_in(log):
    """Blocks of nodes in a file of LCM: sync word, number and time of the event, length of channel and of data."""
    count = 0
    with open(log, "rb") as file:
        while len(head := file.read(28)) == 28:
            sync, _, _, channel, data = struct.unpack(">IqqII", head)
            if sync != 0xEDA1DA01:
                raise RuntimeError(f"{log} is no log of LCM at byte {file.tell() - 28}")
            count += file.read(channel).startswith(b"RB_BLOCK_")
            file.seek(data, os.SEEK_CUR)
    return count


def blocks_of(drive):
    return sum(blocks_in(segment) for segment in drive.record.glob("seg-*.lcm"))


def loss(drive):
    """The logger hears the same nodes, played as fast as the recorder, which they wait for, takes them."""
    log = drive.folder / "stock.lcm"
    recorded = []
    with running("lcm-logger", "-q", "-f", f"--lcm-url={bus_url()}", log) as logger:
        drive.chain(lambda record: recorded.extend(map(blocks_in, record.glob("seg-*.lcm"))))
        if logger.poll() is not None:
            raise RuntimeError(f"lcm-logger has ended with {logger.returncode}")
    sent = blocks_of(drive)
    heard = blocks_in(log)
    log.unlink()
    if heard == 0:
        raise RuntimeError("lcm-logger has heard nothing")
    yield Row("blocks recorded, of all sent", 100.0 * sum(recorded) / sent, "%", "lcm-logger beside it, repeats too",
              100.0 * heard / sent, sum(recorded) / heard)


def live_node(drive):
    share = drive.one_node()
    yield Row("rb-node, 16 x 2 kHz, live", 1e2 * share, "% of a core", "asked", 2.0, share / 0.02, "<=", 1.0)


def system_calls(drive):
    """Counted, not timed, of all programs a block that nodes send."""
    trial = subprocess.run(["strace", "-o", os.devnull, "true"], stderr=subprocess.PIPE, text=True, check=False)
    if trial.returncode != 0:
        raise RuntimeError(f"strace may not trace here: {trial.stderr.strip()}")
    blocks_a_second = blocks_of(drive) / drive.seconds
    calls = {name: each / blocks_a_second for name, each in drive.system_calls_a_second().items()}
    for name, each in sorted(calls.items()):
        yield Row(f"system calls a block: {name}", each, "calls", "a block", 1.0, each)
    every = sum(calls.values())
    yield Row("system calls a block", every, "calls", "asked", MOST_CALLS, every / MOST_CALLS, "<=", 1.0, steady=True)


def durable(drive):
    waited = drive.durable()
    for what, of, bound in (("median", "median_ms", None), ("99 of 100", "p99_ms", 1.0), ("longest", "most_ms", None)):
        yield Row(f"sealed to durable, {what}", waited[of], "ms", "asked of 99 of 100", 300.0, waited[of] / 300.0,
                  "<=" if bound else None, bound)


def verify(drive):
    """Of five turns each the best."""
    logs = [file for file in drive.files() if file.suffix == ".lcm"]
    megabytes = drive.megabytes()
    for where, bound in (("disk", 0.5), ("memory", None)):
        best = {"ours": 1e9, "cat": 1e9}
        for _ in range(rounds(drive, 5)):
            for who, command in (("cat", ["cat", *logs]), ("ours", [BIN / "rb", "verify", drive.record])):
                if where == "disk":
                    drive.forget()
                best[who] = min(best[who], measured(*command).wall_s)
        yield Row(f"verify, from {where}", megabytes / best["ours"], "MB/s", "cat of the same files",
                  megabytes / best["cat"], best["cat"] / best["ours"], ">=" if bound else None, bound)


def exports(drive):
    """CPU time, and what `cp` of the file that was written or read takes of it."""
    with tempfile.TemporaryDirectory(dir=drive.folder) as folder:
        copies = pathlib.Path(folder, "copies")
        copies.mkdir()
        for what, size_mb, took, files in export_rows.rows(drive.record, folder):
            if what == "verify":  # has rows of its own
                continue
            speed = size_mb / took.cpu_s
            copied = size_mb / measured("cp", "--reflink=never", *files, copies).cpu_s
            name = what if what.startswith("import ") else f"export {what}"
            yield Row(name, speed, "MB/s", "cp of the same", copied, speed / copied)
            if what in export_rows.ASKED_MB_S:
                asked = export_rows.ASKED_MB_S[what]
                yield Row(name, speed, "MB/s", "asked", asked, speed / asked, ">=", 1.0)


def rows(wanted, brief=False):
    """Rows of whole programs on a recorded drive."""
    with tempfile.TemporaryDirectory(dir=BIN.parent) as folder:
        for number, (nodes, rate_hz, seconds, brief_seconds, parts) in enumerate((
                (4, 2000, 120.0, 30.0, {"chain, 4 x 16 x 2 kHz": chain, "blocks recorded": loss, "verify": verify,
                                        "exports": exports}),
                (4, 10000, 60.0, 8.0, {"chain, 4 x 16 x 10 kHz": fast, "saturation, 4 x 16 x 10 kHz": saturation}),
                (8, 10000, 30.0, 4.0, {"chain, 8 x 16 x 10 kHz": fast}),
                (4, 2000, 20.0, 9.0, {"rb-node, 16 x 2 kHz, live": live_node, "sealed to durable": durable,
                                      "system calls a block": system_calls}))):
            parts = [part for name, part in parts.items() if wanted(name)]
            if not parts:
                continue
            drive = Drive(pathlib.Path(folder, str(number)), rate_hz, brief_seconds if brief else seconds, nodes, brief=brief)
            for part in parts:
                yield from part(drive)
