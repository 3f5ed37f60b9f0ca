"""What a program takes of the machine."""

import contextlib
import os
import subprocess
import threading
import time
import typing

LONGEST_S = 900.0  # of any program here: one that waits for another that has died would wait for ever
CORES = os.sched_getaffinity(0)
ONE_CORE = {max(CORES)}
OTHER_CORES = CORES - ONE_CORE or ONE_CORE
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


class Taken(typing.NamedTuple):
    cpu_s: float
    memory_mb: float  # at most; the kernel tells no less than that of this interpreter, 14 MB
    wall_s: float = 0.0

    def plus(self, other):
        return Taken(*map(sum, zip(self, other)))


def taken(started):
    """By a program that was started, once it has ended; 3 is the exit code of one that has found a loss."""
    patience = threading.Timer(LONGEST_S, started.kill)
    patience.start()
    _, status, of = os.wait4(started.pid, 0)
    patience.cancel()
    started.returncode = os.waitstatus_to_exitcode(status)
    if started.returncode not in (0, 3):
        raise RuntimeError(f"{' '.join(map(str, started.args))} ends with {started.returncode}")
    return Taken(of.ru_utime + of.ru_stime, 1.024e-3 * of.ru_maxrss)


@contextlib.contextmanager
def only_on(cores):
    """What is started in it has these, all together."""
    os.sched_setaffinity(0, cores)
    try:
        yield
    finally:
        os.sched_setaffinity(0, CORES)


@contextlib.contextmanager
def running(*command, **said):
    """A program that is started, and told to end if it has not by itself, whatever happens beside it."""
    started = subprocess.Popen(command, **{**QUIET, **said})
    try:
        yield started
    finally:
        if started.poll() is None:
            started.terminate()
            started.wait()


def measured(*command):
    begin = time.monotonic()
    with running(*command) as started:
        return taken(started)._replace(wall_s=time.monotonic() - begin)
