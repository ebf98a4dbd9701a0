"""Sweeps and tunings: the tables of the program, with the same journals."""

from __future__ import annotations

import _thread
import json
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import baudbot
import polars
import pyarrow
from baudbot import _native
from common import PROGRAM, ROOT

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

    def test_runs_that_failed_are_told_of(self) -> None:
        self.experiment.write_text(EXPERIMENT.replace("[2400, 9600]", '[9600, "x"]').replace("seeds = 6", "seeds = 2"))
        with self.assertWarnsRegex(UserWarning, r"2 of 4 runs failed, and their rows have no numbers: run 2: .*baud"):
            frame = baudbot.sweep(self.experiment, out=self.folder / "out")
        self.assertEqual(int(frame["distance_m"].isna().sum()), 2)

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


    def test_more_runs_than_an_experiment_can_have_are_refused_at_once(self) -> None:
        tune = self.folder / "tune.toml"
        tune.write_text(EXPERIMENT.replace("values = [2400, 9600]", "from = 1200.0\nto = 9600.0\nwhole = true") + TUNE)
        for call in (lambda: baudbot.sweep(self.experiment, seeds="1..99999999999"), lambda: baudbot.tune(tune, seeds=10**12)):
            with self.assertRaisesRegex(baudbot.Invalid, r"seeds: make \d+ runs, and an experiment has at most 10000000") as caught:
                call()
            self.assertEqual(caught.exception.path, "seeds")
        sweep = [PROGRAM, "sweep", self.experiment, "--seeds", "1..99999999999", "--yes"]
        done = subprocess.run(sweep, capture_output=True, text=True, timeout=60, cwd=self.folder)
        self.assertEqual(done.returncode, 2)
        self.assertIn("seeds: make 199999999998 runs", done.stderr)

    def test_a_run_that_takes_for_ever_is_left_by_a_second_ctrl_c(self) -> None:
        endless = self.folder / "endless.toml"
        endless.write_text(EXPERIMENT.replace("seconds = 5.0", "seconds = 1e8"))
        code = f"import baudbot; baudbot.sweep({str(endless)!r}, out={str(self.folder / 'endless')!r}, jobs=1)"
        asked = subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True)
        for _ in range(2):
            time.sleep(3.0)
            asked.send_signal(signal.SIGINT)
        _, told = asked.communicate(timeout=30)
        self.assertIn("KeyboardInterrupt", told)

    def test_tables_by_arrow(self) -> None:
        runs = baudbot.runs(self.experiment, out=self.folder / "arrow")
        table, frame = pyarrow.table(runs), runs.frame()
        self.assertEqual(table.column_names, list(frame.columns))
        self.assertEqual(str(table.schema.field("run").type), "int64")
        for name in ("run", "seed", "baud", "distance_m", "state_hash", "ending"):
            self.assertEqual(table[name].to_pylist(), frame[name].to_list())
        self.assertEqual(table["goal_time_s"].null_count, 12)
        again = polars.DataFrame(runs)
        self.assertEqual(again["state_hash"].to_list(), frame["state_hash"].to_list())
        with self.assertRaisesRegex(baudbot.Error, "rows.parquet"):
            pyarrow.table(baudbot.Runs(self.folder, "{}"))

    def test_recordings_by_arrow(self) -> None:
        file = self.folder / "run.mcap"
        subprocess.run([PROGRAM, "run", "wander", "--seconds", "3", "--record", file, "--quiet"], check=True)
        recording = baudbot.open(file)
        table, rows = pyarrow.table(recording), list(recording.rows())
        self.assertEqual(table.to_pylist()[-1], rows[-1])
        self.assertEqual(table.num_rows, len(rows))
        self.assertEqual(str(table.schema.field("robot").type), "string")
        readings = polars.DataFrame(recording.readings("robot", "ir_front"))
        self.assertEqual(readings["ir_front"].to_list(), [row["ir_front"] for row in recording.readings("robot", "ir_front")])
        self.assertEqual(pyarrow.table(recording.events())["kind"].to_pylist(), [row["kind"] for row in recording.events()])


