"""Loads other than temperature, as lines of text and for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tedm_cli.cli.printing.table import table
from tedm_cli.results.loads import ROUNDING
from tedm_cli.results.wording import count

if TYPE_CHECKING:
    from tedm_cli.arrays import FloatArray
    from tedm_cli.results.loads import LoadResults, Margins, Modes
    from tedm_cli.stages.loads.build import LoadsSummary
    from tedm_cli.stages.loads.deck import LoadsDeckSummary

_SHARE = 1e-3  # of the mass: what a mode moves less of along an axis is not shown


def loads_deck_lines(done: LoadsDeckSummary) -> list[str]:
    """Size of the deck, and what to know."""
    return [
        f"{done.path}: {count(len(done.loads), 'load')} of {done.cards:,} cards on {done.grids:,} grids",
        *(f"note: {note}" for note in done.notes),
    ]


def loads_deck_dict(done: LoadsDeckSummary) -> dict[str, Any]:
    return {"file": done.path, "grids": done.grids, "cards": done.cards, "loads": done.loads, "notes": done.notes}


def loads_lines(done: LoadsSummary, most: int | None) -> list[str]:
    """The loads that distort most, releases with what they do to alignment, frequencies."""
    r = done.results
    feet = len(set(r.foot) - {"", "INTERFACE"})
    return [
        f"{done.path}: {count(len(r.name), 'load')} ({len(r.motions)} motions of {count(feet, 'foot', 'feet')},"
        f" {count(len(r.releases), 'release')}), {count(len(r.label), 'output')}",
        *([f"no read-outs: {done.no_read_outs}"] if done.no_read_outs else []),
        *_motion_lines(r, most),
        *_release_lines(r, most),
        *([] if r.modes is None else _mode_lines(r.modes, most)),
    ]


def _motion_lines(r: LoadResults, most: int | None) -> list[str]:
    """By what it distorts per metre, then per radian."""
    if not r.motions:
        return []
    lines = [""]
    for unit, words in (("m", "translations of supports, per m"), ("rad", "rotations of supports, per rad")):
        chosen = sorted((k for k in r.motions if r.unit[k] == unit), key=lambda k: -r.ranked[k])
        head = ("load", *_motion_heads(r, "m"), *_heads(r))
        rows = [(r.name[k], *_motions(r, k, 1.0), *_outputs(r, r.by_distortion, k)) for k in chosen[:most]]
        if rows:
            lines += [f"{words} (outputs: by distortion), largest first", *table(head, rows, right=(1, 2, 3))]
            more = len(chosen) - len(rows)
            lines += [f"and {more} more (--top 0: all)"] if more else []
    if r.interface > ROUNDING:
        lines.append(
            f"warning: supports that move as one distort the structure by {r.interface:.1e} of their motion: what else"
            " holds it?"
        )
    else:
        lines.append(f"supports that move as one carry the structure as one, to {r.interface:.1e} of their motion")
    return lines


def _release_lines(r: LoadResults, most: int | None) -> list[str]:
    if not r.releases:
        return []
    head = ("release", *_motion_heads(r, "um"), *_heads(r))
    rows = [(r.name[k], *_motions(r, k, 1e6), *_outputs(r, r.output, k)) for k in r.releases]
    lines = ["", "what a release does to alignment and to the field at rest", *table(head, rows, right=(1, 2, 3))]
    for k in r.releases:
        lines += _spot_lines(r, k, most)
    if r.margins is not None:
        head = ("after", "margin that is", "check", "limit", "left before", "left after", "at")
        margins = []
        for k in r.releases:
            for words, row in (("least", r.margins.least(k)), ("lost most", r.margins.most_lost(k))):
                margins.append((r.name[k], words, *_margin_row(r.margins, row, k)))
        lines += ["margins of the layout, as shares of what is allowed"]
        lines += table(head, margins, right=(3, 4, 5))
    return lines


def _spot_lines(r: LoadResults, load: int, most: int | None) -> list[str]:
    """The spots on photodiodes that move most."""
    spots = [b for b, name in enumerate(r.beam) if name.endswith(("_x", "_y"))]
    if not spots:
        return []
    spots.sort(key=lambda b: -abs(r.beam_shift[b, load]))
    shown = ", ".join(f"{r.beam[b]} {1e6 * r.beam_shift[b, load]:.3g}" for b in spots[: min(most or 3, 3)])
    return [f"spots that {r.name[load]} moves most, um: {shown}"]


def _margin_row(margins: Margins, row: int, load: int) -> tuple[str, ...]:
    limit = f"{margins.limit[row]:.3g} {margins.unit[row]}"
    before, after = margins.left_before[row], margins.left_after(load)[row]
    left = "beam lost" if np.isinf(after) else f"{100.0 * after:.2f} %"
    return margins.check[row], limit, f"{100.0 * before:.2f} %", left, margins.where[row]


def _mode_lines(modes: Modes, most: int | None) -> list[str]:
    left_out = (
        [f"{count(len(modes.rigid), 'rigid motion')} that nothing holds, left out: {', '.join(modes.rigid)}"]
        if modes.rigid
        else []
    )
    rows = [
        (f"{n}", f"{f:.4g}", *(f"{100.0 * s:.1f} %" if s > _SHARE else "" for s in share))
        for n, (f, share) in enumerate(zip(modes.frequency_hz[:most], modes.share, strict=False), start=1)
    ]
    head = ("mode", "Hz", "mass along x", "along y", "along z")
    return ["", "natural frequencies", *left_out, *table(head, rows, right=(0, 1, 2, 3, 4))]


def _motion_heads(r: LoadResults, unit: str) -> list[str]:
    """Of the largest motion of a grid, of it by distortion, and of the largest of an optical element by distortion."""
    return [f"moves {unit}", f"distorts {unit}", *([] if r.bench is None else [f"bench {unit}"])]


def _motions(r: LoadResults, load: int, factor: float) -> list[str]:
    bench = [] if r.bench is None else [r.bench[load]]
    return [f"{factor * value:.3g}" for value in (r.largest[load], r.distortion[load], *bench)]


_UNITS = ("m/s^2", "rad/s^2", "m", "rad")


def _heads(r: LoadResults) -> list[str]:
    return [f"most of {unit}" for unit in _UNITS if r.of_unit(unit)]


def _outputs(r: LoadResults, values: FloatArray, load: int) -> list[str]:
    """The output in each unit that changes most."""
    found = (r.largest_output(values, unit, load) for unit in _UNITS)
    return [f"{one[1]:.2e} {one[0]}" for one in found if one is not None]


def loads_dict(done: LoadsSummary) -> dict[str, Any]:
    """What a program needs of the loads."""
    r = done.results
    return {
        "file": done.path,
        "no_read_outs": done.no_read_outs,
        "interface_distortion": r.interface,
        "relative_residual": r.residual,
        "loads": [
            {
                "name": name,
                "kind": r.kind[k],
                "unit": r.unit[k],
                "foot": r.foot[k],
                "largest_m": r.largest[k],
                "distortion_m": r.distortion[k],
                "bench_distortion_m": None if r.bench is None else r.bench[k],
                "outputs": dict(zip(r.label, r.output[:, k].tolist(), strict=True)),
                "outputs_by_distortion": dict(zip(r.label, r.by_distortion[:, k].tolist(), strict=True)),
                "margins": _margin_dict(r, k),
            }
            for k, name in enumerate(r.name)
        ],
        "units": dict(zip(r.label, r.row_unit, strict=True)),
        "modes": r.modes
        and {
            "frequency_hz": r.modes.frequency_hz,
            "effective_mass": r.modes.effective_mass,
            "mass": r.modes.mass,
            "rigid": r.modes.rigid,
        },
    }


def _margin_dict(r: LoadResults, load: int) -> dict[str, Any] | None:
    if r.margins is None or load not in r.releases:
        return None
    m, left = r.margins, r.margins.left_after(load)
    return {
        words: {
            "check": m.check[row],
            "where": m.where[row],
            "left_before": float(m.left_before[row]),
            "left_after": float(left[row]) if np.isfinite(left[row]) else None,
        }
        for words, row in (("least", m.least(load)), ("lost_most", m.most_lost(load)))
    }
