/** A brain in Python, to begin with. */
export const PYTHON = `"""Follows the wall on its right: the brain of client/python/examples/follow.py."""

import baudbot


class Follow(baudbot.Brain):
    speed = 0.4
    gain = 1.0
    wanted = 0.3  # nearness of the wall: 0 is out of range, 1 is very near

    def step(self, turn):
        ahead = max(turn.value("ir_front", 1.0), turn.value("ir_front_left", 1.0))
        if ahead > self.wanted:
            return baudbot.drive(-0.5 * self.speed, 0.5 * self.speed)  # a corner: to the left
        right = max(turn.value("ir_right", 0.0), turn.value("ir_front_right", 0.0))
        turning = self.gain * self.speed * (right - self.wanted)  # too near: to the left
        return baudbot.drive(self.speed - turning, self.speed + turning)


if __name__ == "__main__":
    baudbot.main(Follow)
`;
