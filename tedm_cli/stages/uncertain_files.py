"""Files of build folders that the uncertainty of a case is made from, besides the matrices of its own mesh."""

from __future__ import annotations

from pathlib import Path

from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.halves import halves_of
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.nearest import BUILD, project_in
from tedm_cli.config.project import Project
from tedm_cli.files.build_folder import ADJOINT_FILE, OPTICS_FILE, SENSITIVITY_FILE


def uncertainty_sources(project: Project, model: ModelConfig, cases: CasesConfig) -> tuple[Path, ...]:
    """The adjoint, where materials or thicknesses are uncertain and there is one, and the matrices of a second mesh."""
    halves, mesh = halves_of(project, model), cases.uncertainty.mesh
    adjoint = [project.build_dir / ADJOINT_FILE] if model.uncertainty.of_structure and halves.gravity else []
    names = [*([SENSITIVITY_FILE] if halves.gravity else []), *([OPTICS_FILE] if halves.read_out else [])]
    other = [] if mesh is None else [build_folder_of(Path(mesh.other)) / name for name in names]
    return (*adjoint, *other)


def build_folder_of(path: Path) -> Path:
    """The build folder of a project, which is named by its file or by its folder; else `path` is that folder."""
    found = project_in(path.parent if path.suffix == ".toml" else path)
    return path if found is None else found.folder / BUILD
