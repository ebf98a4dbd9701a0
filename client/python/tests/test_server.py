"""Brains, operators and observers against a real server, as people use them."""

import asyncio
import json
import os
import subprocess
import sys
import threading
import unittest
from pathlib import Path
from tempfile import TemporaryDirectory

import baudbot
from server import ROOT, Server, WithServer
from server import baudbot as baudbot_program
from baudbot.v1 import control_pb2, world_pb2

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
sys.path.insert(0, str(EXAMPLES))
from avoid import Avoid  # noqa: E402

TEN_SECONDS = ("--pace", "lockstep", "--set", "end.after_s=10.0")


def program(*arguments, **environment):
    command = [sys.executable, EXAMPLES / "avoid.py", *arguments]
    options = {"capture_output": True, "text": True, "timeout": 120}
    return subprocess.run(command, env=os.environ | environment, **options)


class Drives(WithServer):
    def run_of(self, drive):
        server = self.serve("wander", *TEN_SECONDS)
        drive(server)
        with baudbot.Client(server.tcp) as client:
            status = client.world().status
            (robot,) = status.robots
            self.assertEqual((status.tick, robot.collisions), (1000, 0))
            self.assertGreater(robot.distance_m, 1.0)
            self.assertGreater(robot.commands, 400)
            return client.world().hash

    def test_the_same_run_over_tcp_a_unix_socket_and_with_asyncio(self):
        hashes = {
            self.run_of(lambda server: baudbot.attach(Avoid, connect=server.tcp)),
            self.run_of(lambda server: baudbot.attach(Avoid, connect=server.unix, world="wander", robots="rob*")),
            self.run_of(lambda server: asyncio.run(baudbot.aio.attach(Avoid, connect=server.unix))),
            self.run_of(lambda server: self.assertEqual(program("--connect", server.tcp).stderr, "driving robot of world wander\n")),
            self.run_of(lambda server: self.assertEqual(program(BAUDBOT_CONNECT=server.unix).returncode, 0)),
        }
        self.assertEqual(len(hashes), 1, hashes)

    def test_refusals_are_one_line(self):
        server = self.serve("wander", *TEN_SECONDS)
        for arguments, text in [
            (("--connect", server.tcp, "--world", "wandr"), "there is no world `wandr`; did you mean `wander`?"),
            (("--connect", server.tcp, "--robot", "nobody"), "there is no robot `nobody` in world `wander`"),
            (("--connect", server.tcp, "--turn-at", "x"), "parameter `turn_at` of Avoid must be a number, is 'x'"),
            (("--connect", "127.0.0.1:1"), "no server answers at 127.0.0.1:1"),
        ]:
            done = program(*arguments)
            self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
            self.assertIn(text, done.stderr)

    def test_a_robot_that_another_brain_holds_is_taken(self):
        server = self.serve("wander", "--pace", "lockstep", "--paused")
        held = threading.Event()

        class Holds(Avoid):
            def start(self):
                super().start()
                held.set()

        threading.Thread(target=lambda: _ended(Holds, server.tcp), daemon=True).start()
        self.assertTrue(held.wait(30))
        with self.assertRaises(baudbot.Taken):
            baudbot.attach(Avoid, connect=server.tcp)
        server.kill()


def _ended(brain, address, **where):
    """Drives until it ends, whatever the reason."""
    try:
        baudbot.attach(brain, connect=address, reconnect_s=0.0, **where)
    except baudbot.Error:
        pass


class ComesBack(WithServer):
    def test_a_brain_comes_back_to_a_server_that_is_started_again(self):
        folder, told = self.folder(), []
        first = self.serve("wander", "--pace", "lockstep", folder=folder)
        driving = threading.Event()

        class Signals(Avoid):
            def step(self, turn):
                driving.set()
                return super().step(turn)

        ended = []
        thread = threading.Thread(
            target=lambda: ended.append(baudbot.attach(Signals, connect=first.unix, reconnect_s=60.0, tell=told.append))
        )
        thread.start()
        self.assertTrue(driving.wait(30))
        first.kill()
        Path(folder, "baudbot.sock").unlink(missing_ok=True)
        self.serve("wander", *TEN_SECONDS, folder=folder)
        thread.join(90)
        self.assertFalse(thread.is_alive())
        self.assertEqual(ended[0].last_tick, 1000)
        self.assertIn("trying to reconnect for 60 s", told[0])
        self.assertEqual(told[1], "reconnected with a restarted brain: driving robot of world wander")

    def test_an_operator_can_restart_a_brain(self):
        server, told, made = self.serve("wander", *TEN_SECONDS), [], []

        class Counts(Avoid):
            def start(self):
                super().start()
                made.append(self)

            def step(self, turn):
                if len(made) == 1 and turn.tick == 100:
                    restart()
                return super().step(turn)

        def restart():
            with baudbot.Client(server.tcp) as client:
                client.world().detach_brain("robot", restart=True)

        summary = baudbot.attach(Counts, connect=server.tcp, tell=told.append)
        self.assertEqual((summary.last_tick, len(made)), (1000, 2))
        self.assertEqual(told, ["the operator has restarted the brain of robot"])


