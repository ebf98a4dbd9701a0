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


class Elevations(unittest.TestCase):
    """§3.2.3: rays that rise or fall, by going along them in steps until they are in something."""

    STEP, RANGE, RAYS = 0.002, 4.5, 8

    def scene(self, dice):
        """Random things with a lower and an upper edge, a robot with a mast, and eight sonars; and the scenario."""
        texts, things = [], []

        def heights():
            lower = dice.choice([0.0, dice.uniform(0.05, 0.8)])
            upper = lower + dice.uniform(0.05, 0.8)
            return lower, upper, f"height_m = {upper}\n" + (f"lower_edge_m = {lower}\n" if lower else "")

        def place(size):
            far, angle = dice.uniform(size + 0.3, 2.5), dice.uniform(-math.pi, math.pi)
            return far * math.cos(angle), far * math.sin(angle)

        for number in range(5):
            size = dice.uniform(0.05, 0.5)
            (x, y), (lower, upper, look) = place(1.5 * size), heights()
            if dice.random() < 0.5:
                things.append((lambda px, py, x=x, y=y, r=size: (px - x) ** 2 + (py - y) ** 2 <= r * r, lower, upper))
                texts.append(f"[[arena.circles]]\nname = \"disc{number}\"\nx_m = {x}\ny_m = {y}\nradius_m = {size}\n{look}")
            else:
                things.append((lambda px, py, x=x, y=y, r=size: max(abs(px - x), abs(py - y)) <= r, lower, upper))
                corners = [[x - size, y - size], [x + size, y - size], [x + size, y + size], [x - size, y + size]]
                texts.append(f"[[arena.polygons]]\nname = \"box{number}\"\npoints_m = {corners}\n{look}")
        rays = [(dice.uniform(-math.pi, math.pi), dice.uniform(-1.2, 1.2), dice.uniform(0.0, 1.2)) for _ in range(self.RAYS)]
        texts.append(f"[[robots]]\nname = \"looks\"\n{self.BODY}")
        for number, (heading, elevation, height) in enumerate(rays):
            texts.append(
                f"[robots.sensors.s{number}]\nkind = \"sonar\"\nmount = {{ heading_rad = {heading} }}\nheight_m = {height}\n"
                f"elevation_rad = {elevation}\nopening_rad = 0.0\nrays = 1\nmin_m = 0.0\nmax_m = {self.RANGE}\nperiod_ms = 10.0\n"
            )
        # In nothing's way: the mast alone is high, and stands where the first ray goes.
        heading = rays[0][0]
        x, y = 4.0 * math.cos(heading), 4.0 * math.sin(heading)
        mast = (x - 0.6 * math.cos(heading), y - 0.6 * math.sin(heading))
        things.append((lambda px, py: (px - mast[0]) ** 2 + (py - mast[1]) ** 2 <= 0.15**2, 0.1, 1.5))
        things.append((lambda px, py: (px - x) ** 2 + (py - y) ** 2 <= 0.4**2, 0.0, 0.1))
        body = self.BODY.replace("radius_m = 0.2", "radius_m = 0.4, height_m = 0.1, parts = [{ x_m = -0.6, radius_m = 0.15, lower_edge_m = 0.1, height_m = 1.5 }]")
        texts.append(f"[[robots]]\nname = \"stands\"\nstart = {{ x_m = {x}, y_m = {y}, heading_rad = {heading} }}\n{body}")
        return things, rays, "name = \"scene\"\nnoise = false\n" + "".join(texts)

    BODY = "body = { radius_m = 0.2, mass_kg = 3.0, inertia_kg_m2 = 0.2, wheel_radius_m = 0.1 }\n"

    def length(self, things, heading, elevation, height):
        """How far a ray from the middle gets."""
        u, v, w = math.cos(elevation) * math.cos(heading), math.cos(elevation) * math.sin(heading), math.sin(elevation)
        for i in range(round(self.RANGE / self.STEP) + 1):
            t = i * self.STEP
            x, y, z = t * u, t * v, height + t * w
            if z < 0 or any(lower <= z <= upper and inside(x, y) for inside, lower, upper in things):
                return t
        return self.RANGE

    def test_a_hundred_random_scenes_ray_by_ray(self):
        dice = random.Random(2)
        met = 0
        with TemporaryDirectory() as folder:
            for number in range(100):
                things, rays, text = self.scene(dice)
                path = Path(folder, "scene.toml")
                path.write_text(text)
                rows = table(path, "--brain", "constant:left=0,right=0", "--seconds", "0.3")
                row = [row for row in rows if "s7" in row][-1]
                for i, ray in enumerate(rays):
                    expected = self.length(things, *ray)
                    met += expected < self.RANGE
                    self.assertAlmostEqual(row[f"s{i}"], expected, delta=1.5 * self.STEP, msg=f"scene {number}, ray {i}:\n{text}")
        self.assertGreater(met, 400)


if __name__ == "__main__":
    unittest.main()
