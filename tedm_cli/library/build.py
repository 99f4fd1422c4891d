"""A finished build folder, read file by file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from tedm_cli.config.nearest import BUILD, Found, nearest_project
from tedm_cli.contracts import (
    ADJOINT,
    CASE,
    DISTORTION,
    DYNAMICS,
    LOADS,
    OPTICS,
    SENSITIVITY,
    SERIES,
    SIMULATED_SERIES,
    SIMULATION,
    THERMAL,
    UNIT_LOADS,
    FileKind,
)
from tedm_cli.errors import InputError
from tedm_cli.files.build_folder import (
    ADJOINT_FILE,
    DISTORTION_FILE,
    DYNAMICS_FILE,
    LOADS_FILE,
    OPTICS_FILE,
    SENSITIVITY_FILE,
    THERMAL_FILE,
    UNIT_LOADS_FILE,
    case_file_name,
    require_up_to_date,
    series_file_name,
    simulated_series_file_name,
    simulation_file_name,
)
from tedm_cli.files.store import kind_of, open_checked
from tedm_cli.library.datasets import dataset_of

if TYPE_CHECKING:
    import xarray as xr


def open_build(folder: str | PathLike[str] | None = None) -> Build:
    """A build folder that the commands have filled.

    Parameters
    ----------
    folder : relative to the current folder. Default: `build` in the folder of the project, found as the commands do.

    Raises
    ------
    InputError : there is no such folder.
    """
    path = build_folder(nearest_project()) if folder is None else Path(folder)
    if not path.is_dir():
        raise InputError("no such folder", where=str(path), hint="`tedm run` in the folder of the project makes it")
    return Build(path)


def build_folder(project: Found | None) -> Path:
    """Where the results of a project are if nothing else is said; without one, where they would be."""
    return (Path() if project is None else project.folder) / BUILD


@dataclass(frozen=True)
class Build:
    """The results in a build folder; made by `open_build`, or of a `Project`.

    Each file is read when it is asked for, after its seal, contract and origin have been checked, and becomes one
    Dataset ("Python library" in the documentation tells how, "Files between the stages" what is in each). All raise
    `InputError` for a file that is missing, damaged, or stale: not made from what is there now.
    """

    folder: Path

    @property
    def files(self) -> list[str]:
        """Names of the HDF5 files in the folder."""
        return sorted(path.name for path in self.folder.glob("*.h5"))

    def read(self, file: str, only: Sequence[str] = ()) -> xr.Dataset:
        """One file by its name, `distortion.h5`; of a large one `only` the variables of these names.

        Raises
        ------
        InputError : as of all files.
        UsageError : there is no variable of that name.
        """
        return self._read(file, kind_of(self.folder / file), only)

    def _read(self, file: str, kind: FileKind, only: Sequence[str] = ()) -> xr.Dataset:
        with open_checked(self.folder / file, kind) as reader:
            require_up_to_date(reader)
            return dataset_of(reader, only)

    @property
    def unit_loads(self) -> xr.Dataset:
        """The model and its displacements under the unit loads: grids, elements, masses, areas; basic frame, m."""
        return self._read(UNIT_LOADS_FILE, UNIT_LOADS)

    @property
    def distortion(self) -> xr.Dataset:
        """[D]: `D_translation` (area, node, xyz), m/K; `D_opt_rotation` (area, optical, xyz), rad/K; basic frame."""
        return self._read(DISTORTION_FILE, DISTORTION)

    @property
    def sensitivity(self) -> xr.Dataset:
        """[S_SG] and the field at rest, frames of the test masses.

        `S` (row, area), m/s²/K and rad/s²/K as `row_unit` says; `dc_acceleration` (test_mass, source, xyz), m/s²;
        `stiffness_gamma_lin` (test_mass, source, xyz, xyz_column), 1/s²; verdicts along `dc_verdict`.
        """
        return self._read(SENSITIVITY_FILE, SENSITIVITY)

    @property
    def optics(self) -> xr.Dataset:
        """N: `N` (set, read_out, area), m/K and rad/K as `read_out_unit` says, and the matrices it is made of."""
        return self._read(OPTICS_FILE, OPTICS)

    @property
    def thermal(self) -> xr.Dataset:
        """The thermal network: `steady_K` (node), K; `transfer` (frequency, free, disturbance), K/K or K/W, complex;
        `psd` (frequency, free, free_column), K²/Hz; `sensitivity` (row, map_node), per K."""
        return self._read(THERMAL_FILE, THERMAL)

    @property
    def adjoint(self) -> xr.Dataset:
        """What every temperature does: `s` (row, node), per K; `area_gradient` (row, area, xyz), per K/m; basic frame.

        Of a model that has none `refusal` says why.
        """
        return self._read(ADJOINT_FILE, ADJOINT)

    @property
    def loads(self) -> xr.Dataset:
        """Loads other than temperature: `output_whole` and `output_distortion` (row, load), per `load_unit`;
        `D_translation` (load, node, xyz), m; `mode_frequency` (mode), Hz; basic frame."""
        return self._read(LOADS_FILE, LOADS)

    @property
    def dynamics(self) -> xr.Dataset:
        """The drag-free loop: equations of motion, controller, margins, poles."""
        return self._read(DYNAMICS_FILE, DYNAMICS)

    def case(self, case: int | str) -> xr.Dataset:
        """A correlation case as `tedm run-case` left it: what `run_case` returns."""
        return self._read(case_file_name(str(case)), CASE)

    def simulation(self, case: int | str) -> xr.Dataset:
        """A correlation case in closed loop, of `tedm simulate`."""
        return self._read(simulation_file_name(str(case)), SIMULATION)

    def series(self, name: str, *, in_loop: bool = False) -> xr.Dataset:
        """A temperature series, of `tedm run-series` or, `in_loop`, of `tedm simulate --series`."""
        if in_loop:
            return self._read(simulated_series_file_name(name), SIMULATED_SERIES)
        return self._read(series_file_name(name), SERIES)
