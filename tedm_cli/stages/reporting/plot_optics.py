"""plot, the optics: the bench, its matrices, and the bench under the loads of single areas."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.config.project import Project
from tedm_cli.contracts import OPTICS
from tedm_cli.errors import UsageError
from tedm_cli.figures.drawing.pages import NUMBER, SHARES, in_parts, map_pages, without_twins
from tedm_cli.figures.drawing.spec import FigureSpec
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.optics.benches import benches
from tedm_cli.optics.exaggerated import exaggerated_bench, motion_of_elements
from tedm_cli.results.areas import maps_by_kind, read_areas
from tedm_cli.results.build_folder import ReadOutMatrices, Results
from tedm_cli.results.optics import ReadOuts, read_bench_motion, read_out_maps, read_read_outs
from tedm_cli.results.ranking import first_largest
from tedm_cli.results.titles import outputs_title
from tedm_cli.results.wording import READ_OUT_UNIT, and_text, number_text, the_bench
from tedm_cli.stages.reporting import draw

if TYPE_CHECKING:
    from tedm_cli.figures.drawing.spec import Figure

_QUANTITY = {"m": "displacement", "rad": "angle"}


def optics_specs(results: Results) -> list[FigureSpec]:
    """Figures of the optics, in the order of the report; none of a project without."""
    if results.read_out is None:
        return []
    file, layout = results.read_out.reader, results.read_out.layout
    areas = read_areas(file)
    source = (results.read_out.source,)
    first = next(iter(layout.sets))
    read_outs = read_read_outs(file)
    names = list(benches(layout))
    bench, drawn_benches = the_bench(len(names)), "bench" if len(names) == 1 else f"benches {and_text(names)}"
    specs: list[FigureSpec] = []

    def add(name: str, section: str, caption: str, drawn: Callable[[], Figure]) -> None:
        specs.append(FigureSpec(name, section, caption, source, drawn))

    if layout.has_geometry:  # else S_BW was made elsewhere, and where the beams run is not known
        add(
            "bench.svg",
            "bench",
            f"The optical {drawn_benches} to scale, layout frame. Where both beams of a photodiode coincide, the"
            " reference beam is the light dashed line below the other; plates are drawn with their thickness, mirrors"
            " as far as their aperture.",
            partial(draw.bench, layout),
        )
    add(
        "s_bw.svg",
        "optics",
        "Optical sensitivity matrix S_BW: five outputs of every beam by six motions of every element, about its"
        " finite-element grid. Lengths count in units of the bench size, so that entries in m/m, m/rad and rad/rad"
        " compare; white is zero.",
        partial(draw.optical_sensitivity, layout, file),
    )
    maps = [without_twins(m) for m in read_out_maps(file)]
    for suffix, noun, mine, own in maps_by_kind(maps, areas):
        per = "kelvin" if own.unit[0] == "K" else own.unit[0]
        for part, page in in_parts(map_pages(mine, own, NUMBER)):
            add(
                f"read_out_by_area{suffix}{part.suffix}.svg",
                "read-out",
                f"Read-out N of photodiode set{'s' if len(layout.sets) > 1 else ''} {' and '.join(layout.sets)} per"
                f" {per} of each {noun}, with its sign; the colours are logarithmic. Read-outs that are equal share a"
                f" column{part.words}.",
                partial(draw.read_out_by_area, page, own),
            )
    made = "and the distortion of each element by its motions"
    if read_outs.plates is not None:
        made = "the distortion of each element by its motions, and the glass of each plate by its index and thickness"
    for unit, (shown, _) in READ_OUT_UNIT.items():
        rows = [i for i, u in enumerate(read_outs.unit) if u == unit]
        for part, some in in_parts([rows[i : i + SHARES] for i in range(0, len(rows), SHARES)]):
            add(
                f"shares_{_QUANTITY[unit]}{part.suffix}.svg",
                "read-out",
                f"Read-outs of {_QUANTITY[unit]} of set {first} ({shown}/K): the areas that matter most, and what"
                f" makes the read-out under the first of these areas: {bench} moving as one against the test masses,"
                f" {made}. Contributions have signs; they sum to the read-out{part.words}.",
                partial(_shares_figure, read_outs, first, areas, some, f"{bench} as one".removeprefix("the ")),
            )
    if not layout.has_geometry:
        return specs
    worst: dict[int, list[str]] = {}
    for name, row in zip(read_outs.label, read_outs.N[first], strict=True):
        worst.setdefault(worst_area(row, ~areas.gradient), []).append(name)
    for area, felt_by in worst.items():
        specs.append(
            _area_spec(
                results.read_out,
                results.distortion,
                areas,
                area,
                f" It is the worst area for the {outputs_title([f'{first}_{name}' for name in felt_by])}.",
            )
        )
    return specs


def area_specs(project: Project, results: Results, names: Sequence[str]) -> list[FigureSpec]:
    """The bench under the unit loads of the areas `names`, each a figure.

    Raises
    ------
    UsageError : there is no such area, or the layout has no geometry to draw.
    ConfigError : the project has no optics.
    """
    optics = results.read_out
    if optics is None:
        raise project.lacks_optics()
    if names and not optics.layout.has_geometry:
        raise UsageError("the layout has no geometry of its beams, so the bench cannot be drawn", where="--area")
    areas = read_areas(optics.reader)
    known = areas.name.tolist()
    unknown = [name for name in names if name not in known]
    if unknown:
        near = difflib.get_close_matches(unknown[0], known, n=1)
        raise UsageError(
            f"no thermal area is called {', '.join(unknown)}",
            where=str(optics.file.path),
            hint=f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}",
        )
    return [_area_spec(optics, results.distortion, areas, known.index(name), "") for name in dict.fromkeys(names)]


def worst_area(read_out: FloatArray, of: BoolArray) -> int:
    """The area with the largest read-out [k] of those in `of` [k], the first of those that tie up to rounding."""
    found: int = first_largest(np.flatnonzero(of).tolist(), np.abs(read_out[of]).tolist())
    return found


def _shares_figure(r: ReadOuts, name: str, areas: AreaTable, rows: Sequence[int], bench: str) -> Figure:
    """What makes some read-outs of one set that share a unit, each under the area with the largest."""
    from tedm_cli.figures.optics.shares import ReadOutShares, shares_figure

    noise = r.N[name]
    means = ~areas.gradient
    worst = [worst_area(row, means) for row in noise]
    distortion = r.by_motion(name, r.motion - r.rigid_motion)
    as_one = r.by_motion(name, r.rigid_motion).sum(axis=1, keepdims=True)
    share = np.concatenate([as_one, distortion], axis=1)  # the sum of the rigid part alone is of use: its terms cancel
    if r.plates is not None:
        by_plate = r.by_plate(name)
        plates, changes = by_plate.shape[1:3]
        share = np.pad(share, ((0, 0), (0, plates), (0, changes), (0, 0)))
        share[:, -plates:, -changes:] = by_plate
    unit = r.unit[rows[0]]
    shown, factor = READ_OUT_UNIT[unit]
    chosen = [
        ReadOutShares(
            r.label[i], shown, factor * np.where(means, noise[i], 0.0), worst[i], factor * share[i, :, :, worst[i]]
        )
        for i in rows
    ]
    title = f"What makes the read-out {_QUANTITY[unit]}s, set {name}"
    return shares_figure(chosen, areas.name.tolist(), [bench, *r.part_names], title)


def _area_spec(optics: ReadOutMatrices, distortion: Reader, areas: AreaTable, area: int, remark: str) -> FigureSpec:
    file = optics.reader
    number, name = int(file.array(OPTICS.AREA_ID)[area]), str(areas.name[area])
    safe = re.sub(r"[^A-Za-z0-9._-]+", "_", name)  # names come from the user's files
    several = "" if len(benches(optics.layout)) == 1 else "es"
    load = f"1 {areas.unit[area]} of {name}"
    return FigureSpec(
        f"bench_area{number:02d}_{safe}.svg",
        "load",
        f"The bench{several} under {load}, before (grey) and after, motions exaggerated.{remark} Beams are"
        " traced through the exaggerated poses, surfaces extended where a beam misses them; test masses stay where they"
        " are.",
        (optics.source,),
        partial(_load_figure, optics, distortion, area, f"1 {areas.unit[area]} on {name}"),
    )


def _load_figure(optics: ReadOutMatrices, distortion: Reader, area: int, load: str) -> Figure:
    from tedm_cli.figures.optics.bench import exaggerated_figure

    layout, r, bench = optics.layout, read_read_outs(optics.reader), read_bench_motion(distortion)
    motion = motion_of_elements(layout, bench.motion[area], bench.position_m)
    by_text: dict[str, list[str]] = {}
    for read_out_set in layout.sets:
        parts = []
        for label, unit, value in zip(r.label, r.unit, r.N[read_out_set][:, area], strict=True):
            shown, factor = READ_OUT_UNIT[unit]
            parts.append(f"{label} {number_text(factor * value)} {shown}".replace(" ", "\N{NO-BREAK SPACE}"))
        by_text.setdefault(", ".join(parts), []).append(read_out_set)
    lines = [
        f"{'sets' if len(sets) > 1 else 'set'} {' and '.join(sets)} read{'' if len(sets) > 1 else 's'} {text}"
        for text, sets in by_text.items()
    ]
    return exaggerated_figure(layout, exaggerated_bench(layout, motion), load, lines)
