"""Checks between the keys and the tables of the optical layout file, on whatever part of it is well formed."""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from pydantic import TypeAdapter, ValidationError

from tedm_cli.config.base import Strict
from tedm_cli.config.optics.tables import (
    CHANGE_KEYS,
    KEYS,
    OPTIONAL_KEYS,
    ElementTable,
    OpticsTables,
    PathTable,
    ReadOut,
)
from tedm_cli.optics.layout import N_LASER

#: By how much the length of a unit vector of seven decimals may be off; so may what is at right angles to it.
ROUNDED = 1e-7

Problems = list[tuple[str, str]]
T = TypeVar("T", bound=Strict)


def cross_checks(data: dict[str, Any], needs_grids: bool = True) -> Problems:
    """Problems between keys and between tables, in the parts of `data` that are well formed."""
    imported = isinstance(data.get("imported"), dict) and "S_BW" in data["imported"]
    raw_elements, raw_paths = _entries(data.get("element")), _entries(data.get("path"))
    elements = [_salvaged(ElementTable, raw) for raw in raw_elements]
    paths = [_salvaged(PathTable, raw)[0] for raw in raw_paths]
    # Malformed elements are still known by name, so that no step is called unknown because of them.
    known: dict[str, ElementTable | None] = {
        raw["name"]: element if whole else None
        for raw, (element, whole) in zip(raw_elements, elements, strict=True)
        if isinstance(raw.get("name"), str)
    }
    raw_sets = data.get("sets")
    sets = {name: _parsed(list[str], v) for name, v in raw_sets.items()} if isinstance(raw_sets, dict) else {}
    read_out: list[str] | None = _parsed(ReadOut, data.get("read_out"))
    raw_grids = data.get("grids")
    # A malformed grid number is reported as such, not as an element without one.
    grids = dict(raw_grids) if isinstance(raw_grids, dict) else {}

    out = _duplicates("element", "name", [raw.get("name") for raw in raw_elements])
    for i, (element, whole) in enumerate(elements):
        if element is not None:
            out += _vector_problems(f"element[{i}]", element)
            out += _key_problems(f"element[{i}]", element, grids, imported, needs_grids) if whole else []
    out += _grid_problems(grids, known)
    n_tm = sum(raw.get("kind") == "test_mass" for raw in raw_elements)
    if raw_elements and n_tm == 0:
        out.append(("element", "none is a test_mass"))
    for i, path in enumerate(paths):
        if path is not None:
            out += _path_problems(f"path[{i}]", path, known, imported)
    beams = Counter((str(raw.get("photodiode")), str(raw.get("beam"))) for raw in raw_paths)
    for i, raw in enumerate(raw_elements):
        for beam in ("meas", "ref") if raw.get("kind") == "photodiode" else ():
            if (n := beams[str(raw.get("name")), beam]) != 1:
                out.append((f"element[{i}]", f"photodiode {raw.get('name')} has {n} paths with beam {beam}, not one"))
    if read_out is not None:
        out += _duplicates("read_out", "", read_out)
    own = [_parsed(ReadOut, raw.get("read_out")) if raw.get("kind") == "test_mass" else [] for raw in raw_elements]
    for i, dofs in enumerate(own):
        out += _duplicates(f"element[{i}].read_out", "", dofs or [])
    n_dof = sum(len(read_out or ()) if dofs is None else len(dofs) for dofs in own)
    out += _expansion_problems(_entries(data.get("test_mass_expansion")), known)
    for set_name, photodiodes in sets.items():
        out += _set_problems(f"sets.{set_name}", photodiodes or [], known)
        if photodiodes and (n_out := N_LASER * len(photodiodes)) < n_dof:
            out.append((f"sets.{set_name}", f"{n_out} laser outputs cannot give {n_dof} read-outs"))
    return out


def lacks_geometry(tables: OpticsTables) -> list[str]:
    """What a valid layout would still need to be traced, as dotted paths."""
    missing = [
        f"element[{i}].{key}"
        for i, e in enumerate(tables.element)
        for key in OPTIONAL_KEYS
        if key in KEYS[e.kind][0] - {"grid"} and getattr(e, key) is None
    ]
    return missing + [f"path[{i}].steps" for i, path in enumerate(tables.path) if path.steps is None]


