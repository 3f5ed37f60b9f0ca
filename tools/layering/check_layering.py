#!/usr/bin/env python3
"""Holds the sources to the plan of rooms, tools/layering/rooms.txt: check_layering.py ROOT [--draw common|host]

Prints one line "file:line: reason" for each violation: an include that the plan does not allow, a circle, a folder
that is no room, an arrow that nobody uses, a library outside its place, a class in two sources.  --draw prints the
rooms as the README of that folder draws them.  Exit codes: 0 none, 1 some, 2 usage.
"""

import pathlib
import re
import sys

TOPS = ("common", "firmware", "host", "sim", "tools", "hil_tests")
ROOMS_FILE = "tools/layering/rooms.txt"
DRAWN = {"common": "common/README.md", "host": "host/README.md"}

# Includes that stay in one place: beginning of an include -> the only paths that may have it.
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
    "hdf5.h": "host/recording/formats/hdf5_handle.hpp",
    "host/recording/formats/hdf5_handle.hpp": "host/recording/formats/hdf5_",
    "sndfile": "host/recording/formats/wav_",
    "zlib": "host/recording/formats/mcap_writer.cpp",
    "openssl/": "host/recording/transfer/digest.cpp",
}

# The same of interfaces of the system, which tests may use to play the other side.
KEPT_IN_PRODUCT = {
    "gpiod.h": ("common/gpio/gpio_chip.cpp",),
    "libusb": ("firmware/backends/usb/usb_device.cpp",),
    "systemd/": ("host/recorder/power/sleep_inhibitor.cpp",),
    "linux/can": ("firmware/backends/socketcan/can_socket.cpp", "firmware/backends/socketcan/can_link.cpp"),
}

GENERATED = ("embedded/", "derived/", "wire/")  # headers made by the build
WIRE = "common/wire"  # whose messages "wire/" headers are

INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
FIELD = re.compile(r"^(?P<type>[\w.]+)\s+\w+\s*(?P<extents>(\[[^\]]*\]\s*)*);")
CONSTANT = re.compile(r"^const\s+\w+\s+(\w+)\s*=")
NAMESPACE = re.compile(r"^namespace\s+([\w:]+)\s*\{")
NAMESPACE_END = re.compile(r"^\}  // namespace")
DEFINITION = re.compile(r"^(?:struct|class|enum(?:\s+class|\s+struct)?|union)\s+(\w+)(?:\s+final)?\s*(?::[^:;].*)?\{")


# Measure ours against the libraries themselves.
PEERS = {("fftw3", "tools/bench/peers.cpp"), ("fftw3", "tools/bench/floor.cpp"), ("lcm/", "tools/bench/link.cpp")}


class Rooms:
    """rooms.txt: one line a room, `name | what it is | whom it may know`; * may know all.

    The room of a file is its folder; tests of a room may know all, and so may a main.cpp, which wires.
    """

    def __init__(self, text):
        self.what, self.knows, self.errors = {}, {}, []
        for number, line in enumerate(text.splitlines(), 1):
            if not line.strip() or line.startswith("#"):
                continue
            parts = [part.strip() for part in line.split("|")]
            if len(parts) != 3 or not all(parts[:2]):
                self.errors.append((number, "not a line `room | what it is | rooms it may know`"))
            elif parts[0] in self.what:
                self.errors.append((number, f"{parts[0]} is there twice"))
            else:
                self.what[parts[0]], self.knows[parts[0]] = parts[1], parts[2].split()
        for name, known in self.knows.items():
            self.errors += [(0, f"{name} may know {one}, which is no room") for one in known if one not in self.what and one != "*"]
        self.floors = self._floors()

    def _floors(self):
        """Height of each room above those that know nobody; a circle is an error."""
        floors = {}

        def floor(name, path):
            if name in path:
                circle = path[path.index(name):] + [name]
                self.errors.append((0, "circle of rooms: " + " > ".join(circle)))
                return 0
            if name not in floors:
                known = [one for one in self.knows.get(name, []) if one in self.what]
                floors[name] = max((1 + floor(one, path + [name]) for one in known), default=0)
            return floors[name]

        for name in self.what:
            floor(name, [])
        return floors

    def drawing(self, top):
        """The rooms below `top` as its README draws them: who knows most on top, and whom each knows."""
        below = [name for name in self.what if name == top or name.startswith(top + "/")]
        width = max(len(name) for name in below) - len(top)
        lines = []
        for name in sorted(below, key=lambda name: (-self.floors[name], name)):
            known = [one.removeprefix(top + "/") for one in self.knows[name] if one in below]
            other = len(self.knows[name]) - len(known)
            if other:
                known.append(f"(and {other} of common)")
            lines.append(f"    {name.removeprefix(top + '/'):{width}} {'─▶ ' + ' '.join(known) if known else ''}".rstrip())
        return "\n".join(lines)


def room_of(path):
    """Folder of a file without its test part, and whether that makes it a test."""
    folder = path.rsplit("/", 1)[0]
    if folder == "common/test" or path.startswith("tools/cmake/"):
        return folder, False
    if folder.startswith("common/test/"):
        return "common/test", True
    cut = re.sub(r"/test(/.*)?$", "", folder)
    return cut, cut != folder


