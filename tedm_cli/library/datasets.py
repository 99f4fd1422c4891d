"""Any file between the stages as one Dataset, by its contract: what a contract gains is there without a line here."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tedm_cli.arrays import AnyArray
from tedm_cli.contracts import CASE, Dataset, FileKind
from tedm_cli.files.store import Reader
from tedm_cli.library.xarray_door import Variable, dataset, variable
from tedm_cli.stages.common import known_name

if TYPE_CHECKING:
    import xarray as xr

_BRACES = re.compile(r"{(\w+)}")
_NO_COORDINATES = (CASE.OUTPUT_KIND,)  # the unit says as much, and titles of plots have room for few coordinates
_OF_PATH = re.compile(r"see ((?:/\w+)+)")  # in units


def dataset_of(file: Reader, only: Sequence[str] = ()) -> xr.Dataset:
    """The contents of an open file.

    A path becomes a name (`/verdict/ratio`: `verdict_ratio`). A family becomes one variable with a dimension for its
    names (`/psd/{output}`: `psd` along `output`), NaN where it lacks a member. Dimensions are those of the contract and
    have their labels as coordinates; what else is said of a label (`area_group`, `output_unit`), and every list of
    words, is a coordinate too. Arrays of numbers are float64 or int64 as the stages read them, attributes `units`,
    `long_name` and `frame`.

    Parameters
    ----------
    only : names of the variables to read, of large files; all by default.

    Raises
    ------
    UsageError : there is no variable of a name in `only`; the nearest is named.
    """
    kind = file.kind
    members = {spec: _members(file, spec) for spec in kind.datasets.values()}
    there = {name_of(spec): spec for spec, paths in members.items() if paths}
    labels = {kind.label_of(dim) for spec in there.values() for dim in dims_of(kind, spec)}
    wanted = set(only) or there.keys()
    for name in only:
        known_name("variable", name, list(there))
    variables: dict[str, Variable] = {}
    coordinates: dict[str, Variable] = {}
    for name, spec in there.items():
        if spec in labels:
            continue
        if _is_coordinate(kind, spec):
            coordinates[name] = _read(file, spec, members[spec])
        elif name in wanted:
            variables[name] = _read(file, spec, members[spec])
    used = {dim for dims, *_ in variables.values() for dim in dims}
    if not only:
        used |= {dim for spec in there.values() for dim in dims_of(kind, spec)}
    coordinates = {name: c for name, c in coordinates.items() if name in only or set(c[0]) <= used}
    for dim in sorted(used):
        label = kind.label_of(dim)
        if isinstance(label, tuple):
            coordinates[dim] = (dim,), list(label), {}
        elif label is not None and file.has(label):
            _, values, attributes = _read(file, kind.datasets[label], members[kind.datasets[label]])
            coordinates[dim] = variable((dim,), values, attributes.get("units", ""), attributes["long_name"])
    return dataset(variables, coordinates, dict(file.attributes))


def name_of(spec: Dataset) -> str:
    """The variable that a dataset becomes."""
    return "_".join(part for part in spec.path.strip("/").split("/") if part != "label" and "{" not in part)


def dims_of(kind: FileKind, spec: Dataset) -> tuple[str, ...]:
    """Its dimensions, those of its family first."""
    families = (kind.datasets[kind.families[brace]].dims[0] for brace in _BRACES.findall(spec))
    return (*families, *spec.dims)


def _is_coordinate(kind: FileKind, spec: Dataset) -> bool:
    """Whether it says something of the places along one dimension."""
    if "{" in spec.path or len(spec.dims) != 1 or spec.path in _NO_COORDINATES:
        return False
    label = kind.label_of(spec.dims[0])
    beside = isinstance(label, str) and label.rpartition("/")[0] == spec.path.rpartition("/")[0] != ""
    return spec.dtype == "str" or (beside and spec.dtype == "int")


def _members(file: Reader, spec: Dataset) -> dict[tuple[str, ...], str]:
    """Paths that the file has of a dataset, by the names in its braces."""
    families = [file.strings(file.kind.families[brace]) for brace in _BRACES.findall(spec)]
    paths = {names: spec.of(*names) for names in itertools.product(*families)}
    return {names: path for names, path in paths.items() if file.has(path)}


def _read(file: Reader, spec: Dataset, members: dict[tuple[str, ...], str]) -> Variable:
    kind = file.kind
    if spec.dtype == "str":
        values: object = np.array(file.strings(spec.path), dtype=str) if spec.dims else file.string(spec.path)
        return variable(spec.dims, values, "", spec.long_name)
    names = [file.strings(kind.families[brace]) for brace in _BRACES.findall(spec)]
    arrays = {each: file.array(path) for each, path in members.items()}
    if not names:
        return variable(spec.dims, arrays[()], _named(kind, file.units(spec.path)), spec.long_name, spec.frame)
    shape = next(iter(arrays.values())).shape
    stacked: AnyArray = np.full((*map(len, names), *shape), np.nan)
    for place, each in zip(np.ndindex(*map(len, names)), itertools.product(*names), strict=True):
        if each in arrays:
            stacked[place] = arrays[each]
    units = {each: file.units(path) for each, path in members.items()}
    return variable(dims_of(kind, spec), stacked, _common_units(file, spec, units), spec.long_name, spec.frame)


def _named(kind: FileKind, units: str) -> str:
    """`see /output/unit` as `see output_unit`."""
    return _OF_PATH.sub(lambda m: f"see {name_of(kind.datasets[m[1]])}" if m[1] in kind.datasets else m[0], units)


def _common_units(file: Reader, spec: Dataset, units: dict[tuple[str, ...], str]) -> str:
    """The unit of a family; where it hangs on that of the outputs, written with it: `(output_unit)^2/Hz`."""
    if len(set(units.values())) == 1:
        return next(iter(units.values()))
    braces = _BRACES.findall(spec)
    for number, brace in enumerate(braces):
        label = file.kind.families[brace]
        unit_path = f"{label.rpartition('/')[0]}/unit"
        if not file.has(unit_path):
            continue
        own = dict(zip(file.strings(label), file.strings(unit_path), strict=True))
        symbol = name_of(file.kind.datasets[unit_path])
        written = {unit.replace(own[each[number]], symbol, 1) for each, unit in units.items()}
        if len(written) == 1:
            return written.pop()
    return "; ".join(f"{'_'.join(each)}: {unit}" for each, unit in units.items())
