#!/usr/bin/env python3
"""The mistake: a command in each tick, a hundred a second, more than the cable can carry."""

import baudbot


class Chatty(baudbot.Brain):
    """Straight on, or a turn on the spot away from what is near."""

    every_tick = True
    speed = 0.3
    near = 0.25

    def step(self, turn: baudbot.Turn) -> baudbot.Command:
        nearest = max((reading.value for reading in turn.values()), default=0.0)
        if nearest < self.near:
            return baudbot.drive(self.speed, self.speed)
        return baudbot.drive(-0.2, 0.2)


if __name__ == "__main__":
    baudbot.main(Chatty)
