"""Correlations of uncertain parameters, and names that are told twice or not at all."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Annotated

from pydantic import Field

from tedm_cli.config.base import Coefficient, Strict
from tedm_cli.errors import PhysicsError
from tedm_cli.uncertainty.parameters import EXPANSION, MESH, NORMAL, Parameter, Parameters

Pairs = dict[tuple[str, str], float]


class CorrelationTable(Strict):
    """Correlation of parameters of the same file, each pair of those named."""

    parameters: Annotated[list[str], Field(min_length=2)] = Field(
        description="Names of the parameters. Of test masses they end with the axis, such as `TM1_position_x`."
    )
    rho: Coefficient = Field(
        description="Correlation coefficient of the normal variables behind the parameters (a Gaussian copula)."
    )


def pairs_of(tables: Iterable[CorrelationTable]) -> Pairs:
    """Correlation coefficients of pairs of names."""
    return {
        (one, two): table.rho
        for table in tables
        for i, one in enumerate(table.parameters)
        for two in table.parameters[i + 1 :]
    }


def correlation_problems(named: Sequence[tuple[str, str]], tables: Sequence[CorrelationTable]) -> list[tuple[str, str]]:
    """(dotted path, fact): names that are there twice or not at all, pairs that are, coefficients that are impossible.

    `named`: (dotted path, name) of the parameters.
    """
    first: dict[str, str] = {}
    found = []
    for place, name in named:
        if name == MESH:
            found.append((place, f"{MESH!r} is the name of the error by the mesh; choose another"))
        before = first.setdefault(name, place)
        if before != place:
            found.append((place, f"{name!r} is the name of a parameter already, in {before}"))
    pairs: dict[frozenset[str], str] = {}
    for i, table in enumerate(tables):
        place = f"uncertainty.correlation[{i}]"
        for name in dict.fromkeys(n for n in table.parameters if n not in first):
            there = f"there are: {', '.join(first)}" if first else "this file has none"
            found.append((f"{place}.parameters", f"there is no parameter {name!r}; {there}"))
        for one, two in pairs_of([table]):
            before = pairs.setdefault(frozenset((one, two)), place)
            if one == two:
                found.append((f"{place}.parameters", f"{one!r} is there twice"))
            elif before != place:
                found.append((f"{place}.parameters", f"{one} and {two} are correlated already in {before}"))
    if found:
        return found
    items = tuple(Parameter(name, EXPANSION, "", 0.0, NORMAL) for name in first)
    try:
        Parameters.of(items, pairs_of(tables))
    except PhysicsError as error:
        return [("uncertainty.correlation", f"{error.fact}; {error.hint}")]
    return []
