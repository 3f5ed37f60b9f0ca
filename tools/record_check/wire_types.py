"""The layout and fingerprint of each message, from its .lcm file as written.

Source of both: LCM 1.3.1, lcmgen/lcmgen.c (lcm_struct_hash) and the type specification.  Fields lie one after
the other, big endian, behind the fingerprint.
"""

import pathlib
import re
import struct

CODES = {"int8_t": "b", "byte": "B", "int16_t": "h", "int32_t": "i", "int64_t": "q", "float": "f", "double": "d",
         "boolean": "b"}
FIELD = re.compile(r"^(?P<type>\w+)\s+(?P<name>\w+)\s*(?P<extents>(\[\s*\d+\s*\]\s*)*);")
MASK = (1 << 64) - 1


def _update(value, byte):
    # A signed shift: what was negative stays negative.
    signed = value - (1 << 64) if value >> 63 else value
    return (((value << 8) ^ (signed >> 55)) + byte) & MASK


def _update_text(value, text):
    value = _update(value, len(text))
    for character in text.encode():
        value = _update(value, character)
    return value


class WireType:
    """One message type: fingerprint, size, and a way from bytes to a dict of its fields."""

    def __init__(self, name, text):
        self.name = name
        self.fields = []  # name, code, extents
        for line in text[text.find("{"):].splitlines():
            found = FIELD.match(line.split("//")[0].strip())
            if found:
                extents = [int(extent) for extent in re.findall(r"\d+", found["extents"])]
                self.fields.append((found["name"], found["type"], extents))
        if not self.fields:
            raise ValueError(f"{name}: no fields in its .lcm file")
        self.fingerprint = self._fingerprint()
        self.format = struct.Struct(">q" + "".join(self._code(field) for field in self.fields))
        self.size = self.format.size

    def _fingerprint(self):
        value = 0x12345678
        for name, kind, extents in self.fields:
            value = _update_text(value, name)
            value = _update_text(value, kind)
            value = _update(value, len(extents))
            for extent in extents:
                value = _update_text(_update(value, 0), str(extent))
        return ((value << 1) + (value >> 63)) & MASK

    @staticmethod
    def _code(field):
        count = 1
        for extent in field[2]:
            count *= extent
        if CODES[field[1]] == "B" and field[2]:
            return f"{count}s"
        return f"{count if field[2] else ''}{CODES[field[1]]}"

    def offset(self, wanted):
        """Of a field, in bytes from the beginning of the message."""
        code = ">q"
        for field in self.fields:
            if field[0] == wanted:
                return struct.calcsize(code)
            code += self._code(field)
        raise KeyError(f"{self.name} has no field {wanted}")

    def decode(self, data):
        """Fields by name; arrays as tuples, whatever their shape; bytes as bytes."""
        values = iter(self.format.unpack(data)[1:])
        fields = {}
        for name, kind, extents in self.fields:
            count = 1
            for extent in extents:
                count *= extent
            if extents and CODES[kind] != "B":
                fields[name] = tuple(next(values) for _ in range(count))
            else:
                fields[name] = next(values)
        return fields


def read_wire_types(folder):
    """All types in `folder` by fingerprint."""
    types = {}
    for file in sorted(pathlib.Path(folder).glob("*.lcm")):
        kind = WireType(file.stem, file.read_text(encoding="utf-8"))
        types[kind.fingerprint] = kind
    if not types:
        raise FileNotFoundError(f"no .lcm files in {folder}")
    return types
