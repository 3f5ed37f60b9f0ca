#!/usr/bin/env python3
"""Looks for heap, exceptions and RTTI in a program of the board's processor:  check_image.py PLANTED ELF...

PLANTED is a program with a heap: the check is worth something only if it is found there.
Prints each symbol that must not be.  Exit codes: 0 none, 1 some, 77 skipped.
"""

import re
import subprocess
import sys

import run

FORBIDDEN = re.compile(
    r"^(_?(malloc|calloc|realloc|free|sbrk)(_r)?"  # heap
    r"|_Zn[wa].*|_Zd[la].*"  # operator new and delete
    r"|__cxa_(throw|allocate_exception|begin_catch|rethrow|atexit)|_Unwind_RaiseException"
    r"|_ZT[IS].*|__dynamic_cast"  # RTTI
    r"|v?f?s?n?printf|_exit|_write)$")


def forbidden(elf):
    """The symbols of the program that it must not have."""
    text = subprocess.run(["arm-none-eabi-nm", elf], capture_output=True, text=True, check=True).stdout
    return [line.split()[-1] for line in text.splitlines() if FORBIDDEN.match(line.split()[-1])]


def main(arguments):
    if len(arguments) < 3:
        print("usage: check_image.py PLANTED ELF...", file=sys.stderr)
        return 2
    for elf in arguments[1:]:
        run.skip_without_tools("board_arm_image", elf)
    planted = forbidden(arguments[1])
    if "malloc" not in planted or "_Znwj" not in planted:
        print(f"{arguments[1]}: its heap was not seen: {planted}")
        return 1
    found = [f"{elf}: {symbol}" for elf in arguments[2:] for symbol in forbidden(elf)]
    print("\n".join(found) or f"no heap, exceptions or RTTI in {', '.join(arguments[2:])}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
