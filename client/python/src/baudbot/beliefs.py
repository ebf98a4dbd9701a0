"""What a brain may publish for people who watch: it takes no time on any cable and reaches no other brain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from .names import unknown
from .v1 import brain_link_pb2 as pb


@dataclass(slots=True)
class GridMap:
    """Square cells of a map, row by row from the lower left corner."""

    #: Of the lower left corner.
    x_m: float
    y_m: float
    #: The side of a cell.
    cell_m: float
    #: Cells in a row.
    columns: int
    #: A byte per cell: 0 is certainly free, 254 is certainly occupied, 255 is unknown.
    cells: bytes


@dataclass(slots=True)
class Variable:
    """A variable of a brain's motivational state (§4.4.4 of the notes)."""

    name: str
    value: float
    #: Such as hunger; False for what is sensed.
    internal: bool = True
    #: The values at and beyond which the robot dies.
    lethal_below: float | None = None
    lethal_above: float | None = None


@dataclass(slots=True)
class Tendency:
    """The tendency to a behaviour: the bias, and the weighted sum of the variables."""

    behavior: str
    bias: float = 0.0
    #: By the names of the variables; 0 for those that are left out.
    weights: dict[str, float] = field(default_factory=dict)


@dataclass(slots=True)
class Belief:
    """What a brain believes and does, in coordinates of the world as it believes them to be. All parts may be left out."""

    #: The state or behaviour that is active, in a few words.
    state: str = ""
    #: Where it believes it is: x and y in metres, and the heading in radians.
    pose: tuple[float, float, float] | None = None
    #: Other poses that it thinks possible.
    particles: Sequence[tuple[float, float, float]] = ()
    #: Where it intends to go, in metres.
    path: Sequence[tuple[float, float]] = ()
    #: Utilities of behaviours by name.
    utilities: dict[str, float] = field(default_factory=dict)
    #: The name of the active behaviour, among the utilities.
    active: str = ""
    map: GridMap | None = None
    #: The motivational state, by which behaviours are chosen.
    variables: Sequence[Variable] = ()
    #: What follows from the variables.
    tendencies: Sequence[Tendency] = ()

    def message(self) -> pb.Belief:
        """As the contract has it."""
        message = pb.Belief(
            state=self.state,
            utilities=[
                pb.Utility(name=name, value=value, active=name == self.active)
                for name, value in self.utilities.items()
            ],
            particles=[pb.Particle(x_m=x, y_m=y, heading_rad=heading) for x, y, heading in self.particles],
            path=[pb.Point(x_m=x, y_m=y) for x, y in self.path],
        )
        if self.pose is not None:
            x, y, heading = self.pose
            message.pose.CopyFrom(pb.BelievedPose(x_m=x, y_m=y, heading_rad=heading))
        if self.map is not None:
            grid = self.map
            message.map.CopyFrom(
                pb.GridMap(x_m=grid.x_m, y_m=grid.y_m, cell_m=grid.cell_m, columns=grid.columns, cells=grid.cells)
            )
        if self.variables or self.tendencies:
            message.motivation.CopyFrom(self._motivation())
        return message

    def _motivation(self) -> pb.Motivation:
        names = [variable.name for variable in self.variables]
        for tendency in self.tendencies:
            for name in tendency.weights:
                if name not in names:
                    where = f" of the tendency to `{tendency.behavior}`"
                    raise ValueError(unknown("variable", name, names, where))
        return pb.Motivation(
            variables=[
                pb.StateVariable(
                    name=variable.name,
                    value=variable.value,
                    internal=variable.internal,
                    lethal_below=variable.lethal_below,
                    lethal_above=variable.lethal_above,
                )
                for variable in self.variables
            ],
            tendencies=[
                pb.Tendency(
                    name=tendency.behavior,
                    bias=tendency.bias,
                    weights=[tendency.weights.get(name, 0.0) for name in names],
                )
                for tendency in self.tendencies
            ],
        )
