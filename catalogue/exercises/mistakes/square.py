#!/usr/bin/env python3
"""The mistake: the right wheel's signal comes first, so that turns to the left become turns to the right."""

import math

import baudbot


class Square(baudbot.Brain):
    """Straight on for a metre, a quarter of a turn, four times."""

    side = 0
    begun = 0.0

    def step(self, turn: baudbot.Turn) -> baudbot.Command:
        pose = turn.get("odometer")
        if pose is None or self.side == 4:
            return baudbot.stop()
        x, y, heading = pose["x_m"], pose["y_m"], pose["heading_rad"]
        start = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)][self.side]
        if math.hypot(x - start[0], y - start[1]) < 0.97:
            return baudbot.drive(0.4, 0.4)
        if heading < (self.side + 1) * math.pi / 2 - 0.05:
            left, right = -0.2, 0.2
            return baudbot.drive(right, left)
        self.side += 1
        return baudbot.stop()


if __name__ == "__main__":
    baudbot.main(Square)
