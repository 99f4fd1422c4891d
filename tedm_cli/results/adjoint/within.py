"""Gradients within areas, as cases have them: columns of adjoint.h5 beside those of the model's areas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.adjoint.linear_fields import AreaShapes, linear_field
from tedm_cli.area_names import area_name_fact
from tedm_cli.arrays import FloatArray, IndexArray
from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.project import Project
from tedm_cli.config.temperature.spectrum import SpectrumColumns, tabulated
from tedm_cli.config.temperature.tables import spectrum_tables
from tedm_cli.config.temperature.within import WithinTable, gradient_name
from tedm_cli.contracts import ADJOINT
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.build_folder import ADJOINT_FILE, SENSITIVITY_FILE, require_configuration, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.areas import AXES, WITHIN, AreaTable
from tedm_cli.noise.contributions import ReadOutParts
from tedm_cli.noise.selection import listed
from tedm_cli.noise.temperature import Spectrum, TemperatureModel
from tedm_cli.results.outputs import ModelOutputs

NOT_TOLD = "gradients within areas, whatever moves"
"""In place of an optical element: the adjoint has whole read-outs, not what each element does to them."""
_THIN = 1e-6  # of the longest extent of an area: along an axis with less there is nothing for a gradient to be across


@dataclass(frozen=True, eq=False)
class Gradients:
    """The m gradients of a table: what they are of, and what each does.

    areas : [m], their kinds tell the axes. extent_m : [m], from end to end. rows : by label of an output, [m], per K/m.
    spectra : [m].
    """

    areas: AreaTable
    extent_m: FloatArray
    rows: Mapping[str, FloatArray]
    spectra: Sequence[Spectrum]

    def and_last(self, more: Gradients) -> Gradients:
        """These, and after them others of the same outputs; `InputError` for a name that both have."""
        rows = {label: np.concatenate([row, more.rows[label]]) for label, row in self.rows.items()}
        extent = np.concatenate([self.extent_m, more.extent_m])
        return Gradients(self.areas.and_last(more.areas), extent, rows, [*self.spectra, *more.spectra])


@dataclass(frozen=True, eq=False)
class CaseGradients:
    """What the cases of a project have of gradients within areas, by the numbers of the tables that ask for them.

    path : of the adjoint, where a case has any. config : of the cases. refusal : why the adjoint cannot be taken; cases
    without gradients do not need it.
    """

    config: CasesConfig
    where: Path
    tables: Mapping[int, Gradients]
    path: Path | None = None
    refusal: InputError | None = None

    def of(self, case_id: str) -> Gradients | None:
        """The gradients of a case; None where it has none.

        Raises
        ------
        ConfigError : two of its tables make gradients of one name.
        InputError : adjoint.h5 cannot be taken.
        """
        if self.refusal is not None and self.config.within(case_id):
            raise self.refusal
        found: Gradients | None = None
        for number in self.config.within(case_id):
            one = self.tables[number]
            both = [] if found is None else sorted(set(found.areas.name.tolist()) & set(one.areas.name.tolist()))
            if both:
                fact = f"case {case_id} has {both[0]!r} of another table already; name its `cases`"
                raise ConfigError([(f"temperature.within[{number}]", fact)], where=str(self.where))
            found = one if found is None else found.and_last(one)
        return found

    def sources(self, case_id: str) -> list[Path]:
        """The files that the gradients of a case are from."""
        return [self.path] if self.path is not None and self.config.within(case_id) else []


def case_gradients(
    project: Project, config: CasesConfig, outputs: ModelOutputs, tables: Mapping[str, SpectrumColumns] | None = None
) -> CaseGradients:
    """Gradients within areas that the cases have; without any, nothing is read.

    An adjoint.h5 that is missing, stale, without an output, or says why there is none, is refused when a case asks.

    Parameters
    ----------
    outputs : of the model. tables : spectra that no file holds, by the names that the configuration has for them.

    Raises
    ------
    ConfigError : tables that do not fit the areas, or a project that can have no adjoint; all problems at once.
    InputError : a table of spectra that cannot be read.
    """
    wanted = sorted({number for case_id in config.ids for number in config.within(case_id)})
    if not wanted:
        return CaseGradients(config, project.cases, {})
    path = project.build_dir / ADJOINT_FILE
    spectra = spectrum_tables(project, config, tables)
    try:
        acting = _acting(path, wanted[0], outputs, project)
    except InputError as error:
        return CaseGradients(config, project.cases, {}, path, error)
    problems: list[tuple[str, str]] = []
    found: dict[int, Gradients] = {}
    for number in wanted:
        made = _gradients(config.temperature.within[number], outputs.areas, acting, spectra)
        if isinstance(made, Gradients):
            found[number] = made
        else:
            problems += [(f"temperature.within[{number}].{key}".removesuffix("."), fact) for key, fact in made]
    if problems:
        raise ConfigError(problems, where=str(project.cases))
    return CaseGradients(config, project.cases, found, path)


def with_gradients(outputs: ModelOutputs, more: Gradients | None) -> ModelOutputs:
    """The outputs with the gradients' columns behind those of the model's areas. Differences are made of these."""
    if more is None:
        return outputs
    columns = np.array([more.rows[label] for label in outputs.labels])
    unknown = np.full(columns.shape[1], np.nan)
    parts = {
        label: ReadOutParts(
            (*of.names, NOT_TOLD),
            np.block(
                [
                    [of.by_element, np.zeros((len(of.names), columns.shape[1]))],
                    [np.zeros(len(outputs.areas)), more.rows[label]],
                ]
            ),
            None if of.distortion is None else np.concatenate([of.distortion, unknown]),
        )
        for label, of in outputs.parts_of_read_outs.items()
    }
    return replace(
        outputs,
        areas=outputs.areas.and_last(more.areas),
        rows=np.concatenate([outputs.rows, columns], axis=1),
        parts_of_read_outs=parts,
        effects=None if outputs.effects is None else outputs.effects.and_silent(columns.shape[1]),
        area_id=and_numbers(outputs.area_id, columns.shape[1]),
    )


def and_numbers(area_id: IndexArray, more: int) -> IndexArray:
    """Numbers of areas, and of as many more."""
    return np.concatenate([area_id, area_id.max() + 1 + np.arange(more)])


def and_spectra(temperature: TemperatureModel, more: Gradients | None) -> TemperatureModel:
    """The temperatures of the model's areas, and behind them those of the gradients."""
    return temperature if more is None else temperature.and_gradients(more.spectra)


