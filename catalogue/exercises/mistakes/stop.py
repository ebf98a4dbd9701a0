#!/usr/bin/env python3
"""The mistake: it waits for the largest reading, which comes too late."""

import baudbot


class Stop(baudbot.Brain):
    """Drives until the reading is 1."""

    def step(self, turn: baudbot.Turn) -> baudbot.Command:
        if turn.value("ir_front", 0.0) >= 1.0:
            return baudbot.stop()
        return baudbot.drive(1.0, 1.0)


if __name__ == "__main__":
    baudbot.main(Stop)
