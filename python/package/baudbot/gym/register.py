"""The environments that have a name. Gymnasium finds this by the entry point `gymnasium.envs` of the package."""

from __future__ import annotations

import gymnasium

#: By name: the scenario, the fields that are changed of it, and the reward.
ENVIRONMENTS: dict[str, dict[str, object]] = {
    # Drive on, and run into nothing, for a minute.
    "Wander-v0": {
        "scenario": "wander",
        "overrides": {"end.after_s": 60.0},
        "reward": {"distance_m": 1.0, "collisions": -5.0},
    },
    # The same with the robot of Khepera's protocol, which answers only when asked.
    "Khepera-v0": {
        "scenario": "khepera",
        "overrides": {"end.after_s": 60.0},
        "reward": {"distance_m": 1.0, "collisions": -0.5},
    },
}


def register() -> None:
    """Makes the environments known to `gymnasium.make`, as `baudbot/NAME`."""
    for name, options in ENVIRONMENTS.items():
        identifier = f"baudbot/{name}"
        if identifier not in gymnasium.registry:
            gymnasium.register(
                id=identifier,
                entry_point="baudbot.gym:Env",
                vector_entry_point="baudbot.gym:VectorEnv",
                kwargs=options,
            )