def imported_problems(tables: OpticsTables) -> Problems:
    """Of `[imported]`, which can be judged once the rest is valid."""
    table = tables.imported
    out: Problems = []
    if "imported" in tables.model_fields_set and table.S_BW is None and table.P is None:
        out.append(("imported", "names neither S_BW nor P"))
    if table.largest_difference is not None and table.S_BW is None:
        out.append(("imported.largest_difference", "is judged on an imported S_BW; none is named"))
    elif table.largest_difference is not None and (missing := lacks_geometry(tables)):
        more = f" and {len(missing) - 1} more" if len(missing) > 1 else ""
        out.append(("imported.largest_difference", f"the layout cannot be traced: {missing[0]} is missing{more}"))
    return out


def _key_problems(at: str, e: ElementTable, grids: Mapping[str, Any], imported: bool, needs_grids: bool) -> Problems:
    needed, allowed = KEYS[e.kind]
    if imported:  # its surfaces need not be known
        needed, allowed = needed & {"grid"}, needed | allowed
    given = {key for key in OPTIONAL_KEYS if getattr(e, key) is not None}
    absent = needed - given - ({"grid"} if e.name in grids or not needs_grids else set())
    out = [(f"{at}.{key}", f"missing; {_one(e.kind)} ({e.name}) needs it") for key in OPTIONAL_KEYS if key in absent]
    out += [
        (f"{at}.{key}", f"{_one(e.kind)} ({e.name}) has no such key")
        for key in OPTIONAL_KEYS
        if key in given - needed - allowed
    ]
    if e.kind == "mirror" and (e.thickness_m is None) != (e.index is None):
        out.append((at, f"mirror {e.name} with a substrate needs both thickness_m and index"))
    changes = [key for key in CHANGE_KEYS if key in given & allowed]
    if changes and e.kind == "mirror" and e.thickness_m is None and e.index is None:
        out.append((f"{at}.{changes[0]}", f"mirror {e.name} has no substrate (thickness_m and index) to change"))
    if e.area is not None and "area" in allowed and not changes:
        out.append((f"{at}.area", f"has no use: {e.name} gives neither {' nor '.join(CHANGE_KEYS)}"))
    if isinstance(e.aperture_m, list) and e.local_y is None:
        out.append((f"{at}.aperture_m", f"half-sizes along local_y x normal and local_y; {e.name} has no local_y"))
    if e.local_y is not None and e.kind != "photodiode" and not isinstance(e.aperture_m, list):
        out.append((f"{at}.local_y", f"{e.name} has no use for it without aperture_m = [a, b]"))
    return out


def _grid_problems(grids: Mapping[str, Any], known: Mapping[str, ElementTable | None]) -> Problems:
    """Of the table `[grids]`, which gives the grids in place of the elements' own key."""
    out: Problems = []
    for name in grids:
        element = known.get(name)
        if name not in known:
            out.append((f"grids.{name}", f"unknown element {name!r}{_near(name, known)}"))
        elif element is not None and element.kind == "test_mass":
            out.append((f"grids.{name}", f"{name} is a test_mass; it floats and has no grid"))
        elif element is not None and element.grid is not None:
            out.append((f"grids.{name}", f"element {name} gives its grid ({element.grid}) itself"))
    return out


def _vector_problems(at: str, e: ElementTable) -> Problems:
    out: Problems = []
    for key, vector in (("normal", e.normal), ("local_y", e.local_y)):
        if vector is not None and abs((length := float(np.linalg.norm(vector))) - 1.0) > ROUNDED:
            unit = [float(c) for c in np.array(vector) / length] if length > 0.0 else None
            meant = f"; {e.name} may mean {unit}" if unit else ""
            out.append((f"{at}.{key}", f"not a unit vector: its length is {length:.12g}{meant}"))
    if e.local_y is not None and e.normal is not None and abs(cosine := float(np.dot(e.local_y, e.normal))) > ROUNDED:
        out.append((f"{at}.local_y", f"not perpendicular to normal: their product is {cosine:.3g}"))
    return out


