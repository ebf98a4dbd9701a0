#!/usr/bin/env python3
"""A brain in Python: follows the wall on its right."""

import baudbot


class Follow(baudbot.Brain):
    """Follows the wall on its right."""

    speed = 0.4
    gain = 1.0
    wanted = 0.3  # nearness of the wall: 0 is out of range, 1 is very near

    def step(self, turn: baudbot.Turn) -> baudbot.Command:
        ahead = max(turn.value("ir_front", 1.0), turn.value("ir_front_left", 1.0))
        if ahead > self.wanted:
            return baudbot.drive(-0.5 * self.speed, 0.5 * self.speed)  # a corner: to the left, on the spot
        right = max(turn.value("ir_right", 0.0), turn.value("ir_front_right", 0.0))
        turning = self.gain * self.speed * (right - self.wanted)  # too near: to the left
        return baudbot.drive(self.speed - turning, self.speed + turning)


if __name__ == "__main__":
    baudbot.main(Follow)
