"""Recordings that the program made, as tables."""

import csv
import json
import math
import sys
import threading
import unittest
import warnings
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest import mock

import baudbot
from mcap.reader import make_reader
from mcap.writer import Writer
from server import WithServer
from server import baudbot as baudbot_program
from baudbot.v1 import recording_pb2


def record(path, *arguments):
    """A minute of `wander`; its summary. Every 2,000 ticks at least, a chunk of the file is complete."""
    run = ("run", "wander", "--seconds", "60", "--seed", "7", "--quiet", "--json", "--record", path)
    done = baudbot_program(*run, *arguments)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


class Recorded(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(TemporaryDirectory()))
        cls.path = cls.folder / "run.mcap"
        cls.summary = record(cls.path, "--csv", cls.folder / "run.csv")
        with (cls.folder / "run.csv").open() as file:
            cls.truth = {round(float(row["t_s"]) * 100): row for row in csv.DictReader(file)}

    def changed(self, name, change):
        """A file with other bytes."""
        path = self.folder / name
        path.write_bytes(change(self.path.read_bytes()))
        return path

    def test_it_says_what_was_run(self):
        recording = baudbot.open(str(self.path))
        self.assertEqual((recording.seed, recording.step_s, recording.robots), (7, 0.01, ["robot"]))
        self.assertEqual((recording.first_tick, recording.last_tick, recording.problem), (0, 6000, None))
        self.assertIn('name = "wander"', recording.scenario)
        self.assertIn("end.after_s=60.0", recording.overrides)
        self.assertEqual(recording.ending, "the run has ended: the scenario's time is over")
        events = list(recording.events())
        self.assertEqual([(event["t_s"], event["kind"]) for event in events], [(0.0, "brain"), (60.0, "ending")])

    def test_its_rows_are_the_truth_to_the_last_bit(self):
        rows = list(baudbot.open(self.path).rows())
        self.assertEqual(len(rows), 601)
        for row in rows:
            tick = round(row["t_s"] * 100)
            truth = self.truth[tick]
            for column in ("x_m", "y_m", "heading_rad", "speed_m_s", "left_signal"):
                self.assertEqual(row[column], float(truth[column]), (row["t_s"], column))
            # The table has what is sampled at the very instant, which is not there yet when a frame is made.
            if tick > 0:
                self.assertEqual(row["ir_front"], float(self.truth[tick - 1]["ir_front"]), row["t_s"])
            else:
                self.assertTrue(math.isnan(row["ir_front"]), row)

    def test_readings_are_samples_of_some_time_ago_in_steps_of_eight_bits(self):
        rows = list(baudbot.open(self.path).readings("robot", "ir_front"))
        self.assertEqual(list(rows[0]), ["t_s", "robot", "sampled_at_s", "age_s", "readable", "ir_front"])
        self.assertEqual(len(rows), 600)
        for row in rows:
            self.assertAlmostEqual(row["t_s"] - row["sampled_at_s"], row["age_s"])
            self.assertTrue(0.0 < row["age_s"] < 0.04, row)
            sample = float(self.truth[math.ceil(row["sampled_at_s"] * 100)]["ir_front"])
            self.assertLessEqual(abs(row["ir_front"] - sample), 0.5 / 255 + 1e-12, row)

    def test_cycles_end_with_those_of_the_summary(self):
        (robot,) = self.summary["robots"]
        last = list(baudbot.open(self.path).cycles())[-1]
        for name in ("kept", "late", "unanswered"):
            self.assertEqual(last[name], robot["cycles"][name])
        self.assertEqual((last["t_s"], last["deadline_s"]), (60.0, 0.01))
        self.assertGreater(last["p50_s"], 0.02)

    def test_tables_are_read_by_pandas(self):
        import pandas

        recording = baudbot.open(self.path)
        readings = pandas.DataFrame(recording.readings("robot", "ir_front"))
        both = pandas.DataFrame(recording.rows()).merge(readings, on=["t_s", "robot"], suffixes=("", "_reading"))
        self.assertEqual(len(both), 600)
        self.assertEqual(both.ir_front_reading.dtype, float)

    def test_of_a_file_that_is_cut_off_what_is_there_is_read(self):
        path = self.changed("cut.mcap", lambda data: data[: len(data) * 3 // 5])
        with self.assertWarnsRegex(UserWarning, "cut.mcap: the file is cut off or damaged at byte .* up to tick"):
            recording = baudbot.open(path)
        self.assertRegex(recording.problem, "^the file is cut off or damaged at byte [0-9]+$")
        self.assertIsNone(recording.ending)
        rows, whole = list(recording.rows()), list(baudbot.open(self.path).rows())
        self.assertTrue(0 < len(rows) < len(whole), len(rows))
        # As text, as what has not been sampled is not a number, which equals nothing.
        self.assertEqual(repr(rows), repr(whole[: len(rows)]))
        self.assertLessEqual(rows[-1]["t_s"], recording.last_tick * recording.step_s)

    def test_of_a_file_that_is_damaged_the_rest_is_read(self):
        with self.path.open("rb") as file:
            chunks = make_reader(file).get_summary().chunk_indexes
        chunk = max(chunks, key=lambda chunk: chunk.message_end_time - chunk.message_start_time)
        at = chunk.chunk_start_offset + chunk.chunk_length - 1
        path = self.changed("flip.mcap", lambda data: data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :])
        with self.assertWarnsRegex(UserWarning, f"flip.mcap: the file is damaged at byte {chunk.chunk_start_offset};"):
            recording = baudbot.open(path)
        start_s, end_s = chunk.message_start_time / 1e9, chunk.message_end_time / 1e9
        whole, left = ({row["t_s"] for row in one.rows()} for one in (baudbot.open(self.path), recording))
        self.assertTrue(left < whole and len(left) > 100, len(left))
        self.assertTrue(all(start_s <= t_s <= end_s for t_s in whole - left), whole - left)

    def test_what_is_no_recording_is_refused_with_the_reason(self):
        foreign = self.folder / "foreign.mcap"
        with foreign.open("wb") as file:
            writer = Writer(file)
            writer.start()
            channel = writer.register_channel("/chatter", "json", 0)
            writer.add_message(channel, 0, b"{}", 0)
            writer.finish()
        with (self.folder / "newer.mcap").open("wb") as file:
            writer = Writer(file)
            writer.start()
            header = recording_pb2.RecordingHeader(format=9, program_version="8.0.0")
            channel = writer.register_channel("/baudbot/header", "protobuf", 0)
            writer.add_message(channel, 0, header.SerializeToString(), 0)
            writer.finish()
        (self.folder / "text.mcap").write_text("t_s,robot,x_m,y_m\n")
        (self.folder / "empty.mcap").write_bytes(b"")
        self.changed("tiny.mcap", lambda data: data[:300])
        for name, kind, text in [
            ("absent.mcap", baudbot.NotFound, "absent.mcap: there is no such file"),
            (".", baudbot.Error, "cannot be read: Is a directory"),
            ("text.mcap", baudbot.NotARecording, "text.mcap: is not an MCAP file"),
            ("empty.mcap", baudbot.NotARecording, "empty.mcap: is not an MCAP file"),
            ("foreign.mcap", baudbot.NotARecording, "is an MCAP file, but not a recording of baudbot"),
            ("newer.mcap", baudbot.NotARecording, "is of format 9, which baudbot 8.0.0 wrote"),
            ("tiny.mcap", baudbot.NotARecording, "cut off or damaged at byte .*, and the header with the scenario is missing"),
        ]:
            with self.subTest(name), self.assertRaisesRegex(kind, text):
                baudbot.open(self.folder / name)

    def test_names_that_are_not_there_are_told_with_those_that_may_be_meant(self):
        recording = baudbot.open(self.path)
        with self.assertRaisesRegex(baudbot.NotFound, "there is no robot `robt`; did you mean `robot`"):
            recording.readings("robt", "ir_front")
        with self.assertRaisesRegex(baudbot.NotFound, "there is no sensor `ir_frnt` of robot `robot`; did you mean `ir_front`"):
            recording.readings("robot", "ir_frnt")

    def test_without_frames_there_are_no_tables_but_all_else(self):
        path = self.folder / "bare.mcap"
        record(path, "--record-hz", "0")
        recording = baudbot.open(path)
        self.assertEqual((recording.last_tick, recording.problem, len(list(recording.events()))), (6000, None, 2))
        for table in (recording.rows, recording.cycles, recording.frames, lambda: recording.readings("robot", "ir_front")):
            with self.assertRaisesRegex(baudbot.Error, "has no frames.*--record-hz 0.*baudbot export .*bare.mcap --csv"):
                table()

    def test_without_the_package_mcap_it_is_named(self):
        absent = {"mcap": None, "mcap.exceptions": None, "baudbot.mcap_file": None}
        with mock.patch.dict(sys.modules, absent), self.assertRaisesRegex(baudbot.Error, "pip install mcap"):
            baudbot.open(self.path)


class Killed(WithServer):
    def test_the_recording_of_a_killed_server_is_read_up_to_its_last_mark(self):
        folder, far = self.folder(), threading.Event()
        path = Path(folder, "run.mcap")
        server = self.serve("wander", "--pace", "lockstep", "--set", "collision=stop-robot", "--record", path)

        class Drives(baudbot.Brain):
            def step(self, turn):
                if turn.tick > 3000:  # a mark is due after 2,000 ticks
                    far.set()
                return baudbot.drive(0.3, 0.2)

        def drive():
            try:
                baudbot.attach(Drives, connect=server.tcp, reconnect_s=0.0)
            except baudbot.Error:
                pass

        thread = threading.Thread(target=drive)
        thread.start()
        self.assertTrue(far.wait(60))
        # What is written is in the file a moment later; the world runs on meanwhile.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            deadline = threading.Event()
            for _ in range(600):
                if path.exists() and _last_tick(path) >= 2000:
                    break
                deadline.wait(0.1)
        server.kill()
        thread.join(60)
        with self.assertWarnsRegex(UserWarning, "cut off"):
            recording = baudbot.open(path)
        self.assertGreaterEqual(recording.last_tick, 2000)
        self.assertGreaterEqual(len(list(recording.rows())), 200)


def _last_tick(path):
    try:
        return baudbot.open(path).last_tick
    except baudbot.NotARecording:
        return 0


if __name__ == "__main__":
    unittest.main(verbosity=2)
