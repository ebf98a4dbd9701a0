"""Asks as asks.py, with a thread that reads and a queue between them. Argument: the port."""

import queue
import sys
import threading
import time

import serial

port = serial.Serial(sys.argv[-1], 9600, stopbits=serial.STOPBITS_TWO)
lines: queue.Queue[tuple[bytes, int]] = queue.Queue()


def read() -> None:
    while True:
        line = port.read_until(b"\n")
        lines.put((line, time.monotonic_ns()))


threading.Thread(target=read, daemon=True).start()
for _ in range(5):
    begun = time.monotonic_ns()
    port.write(b"N\r")
    line, at = lines.get(timeout=1)
    print(len(line), at - begun)
    time.sleep(0.02)
