"""A project from its configuration, and its cases in memory."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tedm_cli.config import project as config_project
from tedm_cli.config.base import named_by_project, read_toml, validate
from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.correlation.case import CaseTable
from tedm_cli.config.model.file import load_model
from tedm_cli.config.nearest import NO_PROJECT, Found, nearest_project, project_in
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.temperature.spectrum import SpectrumColumns
from tedm_cli.contracts import CASE
from tedm_cli.errors import InputError
from tedm_cli.files.in_memory import in_memory
from tedm_cli.files.store import Writer
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.library.build import Build, build_folder
from tedm_cli.library.datasets import dataset_of
from tedm_cli.library.xarray_door import xarray
from tedm_cli.noise.correlation import CorrelationCase, LabelledMatrix
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.quantities import FREQUENCY, MATRIX_ENTRY, TEMPERATURE_ASD
from tedm_cli.results.cases.file import write_case
from tedm_cli.results.cases.uncertainty import write_uncertainty
from tedm_cli.results.thermal.comparison import write_comparison
from tedm_cli.stages.noise.case import case_setting

if TYPE_CHECKING:
    import xarray as xr

_GIVEN = "temperature"  # in place of a file's name, of spectra that come as an array


def load_project(path: str | PathLike[str] | None = None, build: str | PathLike[str] | None = None) -> Project:
    """A project, found as the commands find it, or from its folder or project file.

    Parameters
    ----------
    path : a folder with `tedm.toml` or `configs/tedm.toml` in it, or a project file of any name. Default: the project
        of the current folder, or of the nearest above it.
    build : the folder with its results, which need not be there yet. Default: `build` in the folder of the project;
        where `path` is a file, in the current one. A folder `configs` counts as part of the folder above it.

    Both are relative to the current folder.

    Raises
    ------
    InputError : there is no such folder or file, or no project in it.
    ConfigError : what is wrong in it.
    """
    found = _found(path)
    return Project(config_project.load_project(found.file, build_folder(found) if build is None else Path(build)))


def _found(path: str | PathLike[str] | None) -> Found:
    if path is None:
        found, fact, where = nearest_project(), NO_PROJECT, Path.cwd()
    else:
        where = Path(path)
        is_file = os.path.lexists(where) and not where.is_dir()
        found = Found(Path(), where) if is_file else project_in(where)
        fact = "no project in this folder: no tedm.toml, nor configs/tedm.toml"
        fact = fact if where.is_dir() else "no such folder or project file"
    if found is None:
        raise InputError(fact, where=str(where), hint="give the folder of a project; `tedm init demo` begins one")
    return found


@dataclasses.dataclass(frozen=True, repr=False)
class Project:
    """A project; made by `load_project`. Files are read anew whenever something is asked for."""

    _project: config_project.Project

    def __repr__(self) -> str:
        return f"<tedm.Project {self.title!r}: {self._project.file.path}, results in {self._project.build_dir}>"

    @property
    def title(self) -> str:
        """What the project file calls it."""
        return self._project.title

    @property
    def build(self) -> Build:
        """The results in its build folder."""
        return Build(self._project.build_dir)

    @property
    def cases(self) -> list[str]:
        """Ids of its correlation cases. Raises `InputError` and `ConfigError` for the cases file."""
        return load_cases(self._project.cases)[1].ids

    @property
    def test_masses(self) -> list[TestMass]:
        """Its test masses, basic frame. Raises `ConfigError` where the model names none."""
        return load_model(self._project.model)[1].required_test_masses(self._project.model)

    @property
    def layout(self) -> OpticalLayout:
        """Its optical layout, for `trace`. Raises `ConfigError` where it has none."""
        return load_layout(self._project.required_optics(), needs_grids=False)[1]

    def run_case(
        self,
        case: int | str,
        *,
        temperature: Mapping[str, Any] | xr.DataArray | None = None,
        correlation: Mapping[str, Any] | xr.DataArray | None = None,
        requirements: Sequence[Mapping[str, Any]] | None = None,
        safety_factor: float | None = None,
        frequency: Mapping[str, Any] | None = None,
    ) -> xr.Dataset:
        """`tedm.run_case` of this project."""
        return run_case(
            self,
            case,
            temperature=temperature,
            correlation=correlation,
            requirements=requirements,
            safety_factor=safety_factor,
            frequency=frequency,
        )


def run_case(
    project: Project | str | PathLike[str],
    case: int | str,
    *,
    temperature: Mapping[str, Any] | xr.DataArray | None = None,
    correlation: Mapping[str, Any] | xr.DataArray | None = None,
    requirements: Sequence[Mapping[str, Any]] | None = None,
    safety_factor: float | None = None,
    frequency: Mapping[str, Any] | None = None,
) -> xr.Dataset:
    """Noise, bounds, verdicts and contributors of one correlation case, in memory; no file is written.

    The sensitivities are those of the build folder. Without changes the numbers are those that `tedm run-case`
    writes, to the bit; a realisation is not made.

    Parameters
    ----------
    project : or what `load_project` takes as its path.
    case : id of a case in the cases file.
    temperature : keys of the table `[temperature]`, in place of those of the file; with `preset` among them, the file's
        table is left aside. Or a DataArray (area, frequency) of one-sided amplitude spectral densities, K/√Hz at Hz,
        with a coordinate of names and one of frequencies.
    correlation : keys of a table `[[case]]` (`blocks`, `partition`, `groups`, `matrix`, `rho`, `delays`), in place of
        all that the case has. Or a DataArray of two dimensions, real or complex, with names of areas as the
        coordinates of both; its rows and columns may be in any order, areas that it lacks are silent.
    requirements : tables `[[requirement]]`, in place of those of the file.
    safety_factor : on amplitudes when judged.
    frequency : keys of the table `[frequency]`, in place of those of the file.

    Returns
    -------
    What `Build.case` returns: `psd` (output, frequency), `contribution_share` (output, area), `bounds_maximum` (output,
    frequency), `temperature_asd`, verdicts along `verdict` (`tedm.table` makes a table of them), and the rest of the
    case file ("Files between the stages" in the documentation). The attribute `changed` names what was given.

    Raises
    ------
    InputError : a file of the build folder is missing, damaged or stale, or the spectra do not fit the areas.
    ConfigError : what is wrong with the configuration, or with what was given in its place; all at once.
    UsageError : there is no such case.
    PhysicsError : the matrix is not a correlation matrix.
    """
    of = (project if isinstance(project, Project) else load_project(project))._project
    given = {
        "temperature": temperature,
        "correlation": correlation,
        "requirements": requirements,
        "safety_factor": safety_factor,
        "frequency": frequency,
    }
    changed = [name for name, value in given.items() if value is not None]
    xarray()  # where it is missing, that is told before anything is computed
    instead, spectra = _in_place(of, given)
    setting = case_setting(of, *load_cases(of.cases, instead), spectra)
    chosen = _case(setting.config, str(case), correlation, of.cases)
    ready = setting.ready(chosen)
    result = setting.run(ready)
    requirement_list = [applied.requirement for applied in setting.criteria.requirements]
    sure, beside = setting.uncertainty(result), setting.comparison(ready, result)

    def write(writer: Writer) -> None:
        write_case(writer, result, ready.outputs.area_id, requirement_list)
        if sure is not None:
            write_uncertainty(writer, sure)
        if beside is not None:
            write_comparison(writer, beside)

    with in_memory(CASE, (setting.file,), f"tedm.run_case({case!r})", write) as file:
        made = dataset_of(file)
    return made.assign_attrs(changed=", ".join(changed)) if changed else made


def _in_place(
    project: config_project.Project, given: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, SpectrumColumns]]:
    """Tables in place of those of the cases file, and spectra that no file holds."""
    _, file = read_toml(project.cases, hint=named_by_project("cases"))
    tables: dict[str, Any] = {}
    spectra: dict[str, SpectrumColumns] = {}
    for key in ("temperature", "frequency"):
        value, there = given[key], file.get(key, {})
        if isinstance(value, Mapping):
            aside = "preset" in value or not isinstance(there, Mapping)
            tables[key] = dict(value) if aside else {**there, **value}
        elif value is not None and key == "temperature":
            tables[key], spectra[_GIVEN] = {"preset": "table", "table": _GIVEN}, _spectra(value)
        elif value is not None:
            raise InputError(f"is {type(value).__name__}, wanted the keys of a table", where=key)
    if given["requirements"] is not None:
        tables["requirement"] = [dict(table) for table in given["requirements"]]
    if given["safety_factor"] is not None:
        tables["safety_factor"] = given["safety_factor"]
    return tables, spectra


def _case(
    config: CasesConfig, case_id: str, given: Mapping[str, Any] | xr.DataArray | None, where: Path
) -> CorrelationCase:
    """The case of that id, with the correlation that was given in place of its own."""
    if given is None:
        return config.case(case_id, where=str(where))
    table = config.case_table(case_id, where=str(where))
    told = {"id": table.id, "title": "Correlation as given", "role": table.role, "reason": table.reason}
    if isinstance(given, Mapping):
        return validate(CaseTable, {**told, **given}, where="correlation").correlation_case("correlation")
    return CorrelationCase(table.id, told["title"], (), "correlation", _matrix(given), role=table.role)


def _matrix(given: xr.DataArray) -> LabelledMatrix:
    """A correlation matrix from a DataArray."""
    if len(getattr(given, "dims", ())) != 2:
        raise InputError("is no DataArray of two dimensions, nor the keys of a case", where="correlation")
    names, columns = (_labels(given, dim, "correlation") for dim in given.dims)
    if sorted(names) != sorted(columns):
        odd = sorted(set(names) ^ set(columns))[:1]
        raise InputError(f"names other areas along one dimension than along the other ({odd})", where="correlation")
    value = np.asarray(given.values)
    if value.dtype.kind not in "fciu":
        raise InputError(f"holds {value.dtype}, wanted numbers", where="correlation")
    value = value.astype(np.complex128 if value.dtype.kind == "c" else np.float64)
    for part in (value.real, value.imag):
        if (at := MATRIX_ENTRY.first_outside(part)) is not None:
            fact = f"of {names[at[0]]} and {columns[at[1]]}: {MATRIX_ENTRY.fact(float(part[at]))}"
            raise InputError(fact, where="correlation")
    order = [columns.index(name) for name in names]
    return LabelledMatrix(tuple(names), value[:, order], "correlation")


def _spectra(given: xr.DataArray) -> SpectrumColumns:
    """Spectra of areas from a DataArray."""
    if set(getattr(given, "dims", ())) != {"area", "frequency"}:
        fact = f"has dimensions {tuple(getattr(given, 'dims', ()))}, wanted area and frequency"
        raise InputError(fact, where="temperature", hint="or give the keys of the table [temperature]")
    given = given.transpose("frequency", "area")
    names = _labels(given, "area", "temperature")
    if "frequency" not in given.coords:
        raise InputError("has no coordinate along frequency", where="temperature")
    frequency, asd = (np.asarray(v, dtype=np.float64) for v in (given["frequency"].values, given.values))
    for quantity, values in ((FREQUENCY, frequency), (TEMPERATURE_ASD, asd)):
        if (at := quantity.first_outside(values)) is not None:
            raise InputError(quantity.fact(float(values[at])), where="temperature")
    return SpectrumColumns("temperature", names, frequency, asd)


def _labels(given: xr.DataArray, dim: Any, where: str) -> list[str]:
    if dim not in given.coords:
        raise InputError(f"has no names of areas as the coordinate {dim}", where=where)
    return [str(name) for name in given[dim].values.tolist()]
