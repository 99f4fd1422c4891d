"""check-layout: the optical layout alone, judged as `build-optics` judges it before it uses it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.model.file import ModelTable, load_model
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.errors import InputError, PhysicsError, TedmError
from tedm_cli.nastran.positions import frames_of, grid_positions
from tedm_cli.nastran.reading import read_deck
from tedm_cli.optics.benches import benches
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.layout_checks import Finding, check_layout, failures
from tedm_cli.stages.layout_match import Match, match_grids, match_layout


@dataclass(frozen=True)
class LayoutReport:
    """What was found in the layout at `path`; `match`: against the model's configuration, None where that is not there.

    `unread`: why it could not be read. `deck`: the model whose grids were compared, too, None where there is none that
    can be read; `unread_deck`: why.
    """

    path: Path
    layout: OpticalLayout
    findings: tuple[Finding, ...]
    match: Match | None
    unread: str
    deck: Path | None = None
    unread_deck: str = ""

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
    decks = [project.resolve(name) for name in (model.model.bdf, model.model.deck) if name is not None]
    deck = next((path for path in decks if path.exists()), decks[0])
    try:
        grid_id, position = _grids(deck, model.model)
    except TedmError as exc:
        unread = str(exc).splitlines()[0] if deck.exists() else f"{deck}: no such file"
        return LayoutReport(path, layout, findings, match_layout(layout, path, model, project.model), "", None, unread)
    match = match_grids(layout, path, model, project.model, grid_id, position)
    return LayoutReport(path, layout, findings, match, "", deck)


def _grids(deck: Path, table: ModelTable) -> tuple[IntArray, FloatArray]:
    """Ids [N], ascending, and positions [N, 3] m, basic frame, of the grids of a deck; nothing else of it is judged."""
    units = table.deck_units()
    model = read_deck(deck, allow_missing_enddata=table.allow_missing_enddata, units=units)
    grid_id = np.array(sorted(model.nodes), dtype=np.int64)
    if not grid_id.size:
        raise InputError("holds no grids", where=str(deck))
    return grid_id, units.length_m * grid_positions(model, grid_id, frames_of(model))


def refuse_failures(findings: tuple[Finding, ...], where: Path) -> None:
    """Raise one `PhysicsError` with a line for every failure that is not only a warning."""
    wrong = failures(findings)
    if wrong:
        raise PhysicsError(
            "\n".join(f.line for f in wrong), where=str(where), hint="`tedm check-layout` prints all margins"
        )
