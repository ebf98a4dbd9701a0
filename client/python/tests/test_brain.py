"""Brains by themselves: parameters, made-up turns, names, settings, waiting."""

import asyncio
import math
import unittest
import unittest.mock
from pathlib import Path

import baudbot
from baudbot.body import Body
from baudbot.names import matching, natural
from baudbot.reconnect import Backoff
from baudbot.scenarios import overrides, read
from baudbot.session import Session
from baudbot.settings import Settings, runs
from baudbot.v1 import brain_link_pb2 as pb
from baudbot.v1 import world_pb2


class Follow(baudbot.Brain):
    speed = 0.5
    turns = 3
    loud = False
    name = "f"

    def step(self, turn):
        return baudbot.drive(self.speed, turn.value("ir", 0.0))


def welcome(robots=1):
    sensors = [
        pb.SensorDescription(sensor="ir", kind=pb.SENSOR_KIND_IR, components=[pb.ComponentDescription(unit="1")]),
        pb.SensorDescription(
            sensor="odometer",
            kind=pb.SENSOR_KIND_ODOMETER,
            components=[pb.ComponentDescription(name=name) for name in ("x_m", "y_m", "heading_rad")],
        ),
    ]
    bodies = [pb.RobotDescription(robot=f"r{i}", sensors=sensors) for i in range(robots)]
    return pb.Welcome(step_ns=10_000_000, lockstep=True, robots=bodies)


def turn(number, tick, *parts):
    robots = [
        pb.RobotTurn(
            robot=robot,
            at_ns=at_ns,
            readings=[pb.Reading(sensor=0, values=[value], readable=readable, sampled_at_ns=max(at_ns - 5_000_000, 0))],
        )
        for robot, at_ns, value, readable in parts
    ]
    return pb.Turn(turn=number, tick=tick, robots=robots)


def answers(session, message):
    for seat, arrived in session.asked(message):
        seat.answer(arrived, seat.brain.step(arrived))
    return session.answer().step


class Parameters(unittest.TestCase):
    def test_are_the_attributes_of_the_class_and_keep_their_types(self):
        self.assertEqual(Follow.parameters(), {"speed": 0.5, "turns": 3, "loud": False, "name": "f"})
        brain = Follow(Body.of(welcome().robots[0], 1), 7, {"speed": "0.25", "turns": 4.0, "loud": "true", "name": 5})
        self.assertEqual((brain.speed, brain.turns, brain.loud, brain.name), (0.25, 4, True, "5"))
        self.assertIsInstance(brain.turns, int)

    def test_what_is_wrong_is_told_with_its_name(self):
        for name, value, words in [
            ("sped", 1, "there is no parameter `sped` of Follow; did you mean `speed`?"),
            ("speed", "fast", "parameter `speed` of Follow must be a number, is 'fast'"),
            ("turns", 1.5, "parameter `turns` of Follow must be a whole number, is 1.5"),
            ("loud", 1, "parameter `loud` of Follow must be true or false, is 1"),
        ]:
            with self.assertRaises(baudbot.Refused) as caught:
                Follow.parameter(name, value)
            self.assertEqual(str(caught.exception), words)


