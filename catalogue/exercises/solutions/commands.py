#!/usr/bin/env python3
"""Wanders, and sends a command only if it differs from the last one."""

import baudbot

RIGHT = ("ir_right", "ir_front_right")
LEFT = ("ir_left", "ir_front_left")


class Sparing(baudbot.Brain):
    """Straight on, or a turn on the spot away from what is near."""

    speed = 0.3
    near = 0.25

    def start(self) -> None:
        self.sent: baudbot.Command | None = None
        self.turning = 0.0

    def step(self, turn: baudbot.Turn) -> baudbot.Command | None:
        command = self.wanted(turn)
        if command == self.sent:
            return None
        self.sent = command
        return command

    def wanted(self, turn: baudbot.Turn) -> baudbot.Command:
        left, right = (max(turn.value(name, 0.0) for name in names) for names in (LEFT, RIGHT))
        if max(left, right, turn.value("ir_front", 0.0)) < self.near:
            self.turning = 0.0
            return baudbot.drive(self.speed, self.speed)
        # To one side until the way is clear, or it would turn to and fro in corners.
        self.turning = self.turning or (0.2 if right >= left else -0.2)
        return baudbot.drive(-self.turning, self.turning)


if __name__ == "__main__":
    baudbot.main(Sparing)
