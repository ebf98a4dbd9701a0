#!/usr/bin/env python3
"""The mistake: half of the track instead of all of it, so that the heading changes by twice as much as it should."""

import math

import baudbot

WHEEL_RADIUS_M = 0.05
TRACK_M = 0.15
COUNTS_PER_TURN = 600


class Odometry(baudbot.Brain):
    """Drives figures of eight in the middle of the floor."""

    speed = 0.5

    def start(self) -> None:
        self.pose = (0.0, 0.0, 0.0)
        self.counts: list[float] | None = None

    def step(self, turn: baudbot.Turn) -> baudbot.Command:
        reading = turn.get("encoders")
        if reading is not None and reading.readable:
            self.add(reading.values)
        bend = 0.2 if turn.at_s % 24.0 < 12.0 else -0.2
        return baudbot.drive(self.speed - bend, self.speed + bend)

    def add(self, counts: list[float]) -> None:
        if self.counts is not None:
            left, right = (self.way(new, old) for new, old in zip(counts, self.counts))
            x, y, heading = self.pose
            heading += (right - left) / TRACK_M
            way = (left + right) / 2
            self.pose = (x + way * math.cos(heading), y + way * math.sin(heading), heading)
        self.counts = counts

    @staticmethod
    def way(new: float, old: float) -> float:
        counts = (new - old + 32768) % 65536 - 32768  # a counter of 16 bits wraps around
        return counts / COUNTS_PER_TURN * math.tau * WHEEL_RADIUS_M

    def belief(self) -> baudbot.Belief:
        return baudbot.Belief(pose=self.pose)


if __name__ == "__main__":
    baudbot.main(Odometry)
