"""What outputs as nodal forces are made of: a deck, and the matrices of a build folder, all of one state."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tedm_cli.arrays import IntArray
from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, OPTICS, SENSITIVITY, UNIT_LOADS
from tedm_cli.files.build_folder import (
    DISTORTION_FILE,
    OPTICS_FILE,
    SENSITIVITY_FILE,
    UNIT_LOADS_FILE,
    provenance,
    require_configuration,
    require_input,
    require_same_areas,
)
from tedm_cli.files.provenance import ConfigFile, Provenance
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.nastran.reading import deck_files, read_deck
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.stages.outputs import Outputs, accelerations, read_outs


@dataclass(frozen=True, eq=False)
class _Optics:
    """optics.h5, the layout that it is of, and the file of this."""

    path: Path
    file: ConfigFile
    layout: OpticalLayout


@dataclass(frozen=True, eq=False, kw_only=True)
class OutputInputs:
    """The files of one state of a build folder, open.

    raw, files : the model of the unit-load deck, not cross-referenced, and its files, the deck first.
    unit, sensitivity : unit_loads.h5 and sensitivity.h5. no_read_outs : why these are not among the outputs; empty
    where they are. trace : what all of it is of.
    """

    config: ModelConfig
    raw: Any
    files: list[Path]
    unit: Reader
    sensitivity: Reader
    trace: Provenance
    no_read_outs: str
    _distortion: Reader
    _read_out: tuple[Reader, _Optics] | None

    @property
    def deck(self) -> Path:
        return self.files[0]

    @property
    def read_out(self) -> tuple[Reader, OpticalLayout] | None:
        """optics.h5 and its layout, where there are read-outs."""
        return None if self._read_out is None else (self._read_out[0], self._read_out[1].layout)

    def outputs(self, grid_id: IntArray) -> Outputs:
        """Accelerations, then read-outs where optics.h5 is, of a structure of the grids `grid_id` [N].

        Raises what `read_outs` does.
        """
        found = accelerations(self.sensitivity, self._distortion)
        if self._read_out is not None:
            file, optics = self._read_out
            found += read_outs(file, optics.layout, optics.file.path, grid_id)
        return found


@contextlib.contextmanager
def output_inputs(
    project: Project, what: str, results: Sequence[Path] = (), more: Sequence[ConfigFile] = ()
) -> Iterator[OutputInputs]:
    """Open what outputs are made of; `results` of another solver and `more` configurations are in its trace as well.

    `what` is made of them, for messages.

    Raises
    ------
    ConfigError : the model has no test masses.
    InputError : a file that is missing or stale.
    """
    config_file, config = load_model(project.model)
    config.require_outputs(project.model, what)
    table, build = config.model, project.build_dir
    deck = project.resolve(table.deck)
    raw = read_deck(
        deck, cross_reference=False, allow_missing_enddata=table.allow_missing_enddata, units=table.deck_units()
    )
    files = deck_files(raw, deck)
    optics, no_read_outs = _optics(project)
    configs = [config_file, *([] if optics is None else [optics.file]), *more]
    own = [build / name for name in (UNIT_LOADS_FILE, DISTORTION_FILE, SENSITIVITY_FILE)]
    own += [] if optics is None else [optics.path]
    trace = provenance(configs, [*own, *files, *results])
    with contextlib.ExitStack() as stack:
        unit = stack.enter_context(open_checked(own[0], UNIT_LOADS))
        distortion = stack.enter_context(open_checked(own[1], DISTORTION))
        sensitivity = stack.enter_context(open_checked(own[2], SENSITIVITY))
        read_out = None if optics is None else (stack.enter_context(open_checked(optics.path, OPTICS)), optics)
        require_configuration(sensitivity, project.model)
        for item in trace.inputs[:2]:
            require_input(sensitivity, item)
        for item in trace.inputs[len(own) : len(own) + len(files)]:
            require_input(unit, item)
        if read_out is not None:
            require_configuration(read_out[0], read_out[1].file.path)
            require_input(read_out[0], trace.inputs[1])
        require_same_areas(sensitivity, distortion, *([] if read_out is None else [read_out[0]]))
        yield OutputInputs(
            config=config,
            raw=raw,
            files=files,
            unit=unit,
            sensitivity=sensitivity,
            trace=trace,
            no_read_outs=no_read_outs,
            _distortion=distortion,
            _read_out=read_out,
        )


def _optics(project: Project) -> tuple[_Optics | None, str]:
    """The read-outs there are, or why there are none."""
    path = project.build_dir / OPTICS_FILE
    if project.optics is None:
        return None, "the project has no optics"
    if not path.exists():
        return None, f"{path} is not there: `{OPTICS.made_by}` makes it"
    return _Optics(path, *load_layout(project.optics)), ""
