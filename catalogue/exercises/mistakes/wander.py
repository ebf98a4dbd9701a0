#!/usr/bin/env python3
"""The mistake: the signals of the wheels are in the wrong order, so that it turns towards what it sees."""

import baudbot


class Avoid(baudbot.Brain):
    """Straight on, and a curve away from what is near."""

    def step(self, turn: baudbot.Turn) -> baudbot.Command:
        left = max(turn.value("ir_left", 0.0), turn.value("ir_front_left", 0.0))
        right = max(turn.value("ir_right", 0.0), turn.value("ir_front_right", 0.0))
        return baudbot.drive(0.4 + 0.3 * (right - left), 0.4 - 0.3 * (right - left))


if __name__ == "__main__":
    baudbot.main(Avoid)
