#!/usr/bin/env python3
"""Drives a square by the odometer: a sequence of states, and a stop at the end."""

import math

import baudbot

CORNERS = [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)]


class Square(baudbot.Brain):
    """Turns towards the next corner, drives there, and so on."""

    reached = 0.03
    side = 0

    def step(self, turn: baudbot.Turn) -> baudbot.Command:
        pose = turn.get("odometer")
        if pose is None or self.side == len(CORNERS):
            return baudbot.stop()
        x, y = CORNERS[self.side]
        dx, dy = x - pose["x_m"], y - pose["y_m"]
        distance = math.hypot(dx, dy)
        if distance < self.reached:
            self.side += 1
            return baudbot.stop()
        off = math.remainder(math.atan2(dy, dx) - pose["heading_rad"], math.tau)
        if abs(off) > 0.3:
            turning = math.copysign(0.15, off)
            return baudbot.drive(-turning, turning)
        forward = min(0.5, 0.1 + distance)
        return baudbot.drive(forward - 0.4 * off, forward + 0.4 * off)


if __name__ == "__main__":
    baudbot.main(Square)
