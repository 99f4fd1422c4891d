"""The results of one variant: each file is read once, when the first criterion asks for it."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar, cast

from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import NO_OPTICS, Project
from tedm_cli.config.trade import CriterionTable
from tedm_cli.contracts import CASE, LOADS, SENSITIVITY, SIMULATION, UNIT_LOADS, FileKind
from tedm_cli.files.build_folder import (
    LOADS_FILE,
    SENSITIVITY_FILE,
    UNIT_LOADS_FILE,
    case_file_name,
    simulation_file_name,
)
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.results.cases.deciding import DIAGNOSTIC, LIKELY
from tedm_cli.results.cases.file import NoiseAt, read_case, read_noise_at
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.results.dynamics.loop import SimulatedCase, read_simulation
from tedm_cli.results.dynamics.no_loop import why_no_loop
from tedm_cli.results.gravity.field import FieldAtRest, read_field
from tedm_cli.results.loads import LoadResults, read_loads
from tedm_cli.results.model import ModelSize, read_model_size
from tedm_cli.results.wording import and_text

T = TypeVar("T")


class LacksError(Exception):
    """That a variant lacks a criterion: the reason, for its cell."""


class VariantResults:
    """What a variant has, by its project; every file that was read is in `files`."""

    def __init__(self, project: Project) -> None:
        self.project = project
        self.cases: CasesConfig = load_cases(project.cases)[1]
        self._model = load_model(project.model)[1]
        self._read: dict[tuple[Path, object], object] = {}

    @property
    def files(self) -> list[Path]:
        """The files that have been read, each once."""
        return list(dict.fromkeys(path for path, _ in self._read))

    @property
    def model(self) -> ModelSize:
        return self._once(UNIT_LOADS_FILE, UNIT_LOADS, read_model_size)

    @property
    def field(self) -> FieldAtRest:
        if not self._model.test_mass:
            raise LacksError("the model has no test masses")
        return self._once(SENSITIVITY_FILE, SENSITIVITY, read_field)

    @property
    def loads(self) -> LoadResults:
        if self.project.loads is None:
            raise LacksError("the project has no loads but temperatures: its file names none")
        if not self._model.test_mass:
            raise LacksError("the model has no test masses")
        return self._once(LOADS_FILE, LOADS, read_loads)

    def noise(self, case_id: str) -> CaseNoise:
        return self._once(case_file_name(case_id), CASE, read_case)

    def noise_at(self, case_id: str) -> NoiseAt:
        """The spectra of all outputs, judged or not."""
        return self._once(case_file_name(case_id), CASE, read_noise_at)

    def simulation(self, case_id: str) -> SimulatedCase:
        if why := why_no_loop(self.project, self._model):
            raise LacksError(why)
        return self._once(simulation_file_name(case_id), SIMULATION, read_simulation)

    def case_ids(self, criterion: CriterionTable, *, in_loop: bool = False) -> list[str]:
        """The cases of a criterion: the one it names; else the likely ones, or all but the diagnostic ones."""
        ids = self.cases.ids_of_areas if in_loop else self.cases.ids
        if criterion.case is not None:
            if criterion.case not in ids:
                raise LacksError(f"has no case {criterion.case}")
            return [criterion.case]
        roles = {case_id: self.cases.case_table(case_id).role for case_id in ids}
        likely = [case_id for case_id, role in roles.items() if role == LIKELY]
        return likely or [case_id for case_id, role in roles.items() if role != DIAGNOSTIC] or ids

    def why_no(self, criterion: CriterionTable, known: Sequence[str]) -> LacksError:
        """That nothing of what is judged is meant by a criterion; `known`: what is, by outputs and requirements."""
        wanted = [*(criterion.outputs or ()), *([criterion.requirement] if criterion.requirement else ())]
        strange = [name for name in wanted if name not in known]
        optics = f" ({NO_OPTICS})" if self.project.optics is None else ""
        if not strange:
            return LacksError("judges nothing of this")
        near = difflib.get_close_matches(strange[0], known, n=1)
        hint = f"; the nearest is {near[0]}" if near else ""
        return LacksError(f"has no {and_text(strange)}{optics}{hint}")

    def _once(self, name: str, kind: FileKind, read: Callable[[Reader], T]) -> T:
        path = self.project.build_dir / name
        if (path, read) not in self._read:
            with open_checked(path, kind) as file:
                self._read[path, read] = read(file)
        return cast(T, self._read[path, read])