class Turns(unittest.TestCase):
    def test_a_command_that_is_made_of_a_reading_that_has_not_come_is_refused_with_the_sensors_name(self):
        class Hasty(baudbot.Brain):
            def step(self, turn):
                return baudbot.drive(0.5, turn.value("ir") - turn.value("odometer"))

        nothing = pb.Turn(turn=1, tick=0, robots=[pb.RobotTurn(robot=0, at_ns=10_000_000)])
        with self.assertRaises(baudbot.Error) as caught:
            answers(Session(welcome(), Hasty), nothing)
        expected = (
            "Hasty.step: a signal is no number, as nothing has arrived from `ir` and `odometer` yet; say what to take until then, "
            'as in turn.value("ir", 0.0)'
        )
        self.assertEqual(str(caught.exception), expected)
        self.assertEqual(answers(Session(welcome(), Follow), nothing).robots[0].command.left_signal, 0.5)

    def test_a_message_without_a_new_reading_is_news(self):
        session = Session(welcome(), Follow)
        answers(session, turn(1, 0, (0, 10_000_000, 0.5, True)))
        for number, has_message in ((2, False), (3, True)):
            asked = turn(number, number, (0, 10_000_000 * number, 0.5, False))
            asked.robots[0].has_message = has_message
            self.assertEqual(answers(session, asked).robots[0].HasField("command"), has_message)

    def test_sensors_go_by_name_with_value_age_and_readability(self):
        body = Body.of(welcome().robots[0], 1)
        message = turn(1, 3, (0, 30_000_000, 0.25, True)).robots[0]
        message.readings.add(sensor=1, values=[1.0, 2.0, 0.5])
        arrived = baudbot.Turn(body, message, 3)
        ir, odometer = arrived["ir"], arrived["odometer"]
        self.assertEqual((ir.value, ir.age_s, ir.readable, arrived.at_s), (0.25, 0.005, True, 0.03))
        self.assertEqual((odometer["y_m"], odometer.values, odometer.age_s), (2.0, [1.0, 2.0, 0.5], None))
        self.assertEqual(list(arrived), ["ir", "odometer"])
        with self.assertRaisesRegex(baudbot.NoReading, "did you mean `odometer`"):
            arrived["odometr"]
        with self.assertRaisesRegex(baudbot.NoReading, "there is no component `x` of sensor `odometer`; there are: heading_rad, x_m, y_m"):
            odometer["x"]

    def test_before_anything_came_there_is_no_value(self):
        body = Body.of(welcome().robots[0], 1)
        arrived = baudbot.Turn(body, pb.RobotTurn(), 0)
        self.assertTrue(math.isnan(arrived.value("ir")))
        self.assertIsNone(arrived.get("ir"))
        self.assertNotIn("ir", arrived)
        with self.assertRaisesRegex(baudbot.NoReading, "nothing has arrived from sensor `ir` yet"):
            arrived["ir"]

    def test_sensors_from_which_nothing_has_come_leave_no_gap_in_the_message(self):
        body = Body.of(welcome().robots[0], 1)
        arrived = baudbot.Turn(body, pb.RobotTurn(readings=[pb.Reading(sensor=1, values=[1.0, 2.0, 0.5])]), 0)
        self.assertEqual((arrived.value("odometer"), arrived["odometer"]["heading_rad"]), (1.0, 0.5))
        self.assertEqual((arrived.value("ir", 7.0), arrived.get("ir"), "ir" in arrived), (7.0, None, False))
        self.assertEqual((list(arrived), len(arrived), "odometer" in arrived), (["odometer"], 1, True))
        for name in ("irr", 3):
            self.assertNotIn(name, arrived)
        with self.assertRaisesRegex(baudbot.NoReading, "did you mean `ir`"):
            arrived.value("irr")


class Beliefs(unittest.TestCase):
    def test_a_motivational_state_has_its_weights_in_the_order_of_its_variables(self):
        hunger = baudbot.Variable("hunger", 0.4, lethal_above=1.0)
        smell = baudbot.Variable("smell", 0.1, internal=False)
        eat = baudbot.Tendency("eat", bias=-0.5, weights={"smell": 2.0})
        message = baudbot.Belief(variables=[hunger, smell], tendencies=[eat]).message()
        first, second = message.motivation.variables
        self.assertEqual((first.name, first.value, first.internal, first.lethal_above), ("hunger", 0.4, True, 1.0))
        self.assertFalse(first.HasField("lethal_below") or second.HasField("lethal_above") or second.internal)
        self.assertEqual(list(message.motivation.tendencies[0].weights), [0.0, 2.0])
        self.assertFalse(baudbot.Belief().message().HasField("motivation"))
        wrong = baudbot.Belief(variables=[hunger], tendencies=[baudbot.Tendency("eat", weights={"hungry": 1.0})])
        with self.assertRaisesRegex(ValueError, "there is no variable `hungry` of the tendency to `eat`.*hunger"):
            wrong.message()


