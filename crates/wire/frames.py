"""Frames of the wire in Python, to copy: docs/reference/wire.md. Run, it compares itself with vectors.txt."""

from pathlib import Path

MOST_BYTES = 517
KINDS = {"poll", "command", "readings"}


def crc16(data):
    crc = 0xFFFF
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1) ^ (0x1021 if crc & 0x8000 else 0)
        crc &= 0xFFFF
    return crc


def encode(message):
    data = message + crc16(message).to_bytes(2, "little")
    out, pieces = bytearray(), data.split(b"\0")
    for i, piece in enumerate(pieces):
        long = len(piece) >= 254
        while len(piece) >= 254:
            out += b"\xff" + piece[:254]
            piece = piece[254:]
        if piece or not long or i + 1 < len(pieces):
            out += bytes([len(piece) + 1]) + piece
    return bytes(out) + b"\0"


def decode(frame):
    """The message in the bytes before a delimiter."""
    if len(frame) > MOST_BYTES:
        raise ValueError("too_long")
    data, at = bytearray(), 0
    while at < len(frame):
        code = frame[at]
        if at + code > len(frame):
            raise ValueError("cobs")
        data += frame[at + 1 : at + code]
        at += code
        if code < 255 and at < len(frame):
            data.append(0)
    if len(data) < 2:
        raise ValueError("too_short")
    message, crc = bytes(data[:-2]), int.from_bytes(data[-2:], "little")
    if crc != crc16(message):
        raise ValueError("crc")
    return message


def found_in(frame):
    """What decoding it finds; a frame that has a message is what encoding makes of that."""
    try:
        message = decode(frame)
    except ValueError as error:
        return str(error)
    assert encode(message) == frame + b"\0", frame.hex(" ")
    return "message"


def main():
    errors = {"too_long", "cobs", "too_short", "crc"}
    vectors = Path(__file__).with_name("vectors.txt").read_text().splitlines()
    lines = [line.split(" | ") for line in vectors if line and not line.startswith(("#", "bare_"))]
    for name, raw, meaning in lines:
        found = [found_in(frame) for frame in bytes.fromhex(raw).split(b"\0") if frame]
        words = (word for word in meaning.split() if word in KINDS or word.startswith("error="))
        told = [word.removeprefix("error=") for word in words]
        expected = [word if word in errors else "message" for word in told]
        assert found == expected, f"{name}: {found}, and not {expected}"
    print(f"{len(lines)} lines of vectors.txt")


if __name__ == "__main__":
    main()
