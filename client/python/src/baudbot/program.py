"""A brain as a program: its command line, and its errors as lines."""

from __future__ import annotations

import argparse
import inspect
import math
import sys

from .attach import drive
from .brain import Brain
from .errors import Error
from .settings import Settings, environment_parameters, runs


def main(brain: type[Brain], arguments: list[str] | None = None) -> None:
    """Runs a brain as a program, with options for where it attaches and for its parameters; `--help` lists them. An experiment
    with `reuse = true` gives the process one run after the other; each makes the brain anew. ::

        if __name__ == "__main__":
            baudbot.main(Follow)
    """
    parser = _parser(brain)
    given = parser.parse_args(arguments)
    parameters = {name: value for name in brain.parameters() if (value := getattr(given, f"set_{name}")) is not None}
    reconnect_s = None if given.reconnect is None else _seconds(parser, given.reconnect)
    try:
        for environment in runs():
            both = sorted(parameters.keys() & environment_parameters(environment).keys())
            if both:
                raise Error(f"--{both[0]} is given, and BAUDBOT_PARAMETERS has {both[0]}, too; leave out one of them")
            settings = Settings.find(
                given.connect, given.world, given.robot, given.seed, parameters, reconnect_s, environment
            )
            summary = drive(brain, settings, announce=True)
            print(f"the run is over after {summary.turns} turns")
    except Error as error:
        sys.exit(f"{parser.prog}: {error}")
    except KeyboardInterrupt:
        sys.exit(130)


def _parser(brain: type[Brain]) -> argparse.ArgumentParser:
    about = inspect.getdoc(brain)
    own = about if about is not None and brain.__doc__ else f"The brain {brain.__name__}."
    parser = argparse.ArgumentParser(description=own.splitlines()[0])
    where = "[default: BAUDBOT_%s, or else %s]"
    parser.add_argument("--connect", metavar="ADDR", help="HOST:PORT or unix:/PATH " + where % ("CONNECT", "127.0.0.1:7400"))
    parser.add_argument("--world", help="name of the world " + where % ("WORLD", "the only one"))
    robot_help = "a robot, or several by a pattern such as 'cell-*'; may be given several times "
    parser.add_argument("--robot", action="append", help=robot_help + where % ("ROBOT", "the world's only one"))
    parser.add_argument("--seed", type=int, help="seed of the brain's random numbers " + where % ("SEED", "1"))
    reconnect_help = "time for which to try to reconnect after a lost connection, in seconds; `off` disables it "
    parser.add_argument("--reconnect", metavar="S|off", help=reconnect_help + where % ("RECONNECT_S", "600"))
    for name, default in brain.parameters().items():
        option = f"--{name.replace('_', '-')}"
        parser.add_argument(option, dest=f"set_{name}", metavar="VALUE", help=f"parameter [default: {default}]")
    return parser


def _seconds(parser: argparse.ArgumentParser, text: str) -> float:
    if text == "off":
        return 0.0
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.0 < seconds < math.inf:
        parser.error(f"--reconnect must be off or a number of seconds above 0, is {text}")
    return seconds
