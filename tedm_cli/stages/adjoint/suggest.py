"""suggest-areas: thermal areas that tell the judged outputs of a field that decorrelates, and how many it takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.adjoint.merging import Merged, area_covariance, merge_areas
from tedm_cli.adjoint.mirrored import mirrored_clusters
from tedm_cli.adjoint.temperature_field import AreaError, area_error, field_products
from tedm_cli.areas.attributes import rule_of
from tedm_cli.areas.csv_file import area_csv_text
from tedm_cli.areas.suggested import suggested_names
from tedm_cli.arrays import IntArray
from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.project import Project
from tedm_cli.errors import UsageError
from tedm_cli.files.build_folder import ADJOINT_FILE
from tedm_cli.files.store import replacing
from tedm_cli.nastran.geometry import model_geometry
from tedm_cli.nastran.loads.area_loads import AreaLoad, none
from tedm_cli.nastran.loads.unit_loads import deck_unit_loads
from tedm_cli.nastran.reading import deck_files, read_deck
from tedm_cli.progress import Step
from tedm_cli.quantities import AREA_ERROR, CORRELATION_LENGTH
from tedm_cli.stages.adjoint.field import ModelField, model_field
from tedm_cli.stages.adjoint.fitting import fit_notes
from tedm_cli.stages.area_drawing import draw_areas, require_format, write_figure

LENGTHS_MM = (20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)
MOST = 2000
"""Areas at most: each is a subcase of the unit loads."""
_FINE = 1000  # clusters of like grids that areas are merged from; twice the count where that is more
_DRAWN = 500  # areas up to which the curve is drawn
_COUNTS = (10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 500, 1000, MOST)


@dataclass(frozen=True, eq=False, kw_only=True)
class Suggestion:
    """Areas that are suggested, and the errors of these and other counts.

    present : of the areas that there are. merged : of all counts, areas that stay as they are among them.
    error : what was asked for, None where a count was.
    members : ids of the grids of the suggested areas of grids. notes : what has to follow when they are taken.
    path : of their CSV.
    """

    field: ModelField
    even: bool
    length_mm: tuple[float, ...]
    count: int
    error: float | None
    present: AreaError
    merged: Merged
    members: dict[str, IntArray]
    notes: list[str]
    path: Path | None

    @property
    def n_present(self) -> int:
        """Areas of mean temperatures that there are."""
        return int((~self.field.areas.gradient).sum())

    @property
    def new(self) -> list[int]:
        """Grids of each suggested area whose grids are not those of a present one."""
        present = {tuple(sorted(self.field.grid_id[rows].tolist())) for rows in self.field.members}
        return [len(ids) for ids in self.members.values() if tuple(sorted(ids.tolist())) not in present]

    @property
    def enough(self) -> bool:
        """Whether the present areas are within the error that was asked for, and no fewer are suggested."""
        worst = np.abs(self.present.ratio - 1.0).max()
        return self.error is not None and bool(worst <= self.error) and self.count >= self.n_present

    @property
    def counts(self) -> list[int]:
        """The counts to tell: round ones, that of the present areas, and the suggested one."""
        known = range(self.merged.fewest, self.merged.k + 1)
        told = {c for c in (*_COUNTS, self.merged.fewest, self.n_present, self.count) if c in known}
        return sorted({self.merged.nearest(c) for c in told})

    def coarsest(self, top: int | None) -> list[tuple[str, str, float, float]]:
        """Present areas that leave most out: name, output, ℓ in mm, and share in the variance of what is left out.

        Of the output and length for which the present areas leave out most.
        """
        number, row = np.unravel_index(int(self.present.difference.argmax()), self.present.difference.shape)
        share = self.present.share[number, row]
        order = np.argsort(-share, kind="stable")[:top]
        what = self.field.outputs[row], self.length_mm[number]
        return [(str(self.field.areas.name[a]), *what, float(share[a])) for a in order if share[a] > 0.0]

    def as_dict(self, top: int | None) -> dict[str, object]:
        """Everything that is printed, as JSON."""
        return {
            "outputs": self.field.outputs,
            "length_mm": list(self.length_mm),
            "amplitude": "even" if self.even else "temperatures of the cases",
            "field_ratio": (self.present.exact * self.field.ratio_per_deviation).tolist(),
            "frequency_hz": self.field.frequency_hz.tolist(),
            "count": self.count,
            "fewest": self.merged.fewest,
            "ratio": self.merged.ratio_at(self.count).tolist(),
            "present": {
                "count": self.n_present,
                "ratio": self.present.ratio.tolist(),
                "left_out": self.present.difference.tolist(),
                "coarsest": [
                    {"area": a, "output": o, "length_mm": mm, "share": share} for a, o, mm, share in self.coarsest(top)
                ],
            },
            "curve": [{"count": c, "ratio": self.merged.ratio_at(c).tolist()} for c in self.counts],
            "areas": {name: len(ids) for name, ids in self.members.items()},
            "notes": self.notes,
        }


def suggest_areas(
    project: Project,
    count: int | None,
    error: float | None,
    length_mm: Sequence[float],
    output: Path | None,
    figure: Path | None,
    curve: Path | None,
    step: Step,
    *,
    even: bool = False,
) -> Suggestion:
    """Suggest so many areas, or the fewest within an error of every ratio; write their CSV and figures.

    Parameters
    ----------
    error : largest |ratio - 1| of standard deviations, areas over field, of all judged outputs and lengths.
    length_mm : correlation lengths of the field. even : `model_field`.

    Raises
    ------
    UsageError : not one of `count` and `error`; too few areas, more than grids, or an error that is not reached.
    InputError, ConfigError : as `model_field`.
    """
    require_format(figure)
    require_format(curve, "--curve")
    length = _lengths(length_mm)
    if (count is None) == (error is None):
        raise UsageError("give --count or --error, one of the two")
    if error is not None and (fact := AREA_ERROR.fact(error)):
        raise UsageError(f"--error: {fact}")
    config = load_model(project.model)[1]
    config.require_adjoint(project.model)
    field = model_field(project, even=even)
    metres = tuple(mm / 1e3 for mm in length)
    found, fine = _merged(field, count, metres, step)
    enough = None if error is None else found.count_within(error)
    if error is not None and enough is None:
        raise _not_reached(field, found, fine, error, length, config)
    number = _count(found, count) if enough is None else enough
    present = area_error(field.points, field.area, metres, step)
    new = found.areas(number)[fine]
    members, origin = _new_areas(field, new, config)
    done = Suggestion(
        field=field,
        even=even,
        length_mm=length,
        count=number,
        error=error,
        present=present,
        merged=found,
        members=members,
        notes=[*_pair_notes(count, number), *fit_notes(project, config, field, members, origin)],
        path=output,
    )
    if output is not None:
        with replacing(output) as temporary:
            temporary.write_text(area_csv_text(members), encoding="utf-8", newline="\n")
    if figure is not None:
        _draw(figure, project, config, field, members, origin)
    if curve is not None:
        _draw_curve(curve, project, done)
    return done


def _draw_curve(path: Path, project: Project, done: Suggestion) -> None:
    """Draw the errors of all counts up to 500, and those of the present areas."""
    from tedm_cli.figures.model.area_error import area_error_figure

    merged = done.merged
    known = range(merged.fewest, merged.k + 1)
    count = np.array([c for c in known if c <= max(_DRAWN, done.count) and merged.nearest(c) == c])
    error = np.array([np.abs(merged.ratio_at(c) - 1.0).max(axis=1) for c in count.tolist()])
    now = np.abs(done.present.ratio - 1.0).max(axis=1)
    title = f"{project.title}: error by number of thermal areas"
    figure = area_error_figure(count, error, done.n_present, now, done.length_mm, title)
    write_figure(path, figure, title, project.build_dir / ADJOINT_FILE)


def _lengths(given: Sequence[float]) -> tuple[float, ...]:
    length = tuple(sorted(set(given))) or LENGTHS_MM
    for value in length:
        if fact := CORRELATION_LENGTH.fact(value):
            raise UsageError(f"--length-mm: {fact}")
    return length


def _merged(field: ModelField, count: int | None, length: tuple[float, ...], step: Step) -> tuple[Merged, IntArray]:
    """Areas of all counts, and the cluster that each point is in before any two are merged."""
    points, free = field.points, field.free
    kept = np.unique(field.area[~free])
    most = int(free.sum()) + len(kept)
    if count is not None and count > min(most, MOST):
        why = f"there are {most:,} grids and areas of elements" if most <= MOST else "each is a subcase of its own"
        raise UsageError(f"--count {count:,}: at most {min(most, MOST):,}, as {why}")
    place = np.full(len(free), -1)
    place[free] = np.arange(int(free.sum()))
    wanted = min(max(_FINE, 2 * (count or 0)), int(free.sum()))
    step(0, 1, "clusters of like grids")
    plane, image = field.areas.plane, field.image[free]
    image = np.where(image >= 0, place[image], -1)
    found, twin, pairs = mirrored_clusters(points.only(free), place[field.pairs], image, plane, wanted)
    step(1, 1, "clusters of like grids")
    fine = np.empty(len(free), dtype=np.int64)
    fine[free], fine[~free] = found, len(twin) + np.searchsorted(kept, field.area[~free])
    twin = np.concatenate([twin, np.full(len(kept), -1)])
    return merge_areas(area_covariance(points, fine, length, step), pairs, twin, step), fine


def _count(found: Merged, count: int | None) -> int:
    assert count is not None
    if count < found.fewest:
        raise UsageError(
            f"--count {count}: at least {found.fewest} areas, as parts that the correlation cases tell apart, and"
            " parts that do not touch, stay apart"
        )
    return found.nearest(count)


def _not_reached(
    field: ModelField, found: Merged, fine: IntArray, error: float, length_mm: tuple[float, ...], config: ModelConfig
) -> UsageError:
    """Of all areas: the output and length that are told worst, and the present area that leaves most of it out."""
    off = np.abs(found.ratio_at(found.k) - 1.0)
    number, row = np.unravel_index(int(off.argmax()), off.shape)
    output, mm = field.outputs[row], length_mm[number]
    left = (field.points.sensitivity - field.points.of_areas(fine))[row : row + 1]
    terms = left * field_products(field.points.position, left, (mm / 1e3,))[0]
    area = int(np.bincount(field.area, terms[0]).argmax())
    name = str(field.areas.name[area])
    fact = (
        f"--error {error:g} is not reached: {found.k:,} areas leave {off.max():.2g}, of {output} at {mm:g} mm,"
        f" most by {name}"
    )
    if not field.kept[area]:
        return UsageError(fact, hint="a larger error, or --count")
    defined = name.upper() in [d.name.upper() for d in config.areas.define]
    where = "[areas] define" if defined else "the unit-load deck, whose temperature cards say the areas of elements"
    return UsageError(
        f"{fact}, an area of elements, which is not divided here",
        hint=f"divide {name} in {where} (`tedm explain {output} --grids` shows where)",
    )


def _pair_notes(count: int | None, number: int) -> list[str]:
    if count in (None, number):
        return []
    return [f"{number} areas, as of {count} one would lack the mirror image that a correlation case asks for"]


def _new_areas(field: ModelField, new: IntArray, config: ModelConfig) -> tuple[dict[str, IntArray], IntArray]:
    """Ids of the grids of each new area of grids, by the areas that they are of, and rows of these."""
    free = field.free[: len(field.grid)]
    number, label = np.unique(new[: len(field.grid)][free], return_inverse=True)
    grid = field.grid[free]
    area, volume = field.area[: len(field.grid)][free], field.points.volume[: len(field.grid)][free]
    first = np.full(len(number), len(field.grid_id))
    np.minimum.at(first, label, grid)
    rank = np.argsort(np.argsort(first))  # numbered by their first grids
    table = config.areas
    names, origin = suggested_names(
        rank[label],
        area,
        volume,
        field.areas.name.tolist(),
        lambda name, old: rule_of(name, table) == rule_of(old, table),
    )
    members = {names[n]: field.grid_id[grid[rank[label] == n]] for n in np.argsort(origin, kind="stable").tolist()}
    return members, np.sort(origin)


def _draw(
    path: Path,
    project: Project,
    config: ModelConfig,
    field: ModelField,
    members: dict[str, IntArray],
    origin: IntArray,
) -> None:
    """Draw the model with the new areas, and those that stay."""
    table, deck = config.model, project.resolve(config.model.deck)
    model = read_deck(deck, allow_missing_enddata=table.allow_missing_enddata, units=table.deck_units())
    geometry = model_geometry(model, deck_files(model, deck))
    loads = {name: AreaLoad(ids, none(), none()) for name, ids in members.items()}
    if field.kept.any():
        stay = set(field.areas.name[field.kept].tolist())
        now = deck_unit_loads(model, geometry, table.uniform_label).areas
        loads |= {a.label: a.area_load(geometry) for a in now if a.label in stay}
    stayed = dict(zip(field.areas.name.tolist(), field.areas.group.tolist(), strict=True))
    group_of = dict(zip(members, field.areas.group[origin].tolist(), strict=True))
    groups = [group_of[name] if name in group_of else stayed[name] for name in loads]
    draw_areas(path, project, config, deck, model, geometry, loads, groups, "suggested thermal areas")
