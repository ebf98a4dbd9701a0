"""Policies: small networks that drive a robot here, and as brains of the program."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _given
from .._errors import Invalid, Mistyped
from ..scenarios import quoted
from .spaces import Shape

#: The weights of a layer, a row for each neuron, and its biases.
Layer = tuple[ArrayLike, ArrayLike]


class Observing(Protocol):
    """An environment, or anything else with the shape of one's observations."""

    @property
    def unwrapped(self) -> Any: ...


class Network:
    """A feedforward network from an observation to an action, with tanh after each layer, also the last.

    `layers` are pairs of weights, of the shape (neurons, inputs), and biases. Each input is scaled: `(input - offset) * scale`. It
    computes in float64, and takes observations with or without ages, flat or not, and a row for each environment of a
    `VectorEnv`. Arrays may have one more axis, in front: a network for each environment.
    """

    def __init__(
        self, layers: Sequence[Layer], *, offset: ArrayLike | None = None, scale: ArrayLike | None = None
    ) -> None:
        self.layers = tuple(_layers(layers))
        inputs = self.layers[0][0].shape[-1]
        self.offset = _numbers(0.0 if offset is None else offset, "offset")
        self.scale = _numbers(1.0 if scale is None else scale, "scale")
        for what, given in (("offset", self.offset), ("scale", self.scale)):
            if given.shape not in ((), (inputs,)):
                raise Invalid(f"{what}: has shape {given.shape}, but ({inputs},) is needed, one for each input", what)

    def __call__(self, observation: Any) -> NDArray[np.float32]:
        answer = (_flat(observation, self.layers[0][0].shape[-1]) - self.offset) * self.scale
        for weights, biases in self.layers:
            answer = np.tanh((weights @ answer[..., None])[..., 0] + biases)
        return answer.astype(np.float32)


def save_policy(
    path: str | os.PathLike[str],
    env: Observing,
    layers: Network | Sequence[Layer],
    *,
    offset: ArrayLike | None = None,
    scale: ArrayLike | None = None,
    description: str = "a policy that has been learnt",
) -> None:
    """Writes a policy as a brain: `baudbot run wander --brain policy.toml`.

    `env` is an environment in which it drives, whose observations are its inputs. `layers` are a `Network`, which has offset and
    scale, or what makes one.
    """
    if not isinstance(layers, Network):
        layers = Network(layers, offset=offset, scale=scale)
    elif offset is not None or scale is not None:
        raise Invalid("offset, scale: the network has its own; leave them out", "offset" if scale is None else "scale")
    shape = getattr(getattr(env, "unwrapped", None), "shape", None)
    if not isinstance(shape, Shape):
        raise Mistyped(f"env: {env!r} is not an environment of baudbot.gym", "env")
    path = _given.path(path, "path")
    text = "\n".join(_lines(layers, shape, _given.text(description, "description"))) + "\n"
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def input_names(shape: Shape) -> tuple[str, ...]:
    """What the inputs of a policy are, in order."""
    more: list[str] = []
    if shape.with_ages:
        more = [f"age of {sensor}" for sensor in shape.sensors] + [f"{sensor} is new" for sensor in shape.sensors]
    return (*shape.columns, *more)


def _lines(network: Network, shape: Shape, description: str) -> Iterator[str]:
    names = input_names(shape)
    inputs, outputs = network.layers[0][0].shape[-1], network.layers[-1][0].shape[-2]
    if network.layers[0][0].ndim != 2:
        raise Invalid("layers: are networks for many environments; choose one of them", "layers")
    if inputs != len(names):
        raise Invalid(f"layers[0]: has {inputs} inputs, but the environment observes {len(names)}: {', '.join(names)}", "layers[0]")
    if outputs != len(shape.signals):
        path, signals = f"layers[{len(network.layers) - 1}]", ", ".join(shape.signals)
        raise Invalid(f"{path}: has {outputs} neurons, but an action has {len(shape.signals)} signals: {signals}", path)
    yield f"description = {quoted(description)}"
    yield ""
    yield "# Inputs: " + ", ".join(names) + "."
    yield "[policy]"
    yield "version = 1"
    yield "sensors = ["
    for name, values in shape.sizes.items():
        yield f"    {{ name = {quoted(name)}, values = {values} }},"
    yield "]"
    yield f"ages = {'true' if shape.with_ages else 'false'}"
    if shape.with_ages:
        yield f"max_age_s = {float(shape.max_age_s)!r}"
    yield f"offset = {np.broadcast_to(network.offset, inputs).tolist()}"
    yield f"scale = {np.broadcast_to(network.scale, inputs).tolist()}"
    yield "# A layer is a list of neurons, a neuron its weights and then its bias."
    yield "layers = ["
    for weights, biases in network.layers:
        yield "    ["
        for neuron in np.column_stack([weights, biases]).tolist():
            yield f"        {neuron},"
        yield "    ],"
    yield "]"


def _flat(observation: Any, inputs: int) -> NDArray[np.float64]:
    """An observation as one array."""
    parts = [observation]
    if isinstance(observation, Mapping):
        parts = [observation[name] for name in ("readings", "ages_s", "readable") if name in observation]
    try:
        flat = np.concatenate(parts, axis=-1, dtype=np.float64)
    except (TypeError, ValueError):
        raise Mistyped(f"observation: {observation!r} is not an observation of an environment", "observation") from None
    if flat.shape[-1] != inputs:
        raise Invalid(f"observation: has {flat.shape[-1]} numbers, but the network has {inputs} inputs", "observation")
    return flat


def _layers(layers: Sequence[Layer]) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    if not isinstance(layers, Sequence):
        raise Mistyped(f"layers: {layers!r} is not a list of pairs of weights and biases", "layers")
    if not layers:
        raise Invalid("layers: there is none", "layers")
    comes_in: int | None = None
    for place, pair in enumerate(layers):
        path = f"layers[{place}]"
        if not isinstance(pair, Sequence) or len(pair) != 2:
            raise Invalid(f"{path}: must be two arrays: weights and biases", path)
        weights, biases = (_numbers(part, path) for part in pair)
        if weights.ndim not in (2, 3) or biases.shape != weights.shape[:-1]:
            shapes = f"{weights.shape} and {biases.shape}"
            raise Invalid(f"{path}: has the shapes {shapes}; (neurons, inputs) and (neurons,) are needed", path)
        if comes_in is not None and weights.shape[-1] != comes_in:
            raise Invalid(f"{path}: has {weights.shape[-1]} inputs, but the layer before it has {comes_in} neurons", path)
        comes_in = weights.shape[-2]
        yield weights, biases


def _numbers(values: ArrayLike, path: str) -> NDArray[np.float64]:
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise Mistyped(f"{path}: is not an array of numbers", path) from None
    if not np.isfinite(array).all():
        raise Invalid(f"{path}: has numbers that are not finite", path)
    return array


__all__ = ["Layer", "Network", "input_names", "save_policy"]
