"""Response times in `baudbot budget` beside PROSA's verified analysis of first in, first out: `python tests/budget/referee.py BAUDBOT`.

The two have the same model if three things hold:

- The cable takes no time (`ideal`, `onboard`), so that the processor alone decides.
- Commands come as the scenario states. `10-per-s` is a sporadic task. Once a tick is a period with as much jitter, as one step may be at the end of
  its tick and the next at the beginning. Answers have the period of the messages and their jitter, which is the bound itself, so that it is computed
  again until it stays as it is. On board the brain first waits for the processor, up to one task.
- No task is late by the shortest period. baudbot leaves out what fell due again meanwhile; in PROSA's model it waits.

A budget has the bound in the age of each reading and in the row `obeying`. Where a brain only answers, that row knows more: the message was served
before its answer came. Neither uses that schedules have phases, so the bounds should be equal. Runs are held against the budget, too, also of sets for
which the models differ.
"""

import json
import math
import random
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from response_time_analysis import fifo
from response_time_analysis.model import WCET, FullyNonPreemptive, IdealProcessor, PeriodicWithJitter, Task, taskset

SETS = 200
RUNS = 60
MS = 1_000_000
# Of half the sets the schedules come round soon.
ROUND_MS = [20, 25, 30, 40, 50, 60, 75, 100]
# The most messages through which a budget goes for what each has.
MOST_MESSAGES = 2048
# The durations of a run are in milliseconds, not in whole nanoseconds.
ROUNDING_NS = 0.5

chance = random.Random(21)


def shares(count: int, load: float) -> list[float]:
    """UUniFast (Bini and Buttazzo, 2005): all ways to divide the load are equally likely."""
    parts = []
    for others in range(count - 1, 0, -1):
        rest = load * chance.random() ** (1 / others)
        parts.append(load - rest)
        load = rest
    return [*parts, load]


def period(comes_round: bool) -> int:
    return chance.choice(ROUND_MS) * MS if comes_round else round(20_000 * 5 ** chance.random()) * 1000


