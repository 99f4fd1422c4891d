"""The optical layout file: strict tables, checks across tables, and the way to the pure layout."""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import Field, PositiveFloat, PositiveInt, TypeAdapter, ValidationError

from tedm_cli.config.base import Strict, read_toml, validate
from tedm_cli.errors import ConfigError
from tedm_cli.optics.layout import N_LASER, Beam, BeamPath, Dof, Element, Kind, OpticalLayout, Step, Vec3
from tedm_cli.provenance import ConfigFile

UNIT_TOLERANCE = 1e-9  # of the length of a unit vector and the right angle between axes

Vector = Annotated[list[float], Field(min_length=3, max_length=3)]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_.-]*$")]
Sets = Annotated[dict[Name, Annotated[list[str], Field(min_length=1)]], Field(min_length=1)]
ReadOut = Annotated[list[Dof], Field(min_length=1)]
Problems = list[tuple[str, str]]
T = TypeVar("T", bound=Strict)

#: Keys beyond name, kind, ref_m and normal: (needed, allowed) by kind.
_KEYS: dict[Kind, tuple[frozenset[str], frozenset[str]]] = {
    "test_mass": (frozenset({"front_offset_m"}), frozenset()),
    "injector": (frozenset({"grid"}), frozenset({"opl_offset_m"})),
    "window": (frozenset({"grid", "thickness_m", "index"}), frozenset({"front_offset_m"})),
    "beamsplitter": (frozenset({"grid", "thickness_m", "index"}), frozenset({"front_offset_m"})),
    "mirror": (frozenset({"grid"}), frozenset({"front_offset_m", "thickness_m", "index"})),
    "photodiode": (frozenset({"grid", "local_y"}), frozenset()),
}
_OPTIONAL = ("grid", "front_offset_m", "thickness_m", "index", "local_y", "opl_offset_m")


class ElementTable(Strict):
    """One `[[element]]`; which of the optional keys belong to it depends on its kind."""

    name: Name
    kind: Kind
    ref_m: Vector
    normal: Vector
    front_offset_m: float | None = None
    thickness_m: PositiveFloat | None = None
    index: Annotated[float, Field(ge=1.0)] | None = None
    local_y: Vector | None = None
    opl_offset_m: float | None = None
    grid: PositiveInt | None = None


class PathTable(Strict):
    """One `[[path]]`: the ordered steps of one beam to one photodiode."""

    photodiode: str
    beam: Beam
    steps: Annotated[list[str], Field(min_length=2)]
    wavefront_radius_m: float | None = None


class FrameTable(Strict):
    """The layout frame in the model's basic frame."""

    origin_m: Vector
    axes: Annotated[list[Vector], Field(min_length=3, max_length=3)]


class OpticsTables(Strict):
    """The whole layout file."""

    title: str
    wavelength_m: PositiveFloat
    read_out: ReadOut
    frame: FrameTable
    sets: Sets
    element: Annotated[list[ElementTable], Field(min_length=1)]
    path: Annotated[list[PathTable], Field(min_length=1)]


def load_layout(path: Path) -> tuple[ConfigFile, OpticalLayout]:
    """Read and check the layout file at `path`.

    Raises
    ------
    InputError : there is no such file.
    ConfigError : the file is not a valid layout; all its problems are listed with their dotted paths.
    """
    file, data = read_toml(path)
    problems: Problems = []
    tables: OpticsTables | None = None
    try:
        tables = validate(OpticsTables, data, where=str(path))
    except ConfigError as exc:
        problems += exc.problems
    # A malformed table must not hide what is wrong in the others, so the checks run on whatever part is well formed.
    problems += _cross_checks(data)
    if problems or tables is None:
        raise ConfigError(problems, where=str(path))
    return file, _layout(tables)


def _layout(tables: OpticsTables) -> OpticalLayout:
    return OpticalLayout(
        title=tables.title,
        wavelength_m=tables.wavelength_m,
        elements=tuple(_element(e) for e in tables.element),
        paths=tuple(_path(p) for p in tables.path),
        sets={name: tuple(photodiodes) for name, photodiodes in tables.sets.items()},
        read_out=tuple(tables.read_out),
        frame_origin_m=_vec3(tables.frame.origin_m),
        frame_axes=(_vec3(tables.frame.axes[0]), _vec3(tables.frame.axes[1]), _vec3(tables.frame.axes[2])),
    )


def _element(e: ElementTable) -> Element:
    return Element(
        name=e.name,
        kind=e.kind,
        ref_m=_vec3(e.ref_m),
        normal=_vec3(_normalised(e.normal)),
        front_offset_m=e.front_offset_m or 0.0,
        thickness_m=e.thickness_m or 0.0,
        index=1.0 if e.index is None else e.index,
        local_y=None if e.local_y is None else _vec3(_normalised(e.local_y)),
        opl_offset_m=e.opl_offset_m or 0.0,
        grid=e.grid,
    )


