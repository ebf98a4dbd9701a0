#!/usr/bin/env python3
"""Stops in front of a wall: the distance comes from Eq. (3.13) of the notes, inverted."""

import math

import baudbot


class Stop(baudbot.Brain):
    """Drives more slowly the nearer the wall is."""

    wanted_m = 0.3

    def start(self) -> None:
        self.is_there = False

    def step(self, turn: baudbot.Turn) -> baudbot.Command:
        reading = turn.value("ir_front", 0.0)
        if reading <= 0.1:
            return baudbot.drive(0.4, 0.4)
        distance = math.sqrt(0.03 / (reading - 0.1))
        self.is_there = self.is_there or distance < self.wanted_m + 0.01
        if self.is_there:
            return baudbot.stop()
        forward = min(0.4, 0.05 + (distance - self.wanted_m))
        return baudbot.drive(forward, forward)


if __name__ == "__main__":
    baudbot.main(Stop)
