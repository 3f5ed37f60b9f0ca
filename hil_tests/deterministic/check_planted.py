#!/usr/bin/env python3
"""Every planted fault must be caught:  check_planted.py RB_FAULTS_PLANTED CHECK_RECORD

Runs seeds of a scenario with the fault until the promises checked inside the program break, and from there on until
tools/check_record.py, which shares nothing with it, calls a record damaged.  Without a fault neither may find
anything.  Exit codes: 0 all caught by both, 1 not, 2 usage.
"""

import pathlib
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

SECONDS = "10"
SEEDS = 12

# Fault: the scenario that brings it out.
FAULTS = {
    "free_on_receive": "power_cut",
    "epoch_reused": "node_killed",
    "no_heartbeat": "loss_60",
    "no_deduplication": "duplicates_reordered",
    "overwrite_oldest": "ring_full",
    "ack_before_sync": "power_cut",
    "silent_ring_full": "ring_full",
    "gap_off_by_one": "ring_full",
    "no_crash_gap": "node_killed",
    "stale_recorder": "two_recorders",
    "no_folder_sync": "power_cut",
    "torn_tail_kept": "power_cut",
    "retry_failed_sync": "power_cut_failing_disk",
    "lost_declared_late": "two_recorders",
    "blocks_swapped": "loss_00",
    "block_altered": "loss_00",
    "one_too_many_lost": "two_recorders",
}


class Checks:
    def __init__(self, program, check_record, folder):
        self.program, self.check_record, self.folder = program, check_record, folder

    def run(self, scenario, seeds, first=1, fault=None, dump=None):
        """(True if a promise was broken, True if the program has nothing to complain of)."""
        command = [self.program, "--scenario", scenario, "--seeds", str(seeds), "--first", str(first),
                   "--seconds", SECONDS]
        command += ["--plant", fault] if fault else []
        command += ["--dump", str(dump)] if dump else []
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode not in (0, 1):
            raise RuntimeError(f"{' '.join(command)}: exit code {done.returncode}: {done.stderr}")
        return "promises broken" in done.stdout, done.returncode == 0

    def known(self):
        """Names of the faults that can be planted, as the program prints them."""
        done = subprocess.run([self.program, "--plant", "?"], capture_output=True, text=True, check=False)
        return done.stderr.partition("there are: ")[2].split("\n")[0].split()

    def verdicts(self, scenario, seed, fault=None):
        """Exit codes of the independent checker for the record of each recorder: 0, 3, and 1 if it is damaged."""
        dump = self.folder / f"{scenario}-{fault}-{seed}"
        self.run(scenario, 1, seed, fault, dump)
        # A recorder that had nothing to record made no recording.
        return [self.verdict(record) for record in sorted(dump.iterdir()) if any(record.glob("seg-*.lcm"))]

    def verdict(self, record):
        command = [sys.executable, self.check_record, str(record), "--truth", str(record / "truth.json")]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        # An uncaught exception has exit code 1, too.
        if done.returncode not in (0, 1, 3) or done.stderr:
            raise RuntimeError(f"{' '.join(command)}: exit code {done.returncode}: {done.stderr}")
        return done.returncode

    def catch(self, fault, scenario):
        """Why this fault is not caught as it must be; empty if it is."""
        seed = next((seed for seed in range(1, SEEDS + 1) if self.run(scenario, 1, seed, fault)[0]), None)
        if seed is None:
            return f"{fault}: not caught in {SEEDS} seeds of {scenario}"
        for again in range(seed, SEEDS + 1):
            if 1 in self.verdicts(scenario, again, fault):
                print(f"{fault}: caught in {scenario}, seed {seed}, and in the record of seed {again} by check_record.py",
                      flush=True)
                return None
        return f"{fault}: caught in {scenario}, seed {seed}, but not by check_record.py in {SEEDS} seeds"

    def is_clean(self, scenario):
        if not self.run(scenario, SEEDS)[1]:
            return f"{scenario}: something is caught without a fault"
        damaged = [seed for seed in range(1, SEEDS + 1) if 1 in self.verdicts(scenario, seed)]
        if damaged:
            return f"{scenario}: check_record.py finds something without a fault in seeds {damaged}"
        print(f"{scenario}: nothing to catch without a fault", flush=True)
        return None


def main(arguments):
    if len(arguments) != 3:
        print(__doc__.split("\n")[0], file=sys.stderr)
        return 2
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        checks = Checks(arguments[1], arguments[2], pathlib.Path(folder))
        if sorted(checks.known()) != sorted(FAULTS):
            wrong.append(f"the program plants {checks.known()}, tried are {list(FAULTS)}")
        with ThreadPoolExecutor(max_workers=2) as pool:
            clean = pool.map(checks.is_clean, sorted(set(FAULTS.values())))
            caught = pool.map(checks.catch, FAULTS.keys(), FAULTS.values())
            wrong += [found for found in (*clean, *caught) if found]
    for line in wrong:
        print(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
