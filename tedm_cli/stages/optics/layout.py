"""check-layout: the optical layout alone, judged as `build-optics` judges it before it uses it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tedm_cli.config.model import load_model
from tedm_cli.config.optics import load_layout
from tedm_cli.config.project import Project
from tedm_cli.errors import PhysicsError, TedmError
from tedm_cli.optics.benches import benches
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.layout_checks import Finding, check_layout, failures
from tedm_cli.stages.layout_match import Match, match_layout


@dataclass(frozen=True)
class LayoutReport:
    """What was found in the layout at `path`; `match`: against the model's configuration, None where that is not there.

    `unread`: why it could not be read.
    """

    path: Path
    layout: OpticalLayout
    findings: tuple[Finding, ...]
    match: Match | None
    unread: str

    @property
    def without_grid(self) -> list[str]:
        """Elements of the bench that no grid carries yet."""
        return [e.name for e in self.layout.bench if e.grid is None]

    @property
    def benches(self) -> dict[str, list[str]]:
        """Names of the elements of each bench."""
        return {name: [e.name for e in elements] for name, elements in benches(self.layout).items()}


def inspect_layout(project: Project) -> LayoutReport:
    """Check the project's layout; nothing is raised for what fails, see `refuse_failures`.

    A layout without geometry, whose S_BW is imported, has nothing to be checked. Grids may be missing: the bench is
    often designed before the finite-element model, whose configuration need not be there or sound either.
    """
    path = project.required_optics()
    _, layout = load_layout(path, needs_grids=False)
    findings = check_layout(layout) if layout.has_geometry else ()
    try:
        _, model = load_model(project.model)
    except TedmError as exc:
        unread = exc.placed.splitlines()[0] if project.model.exists() else f"{project.model}: no such file"
        return LayoutReport(path, layout, findings, None, unread)
    match = match_layout(layout, path, model, project.model)
    return LayoutReport(path, layout, findings, match, "")


def refuse_failures(findings: tuple[Finding, ...], where: Path) -> None:
    """Raise one `PhysicsError` with a line for every failure that is not only a warning."""
    wrong = failures(findings)
    if wrong:
        raise PhysicsError(
            "\n".join(f.line for f in wrong), where=str(where), hint="`tedm check-layout` prints all margins"
        )
