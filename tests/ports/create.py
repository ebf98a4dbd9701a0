"""pycreate2, as it is, drives a Create 2 over a serial port. Argument: the port; `wake` before it switches DTR by RFC 2217.

Nothing here depends on how late this program is: what the robot says of its way has to agree with itself.
"""

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

robot = pycreate2.Create2(port)
if "wake" in sys.argv:
    robot.wake()
robot.start()
robot.safe()
before = robot.get_sensors()
assert before.open_interface_mode == 2, before
assert before.battery_capacity == 3000 and before.voltage > 12_000, before
robot.drive_direct(200, 200)
time.sleep(0.5)
asked = robot.get_sensors()
assert asked.velocity_left == 200 and asked.velocity_right == 200, asked
robot.drive_stop()
time.sleep(0.5)
after = robot.get_sensors()
way_mm = math.pi * WHEEL_DIAMETER_MM * (after.encoder_counts_left - before.encoder_counts_left) / COUNTS_PER_TURN
told_mm = asked.distance + after.distance
assert after.encoder_counts_left == after.encoder_counts_right, after
assert way_mm > 50 and abs(way_mm - told_mm) < 4, (way_mm, told_mm)
for _ in range(20):
    assert robot.get_sensors().open_interface_mode == 2
print(f"create.py: {way_mm:.0f} mm driven over {port}")
