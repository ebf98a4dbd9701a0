#!/usr/bin/env python3
"""The mistake: it drives straight to the next place, as if there were no walls."""

import math

import baudbot

PLACES = [(11.3, 8.2), (0.6, 8.2), (7.3, 8.0), (11.3, 0.8)]


class Straight(baudbot.Brain):
    """Turns towards the next place and drives there."""

    def start(self) -> None:
        self.next = 0

    def step(self, turn: baudbot.Turn) -> baudbot.Command:
        pose = turn.get("odometer")
        if pose is None or self.next == len(PLACES):
            return baudbot.stop()
        x, y = PLACES[self.next]
        dx, dy = x - pose["x_m"], y - pose["y_m"]
        if math.hypot(dx, dy) < 0.2:
            self.next += 1
        off = math.remainder(math.atan2(dy, dx) - pose["heading_rad"], math.tau)
        if abs(off) > 0.3:
            turning = math.copysign(0.2, off)
            return baudbot.drive(-turning, turning)
        return baudbot.drive(0.5 - 0.3 * off, 0.5 + 0.3 * off)


if __name__ == "__main__":
    baudbot.main(Straight)