@dataclass(frozen=True, eq=False)
class _Acting:
    """What adjoint.h5 says: value [r, k], gradient [r, k, 3] of outputs with these labels; shapes of the areas."""

    labels: list[str]
    value: FloatArray
    gradient: FloatArray
    shapes: AreaShapes


def _acting(path: Path, number: int, outputs: ModelOutputs, project: Project) -> _Acting:
    """Read the adjoint; `number` is of a table that asks for it."""
    if not any(source.name == SENSITIVITY_FILE for source in outputs.matrices):
        fact = "takes adjoint.h5, which a project without test masses has not"
        raise ConfigError([(f"temperature.within[{number}]", fact)], where=str(project.cases))
    if not path.exists():
        fact = f"no such file; temperature.within[{number}] of {project.cases} takes gradients within areas from it"
        raise InputError(fact, where=str(path), hint=f"make it with `{ADJOINT.made_by}`, or `tedm run`")
    with open_checked(path, ADJOINT) as file:
        return _read(file, outputs, project)


def _read(file: Reader, outputs: ModelOutputs, project: Project) -> _Acting:
    require_configuration(file, project.model)
    for used in input_files(outputs.matrices):
        require_input(file, used)
    if file.has(ADJOINT.REFUSAL):
        raise InputError(
            f"has no gradients within areas: {'; '.join(file.strings(ADJOINT.REFUSAL))}",
            where=str(file.path),
            hint="take [[temperature.within]] out of the cases file, or define gradients by shells and bars as areas",
        )
    labels = file.strings(ADJOINT.ROW_LABEL)
    missing = [label for label in outputs.labels if label not in labels]
    if missing:
        fact = f"was made without {listed(missing)}"
        raise InputError(fact, where=str(file.path), hint=f"build it again with `{ADJOINT.made_by}`, or `tedm run`")
    row = [labels.index(label) for label in outputs.labels]
    shapes = AreaShapes(
        middle=file.array(ADJOINT.AREA_MIDDLE),
        volume=file.array(ADJOINT.AREA_VOLUME),
        low=file.array(ADJOINT.AREA_LOW),
        high=file.array(ADJOINT.AREA_HIGH),
    )
    value = np.asarray(file.array(ADJOINT.AREA_SUM) + file.array(ADJOINT.DIRECT), dtype=np.float64)
    return _Acting(list(outputs.labels), value[row], file.array(ADJOINT.AREA_GRADIENT)[row], shapes)


