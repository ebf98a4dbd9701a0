"""How long a Khepera's answers take beyond what its cable and its processor need for them. Arguments: the port, its baud rate, how often, and what is asked (`N`).

The last line has the least and the median, in milliseconds.
"""

import json
import statistics
import sys
import time

import serial

BITS_PER_CHARACTER = 11
# The robot's processor: for the last byte of a question, and for each of the answer (the preset `m68331`).
BYTE_MS = 0.04

port, baud, times = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
question = (sys.argv[4] if len(sys.argv) > 4 else "N").encode() + b"\r"
robot = serial.Serial(port, baud, stopbits=2, timeout=20)
beyond_ms = []
for _ in range(times):
    began = time.perf_counter()
    robot.write(question)
    answer = robot.read_until(b"\n")
    took_ms = 1e3 * (time.perf_counter() - began)
    on_wire_ms = 1e3 * (len(question) + len(answer)) * BITS_PER_CHARACTER / baud
    beyond_ms.append(took_ms - on_wire_ms - BYTE_MS * (1 + len(answer)))
print(json.dumps([min(beyond_ms), statistics.median(beyond_ms)]))
