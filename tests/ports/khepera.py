"""Every command of the Khepera over a serial port, with pyserial as it is. Arguments: the port, its baud rate, its stop bits.

Nothing here depends on how late this program is: it asks, and waits for the answer.
"""

import re
import sys

import serial

INTEGERS = r"(,-?\d+)"
# Commands, and what a Khepera with encoders and eight infra-red sensors answers.
DIALOGUE = [
    ("A,3800,800,100", "a"),
    ("B", r"b,\d+\.\d+,\d+\.\d+"),
    ("C,500,500", "c"),
    ("D,5,5", "d"),
    ("E", "e" + INTEGERS + "{2}"),
    ("F,3000,20,4000", "f"),
    ("G,0,0", "g"),
    ("H", "h" + INTEGERS + "{2}"),
    ("J,20,64,20,64", "j"),
    ("K", "k" + INTEGERS + "{6}"),
    ("L,0,1", "l"),
    ("N", "n" + INTEGERS + "{8}"),
    ("O", "o" + INTEGERS + "{8}"),
    ("P,0,0", "p"),
    ("D,0,0", "d"),
    ("R,1", r"r,\d+"),
    ("W,1,1", "w"),
    ("Z", "Command not found"),
    ("D,x", "z,Protocol error"),
]


def main() -> None:
    port, baud, stop_bits = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    robot = serial.serial_for_url(port, baudrate=baud, stopbits=stop_bits, timeout=20)
    for command, expected in DIALOGUE:
        robot.write(command.encode() + b"\r")
        answer = robot.read_until(b"\n").decode()
        if not re.fullmatch(expected + "\r\n", answer):
            sys.exit(f"{command}: {answer!r} is not {expected}")
    print(f"khepera.py: {len(DIALOGUE)} commands answered over {port}")


main()