def _path_problems(at: str, path: PathTable, known: dict[str, ElementTable | None], imported: bool) -> Problems:
    out: Problems = []
    if path.steps is None and not imported:
        out.append((f"{at}.steps", "missing"))
    steps = path.steps or []
    last = len(steps) - 1
    for i, text in enumerate(steps):
        place = f"{at}.steps[{i}]"
        name, colon, op = text.partition(":")
        if name not in known:
            out.append((place, f"unknown element {name!r}{_near(name, known)}"))
            continue
        element = known[name]
        kind = element.kind if element is not None else None
        if i == 0 and (colon or kind not in ("injector", None)):
            out.append((place, f"a path begins with the plain name of an injector, not with {text!r}"))
        elif i == last and (colon or kind not in ("photodiode", None)):
            out.append((place, f"a path ends with the plain name of a photodiode, not with {text!r}"))
        elif i == last and name != path.photodiode:
            out.append((place, f"ends on {name} but the path's photodiode is {path.photodiode}"))
        elif 0 < i < last and op not in ("R", "T"):
            out.append((place, f"{text!r} does not say R (reflected) or T (transmitted), as in '{name}:R'"))
        elif 0 < i < last and kind in ("injector", "photodiode"):
            out.append((place, f"{kind} {name} cannot stand inside a path"))
        elif op == "T" and not imported and element is not None and None in (element.thickness_m, element.index):
            out.append((place, f"{kind} {name} cannot transmit: it has no thickness_m and index"))
    if path.photodiode not in known:
        out.append((f"{at}.photodiode", f"unknown element {path.photodiode!r}{_near(path.photodiode, known)}"))
    if path.wavefront_radius_m == 0.0:
        out.append((f"{at}.wavefront_radius_m", "zero; leave the key out for a plane wave"))
    return out


def _expansion_problems(raw: list[dict[str, Any]], known: Mapping[str, ElementTable | None]) -> Problems:
    out = _duplicates("test_mass_expansion", "test_mass", [entry.get("test_mass") for entry in raw])
    masses = [name for name, element in known.items() if element is None or element.kind == "test_mass"]
    for i, entry in enumerate(raw):
        name = entry.get("test_mass")
        if isinstance(name, str) and name not in masses:
            out.append((f"test_mass_expansion[{i}].test_mass", f"no test_mass is called {name!r}{_near(name, masses)}"))
    return out


def _set_problems(at: str, photodiodes: list[str], known: dict[str, ElementTable | None]) -> Problems:
    out = _duplicates(at, "", photodiodes)
    for i, name in enumerate(photodiodes):
        element = known.get(name)
        if name not in known:
            out.append((f"{at}[{i}]", f"unknown element {name!r}{_near(name, known)}"))
        elif element is not None and element.kind != "photodiode":
            out.append((f"{at}[{i}]", f"{name} is {_one(element.kind)}, not a photodiode"))
    return out


def _duplicates(at: str, key: str, values: Sequence[Any]) -> Problems:
    places: dict[str, int] = {}
    out: Problems = []
    for i, value in enumerate(values):
        if not isinstance(value, str):
            continue
        if value in places:
            out.append((f"{at}[{i}]{'.' if key else ''}{key}", f"{value!r} is already {at}[{places[value]}]"))
        places.setdefault(value, i)
    return out


def _one(kind: str) -> str:
    """The kind with its article."""
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


def _near(name: str, known: Iterable[str]) -> str:
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=0.5)
    return f"; did you mean {near[0]}?" if near else ""


def _entries(value: Any) -> list[dict[str, Any]]:
    """The tables of an array; an entry that is no table stands as an empty one, so that places keep their number."""
    return [v if isinstance(v, dict) else {} for v in value] if isinstance(value, list) else []


def _salvaged(table: type[T], raw: dict[str, Any]) -> tuple[T | None, bool]:
    """`raw` as `table` without its malformed keys (None where those are needed), and whether it was whole."""
    try:
        return table.model_validate(raw), True
    except ValidationError as exc:
        bad = {e["loc"][0] for e in exc.errors()}
        return _parsed(table, {key: v for key, v in raw.items() if key not in bad}), False


def _parsed(kind: Any, value: Any) -> Any:
    """`value` as `kind`, or None where it is malformed (which `validate` has already reported)."""
    try:
        return TypeAdapter(kind).validate_python(value, strict=True)
    except ValidationError:
        return None
