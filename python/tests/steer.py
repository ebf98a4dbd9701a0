"""A brain that does what the tests' environments are told to do."""

import baudbot
from common import nearest_steer


class Steer(baudbot.Brain):
    def step(self, turn: baudbot.Turn) -> baudbot.Command | None:
        if not turn:
            return None
        nearest = max(turn.value(name, 0.0) for name in turn.body.sensors)
        return baudbot.drive(*nearest_steer(nearest))


if __name__ == "__main__":
    baudbot.main(Steer)