class Waiting(unittest.TestCase):
    def test_without_news_a_brain_is_asked_only_when_its_patience_is_over(self):
        session = Session(welcome(), Follow)
        first = answers(session, turn(1, 1, (0, 10_000_000, 0.1, True)))
        self.assertEqual((first.turn, first.robots[0].command.right_signal), (1, 0.1))
        self.assertEqual(first.robots[0].until_message.at_latest_ns, 110_000_000)
        # The server asks all the same: the brain sleeps on.
        quiet = answers(session, turn(2, 2, (0, 20_000_000, 0.1, False)))
        self.assertFalse(quiet.robots[0].HasField("command"))
        self.assertEqual(quiet.robots[0].until_message.at_latest_ns, 110_000_000)
        late = answers(session, turn(3, 11, (0, 110_000_000, 0.1, False)))
        self.assertTrue(late.robots[0].HasField("command"))
        self.assertEqual(session.turns, 2)
        # A world that goes back in time asks anew.
        again = answers(session, turn(4, 1, (0, 10_000_000, 0.1, False)))
        self.assertTrue(again.robots[0].HasField("command"))

    def test_each_run_has_a_new_brain(self):
        class Counts(Follow):
            steps = 0

            def step(self, turn):
                self.steps += 1
                return baudbot.drive(self.steps / 10, 0.0)

        session = Session(welcome(2), Counts)

        def step(number, tick, *robots):
            parts = answers(session, turn(number, tick, *((robot, 10_000_000 * tick, 0.1, True) for robot in robots))).robots
            return [round(10 * part.command.left_signal) for part in parts]

        self.assertEqual([step(tick, tick, 0, 1) for tick in (0, 1, 2)], [[1, 1], [2, 2], [3, 3]])
        # What a robot is asked later in the same tick belongs to the run, too.
        self.assertEqual([step(3, 3, 0), step(4, 3, 1)], [[4], [4]])
        # The world was reset, and restored at once.
        self.assertEqual([step(5, 1, 0, 1), step(6, 2, 0, 1), step(7, 2, 0, 1)], [[1, 1], [2, 2], [1, 1]])

    def test_a_brain_may_be_asked_in_every_tick_or_wait_for_ever(self):
        class Every(Follow):
            every_tick = True

        class Never(Follow):
            patience_s = None

        self.assertFalse(answers(Session(welcome(), Every), turn(1, 1, (0, 1, 0.0, True))).robots[0].HasField("until_message"))
        step = answers(Session(welcome(), Never), turn(1, 1, (0, 1, 0.0, True))).robots[0]
        self.assertTrue(step.HasField("until_message"))
        self.assertFalse(step.until_message.HasField("at_latest_ns"))

    def test_each_robot_of_a_turn_has_a_part_in_the_answer(self):
        session = Session(welcome(3), Follow)
        step = answers(session, turn(1, 1, (0, 1, 0.0, True), (1, 1, 0.0, True), (2, 1, 0.0, True)))
        self.assertEqual([part.robot for part in step.robots], [0, 1, 2])
        step = answers(session, turn(2, 2, (1, 2, 0.0, True), (2, 2, 0.0, False)))
        self.assertEqual([(part.robot, part.HasField("command")) for part in step.robots], [(1, True), (2, False)])

    def test_what_is_no_command_is_an_error_that_names_the_brain(self):
        class Wrong(Follow):
            def step(self, turn):
                return (0.5, 0.5)

        class Late(Follow):
            async def step(self, turn):
                return None

        for brain, words in [(Wrong, r"Wrong.step must return drive\(left, right\), poll\(\) or None, returned \(0.5, 0.5\)")]:
            with self.assertRaisesRegex(baudbot.Error, words):
                answers(Session(welcome(), brain), turn(1, 1, (0, 1, 0.0, True)))
        with self.assertRaisesRegex(baudbot.Error, "await baudbot.aio.attach"):
            baudbot.attach(Late, connect="127.0.0.1:1")


class Names(unittest.TestCase):
    def test_have_a_natural_order_and_patterns(self):
        names = ["cell-10", "cell-2", "ant", "cell-1"]
        self.assertEqual(sorted(names, key=natural), ["ant", "cell-1", "cell-2", "cell-10"])
        self.assertEqual(matching(["cell-*"], names, "robot"), ["cell-1", "cell-2", "cell-10"])
        self.assertEqual(matching(["cell-2", "cell-*"], names, "robot"), ["cell-2", "cell-1", "cell-10"])
        with self.assertRaisesRegex(baudbot.NotFound, "there is no robot `cel-2`; did you mean `cell-2`"):
            matching(["cel-2"], names, "robot")

    def test_arguments_come_before_the_environment(self):
        environment = {
            "BAUDBOT_CONNECT": "unix:/a",
            "BAUDBOT_WORLD": "w",
            "BAUDBOT_ROBOT": "a,b",
            "BAUDBOT_SEED": "7",
            "BAUDBOT_PARAMETERS": '{"speed": 0.25}',
            "BAUDBOT_RECONNECT_S": "0",
        }
        found = Settings.find(environment=environment)
        self.assertEqual(found, Settings("unix:/a", "w", ("a", "b"), 7, {"speed": 0.25}, 0))
        given = Settings.find("h:1", "v", "c", 8, {"turns": 2}, 5.0, environment)
        self.assertEqual(given, Settings("h:1", "v", ("c",), 8, {"speed": 0.25, "turns": 2}, 5.0))
        self.assertEqual(Settings.find(environment={}), Settings())
        for name, text, words in [
            ("BAUDBOT_SEED", "x", "BAUDBOT_SEED must be a number, is 'x'"),
            ("BAUDBOT_PARAMETERS", "[1]", "BAUDBOT_PARAMETERS must be an object"),
            ("BAUDBOT_PARAMETERS", "{", "BAUDBOT_PARAMETERS is not JSON"),
        ]:
            with self.assertRaisesRegex(baudbot.Refused, words):
                Settings.find(environment={name: text})

    def test_a_parameter_is_given_once(self):
        with unittest.mock.patch.dict("os.environ", {"BAUDBOT_PARAMETERS": '{"speed": 0.25}'}):
            with self.assertRaisesRegex(SystemExit, "--speed is given, and BAUDBOT_PARAMETERS has speed, too"):
                baudbot.main(Follow, ["--speed", "0.5"])

    def test_further_runs_are_lines_of_the_input(self):
        environment = {"BAUDBOT_REUSE": "1", "BAUDBOT_SEED": "1", "BAUDBOT_WORLD": "w"}
        lines = ['{"BAUDBOT_SEED": "2"}\n', '{"BAUDBOT_SEED": "3", "BAUDBOT_WORLD": "v"}\n']
        found = [Settings.find(environment=run) for run in runs(environment, lines)]
        self.assertEqual([(run.seed, run.world) for run in found], [(1, "w"), (2, "w"), (3, "v")])
        self.assertEqual(list(runs({}, lines)), [{}])
        for line, words in [("{", "is not JSON"), ("[1]", "must be an object of texts"), ('{"a": 1}', "of texts")]:
            with self.assertRaisesRegex(baudbot.Refused, words):
                list(runs(environment, [line]))

    def test_the_only_world_and_the_only_robot_need_no_name(self):
        def world(name, *robots):
            return world_pb2.WorldStatus(world=name, robots=[world_pb2.RobotStatus(robot=robot) for robot in robots])

        self.assertEqual(Settings().choose([world("w", "r")]), ("w", ["r"]))
        self.assertEqual(Settings(world="v", robots=("*",)).choose([world("w", "r"), world("v", "b", "a")]), ("v", ["a", "b"]))
        for settings, worlds, words in [
            (Settings(), [], "the server has no worlds"),
            (Settings(), [world("b"), world("a")], "several worlds; choose one: a, b"),
            (Settings(), [world("w", "b", "a")], "world `w` has several robots; choose some: a, b"),
            (Settings(world="w"), [world("w")], "world `w` has no robots"),
        ]:
            with self.assertRaisesRegex(baudbot.NotFound, words):
                settings.choose(worlds)


