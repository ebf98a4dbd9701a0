"""pycreate2, as it is, drives a square of 0.5 m. Arguments: the side in mm, the port."""

import math
import sys
import time

import pycreate2

SPEED_MM_S, TRACK_MM, TURN_MM_S = 200, 235, 100
side_mm = int(sys.argv[1])

robot = pycreate2.Create2(sys.argv[2], *map(int, sys.argv[3:]))
robot.start()
robot.full()
for _ in range(4):
    for right, left, way_mm in ((SPEED_MM_S, SPEED_MM_S, side_mm), (TURN_MM_S, -TURN_MM_S, math.pi / 4 * TRACK_MM)):
        robot.drive_direct(right, left)
        time.sleep(way_mm / abs(left))
        robot.drive_stop()
        time.sleep(1.0)
