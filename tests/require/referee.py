"""Robustness as rtamt has it, over random formulas and traces: `python tests/require/referee.py EXAMPLE`, the example `robustness` of
baudbot-require. Its discrete-time offline monitor looks at whole traces with a sample each second.

The script is not called rtamt.py, as it would import itself.
"""

import json
import math
import random
import subprocess
import sys

import rtamt

CASES = 200
SECOND_NS = 1_000_000_000
# Quantities, and their names in rtamt.
NAMES = {"x_m": "x", "speed_m_s": "speed", "age_ms(ir-front)": "age"}
AGE = "age_ms(ir-front)"
# What is compared is never more than about 50, of which this is some units in the last place.
TOLERANCE = 1e-12

chance = random.Random(20)


def number() -> tuple[str, str]:
    value = chance.choice([chance.randint(-3, 3), round(chance.uniform(-3, 3), 3), chance.uniform(-3, 3)])
    return repr(value), f"(0 - {-value!r})" if value < 0 else repr(value)


def expression(depth: int) -> tuple[str, str]:
    """The same in both languages."""
    kind = chance.choice(["number", "quantity", "quantity", "+", "-", "*", "abs", "negative", "min", "max"])
    if depth == 0 or kind == "quantity":
        name = chance.choice(["x_m", "speed_m_s"])
        return name, NAMES[name]
    if kind == "number":
        return number()
    (a, a2), (b, b2) = expression(depth - 1), expression(depth - 1)
    match kind:
        case "abs":
            return f"abs({a})", f"abs({a2})"
        case "negative":
            return f"-({a})", f"(0 - ({a2}))"
        case "min" | "max":
            # rtamt has none of numbers: half the sum less or more half the distance.
            sign = "-" if kind == "min" else "+"
            return f"{kind}({a}, {b})", f"(0.5 * (({a2}) + ({b2})) {sign} 0.5 * abs(({a2}) - ({b2})))"
    return f"({a}) {kind} ({b})", f"(({a2}) {kind} ({b2}))"


def formula(depth: int) -> tuple[str, str]:
    kind = chance.choice(["comparison", "age", "not", "and", "or"])
    if depth == 0 or kind in ("comparison", "age"):
        relation = chance.choice(["<", "<=", ">", ">="])
        if kind == "age":
            # It may be infinite, and is compared as it is.
            (a, a2), (b, b2) = (AGE, NAMES[AGE]), number()
        else:
            (a, a2), (b, b2) = expression(2), expression(1)
        return f"{a} {relation} {b}", f"(({a2}) {relation} ({b2}))"
    (a, a2), (b, b2) = formula(depth - 1), formula(depth - 1)
    if kind == "not":
        return f"not ({a})", f"(not({a2}))"
    return f"({a}) {kind} ({b})", f"(({a2}) {kind} ({b2}))"


def case() -> tuple[dict, str]:
    # rtamt takes no trace of a single sample.
    count, within = chance.randint(2, 40), chance.randint(0, 50)
    values = {name: [chance.choice([float(chance.randint(-2, 2)), chance.uniform(-3, 3)]) for _ in range(count)] for name in NAMES}
    values[AGE] = [None if chance.random() < 0.2 else abs(value) for value in values[AGE]]
    (a, a2), (then, then2) = formula(3), formula(3)
    rule, spec = chance.choice(
        [
            ("always", f"always({a2})"),
            ("never", f"always(not({a2}))"),
            ("eventually", f"eventually({a2})"),
            ("eventually", f"eventually[0:{within}]({a2})"),
            ("whenever", f"always(({a2}) implies (eventually[0:{within}]({then2})))"),
        ]
    )
    return {
        "rule": rule,
        "formula": a,
        "then": then,
        # What is less than a second longer has no further sample.
        "within_ns": within * SECOND_NS + chance.choice([0, SECOND_NS - 1]) if "[" in spec else None,
        "from_ns": chance.randrange(count - 1) * SECOND_NS,
        "times_ns": [i * SECOND_NS for i in range(count)],
        "values": values,
    }, spec


def referee(given: dict, text: str) -> float:
    first = given["from_ns"] // SECOND_NS
    spec = rtamt.StlDiscreteTimeSpecification()
    for name in NAMES.values():
        spec.declare_var(name, "float")
    spec.spec = text
    spec.parse()
    columns = {NAMES[name]: [math.inf if v is None else v for v in column[first:]] for name, column in given["values"].items()}
    return spec.evaluate({"time": list(range(len(given["times_ns"]) - first)), **columns})[0][1]


cases = [case() for _ in range(CASES)]
lines = "".join(json.dumps(given) + "\n" for given, _ in cases)
ran = subprocess.run([sys.argv[1]], input=lines, stdout=subprocess.PIPE, text=True, check=True)
answers = [float(line.split()[0]) for line in ran.stdout.splitlines()]
assert len(answers) == CASES, len(answers)
farthest = 0.0
for (given, text), ours in zip(cases, answers):
    theirs = referee(given, text)
    apart = 0.0 if ours == theirs else abs(ours - theirs)
    assert apart <= TOLERANCE, f"{ours} here, {theirs} of rtamt:\n{json.dumps(given)}\n{text}"
    farthest = max(farthest, apart)
kinds = {rule: sum(given["rule"] == rule for given, _ in cases) for rule in ("always", "never", "eventually", "whenever")}
infinite = sum(map(math.isinf, answers))
print(f"referee.py: {CASES} verdicts ({kinds}, {infinite} infinite) are at most {farthest:.1e} from rtamt's")
