"""What the page knows: temperatures, outputs, cases and the drawing, as one object that JSON can write."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.noise.outputs import Outputs
from tedm_cli.view.bench import BEAMS, KINDS, DrawnBench
from tedm_cli.view.mesh import DrawnMesh
from tedm_cli.view.packing import Quantised, coordinates, numbers, places, quantised, steps


@dataclass(frozen=True, eq=False)
class Limits:
    """Requirements on one grid of F frequencies (Hz): names, titles, amplitudes [r, F] per √Hz, NaN outside bands."""

    frequency_hz: FloatArray
    name: Sequence[str]
    title: Sequence[str]
    amplitude: FloatArray


@dataclass(frozen=True, eq=False)
class VerdictView:
    """One verdict of a case: places of its output and of its limit, the largest ratio and where, and two patterns.

    asd : [F], of the output, without the safety factor. typical, worst : [k] K/√Hz at `hz`, of all columns.
    """

    output: int
    limit: int
    ratio: float
    hz: float
    asd: FloatArray
    pattern_hz: float
    typical: FloatArray
    worst: FloatArray


@dataclass(frozen=True, eq=False)
class Nodes:
    """Thermal nodes: names, groups and sides of the shield [n], and outputs [n_out, n] per kelvin of each."""

    name: Sequence[str]
    group: Sequence[str]
    shield: Sequence[str]
    rows: FloatArray

    @classmethod
    def none(cls, outputs: int) -> Nodes:
        """No nodes."""
        return cls((), (), (), np.zeros((outputs, 0)))


@dataclass(frozen=True, eq=False)
class Film:
    """Temperatures to be played: `time_s` [B] and [k, B] K in 16 bits, and in words what they are."""

    time_s: FloatArray
    temperature: Quantised
    words: str

    @classmethod
    def of(cls, time_s: FloatArray, temperature_K: FloatArray, words: str) -> Film:
        return cls(time_s, quantised(temperature_K), words)


@dataclass(frozen=True, eq=False)
class CaseView:
    """One correlation case. `film` is None where its noise cannot be realised; `nodes`: it is of thermal nodes."""

    id: str
    title: str
    role: str
    reason: str
    safety_factor: float
    temperature: str
    silent: IntArray
    nodes: bool
    verdicts: Sequence[VerdictView]
    film: Film | None


@dataclass(frozen=True, eq=False)
class Box:
    """A compensation mass, which may move, or a test mass, which stays where it is.

    `triangle` [t, 3, 3] m, its surface; `motion` [k, 3 t, 3] m/K of their corners, None of what stays.
    """

    name: str
    kind: str
    triangle: FloatArray
    motion: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class Drawing:
    """What is drawn: mesh, bench, boxes.

    face_node, line_node : [F] and [L], the column of the thermal node that each face and line of the mesh is in, of its
    area where it is in none; -1: none. position : [n, 3] m, of the mesh's grids. motion : [k, n, 3] m/K in 16 bits, as
    [k, 3 n], x of all grids first. grids : of the model in all. colour : [k, 3], RGB of each column.
    """

    mesh: DrawnMesh
    face_node: IntArray
    line_node: IntArray
    position: FloatArray
    motion: Quantised
    grids: int
    bench: DrawnBench
    boxes: Sequence[Box]
    colour: FloatArray


@dataclass(frozen=True, eq=False)
class ViewModel:
    """All of a page. `sources`: file names with their SHA-256; `version` of tedm; `output_titles`: in plain words.

    `outputs`: of the k thermal areas; `nodes` are columns behind these.

    `half`: what is not there of a project with one half of the chain, or "".
    """

    title: str
    version: str
    sources: Sequence[tuple[str, str]]
    outputs: Outputs
    nodes: Nodes
    output_titles: Sequence[str]
    limits: Limits
    cases: Sequence[CaseView]
    series: Sequence[tuple[str, Film]]
    drawing: Drawing
    half: str = ""


def planes(motion: FloatArray) -> FloatArray:
    """Displacements [k, n, 3] as rows [k, 3 n]: x of all corners, then y, then z."""
    return np.ascontiguousarray(motion.transpose(0, 2, 1)).reshape(len(motion), -1)


def nodes_of(group: str) -> str:
    """The group of thermal nodes in areas of a group."""
    return f"{group}, thermal nodes" if group else "thermal nodes"


def payload(view: ViewModel) -> dict[str, Any]:
    """The same for JSON. Sensitivities, patterns and spectra keep all their digits."""
    areas, outputs, nodes = view.outputs.areas, view.outputs, view.nodes
    return {
        "title": view.title,
        "version": view.version,
        "half": view.half,
        "sources": [{"name": name, "sha256": sha256} for name, sha256 in view.sources],
        "areas": {
            "name": [*areas.name.tolist(), *nodes.name],
            "count": len(areas),
            "group": [*areas.group_by_unit.tolist(), *map(nodes_of, nodes.group)],
            "base": [*areas.group_by_unit.tolist(), *nodes.group],
            "unit": [*areas.unit, *["K"] * len(nodes.name)],
            "shield": [*areas.shield.tolist(), *nodes.shield],
        },
        "outputs": {
            "label": list(outputs.labels),
            "title": list(view.output_titles),
            "unit": list(outputs.units),
            "rows": numbers(np.concatenate([outputs.rows, nodes.rows], axis=1)),
        },
        "limits": {
            "frequency": numbers(view.limits.frequency_hz),
            "name": list(view.limits.name),
            "title": list(view.limits.title),
            "amplitude": numbers(view.limits.amplitude),
        },
        "cases": [_case(case) for case in view.cases],
        "series": [{"name": name, **_film(film)} for name, film in view.series],
        "drawing": _drawing(view.drawing),
    }


def _case(case: CaseView) -> dict[str, Any]:
    return {
        "id": case.id,
        "title": case.title,
        "role": case.role,
        "reason": case.reason,
        "safety": case.safety_factor,
        "temperature": case.temperature,
        "silent": case.silent.tolist(),
        "nodes": case.nodes,
        "verdicts": [
            {
                "output": v.output,
                "limit": v.limit,
                "ratio": v.ratio,
                "hz": v.hz,
                "patternHz": v.pattern_hz,
                "asd": numbers(v.asd),
                "typical": numbers(v.typical),
                "worst": numbers(v.worst),
            }
            for v in case.verdicts
        ],
        "film": None if case.film is None else _film(case.film),
    }


def _film(film: Film) -> dict[str, Any]:
    return {
        "time": numbers(film.time_s),
        "scale": numbers(film.temperature.scale),
        "steps": steps(film.temperature.step),
        "words": film.words,
    }


def _drawing(d: Drawing) -> dict[str, Any]:
    bench = quantised(planes(d.bench.motion))
    carried = [np.zeros((len(d.motion.scale), 0, 3)), *(box.motion for box in d.boxes if box.motion is not None)]
    boxes = quantised(planes(np.concatenate(carried, axis=1)))
    return {
        "grids": d.grids,
        "cell": d.mesh.cell_m,
        "mesh": {
            "position": coordinates(d.position),
            "scale": numbers(d.motion.scale),
            "steps": steps(d.motion.step),
            "face": places(d.mesh.face),
            "faceArea": places(d.mesh.face_area),
            "line": places(d.mesh.line),
            "lineArea": places(d.mesh.line_area),
            "faceNode": places(d.face_node),
            "lineNode": places(d.line_node),
        },
        "bench": {
            "position": coordinates(d.bench.position),
            "scale": numbers(bench.scale),
            "steps": steps(bench.step),
            "face": places(d.bench.face),
            "faceKind": places(d.bench.face_kind),
            "segment": places(d.bench.segment),
            "segmentBeam": places(d.bench.segment_beam),
            "kinds": list(KINDS),
            "beams": list(BEAMS),
        },
        "boxes": [
            {"name": b.name, "kind": b.kind, "corner": [[float(v) for v in p] for p in b.triangle.reshape(-1, 3)]}
            for b in d.boxes
        ],
        "carried": {"scale": numbers(boxes.scale), "steps": steps(boxes.step)},
        "colour": [[round(float(v), 4) for v in rgb] for rgb in d.colour],
    }
