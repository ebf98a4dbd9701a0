"""Frames of the wire in Python, to copy: docs/reference/wire.md."""


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