class Raw(WithServer):
    def test_a_raw_brain_reads_and_writes_bytes(self):
        server = self.serve("wander", *TEN_SECONDS)
        read = []

        class Listens(baudbot.RawBrain):
            def step(self, turn):
                read.append(turn.raw)
                return b"\x00" if len(read) == 1 else None

        baudbot.attach(Listens, connect=server.unix)
        with baudbot.Client(server.tcp) as client:
            robot = client.world().status.robots[0]
        self.assertGreater(sum(map(len, read)), 8000)
        self.assertEqual(robot.downlink.bytes, 1)


class Operates(WithServer):
    def test_worlds_are_made_stepped_and_deleted(self):
        server = self.serve("wander", "--paused")
        with baudbot.Client(server.unix) as client:
            world = client.create_world("wander", "slow", baud=2400, seed=7, pace="stepped", set={"end.after_s": 10.0})
            self.assertEqual([world.name for world in client.worlds()], ["slow", "wander"])
            self.assertEqual(world.description.robots[0].description.baud, 2400)
            held = threading.Event()

            class Holds(Avoid):
                def start(self):
                    super().start()
                    held.set()

            threading.Thread(target=lambda: _ended(Holds, server.unix, world="slow"), daemon=True).start()
            self.assertTrue(held.wait(30))
            self.assertEqual(world.step(100).tick, 100)
            start, snapshot = world.hash, world.snapshot()
            self.assertEqual(world.step(10**6).tick, 1000)
            self.assertEqual(world.wait(10.0).ending_kind, world_pb2.ENDING_KIND_TIME_IS_OVER)
            world.restore(snapshot)
            self.assertEqual(world.hash, start)
            world.delete()
            self.assertEqual([world.name for world in client.worlds()], ["wander"])
            with self.assertRaisesRegex(baudbot.NotFound, "did you mean `wander`"):
                client.world("wandr")
            with self.assertRaisesRegex(baudbot.Refused, "step_ms"):
                client.create_world("wander", step_ms=-1.0)

    def test_a_run_becomes_a_table(self):
        import pandas

        server = self.serve("wander", *TEN_SECONDS)
        with baudbot.Client(server.tcp) as client:
            # The world waits for its brain, and shows how it stands meanwhile.
            rows = client.world().rows(every_ticks=10)
            first = next(rows)
            threading.Thread(target=lambda: baudbot.attach(Avoid, connect=server.tcp)).start()
            table = pandas.DataFrame([first, *rows])
        self.assertEqual(list(table.columns[:5]), ["t_s", "robot", "x_m", "y_m", "heading_rad"])
        self.assertIn("ir_front", table.columns)
        self.assertGreater(table.x_m.max() - table.x_m.min(), 0.3)
        self.assertEqual(table.t_s.iloc[-1], 10.0)

    def test_what_has_no_method_is_called_by_the_contract(self):
        server = self.serve("wander", "--paused")
        with baudbot.Client(server.tcp) as client:
            saved = client.call(client.control.SaveWorld, control_pb2.SaveWorldRequest(world="wander"))
            self.assertGreater(len(saved.saved_mcap), 1000)


class WithPrograms(unittest.TestCase):
    # The interpreter that has the package is the one that `python3` means.
    ENVIRONMENT = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}

    def good(self, *arguments):
        done = baudbot_program(*arguments, env=self.ENVIRONMENT, cwd=ROOT)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout


class Programs(WithPrograms):
    """Programs that `baudbot run` and `baudbot sweep` start."""

    def test_a_run_and_an_attached_program_are_the_same(self):
        run = ("run", "wander", "--seconds", "10", "--quiet", "--json", "--brain")
        summary = json.loads(self.good(*run, f"exec:python3 {EXAMPLES}/avoid.py"))
        with TemporaryDirectory() as folder:
            server = Server(folder, "wander", *TEN_SECONDS)
            baudbot.attach(Avoid, connect=server.unix)
            with baudbot.Client(server.unix) as client:
                self.assertEqual(client.world().hash, summary["state_hash"])
            server.kill()

    def test_a_traceback_is_told_with_the_program(self):
        with TemporaryDirectory() as folder:
            bad = Path(folder, "bad.py")
            bad.write_text("import baudbot\nclass Bad(baudbot.Brain):\n  def step(self, turn): return 1 / 0\nbaudbot.attach(Bad)\n")
            done = baudbot_program("run", "wander", "--brain", f"exec:python3 {bad}", env=self.ENVIRONMENT)
        self.assertEqual(done.returncode, 1)
        self.assertIn("exited with code 1 before the run was over; it printed", done.stderr)
        self.assertIn("ZeroDivisionError", done.stderr)

    def test_an_experiment_sweeps_a_program_and_its_table_is_read(self):
        import pandas

        with TemporaryDirectory() as folder:
            self.good("sweep", "catalogue/experiments/follow.toml", "--seeds", "1", "--out", f"{folder}/out", "--quiet")
            rows = pandas.read_csv(f"{folder}/out/rows.csv")
        self.assertEqual(len(rows), 20)
        self.assertTrue(rows.error.isna().all())
        fast = rows[rows.speed == 0.4].set_index("baud")
        self.assertEqual((fast.success[9600], fast.success[600]), (True, False))


