"""Letters of the e-puck over a serial port, in text and in bytes, with pyserial as it is. Argument: the port.

Nothing here depends on how late this program is: it asks, and waits for the answer.
"""

import re
import struct
import sys

import serial

INTEGERS = r"(,-?\d+)"
# Commands, and what an e-puck with eight infra-red sensors and steps answers.
DIALOGUE = [
    ("A", "a" + INTEGERS + "{3}"),
    ("B,1", "b"),
    ("b", "b,1"),
    ("C", "c,3"),
    ("D,300,-300", "d"),
    ("E", "e,300,-300"),
    ("F,2", "f"),
    ("g", "g,0,0,0"),
    ("I", "i" + INTEGERS + "{5}"),
    ("J,0,20,20,4", "j"),
    ("L,8,1", "l"),
    ("M", "m" + INTEGERS + "{5}"),
    ("N", "n" + INTEGERS + "{8}"),
    ("O", "o" + INTEGERS + "{8}"),
    ("P,100,-100", "p"),
    ("q", "q" + INTEGERS + "{2}"),
    ("S", "s"),
    ("T,1", "t"),
    ("U", "u,0,0,0"),
    ("X", "z,Command not found"),
]


def main() -> None:
    robot = serial.serial_for_url(sys.argv[1], baudrate=115_200, timeout=20)
    for command, expected in DIALOGUE:
        robot.write(command.encode() + b"\r")
        answer = robot.read_until(b"\n").decode()
        if not re.fullmatch(expected + "\r\n", answer):
            sys.exit(f"{command}: {answer!r} is not {expected}")
    # Speeds, and what was asked for, in bytes: letters with their signs changed, and a 0.
    robot.write(struct.pack("<bhhbbbb", -ord("D"), 200, -200, -ord("N"), -ord("Q"), -ord("E"), 0))
    numbers = struct.unpack("<12h", robot.read(24))
    if numbers[10:] != (200, -200):
        sys.exit(f"in bytes: {numbers}")
    print(f"e_puck.py: {len(DIALOGUE)} commands answered, and 12 numbers in bytes, over {sys.argv[1]}")


main()
