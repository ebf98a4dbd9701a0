"""The program's physics against equations that are solved here, in another language and by another method."""

import csv
import math
import random
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

from server import baudbot as baudbot_program

SCENARIOS = Path(__file__).resolve().parents[3] / "catalogue/scenarios"


def table(scenario, *arguments):
    """The rows that the program writes of a run."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "run.csv")
        done = baudbot_program("run", scenario, *arguments, "--quiet", "--csv", path)
        assert done.returncode == 0, done.stderr
        with path.open() as file:
            return [{name: float(value) for name, value in row.items() if value and name != "robot"} for row in csv.DictReader(file)]


class Windings(unittest.TestCase):
    """Wahde 2016, Eqs. (1.1)-(1.7), for the robot of `windings`, which drives straight on."""

    R, L, C_E, C_T, C_C, C_V, G = 0.62, 0.01, 0.0333, 0.0333, 0.008, 1e-5, 2.0
    MASS, RADIUS, DAMPING, ROTOR, VOLTAGE = 3.0, 0.1, 2.0, 2e-5, 6.0

    def rates(self, speed, current):
        """(1.1) and (1.7), with the body's motion by (2.31), where the rotors' inertia is a part of the wheels' in (2.26)."""
        omega = self.G * speed / self.RADIUS
        torque = self.C_T * current
        friction = self.C_V * omega + min(self.C_C, torque) if omega < 1e-6 else self.C_V * omega + self.C_C
        gain = 1 / (self.RADIUS * (1 + 2 * self.G**2 * self.ROTOR / (self.MASS * self.RADIUS**2)))
        acceleration = (2 * gain * self.G * (torque - friction) - self.DAMPING * speed) / self.MASS
        return acceleration, (self.VOLTAGE - self.R * current - self.C_E * omega) / self.L

    def solved(self, seconds, step):
        """Speed and current after so long from rest: the midpoint rule, implicit, as for stiff equations, from when friction is overcome."""
        hold = self.C_C / self.C_T
        t = -self.L / self.R * math.log(1 - hold * self.R / self.VOLTAGE)
        speed, current = 1e-12, hold * (1 + 1e-12)
        count = max(1, round((seconds - t) / step))
        h = (seconds - t) / count
        for _ in range(count):
            next_speed, next_current = speed, current
            for _ in range(8):
                a, b = self.rates(max((speed + next_speed) / 2, 1e-6), (current + next_current) / 2)
                next_speed, next_current = speed + h * a, current + h * b
            speed, current = next_speed, next_current
        return speed, current

    def test_current_and_speed_are_those_of_the_equations(self):
        rows = table(SCENARIOS / "devices/windings.toml", "--brain", "constant:left=0.5,right=0.5", "--seconds", "1")
        times = [row["t_s"] for row in rows]
        # The command takes effect at the end of the first steps: the current of one step of 1 ms says when.
        start = next(i for i, row in enumerate(rows) if row["motors.left_current_a"] > 0) - 1
        for after in (0.002, 0.02, 0.1, 0.4, 0.9):
            i = next(i for i, t in enumerate(times) if t >= times[start] + after - 1e-9)
            speed, current = self.solved(times[i] - times[start], 2e-6)
            row = rows[i]
            self.assertAlmostEqual(row["motors.left_current_a"], current, delta=1e-6 * (1 + current))
            self.assertEqual(row["motors.left_current_a"], row["motors.right_current_a"])
            self.assertAlmostEqual(row["speed_m_s"], speed, delta=1e-6)