def check_include(path, rooms, used, quoted, name):
    """Reasons against `#include` of `name` in the file `path` (relative to the root)."""
    for begin, place in KEPT.items():
        if name.startswith(begin) and not path.startswith(place) and (begin, path) not in PEERS:
            yield f"<{name}> belongs in {place} only"
    room, is_test = room_of(path)
    for begin, places in KEPT_IN_PRODUCT.items():
        if name.startswith(begin) and not is_test and not room.startswith("hil_tests") and path not in places:
            yield f"<{name}> belongs in {' and '.join(places)} only"
    target = name.split("/")[0]
    if quoted and target not in TOPS and not name.startswith(GENERATED):
        yield f'"{name}" is not written from the root'
    if target not in TOPS and target != "wire":
        return
    other, of_test = (WIRE, False) if target == "wire" else room_of(name)
    if is_test or path.endswith("/main.cpp") or other == room:
        return
    used.add((room, other))
    known = rooms.knows.get(room, [])
    if other not in known and "*" not in known:
        yield f"{room} must not know {other}: {name}"
    elif of_test and "*" not in known:
        yield f"{room} must not know tests: {name}"


# The outermost class of a definition: of a function, an operator, a member of a class in it; of a static member.
BEFORE = r"^(?=\S)(?!using |template |extern |return )(?:[\w:<>,&*\[\] ]+[ &*])"
MEMBER = re.compile(BEFORE + r"?([A-Z]\w+)(?:::[A-Z]\w+)*::(?:~?\w+|operator *[^\s(]+|operator *\(\))\(")
STATIC_MEMBER = re.compile(BEFORE + r"([A-Z]\w+)(?:::[A-Z]\w+)*::\w+ *(?:=|\{|;|\[)")
# Two ways to do one thing, of which a build has one.
ALTERNATIVES = {"common/dsp/fft_eigen.cpp"}


def check_source(path, text, rooms, used, members):
    room, is_test = room_of(path)
    is_home = path.endswith(".cpp") and not is_test and path not in ALTERNATIVES
    if room not in rooms.what and path not in UNLISTED:
        yield 1, f"{room} is no room of {ROOMS_FILE}"
    for number, line in enumerate(text.splitlines(), 1):
        if found := INCLUDE.match(line):
            for reason in check_include(path, rooms, used, found[1] == '"', found[2]):
                yield number, reason
        elif is_home and (found := MEMBER.match(line) or STATIC_MEMBER.match(line)):
            members.append((found[1], path, number))


def check_homes(members, defined):
    """A class has one source.  One of a header is the same in all rooms, one of a source is that source's own."""
    of_headers = [name.rsplit("::", 1)[-1] for name in defined]
    homes = {}  # class, and room if its name alone does not tell it -> the source of its members
    for name, path, number in members:
        place = (name, "" if of_headers.count(name) == 1 else room_of(path)[0])
        home = homes.get(place, path)
        if home != path:
            yield f"{path}:{number}: {name} has members in {home}, too; allowed: one source for a class"
        homes[place] = path


UNLISTED = {"tools/cmake/rb_headers.hpp", "tools/cmake/rb_test_headers.hpp"}  # of the build


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


def check_readme(root, rooms):
    """The READMEs draw what rooms.txt says."""
    for top, name in DRAWN.items():
        file = root / name
        if file.is_file() and rooms.drawing(top) not in file.read_text(encoding="utf-8"):
            yield f"{name}:1: does not draw {ROOMS_FILE}; its drawing: check_layering.py ROOT --draw {top}"


def check_tree(root, rooms):
    """All violations below `root` as texts.  A tree without sources is one, too."""
    violations = [f"{ROOMS_FILE}:{number}: {reason}" for number, reason in rooms.errors]
    defined = {}  # qualified name -> where it is first defined: one program may hold all headers
    members = []  # (class, source, line) of each definition
    used, found_rooms = set(), set()
    for top in TOPS:
        for file in sorted((root / top).rglob("*")):
            if file.suffix not in (".cpp", ".hpp", ".lcm", ".c", ".h") or not file.is_file():
                continue
            path = file.relative_to(root).as_posix()
            found_rooms.add(room_of(path)[0])
            text = file.read_text(encoding="utf-8")
            if file.suffix == ".lcm":
                found = check_message(text)
            else:
                found = check_source(path, text, rooms, used, members)
            violations += [f"{path}:{number}: {reason}" for number, reason in found]
            if file.suffix not in (".hpp", ".h"):
                continue
            for number, name in definitions(text):
                if first := defined.get(name):
                    violations.append(f"{path}:{number}: {name} is defined in {first}, too; allowed: once")
                defined.setdefault(name, f"{path}:{number}")
    if not found_rooms:
        return [f"{root}: no sources here"]
    violations += check_homes(members, defined)
    violations += [f"{ROOMS_FILE}:0: {name} is no folder with sources" for name in rooms.what if name not in found_rooms]
    violations += [f"{ROOMS_FILE}:0: {name} may know {one}, and does not" for name, known in rooms.knows.items()
                   for one in known if one != "*" and one in rooms.what and (name, one) not in used]
    return violations + list(check_readme(root, rooms))


def main(arguments):
    if len(arguments) not in (2, 4) or len(arguments) == 4 and (arguments[2] != "--draw" or arguments[3] not in DRAWN):
        print(f"usage: check_layering.py ROOT [--draw {'|'.join(DRAWN)}]", file=sys.stderr)
        return 2
    root = pathlib.Path(arguments[1])
    rooms = Rooms((root / ROOMS_FILE).read_text(encoding="utf-8"))
    if len(arguments) == 4:
        print(rooms.drawing(arguments[3]))
        return 0
    violations = check_tree(root, rooms)
    for violation in violations:
        print(violation)
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
