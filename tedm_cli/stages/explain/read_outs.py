"""What the read-out in optics.h5 is made of, by element, degree of freedom, beam and thermal area."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import OPTICS
from tedm_cli.errors import UsageError
from tedm_cli.files.build_folder import OPTICS_FILE
from tedm_cli.files.store import open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.optics.shares import SetComparison, beam_terms, compare_sets, motion_terms, shares
from tedm_cli.results.areas import read_areas, unit_per
from tedm_cli.results.cases.effects import read_effects
from tedm_cli.results.optics import Beams, ReadOuts, read_beams, read_quality, read_read_outs
from tedm_cli.stages.common import known_name

UNIFORM = "uniform"
_ROUNDING = 1e-12


@dataclass(frozen=True, eq=False)
class Shares:
    """Terms of a read-out: their labels, signed shares (sum 1), and sizes: root of the sum of squares over areas."""

    label: tuple[str, ...]
    share: FloatArray
    size: FloatArray

    def ranked(self, most: int | None) -> list[int]:
        """Places of the largest shares, largest first, without those that carry nothing but rounding."""
        order = np.argsort(-np.abs(self.share), kind="stable")[:most]
        return [int(i) for i in order if abs(self.share[i]) > _ROUNDING]


@dataclass(frozen=True)
class Beside:
    """A part of a read-out beside all motion: `plates`, whose glass changes, or the user's own `effects`."""

    name: str
    share: float
    size: float


@dataclass(frozen=True, eq=False)
class ReadOutExplained:
    """One read-out (m/K or rad/K): its size over the areas asked for, their sum (the uniform load), and its parts.

    Of all areas, those of mean temperatures; `gradients` has what each gradient reads, per K/m. `beside`: what is
    beside all motion; nothing where what is asked for is the distortion alone.
    """

    label: str
    unit: str
    size: float
    total: float
    rigid_share: float
    rigid_size: float
    distortion_size: float
    beside: tuple[Beside, ...]
    value: FloatArray
    areas: Shares
    motions: Shares
    elements: Shares
    beams: Shares
    gradients: tuple[tuple[str, float], ...]


