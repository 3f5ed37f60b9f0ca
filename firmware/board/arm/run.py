#!/usr/bin/env python3
"""Runs a program of the board's processor in QEMU:  run.py [--count] ELF

--count: one instruction is 64 ns of the emulator's time (see instruction_counter.hpp).
Prints what the program says; exit code: the program's, 77 with a printed reason if QEMU is missing.
"""

import pathlib
import shutil
import subprocess
import sys

SKIPPED = 77
LONGEST_S = 100


def run(elf, count=False):
    """Exit code and output of the program."""
    command = ["qemu-system-arm", "-M", "mps2-an500", "-display", "none", "-monitor", "none", "-serial", "none",
               "-semihosting-config", "enable=on,target=native", "-kernel", str(elf)]
    if count:
        command += ["-icount", "shift=6"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_S, check=False)
    # Semihosting writes to standard error.
    return done.returncode, done.stdout + done.stderr


def skip_without_tools(name, elf):
    """Ends the program as skipped if something that only tools/setup installs is missing."""
    missing = [] if pathlib.Path(elf).exists() else ["arm-none-eabi-g++ or its C++ library (so there is no " + str(elf) + ")"]
    if not shutil.which("qemu-system-arm"):
        missing.append("qemu-system-arm")
    if missing:
        print(f"[  SKIPPED ] {name} (missing: {', '.join(missing)}; tools/setup check installs it)")
        sys.exit(SKIPPED)


def main(arguments):
    if len(arguments) not in (2, 3) or (len(arguments) == 3 and arguments[1] != "--count"):
        print("usage: run.py [--count] ELF", file=sys.stderr)
        return 2
    elf = arguments[-1]
    skip_without_tools(pathlib.Path(elf).stem, elf)
    code, output = run(elf, len(arguments) == 3)
    print(output, end="")
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv))
