"""Effects of the user's own: from the tables that the model's configuration names, and as a case file tells them."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.effects import read_effect
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE
from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.differences import terms
from tedm_cli.noise.effects import Effects
from tedm_cli.results.areas import unit_per


def effect_files(project: Project, model: ModelConfig) -> list[Path]:
    """The tables of effects that a model names."""
    return [project.resolve(effect.table) for effect in model.effect]


def read_effects(
    project: Project,
    model: ModelConfig,
    labels: Sequence[str],
    units: Sequence[str],
    areas: AreaTable,
    *,
    partly: bool = False,
) -> Effects:
    """The effects of a project on its outputs [n_out], whose units are before "/K": m/s^2, rad/s^2, m, rad.

    With `partly` the outputs are not all that the project has, and lines of others are passed over.

    Raises
    ------
    InputError : a table that cannot be read; an output or an area that there is not, a unit that is another than that
        of the output per kelvin of the area, a pair that stands there twice: with file and line.
    """
    outputs = dict(zip(labels, units, strict=True))
    rows = np.zeros((len(model.effect), len(labels), len(areas)))
    for row, effect in zip(rows, model.effect, strict=True):
        _fill(row, project.resolve(effect.table), outputs, areas, partly)
    return Effects(tuple(effect.name for effect in model.effect), rows)


def _fill(row: FloatArray, path: Path, unit: dict[str, str], areas: AreaTable, partly: bool) -> None:
    labels, names = list(unit), areas.name.tolist()
    seen: dict[tuple[int, int], int] = {}
    for line in read_effect(path):
        where = f"{path}:{line.line}"
        if partly and line.text["output"] not in unit:
            continue
        o = _place("output", line.text["output"], labels, where, "`tedm explain` lists them")
        a = _place("thermal area", line.text["area"], names, where, "`tedm areas` lists them")
        wanted = unit_per(unit[labels[o]], areas.unit[a])
        if line.text["unit"].replace(" ", "").replace("²", "^2") != wanted:
            fact = f"unit {line.text['unit'][:40]!r}: {labels[o]} by {names[a]} is in {wanted}"
            raise InputError(fact, where=where, hint="convert the value, and write its unit so")
        if (o, a) in seen:
            fact = f"{labels[o]} by {names[a]} stands in line {seen[o, a]} already"
            raise InputError(fact, where=where, hint="add the two up, or give them to two effects")
        seen[o, a] = line.line
        row[o, a] = line.number["value"]


def _place(what: str, name: str, known: list[str], where: str, lists: str) -> int:
    if name in known:
        return known.index(name)
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]}?" if near else lists
    raise InputError(f"no {what} is called {name[:60]!r}", where=where, hint=hint)


@dataclass(frozen=True, eq=False)
class OwnEffect:
    """What an effect of the user's own makes of an output: row [k], `unit` of the output per unit of each area."""

    name: str
    output: str
    unit: str
    row: FloatArray


def own_effects(file: Reader) -> list[OwnEffect]:
    """Effects of the user's own in a case file on all outputs, without differences, that they are on."""
    labels, units = file.strings(CASE.OUTPUT_LABEL), file.strings(CASE.OUTPUT_UNIT)
    found = [
        OwnEffect(name, label, unit, row)
        for label, unit in zip(labels, units, strict=True)
        if terms(label) is None
        for name, row in effect_rows(file, label).items()
        if row.any()
    ]
    names = list(dict.fromkeys(effect.name for effect in found))
    return sorted(found, key=lambda effect: names.index(effect.name))


def effect_rows(file: Reader, output: str) -> dict[str, FloatArray]:
    """What each effect of the user's own makes of an output, [k] per unit of each area, by name; in a case file."""
    if not file.has(CASE.EFFECT_NAME):
        return {}
    return dict(zip(file.strings(CASE.EFFECT_NAME), file.array(CASE.EFFECT_ROW.of(output)), strict=True))
