"""Decodes the telemetry of meerkat-mwd: bytes of a line in, one JSON object a frame out.

    python3 mwd_telemetry.py CAPTURE

Needs Python 3.8 or later and no package. telemetry.layout beside this file has the layout of every payload;
docs/telemetry.md explains it.
"""

import json
import math
import pathlib
import struct
import sys


class Layout:
    """Structs, enums and flags of a layout file, and the kinds of frames."""

    def __init__(self, text):
        self.frames, self.types = {}, {}
        members = None
        for line in text.splitlines():
            words = line.split()
            if not words or words[0].startswith("#"):
                continue
            if line.startswith("frame "):
                self.frames[int(words[1])] = words[2]
            elif line[0] != " ":
                members = []
                self.types[words[1]] = (words[0], members)
            else:
                members.append((words[0], words[1] if len(words) > 1 else None))


LAYOUT = Layout((pathlib.Path(__file__).parent / "telemetry.layout").read_text())


class Malformed(ValueError):
    """A payload that does not fit its layout: another version wrote it."""


class Reader:
    """Reads postcard's encoding."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, count):
        if self.at + count > len(self.data):
            raise Malformed("too short")
        self.at += count
        return self.data[self.at - count : self.at]

    def varint(self, bits):
        """Seven bits a byte, the lowest first; the highest bit of a byte says that another follows."""
        value = 0
        for place in range((bits + 6) // 7):
            byte = self.take(1)[0]
            value |= (byte & 0x7F) << 7 * place
            if byte < 0x80:
                if value >> bits:
                    break
                return value
        raise Malformed("a number that is too large")

    def tag(self):
        byte = self.take(1)[0]
        if byte > 1:
            raise Malformed("neither true nor false")
        return byte == 1

    def value(self, kind):
        if kind[0] == "?":
            return self.value(kind[1:]) if self.tag() else None
        if kind[0] == "*":
            return [self.value(kind[1:]) for _ in range(self.varint(32))]
        if kind[0] == "[":
            count, of = kind[1:].split("]", 1)
            return [self.value(of) for _ in range(int(count))]
        if kind == "u8":
            return self.take(1)[0]
        if kind in ("u16", "u32", "u64"):
            return self.varint(int(kind[1:]))
        if kind in ("le16", "le64"):
            return int.from_bytes(self.take(int(kind[2:]) // 8), "little")
        if kind == "f32":
            number = struct.unpack("<f", self.take(4))[0]
            return number if math.isfinite(number) else None
        if kind == "bool":
            return self.tag()
        if kind == "text":
            try:
                return self.take(self.varint(32)).decode()
            except UnicodeDecodeError as error:
                raise Malformed("no UTF-8") from error
        sort, members = LAYOUT.types[kind]
        if sort == "struct":
            return {name: self.value(of) for name, of in members}
        if sort == "flags":
            bits = self.varint(16)
            return " | ".join(name for name, bit in members if bits & int(bit))
        number = self.varint(32)
        if number >= len(members):
            raise Malformed("a choice of another version")
        name, of = members[number]
        return name if of is None else {name: self.value(of)}


def crc32c(data):
    """CRC-32C (RFC 3720, section 12.1)."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def unstuff(data):
    """Takes COBS out: a code says after how many bytes a zero stood; 255 says that none did."""
    out, at = bytearray(), 0
    while at < len(data):
        code = data[at]
        if code == 0 or at + code > len(data):
            return None
        out += data[at + 1 : at + code]
        at += code
        if code < 255 and at < len(data):
            out.append(0)
    return bytes(out)


def frames(data):
    """Frames of a line with a right check: kind, sequence number, payload."""
    for stuffed in data.split(b"\0")[:-1]:
        frame = unstuff(stuffed)
        if frame and len(frame) >= 7 and crc32c(frame[:-4]) == int.from_bytes(frame[-4:], "little"):
            yield frame[0], int.from_bytes(frame[1:3], "little"), frame[3:-4]


def decode(kind, payload):
    """Name and content of a payload; numbers that are not finite are None."""
    if kind not in LAYOUT.frames:
        raise Malformed("a kind of another version")
    reader = Reader(payload)
    name = LAYOUT.frames[kind]
    value = reader.value(name)
    if reader.at != len(payload):
        raise Malformed("too long")
    return name, value


def main():
    with open(sys.argv[1], "rb") as file:
        data = file.read()
    for kind, sequence, payload in frames(data):
        try:
            name, value = decode(kind, payload)
            print(json.dumps({"sequence": sequence, name: value}, separators=(",", ":")))
        except Malformed as error:
            print(json.dumps({"sequence": sequence, "kind": kind, "error": str(error)}))


if __name__ == "__main__":
    main()
