"""How thermal nodes lie on the finite elements."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator, Field, field_validator, model_validator

from tedm_cli.config.base import Bounded, FileName, Form, Length, OneLine, Strict
from tedm_cli.config.model.areas import SelectionTable
from tedm_cli.quantities import CONDUCTIVITY, LINK_CONDUCTANCE

_ID = re.compile(r"[1-9][0-9]{0,8}")


def _by_material(value: dict[str, float]) -> dict[str, float]:
    for key in value:
        if not _ID.fullmatch(key):
            raise ValueError(f"{key!r} is no id of a material")
    return value


Conductivities = Annotated[
    dict[str, Annotated[float, Bounded(CONDUCTIVITY)]],
    AfterValidator(_by_material),
    Form("table of numbers by id of a material"),
]


class NodeTable(SelectionTable):
    """One thermal node: the elements that meet every criterion given, and those of each selection in `also`.

    Ids are `7`, `"4:9"` or a list of these.
    """

    name: OneLine = Field(description="Name of the thermal node.")
    also: list[SelectionTable] = Field(
        default_factory=list, description="Selections whose elements are of the node as well."
    )

    def selections(self) -> list[SelectionTable]:
        """The node is the union of these."""
        return [self, *self.also]


class MapTable(Strict):
    """Which elements each thermal node is, and how they conduct.

    The temperature of a node is kept as the average over its elements, and of all fields with these averages the grids
    get the one that conduction chooses. With `weights` the areas get theirs from the nodes as in `run-series`, and no
    element conducts.
    """

    elements: FileName | None = Field(default=None, description="A CSV `tmm_node,element_id`.")
    nodes: list[NodeTable] = Field(
        alias="node", default_factory=list, description="Nodes by sets, properties, materials, elements and boxes."
    )
    nearest: FileName | None = Field(
        default=None,
        description="A CSV with `node`, `x_m`, `y_m` and `z_m` among its columns, such as that of the network's nodes. "
        "Every conducting element of no node yet is of the one that is nearest to its centre. Nodes without a place "
        "are passed over.",
    )
    nearest_within_m: Length | None = Field(
        default=None, description="Largest distance of `nearest`. Elements that are further away stay in no node."
    )
    areas: bool = Field(
        default=False,
        description="Whether the thermal areas of the model are the nodes: the elements that an area selects as such, "
        "or what of the elements is at its grids.",
    )
    weights: FileName | None = Field(
        default=None,
        description="A CSV `node,area,weight`: all of an area has the weighted mean of its nodes, as with TEMP cards.",
    )
    unmapped: list[OneLine] = Field(
        default_factory=list,
        description="Thermal areas that no node is for. They keep a spectrum of their own. Else a part of the model "
        "that conduction does not join to any node is refused.",
    )
    rigid_conductance_W_K: Annotated[float, Bounded(LINK_CONDUCTANCE)] | None = Field(
        default=None,
        description="Conductance from the independent to each dependent grid of a rigid element, or from the reference "
        "grid of an RBE3 to each of the others. Left out, they do not conduct.",
    )
    conductivity_W_m_K: Conductivities = Field(
        default_factory=dict, description="Conductivity of materials to which the deck gives no MAT4."
    )

    @field_validator("nodes")
    @classmethod
    def _one_each(cls, value: list[NodeTable]) -> list[NodeTable]:
        first: dict[str, str] = {}
        for node in value:
            if (name := first.setdefault(node.name.upper(), node.name)) is not node.name:
                raise ValueError(f"node {node.name!r} is there twice (as {name!r}); unite them by `also`")
        return value

    @model_validator(mode="after")
    def _one_way(self) -> MapTable:
        by_element = [key for key in ("elements", "nodes", "nearest") if getattr(self, key)]
        ways = [" and ".join(by_element).replace("nodes", "node")] * bool(by_element)
        ways += ["areas"] * self.areas + ["weights"] * (self.weights is not None)
        if not ways:
            raise ValueError("says of no node where it is: give elements, node, nearest, areas = true or weights")
        if len(ways) > 1:
            raise ValueError(f"gives {' and '.join(ways)}: these are different ways, give one")
        if self.nearest_within_m is not None and self.nearest is None:
            raise ValueError("nearest_within_m is of nearest, which is not given")
        if self.weights is not None and (self.conductivity_W_m_K or self.rigid_conductance_W_K is not None):
            raise ValueError("with weights nothing conducts: leave the conductivities and conductances out")
        if len({name.upper() for name in self.unmapped}) < len(self.unmapped):
            raise ValueError("unmapped names an area twice")
        return self

    def file_names(self) -> list[str]:
        """The files that it names."""
        return [name for name in (self.elements, self.nearest, self.weights) if name is not None]
