#!/usr/bin/env python3
"""A brain in Python: drives about and turns away from what its infrared sensors see."""

import math

import baudbot


class Avoid(baudbot.Brain):
    """Turns away from what its infrared sensors see."""

    # A reading is a nearness: 0 if nothing is in range, 1 if something is very near.
    turn_at = 0.28
    clear_at = 0.2

    def start(self) -> None:
        # Those that look to the side or back are of no use here. Positive bearings are to the left.
        ahead = [sensor for sensor in self.body.of_kind("ir") if math.cos(sensor.heading_rad) > 0.3]
        if not ahead:
            raise baudbot.Error(f"robot `{self.body.robot}` has no infrared sensor that looks ahead")
        self.bearings = {sensor.name: sensor.heading_rad for sensor in ahead}
        self.spin = 0.0  # turning on the spot to the left (1) or to the right (-1), or driving (0)

    def step(self, turn: baudbot.Turn) -> baudbot.Command:
        nearness = {name: turn.value(name, 0.0) for name in self.bearings if name in turn}
        nearest = max(nearness.values(), default=math.inf)
        if nearest == math.inf:
            return baudbot.stop()  # nothing has come over the cable yet
        if nearest < self.clear_at:
            self.spin = 0.0
        elif nearest >= self.turn_at and self.spin == 0.0:
            # Away from the nearer side, and the same way until all is clear, or it dithers in a corner.
            side = sum(near * math.sin(self.bearings[name]) for name, near in nearness.items())
            self.spin = -1.0 if side > 0.0 else 1.0
        if self.spin != 0.0:
            return baudbot.drive(-0.5 * self.spin, 0.5 * self.spin)
        return baudbot.drive(0.5 - nearest, 0.5 - nearest)  # the nearer, the slower


if __name__ == "__main__":
    baudbot.main(Avoid)