def schedules() -> dict:
    """A robot without the costs of its tasks; times are in nanoseconds."""
    comes_round = chance.random() < 0.5
    periods = [period(comes_round) for _ in range(chance.randint(1, 8))]
    phases = [chance.choice([0, chance.randrange(period // 1000) * 1000]) for period in periods]
    frame, step = period(comes_round), chance.choice([5, 8, 10, 20]) * MS
    pause = chance.choice([ms for ms in (8, 10, 20, 25, 40, 50, 100) if ms * MS >= step]) * MS
    apart = {"on-message": max(frame, step), "when-free": step, "every-tick": step, f"{1000 * MS // pause}-per-s": pause}
    writes = chance.choice(list(apart))
    return {
        "kind": chance.choice(["ideal", "ideal", "onboard"]),
        "sensors": list(zip(periods, phases)),
        "frame": frame,
        # Not before the first reads, so that the first message has all sensors and is the longest.
        "phase": max(phases) + chance.choice([0, chance.randrange(frame // 1000) * 1000]),
        "step": step,
        "writes": writes,
        "pause": pause,
        "command": apart[writes],
    }


def task_set() -> dict:
    robot = schedules()
    count = len(robot["sensors"])
    # docs/reference/wire.md: readings of a byte each with ages, and a command for two motors.
    bytes_up, bytes_down = 8 + -(-count // 8) + 2 * count, 8
    *reads, up, down = shares(count + 2, chance.uniform(0.1, 0.95))
    robot["sensors"] = [(period, phase, int(share * period)) for (period, phase), share in zip(robot["sensors"], reads)]
    command = int(down * robot["command"])
    robot["framing"] = int(up * robot["frame"] / bytes_up)
    robot["receiving"] = int(chance.random() * command / bytes_down)
    robot["obeying"] = command - robot["receiving"] * bytes_down
    # On board there are no bytes.
    is_onboard = robot["kind"] == "onboard"
    robot["frame_cost"] = 0 if is_onboard else robot["framing"] * bytes_up
    robot["command_cost"] = robot["obeying"] if is_onboard else command
    return robot


def scenario(robot: dict) -> str:
    """A robot in an empty arena. It meets its deadline, so that no remedies are searched for."""
    lines = [
        f"step_ms = {robot['step'] / MS}",
        "[[robots]]",
        'name = "robot"',
        "body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }",
        "motors = { signal_bits = 8 }",
        f'link = {{ kind = "{robot["kind"]}" }}',
        f'brain = {{ writes = "{robot["writes"]}", deadline_ms = 1e6 }}',
        f"firmware = {{ period_ms = {robot['frame'] / MS}, phase_ms = {robot['phase'] / MS} }}",
        "[robots.microcontroller]",
        f"framing_us_per_byte = {robot['framing'] / 1000}",
        f"receiving_us_per_byte = {robot['receiving'] / 1000}",
        f"obeying_us = {robot['obeying'] / 1000}",
    ]
    for i, (period, phase, cost) in enumerate(robot["sensors"]):
        lines += [
            f"[robots.sensors.s{i}]",
            'kind = "floor"\nmount = {}\nbits = 8',
            f"period_ms = {period / MS}\nphase_ms = {phase / MS}\nacquisition_us = {cost / 1000}",
        ]
    return "\n".join(lines) + "\n"


def asked(*words: str) -> dict:
    ran = subprocess.run([sys.argv[1], *words], stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(ran.stdout)["robots"][0]


def fifo_ns(robot: dict, commands: PeriodicWithJitter) -> float:
    works = [(PeriodicWithJitter(period, 0), cost) for period, _, cost in robot["sensors"]]
    works += [(PeriodicWithJitter(robot["frame"], 0), robot["frame_cost"]), (commands, robot["command_cost"])]
    tasks = taskset(Task(arrivals, FullyNonPreemptive(WCET(cost))) for arrivals, cost in works if cost > 0)
    bound = fifo.rta(tasks, IdealProcessor(), horizon=10_000 * MS).response_time_bound
    return math.inf if bound is None else bound


def theirs_ns(robot: dict, rows: dict) -> float:
    """PROSA's response time. Of the budget it takes what is no matter of the processor: the wait for the brain's step."""
    waits = 0
    if robot["kind"] == "onboard":
        waits = max(robot["command_cost"], *(cost for _, _, cost in robot["sensors"]))
    bound = fifo_ns(robot, PeriodicWithJitter(robot["step"], robot["step"] + waits))
    if robot["writes"].endswith("-per-s"):
        bound = min(bound, fifo_ns(robot, PeriodicWithJitter(robot["pause"], waits)))
    if robot["writes"] == "on-message":
        jitter = rows["framing"]["worst_ns"] - rows["framing"]["best_ns"] + rows["step"]["worst_ns"]
        late, last = 0, None
        while late != last and late < math.inf:
            last = late
            late = min(bound, fifo_ns(robot, PeriodicWithJitter(robot["frame"], late + jitter)))
        bound = late
    return bound


def besides_ns(robot: dict, sensor: tuple[int, int, int], step_ns: int) -> int:
    """The age of a reading at the brain, less the response time of its message."""
    (period, phase, cost), frame = sensor, robot["frame"]
    count = math.lcm(frame, *(period for period, _, _ in robot["sensors"])) // frame
    if count <= MOST_MESSAGES:
        waits = [(robot["phase"] + k * frame - phase) % period for k in range(count + 1)]
        return max(wait for k, wait in enumerate(waits) if k == 0 or wait < frame) + step_ns
    # Until it is read again, or the next message goes; before the first there is none.
    return min(period - cost + robot["frame_cost"], max(frame, robot["phase"] - phase)) + step_ns


def ours_ns(robot: dict, budget: dict, rows: dict) -> list[int]:
    """The same response time in all the places of a budget that have it."""
    step_ns = rows["step"]["worst_ns"]
    ages = zip(budget["ages"], robot["sensors"], strict=True)
    bounds = [age["worst_ns"] - besides_ns(robot, sensor, step_ns) for age, sensor in ages]
    if robot["kind"] == "onboard" or robot["writes"] != "on-message":
        bounds.append(rows["obeying"]["worst_ns"])
    return bounds


def longest_ns(budget: dict, run: dict) -> list[tuple[float, float]]:
    """What a run has seen at most, and the budget's bound of that, where it has one."""
    pairs = [(run["cycles"]["duration"], budget["cycle"]["total"])]
    pairs += [(sensor["age"], age) for sensor, age in zip(run["sensors"], budget["ages"], strict=True)]
    known = [(seen, bound["worst_ns"]) for seen, bound in pairs if seen and bound["worst_ns"]]
    return [(seen["max_ms"] * MS, bound) for seen, bound in known]


ratios, seen_ratios = [], []
differ = runs = runs_that_differ = 0
with tempfile.TemporaryDirectory() as folder:
    file = Path(folder, "set.toml")
    while len(ratios) < SETS:
        robot = task_set()
        file.write_text(scenario(robot))
        budget = asked("budget", str(file), "--json")
        rows = {row["part"]: row for row in budget["cycle"]["rows"]}
        told = f"{robot}\n{scenario(robot)}"
        assert rows["framing"]["worst_ns"] == robot["frame_cost"], told
        theirs = theirs_ns(robot, rows)
        is_same = theirs < min(robot["frame"], *(period for period, _, _ in robot["sensors"]))
        if is_same:
            bounds = ours_ns(robot, budget, rows)
            assert min(bounds) >= theirs, f"{bounds} ns here, {theirs} ns of PROSA:\n{told}"
            ratios.append(max(bounds) / theirs)
        else:
            differ += 1
        # The brain `constant` answers each message, and says something now and then where none comes.
        if runs < RUNS and robot["writes"] in ("when-free", "every-tick"):
            run = asked("run", str(file), "--json", "--quiet", "--brain", "constant", "--seconds", "5")
            missed = run["frames_missed"] + sum(sensor["missed"] for sensor in run["sensors"])
            assert not (is_same and missed), f"{missed} missed:\n{told}"
            for seen, bound in longest_ns(budget, run):
                assert seen <= bound + ROUNDING_NS, f"{seen} ns seen, {bound} ns foretold:\n{told}"
                seen_ratios.append(seen / bound)
            runs += 1
            runs_that_differ += not is_same

print(
    f"referee.py: of {SETS} response times {ratios.count(1)} are PROSA's, the longest {max(ratios):.3f} times as long, median "
    f"{statistics.median(ratios):.3f}; for {differ} more sets the models differ. {runs} runs, {runs_that_differ} of these, have seen up to "
    f"{max(seen_ratios):.3f} of their bounds, median {statistics.median(seen_ratios):.3f}"
)
