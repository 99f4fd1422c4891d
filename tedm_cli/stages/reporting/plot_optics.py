"""plot, the optics: the bench, its matrices, and the bench under the loads of single areas."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import UsageError
from tedm_cli.figures.spec import FigureSpec
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.optics.exaggerated import exaggerated_bench, motion_of_elements
from tedm_cli.optics.layout import N_MOTIONS
from tedm_cli.optics.shares import motion_terms
from tedm_cli.results.areas import AreaMap, read_areas
from tedm_cli.results.build_folder import Results
from tedm_cli.results.ranking import first_largest
from tedm_cli.results.wording import number_text
from tedm_cli.stages.reporting import draw

if TYPE_CHECKING:
    from tedm_cli.figures.spec import Figure

_SHOWN = {"m": ("pm", 1e12), "rad": ("nrad", 1e9)}  # units of read-outs in figures
_QUANTITY = {"m": "displacement", "rad": "angle"}


def optics_specs(results: Results) -> list[FigureSpec]:
    """Figures of the optics, in the order of the report."""
    file, layout = results.optics, results.layout
    areas = read_areas(file)
    source = (f"{results.optics_file.path.name} {results.optics_file.sha256}",)
    first = next(iter(layout.sets))
    specs: list[FigureSpec] = []

    def add(name: str, section: str, caption: str, drawn: Callable[[], Figure]) -> None:
        specs.append(FigureSpec(name, section, caption, source, drawn))

    if layout.has_geometry:  # else S_BW was made elsewhere, and where the beams run is not known
        add(
            "bench.svg",
            "bench",
            "The optical bench to scale, layout frame. Where both beams of a photodiode coincide, the reference beam is"
            " the light dashed line below the other; plates are drawn with their thickness, mirrors as far as their"
            " aperture.",
            partial(draw.bench, layout),
        )
    add(
        "s_bw.svg",
        "optics",
        "Optical sensitivity matrix S_BW: five outputs of every beam by six motions of every element, about its"
        " finite-element grid. Lengths count in units of the bench size, so that entries in m/m, m/rad and rad/rad"
        " compare; white is zero.",
        partial(draw.optical_sensitivity, layout, file.array("/S_BW")),
    )
    add(
        "read_out_by_area.svg",
        "read-out",
        f"Read-out N of photodiode set{'s' if len(layout.sets) > 1 else ''} {' and '.join(layout.sets)} per kelvin of"
        " each thermal area, with its sign; the colours are logarithmic.",
        partial(draw.read_out_by_area, read_out_maps(file), areas, "Read-out by area"),
    )
    for unit, (shown, _) in _SHOWN.items():
        if unit in file.strings("/label/read_out_unit"):
            add(
                f"shares_{_QUANTITY[unit]}.svg",
                "read-out",
                f"Read-outs of {_QUANTITY[unit]} of set {first} ({shown}/K): the areas that matter most, and what"
                " makes the read-out under the first of these areas: the bench moving as one against the test masses,"
                " and the distortion of each element by its motions. Contributions have signs; they sum to the"
                " read-out.",
                partial(_shares_figure, results, areas, unit),
            )
    if not layout.has_geometry:
        return specs
    worst: dict[int, list[str]] = {}
    for name, row in zip(file.strings("/label/read_out"), file.array(f"/N/{first}"), strict=True):
        worst.setdefault(worst_area(row), []).append(name)
    for area, read_outs in worst.items():
        specs.append(_area_spec(results, areas, area, f" It is the worst area for {', '.join(read_outs)}."))
    return specs


def area_specs(results: Results, names: Sequence[str]) -> list[FigureSpec]:
    """The bench under the unit loads of the areas `names`, each a figure.

    Raises
    ------
    UsageError : there is no such area, or the layout has no geometry to draw.
    """
    if names and not results.layout.has_geometry:
        raise UsageError("the layout says not where its beams run, so no bench can be drawn", where="--area")
    areas = read_areas(results.optics)
    known = areas.name.tolist()
    unknown = [name for name in names if name not in known]
    if unknown:
        near = difflib.get_close_matches(unknown[0], known, n=1)
        raise UsageError(
            f"no thermal area is called {', '.join(unknown)}",
            where=str(results.optics_file.path),
            hint=f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}",
        )
    return [_area_spec(results, areas, known.index(name), "") for name in dict.fromkeys(names)]


def worst_area(read_out: FloatArray) -> int:
    """The area with the largest read-out [k], the first of those that tie up to rounding."""
    return first_largest(range(len(read_out)), [float(v) for v in np.abs(read_out)])


def read_out_maps(file: Reader) -> list[AreaMap]:
    """N of all photodiode sets, a panel for each unit, read-outs of the sets beside each other."""
    sets, labels = file.strings("/set/name"), file.strings("/label/read_out")
    units = file.strings("/label/read_out_unit")
    noise = {name: file.array(f"/N/{name}") for name in sets}
    maps = []
    for unit in dict.fromkeys(units):
        shown, factor = _SHOWN[unit]
        chosen = [(i, name) for i, u in enumerate(units) if u == unit for name in sets]
        value = factor * np.array([noise[name][i] for i, name in chosen])
        names = [f"{name}_{labels[i]}" for i, name in chosen]
        maps.append(AreaMap("N", f"{shown}/K", names, value))
    return maps


def _shares_figure(results: Results, areas: AreaTable, unit: str) -> Figure:
    from tedm_cli.figures.shares import ReadOutShares, shares_figure

    file, layout = results.optics, results.layout
    name = next(iter(layout.sets))
    noise, labels, units = (
        file.array(f"/N/{name}"),
        file.strings("/label/read_out"),
        file.strings("/label/read_out_unit"),
    )
    worst = [worst_area(row) for row in noise]
    gain, motion, rigid = file.array(f"/gain/{name}"), file.array("/motion"), file.array("/rigid_motion")
    shape = (len(labels), len(layout.elements), N_MOTIONS, len(areas))
    distortion = motion_terms(gain, motion - rigid).reshape(shape)
    as_one = motion_terms(gain, rigid).reshape(shape).sum(axis=1, keepdims=True)
    share = np.concatenate([as_one, distortion], axis=1)  # the sum of the rigid part alone is of use: its terms cancel
    shown, factor = _SHOWN[unit]
    chosen = [
        ReadOutShares(labels[i], shown, factor * noise[i], worst[i], factor * share[i, :, :, worst[i]])
        for i, u in enumerate(units)
        if u == unit
    ]
    title = f"What makes the read-out {_QUANTITY[unit]}s, set {name}"
    return shares_figure(chosen, areas.name.tolist(), ["bench as one", *(e.name for e in layout.elements)], title)


def _area_spec(results: Results, areas: AreaTable, area: int, remark: str) -> FigureSpec:
    file = results.optics
    number, name = int(file.array("/area/id")[area]), str(areas.name[area])
    safe = re.sub(r"[^A-Za-z0-9._-]+", "_", name)  # names come from the user's files
    return FigureSpec(
        f"bench_area{number:02d}_{safe}.svg",
        "load",
        f"The bench under 1 K of {name}, before (grey) and after, motions exaggerated.{remark} Beams are traced through"
        " the exaggerated poses, surfaces extended where a beam misses them; test masses stay where they are.",
        (f"{results.optics_file.path.name} {results.optics_file.sha256}",),
        partial(_load_figure, results, area, name),
    )


def _load_figure(results: Results, area: int, name: str) -> Figure:
    from tedm_cli.figures.bench import exaggerated_figure

    layout, file = results.layout, results.optics
    motion = motion_of_elements(layout, _motion(results)[area], results.distortion.array("/optical/position"))
    by_text: dict[str, list[str]] = {}
    units = file.strings("/label/read_out_unit")
    for read_out_set in layout.sets:
        values = file.array(f"/N/{read_out_set}")[:, area]
        parts = [
            f"{label} {number_text(factor * value)} {shown}"
            for label, value, (shown, factor) in zip(
                file.strings("/label/read_out"), values, (_SHOWN[u] for u in units), strict=True
            )
        ]
        by_text.setdefault(", ".join(parts), []).append(read_out_set)
    lines = [
        f"{'sets' if len(sets) > 1 else 'set'} {' and '.join(sets)} read{'' if len(sets) > 1 else 's'} {text}"
        for text, sets in by_text.items()
    ]
    return exaggerated_figure(layout, exaggerated_bench(layout, motion), f"1 K on {name}", lines)


def _motion(results: Results) -> FloatArray:
    """Motion of the grids of the bench elements per kelvin of every area, [k, n_bench, 6], basic frame."""
    file = results.distortion
    return np.concatenate([file.array("/D_opt/translation"), file.array("/D_opt/rotation")], axis=2)
