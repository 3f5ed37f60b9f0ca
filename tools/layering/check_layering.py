#!/usr/bin/env python3
"""Forbids what ARCHITECTURE forbids: check_layering.py ROOT

Prints one line "file:line: reason" for each violation.  Exit codes: 0 none, 1 some, 2 usage.
"""

import pathlib
import re
import sys

ROOMS = ("common", "firmware", "host", "sim", "tools", "hil_tests")
MAY_INCLUDE = {
    "common": {"common"},
    "firmware": {"common", "firmware"},
    "host": {"common", "host"},
    "sim": {"common", "sim"},
}  # tools and hil_tests may include all

# What stays in one place: beginning of an include -> the only paths that may have it.
KEPT = {
    "toml++/": "common/config/toml_library.hpp",
    "toml.hpp": "common/config/toml_library.hpp",
    "common/config/toml_library.hpp": "common/config/",
    "lcm/": "common/bus/",
    "wire/": "common/bus/",
    "fftw3": "common/dsp/fft.cpp",
    "ginac/": "common/multibody/algebra.cpp",
    "cln/": "common/multibody/algebra.cpp",
    "boost/": "host/web/web_server.cpp",
    "hdf5.h": "host/exchange/hdf5_handle.hpp",
    "host/exchange/hdf5_handle.hpp": "host/exchange/hdf5_",
    "sndfile": "host/exchange/wav_",
    "zlib": "host/exchange/mcap_writer.cpp",
    "openssl/": "host/transfer/digest.cpp",
}

# The same of interfaces of the system, which tests may use to play the other side.
KEPT_IN_PRODUCT = {
    "gpiod.h": ("common/gpio/gpio_chip.cpp",),
    "libusb": ("firmware/backends/usb/usb_device.cpp",),
    "linux/can": ("firmware/backends/socketcan/can_socket.cpp", "firmware/backends/socketcan/can_link.cpp"),
}

GENERATED = ("embedded/", "derived/", "wire/")  # headers made by the build, not in any room
MOST_LINES = 300

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
FIELD = re.compile(r"^(?P<type>[\w.]+)\s+\w+\s*(?P<extents>(\[[^\]]*\]\s*)*);")
CONSTANT = re.compile(r"^const\s+\w+\s+(\w+)\s*=")
NAMESPACE = re.compile(r"^namespace\s+([\w:]+)\s*\{")
NAMESPACE_END = re.compile(r"^\}  // namespace")
DEFINITION = re.compile(r"^(?:struct|class|enum(?:\s+class|\s+struct)?|union)\s+(\w+)(?:\s+final)?\s*(?::[^:;].*)?\{")


# Measure ours against the libraries themselves.
PEERS = {("fftw3", "tools/bench/peers.cpp"), ("lcm/", "tools/bench/link.cpp")}


def check_include(path, room, quoted, name):
    """Reasons against `#include` of `name` in the file `path` (relative to the root)."""
    for begin, place in KEPT.items():
        if name.startswith(begin) and not path.startswith(place) and (begin, path) not in PEERS:
            yield f"<{name}> belongs in {place} only"
    is_test = room == "hil_tests" or "/test/" in path
    for begin, places in KEPT_IN_PRODUCT.items():
        if name.startswith(begin) and not is_test and path not in places:
            yield f"<{name}> belongs in {' and '.join(places)} only"
    target = name.split("/")[0]
    if quoted and target not in ROOMS and not name.startswith(GENERATED):
        yield f'"{name}" is not written from the root'
    if target not in ROOMS or room not in MAY_INCLUDE:
        return
    wires_or_tests = path.endswith("/main.cpp") or "/test/" in path
    if target not in MAY_INCLUDE[room] and not wires_or_tests:
        yield f"{room} must not know {target}: {name}"


def check_source(path, text):
    room = path.split("/")[0]
    lines = text.splitlines()
    if len(lines) > MOST_LINES:
        yield MOST_LINES + 1, f"{len(lines)} lines; allowed: {MOST_LINES}"
    for number, line in enumerate(lines, 1):
        if found := INCLUDE.match(line):
            for reason in check_include(path, room, found[1] == '"', found[2]):
                yield number, reason


def check_message(text):
    """Fixed extents and no strings keep encoding free of allocation and every message of one size."""
    constants = set()
    for number, line in enumerate(text.splitlines(), 1):
        line = line.split("//")[0].strip()
        if found := CONSTANT.match(line):
            constants.add(found[1])
            continue
        if not (found := FIELD.match(line)):
            continue
        if found["type"] == "string":
            yield number, "type string has no fixed size; allowed: byte name[N]"
        for extent in re.findall(r"\[([^\]]*)\]", found["extents"]):
            if not extent.strip().isdigit() and extent.strip() not in constants:
                yield number, f"extent [{extent}] is not fixed; allowed: a number"


def definitions(text):
    """(line, qualified name) of each type that a header defines at the top level of a namespace."""
    spaces = []
    for number, line in enumerate(text.splitlines(), 1):
        if found := NAMESPACE.match(line):
            spaces.append(found[1])
        elif NAMESPACE_END.match(line) and spaces:
            spaces.pop()
        elif spaces and (found := DEFINITION.match(line)):
            yield number, "::".join([*spaces, found[1]])


def check_tree(root):
    """All violations below `root` as texts.  A tree without sources is one, too."""
    violations = []
    defined = {}  # qualified name -> where it is first defined: one program may hold all headers
    sources = 0
    for room in ROOMS:
        for file in sorted((root / room).rglob("*")):
            if file.suffix not in (".cpp", ".hpp", ".lcm", ".c", ".h") or not file.is_file():
                continue
            sources += 1
            path = file.relative_to(root).as_posix()
            text = file.read_text(encoding="utf-8")
            found = check_message(text) if file.suffix == ".lcm" else check_source(path, text)
            violations += [f"{path}:{number}: {reason}" for number, reason in found]
            if file.suffix not in (".hpp", ".h"):
                continue
            for number, name in definitions(text):
                if first := defined.get(name):
                    violations.append(f"{path}:{number}: {name} is defined in {first}, too; allowed: once")
                defined.setdefault(name, f"{path}:{number}")
    if sources == 0:
        violations.append(f"{root}: no sources here")
    return violations


def main(arguments):
    if len(arguments) != 2:
        print("usage: check_layering.py ROOT", file=sys.stderr)
        return 2
    violations = check_tree(pathlib.Path(arguments[1]))
    for violation in violations:
        print(violation)
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