def _gradients(
    of: WithinTable, areas: AreaTable, acting: _Acting, spectra: Mapping[str, SpectrumColumns]
) -> Gradients | list[tuple[str, str]]:
    """What a table asks for; or (key, fact) of all that is wrong with it."""
    facts = of.unknown(areas)
    mask = of.select(areas)
    if not facts and not mask.any():
        facts.append(("", "selects none of the areas of mean temperatures"))
    chosen = np.flatnonzero(mask)
    flat = [str(areas.name[i]) for i in chosen if not acting.shapes.volume[i] > 0.0]
    if flat:
        fact = f"{listed(flat)} {'has' if len(flat) == 1 else 'have'} no volume in the elements, so no centroid"
        facts.append(("", f"{fact} that a gradient could be about; leave {'it' if len(flat) == 1 else 'them'} out"))
    if of.name is not None:
        facts += _not_one_body(areas, chosen)
    if facts:
        return facts
    bodies = [(of.name, chosen)] if of.name is not None else [(str(areas.name[i]), chosen[chosen == i]) for i in chosen]
    made: list[tuple[str, IndexArray, int, float]] = []
    for body, members in bodies:
        extent = acting.shapes.extent_of(members)
        thick = extent > _THIN * extent.max()
        if not thick.any():
            facts.append(("", f"{body} is a point: no gradient is across it"))
        thin = [axis for axis in of.axes or () if not thick[AXES.index(axis)]]
        if thin and thick.any():
            facts.append(
                ("axes", f"{body} has no extent along {' and '.join(thin)}, so no gradient is across it there")
            )
        axes = [i for i, axis in enumerate(AXES) if thick[i] and (of.axes is None or axis in of.axes)]
        made += [(body, members, axis, float(extent[axis])) for axis in axes]
    names = [gradient_name(body, AXES[axis]) for body, _, axis, _ in made]
    facts += [("", f"the name of a gradient would be {name!r}: {f}") for name in names if (f := area_name_fact(name))]
    taken = [name for name in names if name in areas.name.tolist()]
    facts += [("name", f"{name!r} is the name of a thermal area of the model") for name in taken]
    if facts:
        return facts
    first = np.array([members[0] for _, members, _, _ in made])
    sides = [_common(areas.side[members].tolist()) for _, members, _, _ in made]
    table = AreaTable(
        np.array(names),
        areas.group[first],
        areas.shield[first],
        np.array(sides),
        np.array([acting.shapes.middle_of(members) for _, members, _, _ in made]),
        plane=areas.plane,
        kind=np.array([WITHIN[axis] for _, _, axis, _ in made]),
    )
    fields = [linear_field(acting.value, acting.gradient, acting.shapes, m)[:, axis] for _, m, axis, _ in made]
    extents = np.array([extent for *_, extent in made])
    try:
        found = _spectra(of, table, extents, spectra)
    except InputError as error:
        return [("table", error.fact)]
    return Gradients(table, extents, dict(zip(acting.labels, np.array(fields).T, strict=True)), found)


def _not_one_body(areas: AreaTable, chosen: IndexArray) -> list[tuple[str, str]]:
    """What keeps areas from being one body: blocks choose by group and shield."""
    facts = []
    for what, column in (("groups", areas.group), ("sides of the shield", areas.shield)):
        found = sorted(set(column[chosen].tolist()))
        if len(found) > 1:
            facts.append(
                ("name", f"the areas of one body are of {len(found)} {what}: {listed(found)}; name one of them")
            )
    return facts


def _common(values: list[str]) -> str:
    """The one side of areas, or neither."""
    return values[0] if len(set(values)) == 1 else "mid"


def _spectra(
    of: WithinTable, table: AreaTable, extent_m: FloatArray, spectra: Mapping[str, SpectrumColumns]
) -> list[Spectrum]:
    if of.table is not None:
        found = tabulated(spectra[of.table], table, np.ones(len(table), dtype=bool), True)
        return [found[i] for i in range(len(table))]
    if of.across_K is not None:
        return [of.spectrum(of.across_K / extent) for extent in extent_m.tolist()]
    assert of.level_K_per_m is not None  # the configuration requires one of them
    return [of.spectrum(of.level_K_per_m)] * len(table)
