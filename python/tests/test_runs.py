"""Sweeps and tunings: the tables of the program, with the same journals."""

from __future__ import annotations

import _thread
import subprocess
import tempfile
import threading
import unittest
from pathlib import Path

import baudbot
from common import PROGRAM

EXPERIMENT = """
name = "baud"
scenario = "wander"
brain = "avoid"
seconds = 5.0
seeds = 6

[[fields]]
field = "robots.robot.link.baud"
label = "baud"
values = [2400, 9600]
"""


TUNE = """
[tune]
method = "ga"
maximize = { distance_m = 1.0 }
generations = 2
population = 4
check_seeds = 2
"""


class Sweeps(unittest.TestCase):
    def setUp(self) -> None:
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = Path(place.name)
        self.experiment = self.folder / "baud.toml"
        self.experiment.write_text(EXPERIMENT)

    def test_a_table_is_that_of_the_program(self) -> None:
        told: list[tuple[int, int]] = []
        here = self.folder / "here"
        frame = baudbot.sweep(self.experiment, out=here, progress=lambda done, total: told.append((done, total)))
        there = self.folder / "there"
        subprocess.run([PROGRAM, "sweep", self.experiment, "--out", there, "--quiet", "--yes"], check=True)
        for name in ("rows.csv", "summary.txt"):
            self.assertEqual((here / name).read_bytes(), (there / name).read_bytes())
        self.assertEqual(len(frame), 12)
        self.assertEqual(sorted(frame["baud"].unique()), [2400, 9600])
        self.assertTrue(all(len(hash) == 16 for hash in frame["state_hash"]))
        self.assertEqual(told[-1][1], 12)
        self.assertIn("<table", baudbot.runs(self.experiment, out=here)._repr_html_())

    def test_one_goes_on_where_the_other_was_stopped(self) -> None:
        long = self.folder / "long.toml"
        long.write_text(EXPERIMENT.replace("seconds = 5.0", "seconds = 300.0").replace("seeds = 6", "seeds = 40"))
        out = self.folder / "out"
        threading.Timer(1.0, _thread.interrupt_main).start()
        with self.assertRaises(KeyboardInterrupt):
            baudbot.sweep(long, out=out)
        done = (out / "rows.jsonl").read_text().count('"ending"')
        self.assertTrue(0 < done < 80, done)
        before = (out / "rows.jsonl").read_text()
        subprocess.run([PROGRAM, "sweep", long, "--out", out, "--yes", "--quiet"], check=True)
        self.assertTrue((out / "rows.jsonl").read_text().startswith(before))
        self.assertEqual(len(baudbot.sweep(long, out=out)), 80)

    def test_what_is_wrong_is_named(self) -> None:
        with self.assertRaisesRegex(baudbot.Error, "nothing.toml"):
            baudbot.sweep(self.folder / "nothing.toml")
        bad = self.folder / "bad.toml"
        bad.write_text(EXPERIMENT.replace("link.baud", "link.bawd"))
        with self.assertRaisesRegex(baudbot.Invalid, "bawd"):
            baudbot.sweep(bad, out=self.folder / "bad")
        with self.assertRaisesRegex(baudbot.Invalid, "jobs"):
            baudbot.sweep(self.experiment, jobs=0)
        with self.assertRaisesRegex(baudbot.Invalid, "seeds"):
            baudbot.sweep(self.experiment, seeds="many")


class Tunings(unittest.TestCase):
    def test_the_best_and_all_candidates(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            experiment = Path(folder) / "small.toml"
            experiment.write_text(EXPERIMENT.replace("values = [2400, 9600]", "from = 1200.0\nto = 9600.0\nwhole = true") + TUNE)
            told = baudbot.tune(experiment, out=Path(folder) / "out")
            self.assertGreaterEqual(told["best"]["outcome"]["score"], told["untuned"]["score"] or 0.0)
            self.assertEqual(len(told["frame"]), told["candidates"] + 1)


if __name__ == "__main__":
    unittest.main()
