"""Asks a Khepera for its sensors with pyserial. Prints as asks.c. Argument: the port."""

import sys
import time

import serial

port = serial.Serial(sys.argv[-1], 9600, stopbits=serial.STOPBITS_TWO, timeout=1)
for _ in range(5):
    begun = time.monotonic_ns()
    port.write(b"N\r")
    answer = port.read_until(b"\n")
    assert answer.endswith(b"\n"), answer
    print(len(answer), time.monotonic_ns() - begun)
    time.sleep(0.02)
