"""Client of a board's link in pure Python: the frames, the messages of `wire.json`, a session.

    python3 wire.py 127.0.0.1:7001     moves the arm of `armbridge serve board --listen`
    python3 wire.py --check            encodes and decodes the test vectors
"""

import json, pathlib, socket, struct, sys, time, zlib

WIRE = json.loads((pathlib.Path(__file__).parent / "wire.json").read_text())
TYPES, MESSAGES = WIRE["types"], {b"B": "ToBoard", b"H": "ToHost"}


def varint(value):
    return bytes([value]) if value < 128 else bytes([value & 127 | 128]) + varint(value >> 7)


def encode(shape, value):
    """A value of this shape: structs are dicts, enums their names or {name: content}."""
    if isinstance(shape, str):
        if shape in TYPES:
            return encode(TYPES[shape], value)
        if shape in ("bool", "u8"):
            return bytes([value])
        if shape == "f32":
            return struct.pack("<f", value)
        return varint(value if shape[0] == "u" else value << 1 ^ value >> 16)
    ((kind, inner),) = shape.items()
    if kind == "option":
        return b"\0" if value is None else b"\1" + encode(inner, value)
    if kind == "tuple":
        return b"".join(map(encode, inner, value))
    if kind == "struct":
        return b"".join(encode(field, value[name]) for name, field in inner)
    name, content = (value, None) if isinstance(value, str) else next(iter(value.items()))
    index, shape = next((i, it[1]) for i, it in enumerate(inner) if it[0] == name)
    return varint(index) + (encode(shape, content) if shape else b"")


def decode(shape, data):
    """The value of this shape at the beginning of the data, which an iterator gives."""
    if isinstance(shape, str):
        if shape in TYPES:
            return decode(TYPES[shape], data)
        if shape in ("bool", "u8"):
            return next(data)
        if shape == "f32":
            return struct.unpack("<f", bytes(next(data) for _ in range(4)))[0]
        value = place = 0
        while (byte := next(data)) > 127:
            value, place = value | (byte & 127) << place, place + 7
        value |= byte << place
        return value if shape[0] == "u" else value >> 1 ^ -(value & 1)
    ((kind, inner),) = shape.items()
    if kind == "option":
        return decode(inner, data) if next(data) else None
    if kind == "tuple":
        return [decode(item, data) for item in inner]
    if kind == "struct":
        return {name: decode(field, data) for name, field in inner}
    name, content = inner[decode("u32", data)]
    return {name: decode(content, data)} if content else name


def frame(direction, sequence, message):
    body = struct.pack("<BcH", 1, direction.encode(), sequence)
    body += encode(MESSAGES[direction.encode()], message)
    body += struct.pack("<I", zlib.crc32(body))
    return b"".join(bytes([len(part) + 1]) + part for part in body.split(b"\0")) + b"\0"


def unframe(stuffed):
    """Direction, number and message of a frame without its end; None if it is damaged."""
    whole, at = b"", 0
    while at < len(stuffed):
        whole += stuffed[at + 1 : at + stuffed[at]] + b"\0"
        at += stuffed[at]
    body, crc = whole[:-5], whole[-5:-1]
    if len(body) < 5 or struct.pack("<I", zlib.crc32(body)) != crc:
        return None
    _, direction, number = struct.unpack("<BcH", body[:4])
    shape = MESSAGES.get(direction)
    return direction.decode(), number, shape and decode(shape, iter(body[4:]))


class Board:
    """A session. `poll` has to be called at least every 50 ms."""

    def __init__(self, host, port):
        self.socket = socket.create_connection((host, port), timeout=0.05)
        self.sequence, self.bytes, self.latest, self.acks = 0, b"", {}, {}
        self.send({"Hello": {"schema": WIRE["schema"], "version": [0, 1, 0]}})
        self.until(lambda: "Board" in self.latest and self.mode() == "Idle")

    def send(self, message):
        self.socket.sendall(frame("B", self.sequence, message))
        self.sequence = (self.sequence + 1) % 65536

    def mode(self):
        return self.latest.get("Record", {}).get("mode")

    def poll(self):
        self.send("Heartbeat")
        try:
            self.bytes += self.socket.recv(65536)
        except TimeoutError:
            return
        *frames, self.bytes = self.bytes.split(b"\0")
        for direction, _, message in filter(None, map(unframe, frames)):
            if direction == "H" and isinstance(message, dict):
                self.latest.update(message)
                ack = message.get("Ack", {})
                self.acks[ack.get("sequence")] = ack.get("result")

    def until(self, is_met, timeout=10):
        end = time.monotonic() + timeout
        while not is_met() and time.monotonic() < end:
            self.poll()
        assert is_met(), f"after {timeout} s the board is in {self.mode()}"

    def command(self, command):
        result = "EncoderUnknown"  # Until 48 samples at rest have shown an encoder's noise.
        while "EncoderUnknown" in str(result):
            sequence = self.sequence
            self.send({"Command": command})
            self.until(lambda: sequence in self.acks)
            result = self.acks.pop(sequence)
        assert "Err" not in result, f"refused: {result}"


def check():
    for vector in WIRE["vectors"]:
        sent = frame(vector["direction"], vector["sequence"], vector["message"])
        assert sent.hex() == vector["frame"] and frame(*unframe(sent[:-1])) == sent, vector
    print(len(WIRE["vectors"]), "vectors")


def move(place):
    board = Board(*place.split(":"))
    board.command({"Arm": {"session": board.latest["Board"]["session"]}})
    board.until(lambda: board.mode() == "Armed")
    board.command({"Regulate": [0.0, 0.0]})
    board.command({"Follow": {"MinimumJerk": {"to_rad": [0.2, -0.1], "duration_s": 1.0}}})
    latest = lambda name: board.latest["Record"]["output"][name]
    board.until(lambda: abs(latest("reference_rad")[0] - 0.2) < 1e-4)
    print("angles {:.3f} and {:.3f} rad".format(*latest("angle_rad")))
    board.send("Goodbye")


if __name__ == "__main__":
    check() if sys.argv[1] == "--check" else move(sys.argv[1])