@dataclass(frozen=True, eq=False)
class Explanation:
    """What was asked, every read-out of the set, and how the sets differ in all areas of mean temperatures.

    `areas`: their names. `load_unit`: that of what is asked for, K, or K/m of one gradient.
    """

    path: Path
    set_name: str
    condition: float
    areas: tuple[str, ...]
    load: str
    load_unit: str
    distortion_only: bool
    read_outs: tuple[ReadOutExplained, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    comparisons: tuple[SetComparison, ...]


def explain(
    project: Project,
    read_out: str | None = None,
    set_name: str | None = None,
    area: str | None = None,
    *,
    uniform: bool = False,
    distortion_only: bool = False,
) -> Explanation:
    """Shares in one read-out or all of them, over all areas, for one of them, or for the uniform load.

    Raises
    ------
    UsageError : there is no such read-out, set or area; what there is, is listed.
    ConfigError : the project has no optics.
    """
    project.required_optics()
    model = load_model(project.model)[1]
    path = project.build_dir / OPTICS_FILE
    with open_checked(path, OPTICS) as file:
        r, condition = read_read_outs(file), read_quality(file).condition
        sets, names = r.sets, r.label
        chosen = known_name("set", set_name, sets) if set_name is not None else sets[0]
        wanted = [known_name("read-out", read_out, names)] if read_out is not None else names
        table = read_areas(file)
        areas, means = table.name.tolist(), ~table.gradient
        if uniform and area is not None:
            raise UsageError("--area and --uniform ask for different loads", hint="give one of them")
        load = UNIFORM if uniform else "" if area is None else known_name("area", area, areas)
        every = np.eye(len(areas))
        if load == UNIFORM:
            columns = every[:, means].sum(axis=1, keepdims=True)
        else:
            columns = every[:, means] if area is None else every[:, [areas.index(load)]]
        unit = "K" if area is None else table.unit[areas.index(load)]
        loads = [load] if load else table.name[means].tolist()
        units = r.unit * len(sets)
        effects = read_effects(project, model, r.names, units, table, partly=True)
        row = sets.index(chosen) * len(names)
        own = effects.rows[:, row : row + len(names)] @ columns
        effects_of = dict(zip(effects.part_names, own, strict=True))
        read_outs = [
            replace(one, unit=unit_per(one.unit, unit), gradients=() if load else apart)
            for one, apart in zip(
                _explained(r, read_beams(file, chosen), chosen, wanted, columns, loads, distortion_only, effects_of),
                _gradients(r, chosen, wanted, table, distortion_only),
                strict=True,
            )
        ]
        pairs = [(a, b) for i, a in enumerate(sets) for b in sets[i + 1 :]]
        return Explanation(
            path,
            chosen,
            condition[chosen],
            tuple(table.name[means].tolist()),
            load,
            unit,
            distortion_only,
            tuple(read_outs),
            tuple(names),
            tuple(r.unit),
            tuple(compare_sets(a, r.N[a][:, means], b, r.N[b][:, means]) for a, b in pairs),
        )


def _explained(
    r: ReadOuts,
    beams: Beams,
    set_name: str,
    wanted: Sequence[str],
    columns: FloatArray,
    loads: Sequence[str],
    distortion_only: bool,
    effects: Mapping[str, FloatArray],
) -> list[ReadOutExplained]:
    """Of every wanted read-out; `columns` [k, n] turns areas into the loads asked for. `effects`: by name, [r, n]."""
    motion, rigid = r.motion @ columns, r.rigid_motion @ columns
    gain = r.gain[set_name]
    plates = None if distortion_only else r.plates
    if distortion_only:
        motion, rigid = motion - rigid, np.zeros_like(rigid)
    N, N_rigid = gain @ motion, gain @ rigid
    names = (beams.motion, r.element)
    by_motion = motion_terms(gain, motion)
    by_element = r.by_motion(set_name, motion).sum(axis=2)
    N_motion, beside = N, dict[str, FloatArray]()
    outputs = beams.S_BW @ motion
    if plates is not None:
        changes = plates.terms(set_name) @ columns  # [r, p, 2, n]
        beside["plates"] = changes.sum(axis=(1, 2))
        outputs = outputs + (plates.outputs @ columns).sum(axis=(1, 2))
        by_motion = np.concatenate([by_motion, changes.reshape(len(N), -1, N.shape[1])], axis=1)
        by_element = np.concatenate([by_element, changes.sum(axis=2)], axis=1)
        names = ([*beams.motion, *plates.changes], r.part_names)
    by_beam = beam_terms(beams.inverse, beams.P, outputs)
    acting = {} if distortion_only else {name: rows for name, rows in effects.items() if rows.any()}
    if acting:
        beside["effects"] = sum(acting.values(), np.zeros_like(N))
        more = np.stack(list(acting.values()), axis=1)
        by_motion, by_element, by_beam = (
            np.concatenate([terms, more], axis=1) for terms in (by_motion, by_element, by_beam)
        )
    N = N_motion + sum(beside.values(), np.zeros_like(N))
    out = []
    for label in wanted:
        row = r.label.index(label)
        total = N[row]
        power = float(total @ total)
        out.append(
            ReadOutExplained(
                label=label,
                unit=r.unit[row],
                size=float(np.sqrt(power)),
                total=float(total.sum()),
                rigid_share=float(shares(N_rigid[[row]], total)[0]),
                rigid_size=float(np.linalg.norm(N_rigid[row])),
                distortion_size=float(np.linalg.norm(N_motion[row] - N_rigid[row])),
                beside=tuple(_beside(name, rows[row], total) for name, rows in beside.items()),
                value=total,
                areas=Shares(tuple(loads), total**2 / power if power > 0 else np.zeros(len(total)), np.abs(total)),
                motions=_shares([*names[0], *acting], by_motion[row], total),
                elements=_shares([*names[1], *acting], by_element[row], total),
                beams=_shares([*beams.label, *acting], by_beam[row], total),
                gradients=(),
            )
        )
    return out


def _gradients(
    r: ReadOuts, set_name: str, wanted: Sequence[str], table: AreaTable, distortion_only: bool
) -> list[tuple[tuple[str, float], ...]]:
    """What every wanted read-out is per K/m of each gradient, the largest first."""
    names = table.name[table.gradient].tolist()
    motion = r.motion - r.rigid_motion if distortion_only else r.motion
    N = r.gain[set_name] @ motion[:, table.gradient]  # plates have no gradients
    found = []
    for label in wanted:
        values = N[r.label.index(label)].tolist()
        found.append(tuple(sorted(zip(names, values, strict=True), key=lambda pair: -abs(pair[1]))))
    return found


def _beside(name: str, term: FloatArray, total: FloatArray) -> Beside:
    """A term [n] of a read-out beside all motion."""
    return Beside(name, float(shares(term[None], total)[0]), float(np.linalg.norm(term)))


def _shares(labels: Sequence[str], terms: FloatArray, total: FloatArray) -> Shares:
    return Shares(tuple(labels), shares(terms, total), np.linalg.norm(terms, axis=1))