class Reconnecting(unittest.TestCase):
    def test_waits_grow_until_the_limit_and_what_does_not_pass_ends_it(self):
        now, told = [0.0], []
        backoff = Backoff(10.0, told.append, lambda: now[0])
        with self.assertRaises(baudbot.NoServer):
            backoff.wait_s(baudbot.NoServer("never there"))
        backoff.connected()
        waits = []
        with self.assertRaises(baudbot.NoServer):
            while True:
                waits.append(backoff.wait_s(baudbot.NoServer("gone")))
                now[0] += waits[-1]
        self.assertEqual(waits, [0.25, 0.5, 1.0, 2.0, 4.0, 2.25])
        self.assertEqual(told, ["gone; trying to reconnect for 10 s"])
        for limit_s, error in [(10.0, baudbot.Refused("no")), (0.0, baudbot.NoServer("gone"))]:
            backoff = Backoff(limit_s, told.append)
            backoff.connected()
            with self.assertRaises(type(error)):
                backoff.wait_s(error)

    def test_a_robot_that_stays_held_is_held_by_another_brain(self):
        now = [0.0]
        backoff = Backoff(600.0, lambda line: None, lambda: now[0])
        backoff.connected()
        backoff.wait_s(baudbot.NoServer("gone"))
        for held_for_s in (0.0, 44.0):
            now[0] = 100.0 + held_for_s
            backoff.wait_s(baudbot.Taken("held"))
        now[0] = 145.0
        with self.assertRaises(baudbot.Taken):
            backoff.wait_s(baudbot.Taken("held"))


class Scenarios(unittest.TestCase):
    def test_are_built_in_files_or_texts(self):
        self.assertIn('name = "wander"', read("wander"))
        self.assertEqual(read("step_ms = 5.0"), "step_ms = 5.0")
        with self.assertRaisesRegex(baudbot.NotFound, "there is no file or built-in scenario `wandr`; did you mean `wander`"):
            read("wandr")

    def test_fields_are_changed_by_path_and_by_keyword(self):
        changes = overrides(read("wander"), {"robots.robot.start": {"x_m": 1}}, {"baud": 2400, "seed": 7, "noise": False})
        expected = ['robots.robot.start={ "x_m" = 1 }', "robots.0.link.baud=2400", "seed=7", "noise=false"]
        self.assertEqual(changes, expected)


class Documents(unittest.TestCase):
    def test_the_pages_have_the_example(self):
        package = Path(__file__).resolve().parents[1]
        example = (package / "examples/follow.py").read_text().split('"""\n', 1)[1].strip()
        for page in (package / "README.md", package.parents[1] / "docs/tutorials/python.md"):
            self.assertIn(f"```python\n{example}\n```", page.read_text())


class Async(unittest.TestCase):
    def test_errors_are_the_same(self):
        with self.assertRaisesRegex(baudbot.NoServer, "no server answers at 127.0.0.1:1 "):
            asyncio.run(baudbot.aio.attach(Follow, connect="127.0.0.1:1"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
