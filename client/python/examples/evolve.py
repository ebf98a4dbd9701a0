#!/usr/bin/env python3
"""A small evolution strategy: each generation drives sixteen robots at once, and the best have children."""

import random
import sys
from collections.abc import Sequence

import baudbot

WORLDS, PARENTS, SECONDS = 16, 4, 8.0


def command(weights: Sequence[float], turn: baudbot.Turn) -> baudbot.Command:
    """A policy: the signal of each motor is a weighted sum of what the infrared sensors see, and a bias."""
    seen = [turn.value(name, 0.0) for name in turn.body.sensor_names if name.startswith("ir_")] + [1.0]
    half = len(weights) // 2
    left, right = (sum(w * s for w, s in zip(part, seen)) for part in (weights[:half], weights[half:]))
    return baudbot.drive(max(-1.0, min(left, 1.0)), max(-1.0, min(right, 1.0)))


def scores(trainer: baudbot.Trainer, candidates: Sequence[Sequence[float]]) -> list[float]:
    """How far each candidate drives, less its collisions. A brain could not know that: it is the truth."""
    results = trainer.reset()
    while not all(result.ended for result in results):
        outputs = [None if r.ended else command(weights, r.turn) for weights, r in zip(candidates, results)]
        results = trainer.step(outputs)
    return [result.truth.distance_m - result.truth.collisions for result in results]


def evolve(trainer: baudbot.Trainer, generations: int, seed: int = 1) -> list[float]:
    """The best score of each generation. The best candidate lives on, so that the score never falls."""
    (body,) = trainer.results[0].turns.values()
    size = 2 * (1 + sum(name.startswith("ir_") for name in body.body.sensor_names))
    chance, best = random.Random(seed), []
    candidates = [[chance.gauss(0.0, 0.5) for _ in range(size)] for _ in range(WORLDS)]
    for _ in range(generations):
        ranked = sorted(zip(scores(trainer, candidates), candidates), reverse=True)
        best.append(ranked[0][0])
        parents = [weights for _, weights in ranked[:PARENTS]]
        children = (chance.choice(parents) for _ in range(WORLDS - 1))
        candidates = [parents[0]] + [[w + chance.gauss(0.0, 0.15) for w in child] for child in children]
    return best


if __name__ == "__main__":
    with baudbot.Trainer(sys.argv[1] if len(sys.argv) > 1 else "unix:/tmp/trainer.sock") as connected:
        connected.create("wander", count=WORLDS, set={"end.after_s": SECONDS})
        for number, score in enumerate(evolve(connected, generations=30), 1):
            print(f"generation {number}: {score:.3f}")
