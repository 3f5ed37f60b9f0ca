#!/usr/bin/env python3
"""Prints flash, RAM and instructions of the board's firmware, and holds them to its budget:  figures.py ELF

Exit codes: 0 within the budget, 1 not, 77 skipped.
"""

import re
import subprocess
import sys

import run

FLASH_BYTES = 32 * 1024
RAM_BYTES = 256 * 1024
STACK_BYTES = 4 * 1024
CLOCK_HZ = 400e6
RATE_HZ = 10e3
# A Cortex-M7 issues up to two instructions a cycle.  From tightly coupled memory, most take one cycle at most, a
# wrongly predicted branch about 7, a division 2 to 16: two for each is an upper bound of such a mixture.
CYCLES_PER_INSTRUCTION = 2
SHARE = 0.5


def sections(elf):
    """Sizes of the program's sections in bytes."""
    text = subprocess.run(["arm-none-eabi-size", "-A", elf], capture_output=True, text=True, check=True).stdout
    return {name: int(size) for name, size in re.findall(r"^(\.[\w.]+)\s+(\d+)", text, re.MULTILINE)}


def main(arguments):
    if len(arguments) != 2:
        print("usage: figures.py ELF", file=sys.stderr)
        return 2
    elf = arguments[1]
    run.skip_without_tools("board_arm_figures", elf)
    code, output = run.run(elf, count=True)
    if code != 0:
        print(output, f"exit code {code}", sep="")
        return 1
    figure = {name: int(value) for name, value in re.findall(r"^(\w+) (\d+)$", output, re.MULTILINE)}
    size = sections(elf)
    flash, ram, stack = size[".board"], size[".board_ram"], figure["stack_bytes"]
    cycles = figure["scan_worst"] * CYCLES_PER_INSTRUCTION
    share = cycles * RATE_HZ / CLOCK_HZ
    print(f"flash: {flash} bytes of the board's own code and tables (allowed {FLASH_BYTES}); "
          f"whole image with this measurement, start-up and libraries {sum(size[s] for s in ('.vectors', '.board', '.text'))}")
    print(f"RAM: {ram} bytes, of them {figure['board_object_bytes']} the board's object and the rest its transfer buffer "
          f"(allowed {RAM_BYTES}); no heap")
    print(f"stack: {stack} bytes, the deepest call chain of this run (allowed {STACK_BYTES}); an interrupt adds at most "
          f"as much again and its frame of 104")
    print("instructions executed (QEMU -icount, to 5 each), 10 kHz, two 1000-pulse quadrature encoders at 20 turns/s, "
          "references at 20 kHz:")
    print(f"  interrupts of one scan period: {figure['interrupts_mean']} in the mean, {figure['interrupts_worst']} at worst")
    print(f"  packet with CRC-32C: {figure['packet_per_scan_worst']} per scan at worst, {figure['packet_worst']} the longest; "
          f"a look without packet {figure['idle_worst']}")
    print(f"  per scan at worst: {figure['scan_worst']} instructions = at most {cycles} cycles "
          f"at {CYCLES_PER_INSTRUCTION} cycles per instruction")
    print(f"share of {CLOCK_HZ / 1e6:.0f} MHz at {RATE_HZ / 1e3:.0f} kHz: at most {100 * share:.1f} % "
          f"(allowed {100 * SHARE:.0f} %)")
    within = flash <= FLASH_BYTES and ram <= RAM_BYTES and stack <= STACK_BYTES and share <= SHARE
    return 0 if within else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv))