class ManyRuns(WithPrograms):
    """Processes that do run after run, as `reuse = true` in an experiment asks for."""

    def sweep(self, program, reuse, *, seeds=24):
        """The rows of a sweep by one worker, and what went wrong."""
        import pandas

        with TemporaryDirectory() as folder:
            Path(folder, "brain.py").write_text(program)
            Path(folder, "sweep.toml").write_text(
                f'scenario = "wander"\nseconds = 3.0\nseeds = {seeds}\n'
                f'[brain]\nexec = "python3 brain.py"\nreuse = {str(reuse).lower()}\n'
                '[[fields]]\nfield = "brain.speed"\nvalues = [0.3, 0.5]\n'
            )
            command = ("sweep", f"{folder}/sweep.toml", "--out", f"{folder}/out", "--jobs", "1", "--quiet")
            done = baudbot_program(*command, env=self.ENVIRONMENT)
            processes = Path(folder, "started").read_text().split() if Path(folder, "started").exists() else []
            table = Path(folder, "out", "rows.csv")
            rows = pandas.read_csv(table) if table.exists() else None
        return rows, processes, done.stderr

    def test_the_runs_are_those_of_fresh_processes(self):
        program = (
            "import os, sys\n"
            f"sys.path.insert(0, {str(EXAMPLES)!r})\n"
            "open('started', 'a').write(f'{os.getpid()}\\n')\n"
            "import baudbot, follow\n"
            "baudbot.main(follow.Follow)\n"
        )
        fresh, started, said = self.sweep(program, False)
        self.assertEqual(len(started), 48, said)
        reused, started, said = self.sweep(program, True)
        # One for all runs, the first too, by which the length of the sweep is estimated; and one for each of its runs that are
        # done again: the second, the 22nd, the 42nd and the last.
        self.assertEqual(len(started), 5, said)
        self.assertEqual(list(fresh.state_hash), list(reused.state_hash))
        self.assertEqual(len(set(reused.state_hash)), 48)

    def test_what_is_kept_from_run_to_run_is_found(self):
        program = (
            "import baudbot\n"
            "turns = 0\n"
            "class Leaks(baudbot.Brain):\n"
            "  speed = 0.5\n"
            "  def step(self, turn):\n"
            "    global turns\n"
            "    turns += 1\n"
            "    return baudbot.drive(self.speed, self.speed if turns < 100 else 0.0)\n"
            "baudbot.main(Leaks)\n"
        )
        rows, _, said = self.sweep(program, True)
        self.assertIsNone(rows)
        self.assertRegex(said, "run 1 with seed 2 ends with the state .*; done again by a new process it ends with")
        self.assertIn("keeps state from one run to the next", said)

    def test_what_gathers_over_many_runs_is_found_in_the_last(self):
        program = (
            "import baudbot\n"
            "runs = 0\n"
            "class Leaks(baudbot.Brain):\n"
            "  speed = 0.5\n"
            "  def start(self):\n"
            "    global runs\n"
            "    runs += 1\n"
            "  def step(self, turn):\n"
            "    return baudbot.drive(self.speed, self.speed if runs < 5 else 0.0)\n"
            "baudbot.main(Leaks)\n"
        )
        rows, _, said = self.sweep(program, True, seeds=4)
        self.assertIsNone(rows)
        self.assertIn("run 7 with seed 4 ends with the state", said)

    def test_a_program_for_one_run_is_told_so(self):
        program = "import baudbot\nfrom avoid import Avoid\nAvoid.speed = 0.4\nbaudbot.attach(Avoid)\n"
        rows, _, said = self.sweep(f"import sys\nsys.path.insert(0, {str(EXAMPLES)!r})\n{program}", True, seeds=2)
        self.assertIsNone(rows)
        self.assertIn("exited with code 0 after a run; for many runs it reads the next one", said)


class Publishes(WithServer):
    def test_observers_see_what_a_brain_believes(self):
        server = self.serve("wander", *TEN_SECONDS)

        class Believes(Avoid):
            def belief(self):
                return baudbot.Belief(state="turning" if self.spin else "driving", pose=(0.5, 0.25, 0.0))

        with baudbot.Client(server.tcp) as client:
            world = client.world()
            frames = world.watch(every_ticks=1)
            seen = [next(frames)]
            threading.Thread(target=lambda: baudbot.attach(Believes, connect=server.tcp)).start()
            seen.extend(frames)
        believed = [note.belief for frame in seen for note in frame.annotations]
        self.assertGreater(len(believed), 10)
        self.assertEqual(believed[0].pose.x_m, 0.5)


if __name__ == "__main__":
    unittest.main(verbosity=2)
