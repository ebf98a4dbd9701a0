"""pycreate2, as it is, drives a Create 2 over a serial port. Argument: the port; `wake` before it switches DTR by RFC 2217.

Nothing here depends on how late this program is: what the robot says of its way has to agree with itself. The last line has the
speeds of the left and the right wheel that it was told, in mm/s.
"""

import json
import math
import sys
import time

import serial.rfc2217

port = sys.argv[-1]
if port.startswith("rfc2217:"):
    # pycreate2 makes a serial.Serial; that of RFC 2217 takes its place.
    serial.Serial = serial.rfc2217.Serial

import pycreate2  # noqa: E402

COUNTS_PER_TURN = 508.8
WHEEL_DIAMETER_MM = 72.0
# Bytes of the packets from 7 on (iRobot, Create 2 Open Interface; pycreate2, packets.py).
SIZES = [1] * 12 + [2, 2, 1, 2, 2, 1, 2, 2, 2, 2, 2, 2, 2, 1, 2, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 1]
SIZES += [2] * 6 + [1, 1] + [2] * 4 + [1]
# And of the groups.
GROUPS = {0: 26, 1: 10, 2: 6, 3: 10, 4: 14, 5: 12, 6: 52, 100: 80, 101: 28, 106: 12, 107: 9}

robot = pycreate2.Create2(port)
if "wake" in sys.argv:
    robot.wake()
robot.start()
robot.safe()
told = []


def drive(right: int, left: int) -> None:
    robot.drive_direct(right, left)
    told.append([left, right])


for number, size in [*enumerate(SIZES, 7), *GROUPS.items()]:
    robot.SCI.write(142, (number,))
    # The answer, and nothing behind it.
    assert len(robot.SCI.read(size)) == size, f"packet {number} has not {size} bytes"
assert len(SIZES) == 52 and sum(SIZES) == 80

before = robot.get_sensors()
assert before.open_interface_mode == 2, before
assert before.battery_capacity == 3000 and before.voltage > 12_000, before
drive(200, 200)
time.sleep(0.5)
asked = robot.get_sensors()
assert asked.velocity_left == 200 and asked.velocity_right == 200, asked
drive(0, 0)
time.sleep(0.5)
after = robot.get_sensors()
way_mm = math.pi * WHEEL_DIAMETER_MM * (after.encoder_counts_left - before.encoder_counts_left) / COUNTS_PER_TURN
told_mm = asked.distance + after.distance
assert after.encoder_counts_left == after.encoder_counts_right, after
assert way_mm > 50 and abs(way_mm - told_mm) < 4, (way_mm, told_mm)
drive(100, -100)
time.sleep(0.6)
drive(200, 100)
time.sleep(0.4)
robot.drive_stop()
told.append([0, 0])
time.sleep(0.6)
for _ in range(20):
    assert robot.get_sensors().open_interface_mode == 2
print(json.dumps(told))
