"""A laptop's program that drives a robot with a sketch of its own by pyserial: the program of docs/tutorials/firmware.md.

Argument: the port. The last line has what was read, as JSON.
"""

import json
import sys
import time

import serial

port = serial.Serial(sys.argv[1], 9600, timeout=5)
time.sleep(2)
seen = []
for left, right in [(60, 60)] * 20 + [(-40, 40)] * 10 + [(0, 0)]:
    port.write(bytes([128 + left, 128 + right]))
    line = port.readline()
    assert line.endswith(b"\r\n"), line
    seen.append(int(line))
    time.sleep(0.05)
time.sleep(0.5)
assert port.in_waiting == 0
print(json.dumps(seen))