def _path(p: PathTable) -> BeamPath:
    steps = [Step(p.steps[0], "emit")]
    for text in p.steps[1:-1]:
        name, _, op = text.partition(":")
        steps.append(Step(name, "R" if op == "R" else "T"))
    steps.append(Step(p.steps[-1], "detect"))
    return BeamPath(p.photodiode, p.beam, tuple(steps), p.wavefront_radius_m)


def _vec3(v: Sequence[float]) -> Vec3:
    return (float(v[0]), float(v[1]), float(v[2]))


def _normalised(v: Sequence[float]) -> list[float]:
    return list(np.array(v) / np.linalg.norm(v))


def _cross_checks(data: dict[str, Any]) -> Problems:
    """Problems between keys and between tables, in the parts of `data` that are well formed."""
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
    frame: FrameTable | None = _parsed(FrameTable, data.get("frame"))

    out = _duplicates("element", "name", [raw.get("name") for raw in raw_elements])
    for i, (element, whole) in enumerate(elements):
        if element is not None:
            out += _vector_problems(f"element[{i}]", element)
            out += _key_problems(f"element[{i}]", element) if whole else []
    n_tm = sum(raw.get("kind") == "test_mass" for raw in raw_elements)
    if raw_elements and n_tm == 0:
        out.append(("element", "none is a test_mass"))
    for i, path in enumerate(paths):
        if path is not None:
            out += _path_problems(f"path[{i}]", path, known)
    beams = Counter((str(raw.get("photodiode")), str(raw.get("beam"))) for raw in raw_paths)
    for i, raw in enumerate(raw_elements):
        for beam in ("meas", "ref") if raw.get("kind") == "photodiode" else ():
            if (n := beams[str(raw.get("name")), beam]) != 1:
                out.append((f"element[{i}]", f"photodiode {raw.get('name')} has {n} paths with beam {beam}, not one"))
    if read_out is not None:
        out += _duplicates("read_out", "", read_out)
    for set_name, photodiodes in sets.items():
        out += _set_problems(f"sets.{set_name}", photodiodes or [], known)
        if photodiodes and (n_out := N_LASER * len(photodiodes)) < (n_dof := n_tm * len(read_out or ())):
            out.append((f"sets.{set_name}", f"{n_out} laser outputs cannot give {n_dof} read-outs"))
    if frame is not None:
        axes = np.array(frame.axes)
        if np.abs(axes @ axes.T - np.eye(3)).max() > UNIT_TOLERANCE or np.linalg.det(axes) < 0:
            out.append(("frame.axes", "rows are not right-handed orthogonal unit vectors"))
    return out


def _key_problems(at: str, e: ElementTable) -> Problems:
    needed, allowed = _KEYS[e.kind]
    given = {key for key in _OPTIONAL if getattr(e, key) is not None}
    out = [(f"{at}.{key}", f"missing; a {e.kind} ({e.name}) needs it") for key in _OPTIONAL if key in needed - given]
    out += [
        (f"{at}.{key}", f"a {e.kind} ({e.name}) has no such key")
        for key in _OPTIONAL
        if key in given - needed - allowed
    ]
    if e.kind == "mirror" and (e.thickness_m is None) != (e.index is None):
        out.append((at, f"mirror {e.name} with a substrate needs both thickness_m and index"))
    return out


def _vector_problems(at: str, e: ElementTable) -> Problems:
    out: Problems = []
    for key, vector in (("normal", e.normal), ("local_y", e.local_y)):
        if vector is not None and abs((length := float(np.linalg.norm(vector))) - 1.0) > UNIT_TOLERANCE:
            out.append((f"{at}.{key}", f"not a unit vector: its length is {length:.12g}"))
    if e.local_y is not None and abs(cosine := float(np.dot(e.local_y, e.normal))) > UNIT_TOLERANCE:
        out.append((f"{at}.local_y", f"not perpendicular to normal: their product is {cosine:.3g}"))
    return out


def _path_problems(at: str, path: PathTable, known: dict[str, ElementTable | None]) -> Problems:
    out: Problems = []
    last = len(path.steps) - 1
    for i, text in enumerate(path.steps):
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
        elif op == "T" and element is not None and (element.thickness_m is None or element.index is None):
            out.append((place, f"{kind} {name} cannot transmit: it has no thickness_m and index"))
    if path.photodiode not in known:
        out.append((f"{at}.photodiode", f"unknown element {path.photodiode!r}{_near(path.photodiode, known)}"))
    if path.wavefront_radius_m == 0.0:
        out.append((f"{at}.wavefront_radius_m", "zero; leave the key out for a plane wave"))
    return out


def _set_problems(at: str, photodiodes: list[str], known: dict[str, ElementTable | None]) -> Problems:
    out = _duplicates(at, "", photodiodes)
    for i, name in enumerate(photodiodes):
        element = known.get(name)
        if name not in known:
            out.append((f"{at}[{i}]", f"unknown element {name!r}{_near(name, known)}"))
        elif element is not None and element.kind != "photodiode":
            out.append((f"{at}[{i}]", f"{name} is a {element.kind}, not a photodiode"))
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