class Images(unittest.TestCase):
    """The pixels of a camera, each by a line of sight in three dimensions that is cut with every face of every thing."""

    COLUMNS, ROWS, RANGE, SKY, FLOOR = 12, 9, 30.0, (1, 2, 3), (4, 5, 6)

    def scene(self, dice):
        """A random scene: its things, the camera's pose, height and opening; and the scenario."""
        heading, height, opening = dice.uniform(-3, 3), dice.uniform(0.1, 1.2), dice.uniform(0.3, 2.4)
        things, texts = [], []
        while len(things) < 6:
            name = f"thing{len(things)}"
            x, y, size, top = dice.uniform(-5, 5), dice.uniform(-5, 5), dice.uniform(0.1, 1.5), dice.choice([0.05, 0.3, 0.8, 1.5, 4.0])
            if math.hypot(x, y) < size + 0.4:
                continue
            color = [10 + 10 * len(things), 20, 30]
            look = f"name = \"{name}\"\nheight_m = {top}\ncolor = {color}\n"
            if dice.random() < 0.4:
                things.append(("disc", (x, y, size), top, tuple(color)))
                texts.append(f"[[arena.circles]]\n{look}x_m = {x}\ny_m = {y}\nradius_m = {size}\n")
                continue
            angles = sorted(dice.uniform(0, 2 * math.pi) for _ in range(dice.randint(3, 6)))
            corners = [(x + size * math.cos(a), y + size * math.sin(a)) for a in angles]
            solid = dice.random() < 0.7
            things.append(("solid" if solid else "hollow", corners, top, tuple(color)))
            points = ", ".join(f"[{a}, {b}]" for a, b in corners)
            texts.append(f"[[arena.polygons]]\n{look}solid = {str(solid).lower()}\npoints_m = [{points}]\n")
        robot = f"""
            [[robots]]
            name = "robot"
            start = {{ heading_rad = {heading} }}
            body = {{ radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }}
            [robots.sensors.eye]
            kind = "camera"
            mount = {{}}
            height_m = {height}
            opening_rad = {opening}
            columns = {self.COLUMNS}
            rows = {self.ROWS}
            range_m = {self.RANGE}
            background = {list(self.SKY)}
            floor = {list(self.FLOOR)}
            port = {{ link = {{ kind = "ideal" }} }}
            """
        return things, heading, height, opening, "name = \"scene\"\n" + "".join(texts) + robot

    def hits(self, thing, eye, ray):
        """The distances, in lengths of the ray, at which a ray meets the sides and the top of a thing."""
        form, shape, top, _ = thing
        (x, y, z), (u, v, w) = eye, ray
        up = lambda t: t > 0 and 0 <= z + t * w <= top
        if form == "disc":
            cx, cy, radius = shape
            a, b, c = u * u + v * v, u * (x - cx) + v * (y - cy), (x - cx) ** 2 + (y - cy) ** 2 - radius**2
            root = b * b - a * c
            sides = [(-b + sign * math.sqrt(root)) / a for sign in (-1, 1)] if root > 0 else []
            over = lambda px, py: (px - cx) ** 2 + (py - cy) ** 2 < radius**2
        else:
            sides = []
            for (ax, ay), (bx, by) in zip(shape, shape[1:] + shape[:1]):
                ex, ey = bx - ax, by - ay
                cross = u * ey - v * ex
                if cross:
                    t, s = ((ax - x) * ey - (ay - y) * ex) / cross, ((ax - x) * v - (ay - y) * u) / cross
                    sides += [t] if 0 <= s <= 1 else []
            turns = lambda px, py: [(bx - ax) * (py - ay) - (by - ay) * (px - ax) for (ax, ay), (bx, by) in zip(shape, shape[1:] + shape[:1])]
            over = lambda px, py: form == "solid" and all(turn > 0 for turn in turns(px, py))
        flat = (top - z) / w if w else math.inf
        lid = [flat] if flat > 0 and math.isfinite(flat) and z > top and over(x + flat * u, y + flat * v) else []
        return [t for t in sides if up(t)] + lid

    def pixel(self, things, eye, ray):
        """The colour that a line of sight sees."""
        seen = [(t, color) for thing in things for t in self.hits(thing, eye, ray) for color in [thing[3]]]
        if ray[2] < 0:
            seen.append((-eye[2] / ray[2], self.FLOOR))
        t, color = min(seen, default=(math.inf, self.SKY))
        return color if t * math.hypot(ray[0], ray[1]) <= self.RANGE else self.SKY

    def test_a_hundred_random_scenes_pixel_by_pixel(self):
        dice = random.Random(1)
        kinds = set()
        with TemporaryDirectory() as folder:
            for number in range(100):
                things, heading, height, opening, text = self.scene(dice)
                path = Path(folder, "scene.toml")
                path.write_text(text)
                row = table(path, "--brain", "constant:left=0,right=0", "--seconds", "0.05")[-1]
                pitch = 2 * math.tan(opening / 2) / self.COLUMNS
                count = self.COLUMNS * self.ROWS
                for i in range(count):
                    right = pitch * (i % self.COLUMNS + 0.5 - self.COLUMNS / 2)
                    down = pitch * (i // self.COLUMNS + 0.5 - self.ROWS / 2)
                    ray = (math.cos(heading) + right * math.sin(heading), math.sin(heading) - right * math.cos(heading), -down)
                    expected = self.pixel(things, (0, 0, height), ray)
                    found = tuple(round(255 * row[f"eye.{channel}.{i}"]) for channel in ("red", "green", "blue"))
                    self.assertEqual(found, expected, f"scene {number}, pixel {i}:\n{text}")
                    kinds.add(expected)
        self.assertEqual(len(kinds), 8, "things, floor and sky")


if __name__ == "__main__":
    unittest.main()
