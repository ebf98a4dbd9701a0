"""Environments of Gymnasium: a robot at the end of its cable.

A step is a control cycle of the cable: what the robot is to do travels to it, and the environment runs until the robot has sent
a message again. The observation is what a brain has: readings, how old they are, and which of them are new::

    import gymnasium

    env = gymnasium.make("baudbot/Wander-v0")
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

`baudbot.gym.Env` is an environment of any scenario, `baudbot.gym.VectorEnv` many of them on several threads.
`Network` is a policy for them, which `save_policy` writes as a brain of the program.
"""

from .env import Env, Step
from .policy import Network, save_policy
from .register import register
from .spaces import Shape
from .vector import VectorEnv

__all__ = ["Env", "Network", "Shape", "Step", "VectorEnv", "register", "save_policy"]