class Packed(unittest.TestCase):
    """What `baudbot.ray` sends to other machines."""

    def test_programs_of_microcontrollers_are_in_it(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            shutil.copy(ROOT / "catalogue/scenarios/firmware/wander.hex", folder / "own.hex")
            # A jump to itself.
            (folder / "idle.hex").write_text(":02000000FFCF30\n:00000001FF\n")
            varied = EXPERIMENT.replace("robots.robot.link.baud", "robots.robot.microcontroller.program").replace('brain = "avoid"', 'brain = "none"')
            varied = varied.replace("[2400, 9600]", '["own.hex", "idle.hex"]').replace('"wander"', f'"{ROOT}/catalogue/scenarios/firmware.toml"')
            file = folder / "varied.toml"
            file.write_text(varied.replace("seeds = 6", "seeds = 1"))
            frame = baudbot.sweep(file, out=folder / "here")
            self.assertEqual((frame["distance_m"] > 0.1).to_list(), [True, False])
            packed, runs = _native.pack(file, None, None)
            self.assertEqual(runs, 2)
            for program in folder.glob("*.hex"):
                program.unlink()
            _native.sweep(packed, folder / "there", None, 1, False, None, None)
            self.assertEqual((folder / "here/rows.csv").read_bytes(), (folder / "there/rows.csv").read_bytes())

    def test_a_search_in_shards_is_that_of_one_machine(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            file = folder / "near.toml"
            file.write_text(EXPERIMENT + '[require]\nalways = "clearance_m > 0.1"\n[worst]\nmethod = "random"\n')
            packed, runs = _native.pack(file, None, 12)
            for shard in range(2):
                _native.worst(packed, folder / f"shards/{shard}", None, 1, False, None, runs, None, False, f"{shard}/2")
            merged = _native.merge_worst(packed, [folder / "shards"], folder / "merged", None, False, runs)
            self.assertEqual(json.loads(merged[0]), baudbot.worst(file, out=folder / "here", runs=12))
            self.assertEqual((folder / "merged/summary.txt").read_bytes(), (folder / "here/summary.txt").read_bytes())
            file.write_text(file.read_text().replace('"random"', '"cma-es"'))
            with self.assertRaisesRegex(baudbot.Invalid, "only the method `random` has shards|needs"):
                _native.pack(file, None, 12)

    def test_brains_that_others_do_not_have_are_refused(self) -> None:
        with tempfile.TemporaryDirectory() as name:
            file = Path(name) / "own.toml"
            for brain, words in (('{ exec = "python3 own.py" }', "brain.exec: `python3 own.py` is a program"), (f'"{__file__}"', "brain: .* is a file")):
                file.write_text(EXPERIMENT.replace('"avoid"', brain))
                with self.assertRaisesRegex(baudbot.Invalid, f"{words}.*, which other machines do not have; copy it there"):
                    _native.pack(file, None, None)


class Tunings(unittest.TestCase):
    def test_the_best_and_all_candidates(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            experiment = Path(folder) / "small.toml"
            experiment.write_text(EXPERIMENT.replace("values = [2400, 9600]", "from = 1200.0\nto = 9600.0\nwhole = true") + TUNE)
            told = baudbot.tune(experiment, out=Path(folder) / "out")
            self.assertGreaterEqual(told["best"]["outcome"]["score"], told["untuned"]["score"] or 0.0)
            self.assertEqual(len(told["frame"]), told["candidates"] + 1)


class Searches(unittest.TestCase):
    def test_the_worst_run_costs_what_it_is_told_to(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            experiment = Path(folder) / "near.toml"
            ranges = EXPERIMENT.replace("values = [2400, 9600]", "from = 1200.0\nto = 9600.0\nwhole = true")
            experiment.write_text(ranges + "[require]\nalways = \"clearance_m > 0.3\"\n")
            told = baudbot.worst(experiment, out=Path(folder) / "out", runs=20)
            self.assertEqual(told["runs"], 20)
            run = told["worst"][0]
            cost = baudbot.cost(experiment, {"baud": float(run["values"]["baud"])}, seed=run["seed"])
            self.assertEqual((cost["robustness"], cost["state_hash"]), (run["robustness"], run["state_hash"]))
            self.assertTrue((Path(folder) / "out" / "worst.toml").exists())
            with self.assertRaisesRegex(baudbot.Invalid, "values.baud: must be from 1200 to 9600, is 3"):
                baudbot.cost(experiment, {"baud": 3.0})
            with self.assertRaisesRegex(baudbot.Invalid, "there is no field `bauds`; there is only `baud`"):
                baudbot.cost(experiment, {"bauds": 2400.0})


if __name__ == "__main__":
    unittest.main()
