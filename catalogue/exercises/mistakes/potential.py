#!/usr/bin/env python3
"""The mistake: down the potential field, and no way out of the place in front of the wedge from which every direction leads uphill."""

import math

import baudbot

GOAL = (2.0, 0.0)
PILLARS = [(1.0, 0.0), (0.8, 0.3), (0.8, -0.3)]


class Downhill(baudbot.Brain):
    """The steepest way down: a paraboloid at the goal, a Gaussian hill at each pillar."""

    def step(self, turn: baudbot.Turn) -> baudbot.Command:
        pose = turn.get("odometer")
        if pose is None:
            return baudbot.stop()
        x, y = pose["x_m"], pose["y_m"]
        down_x, down_y = 0.2 * (GOAL[0] - x), 0.2 * (GOAL[1] - y)
        for px, py in PILLARS:
            height = 1.0 * math.exp(-((x - px) ** 2 + (y - py) ** 2) / 0.06)
            down_x += height * (x - px) / 0.03
            down_y += height * (y - py) / 0.03
        off = math.remainder(math.atan2(down_y, down_x) - pose["heading_rad"], math.tau)
        forward = 0.2 if abs(off) < 0.5 else 0.0
        turning = max(-0.2, min(0.2, 0.4 * off))
        return baudbot.drive(forward - turning, forward + turning)


if __name__ == "__main__":
    baudbot.main(Downhill)
