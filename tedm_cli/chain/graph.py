"""The chain as steps: the command of each, the files that it makes, and the files that they are made of.

The Makefile has a rule for each stage, with the same files; a test holds both to the same steps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

FIGURES_STAMP, REPORT, VIEW = "figures.stamp", "report.html", "view.html"
HALVES, SYMMETRY_PLANE, TIES = "halves", "symmetry_plane", "ties"


@dataclass(frozen=True)
class Named:
    """A case or a time series: its name on the command line, its result file, and files that it alone is made of."""

    name: str
    file: Path
    tables: tuple[Path, ...] = ()


@dataclass(frozen=True)
class ChainFiles:
    """The files that the configuration of a project names, and those of its build folder.

    Parameters
    ----------
    project, model, optics, cases, dynamics, thermal, loads : the configuration files; without `optics`, self-gravity
    alone.
    bdf, areas : the model that unit loads are made from, and the list of its thermal areas.
    deck, results, solved_here : unit-load deck and results; whether they are made here, or are the user's own.
    superelements : matrices and lists of superelements.
    unit_loads, distortion, loop : what the stages make of them; `loop` is None where there is no drag-free loop.
    sensitivity, read_out : the matrices of the two halves of the chain, where the project has them.
    adjoint : what every temperature does to their outputs; of a project with test masses. adjoint_results : of the
    user's own solver, that it is made of; none where it is solved here. case_needs_adjoint : whether cases take
    something of it.
    gravity_sources, optics_sources, dynamics_sources : tables beside the configuration that these halves read.
    other_loads : what loads other than temperature do, where the project has some and test masses.
    network : what is made of the thermal model, where there is one. thermal_sources : all that it is made from besides
        its own file: tables, and those results and configurations that it needs.
    effects : tables of the user's own effects on outputs.
    case_sources, spectra : of requirements and correlations; of the temperature noise.
    uncertainty_sources : the adjoint, where materials are uncertain, and files of a second mesh.
    runs, simulations, series, simulated_series : what `run-case`, `simulate`, `run-series`, `simulate --series` make.
    older_series : files of series in the build folder, which the page shows too.
    plane : the symmetry plane, in a form that changes when the plane does.
    ties : what compensation masses are tied to, a line for each; of their table nothing else matters to unit loads.
    code : the newest file of the program.
    """

    build_dir: Path
    project: Path
    model: Path
    optics: Path | None
    cases: Path
    dynamics: Path | None
    thermal: Path | None
    loads: Path | None
    bdf: Path | None
    areas: Path | None
    superelements: tuple[Path, ...]
    deck: Path
    results: tuple[Path, ...]
    solved_here: bool
    unit_loads: Path
    distortion: Path
    sensitivity: Path | None
    read_out: Path | None
    adjoint: Path | None
    adjoint_results: tuple[Path, ...]
    case_needs_adjoint: bool
    loop: Path | None
    network: Path | None
    other_loads: Path | None
    gravity_sources: tuple[Path, ...]
    effects: tuple[Path, ...]
    optics_sources: tuple[Path, ...]
    dynamics_sources: tuple[Path, ...]
    thermal_sources: tuple[Path, ...]
    case_sources: tuple[Path, ...]
    spectra: tuple[Path, ...]
    uncertainty_sources: tuple[Path, ...]
    runs: tuple[Named, ...]
    simulations: tuple[Named, ...]
    series: tuple[Named, ...]
    simulated_series: tuple[Named, ...]
    older_series: tuple[Path, ...]
    plane: str
    ties: str
    code: Path

    @property
    def matrices(self) -> tuple[Path, ...]:
        return _there(self.sensitivity, self.read_out)

    @property
    def case_adjoint(self) -> Path | None:
        """The adjoint, where cases are made from it as well."""
        return self.adjoint if self.case_needs_adjoint else None

    def remembered(self) -> dict[Path, str]:
        """Files of the build folder that change when the halves of the chain do, the symmetry plane, or what
        compensation masses are tied to; their texts."""
        names = " ".join(path.name for path in self.matrices)
        texts = {HALVES: f"{names}\n", SYMMETRY_PLANE: f"{self.plane}\n", TIES: self.ties}
        return {self.build_dir / name: text for name, text in texts.items()}


@dataclass(frozen=True)
class Step:
    """One command of the chain.

    Parameters
    ----------
    command : the words after `tedm`, without the options that name project and build folder.
    outputs, inputs : the files that decide whether it has to run.
    stamp : whether the output is an empty file that says when the command has run.
    on_request : whether it is run only where it is asked for by name: nothing else is made of it.
    """

    command: tuple[str, ...]
    outputs: tuple[Path, ...]
    inputs: tuple[Path, ...]
    stamp: bool = False
    on_request: bool = False

    @property
    def stage(self) -> str:
        return self.command[0]

    @property
    def words(self) -> str:
        return " ".join(self.command)


def chain_of(files: ChainFiles) -> tuple[Step, ...]:
    """The steps of a project, in an order in which they can run."""
    build, matrices = files.build_dir, files.matrices
    halves = build / HALVES
    steps: list[Step] = []

    def step(
        command: Iterable[str],
        outputs: Iterable[Path],
        *inputs: Path | None,
        stamp: bool = False,
        on_request: bool = False,
    ) -> None:
        made_of = tuple(dict.fromkeys(_there(*inputs)))
        steps.append(Step(tuple(command), tuple(outputs), made_of, stamp, on_request))

    told_of = (files.project, files.model, files.code)
    if files.solved_here:
        step(["write-deck"], [files.deck], files.bdf, files.areas, *files.superelements, *told_of)
        step(["solve"], files.results, files.deck)
    told = (
        files.areas,
        *files.superelements,
        files.project,
        files.model,
        build / SYMMETRY_PLANE,
        build / TIES,
        files.code,
    )
    step(["ingest"], [files.unit_loads], files.deck, *files.results, *told)
    step(["build-distortion"], [files.distortion], files.unit_loads, files.optics, halves)
    if files.sensitivity is not None:
        step(["build-sensitivity"], [files.sensitivity], files.distortion, files.model, *files.gravity_sources)
    if files.read_out is not None:
        step(["build-optics"], [files.read_out], files.distortion, files.optics, *files.optics_sources)
    if files.adjoint is not None:
        found = (files.deck, *matrices, halves, *files.adjoint_results)
        step(["build-adjoint", "--or-say-why"], [files.adjoint], *found)
    if files.network is not None:
        step(["build-thermal"], [files.network], files.thermal, *files.thermal_sources)
    cases = (files.cases, *files.effects, *files.case_sources)
    for run in files.runs:
        used = (*matrices, files.case_adjoint, *files.uncertainty_sources, halves)
        step(["run-case", run.name], [run.file], *used, *run.tables, *cases, *files.spectra)
    for run in files.series:
        step(["run-series", run.name], [run.file], *matrices, halves, *cases, *run.tables)
    if files.loop is not None:
        step(["build-dynamics"], [files.loop], *matrices, *files.effects, files.dynamics, *files.dynamics_sources)
        for run in files.simulations:
            used = (files.loop, files.case_adjoint, *run.tables)
            step(["simulate", run.name], [run.file], *used, *cases, *files.spectra)
        for run in files.simulated_series:
            step(["simulate", "--series", run.name], [run.file], files.loop, *cases, *run.tables)
    made = [run.file for run in (*files.runs, *files.simulations, *files.series)]
    drawn = build / FIGURES_STAMP
    drawn_of = (*made, *(run.file for run in files.simulated_series), files.adjoint, files.network)
    step(["plot"], [drawn], *drawn_of, stamp=True)
    step(["report"], [build / REPORT], drawn, files.project)
    step(["view"], [build / VIEW], *made, *files.older_series)
    if files.other_loads is not None:
        step(["build-loads"], [files.other_loads], files.deck, *matrices, halves, files.loads, on_request=True)
    return tuple(steps)


def leading_to(steps: tuple[Step, ...], is_wanted: Callable[[Step], bool]) -> tuple[Step, ...]:
    """The steps that are wanted, and all that they are made from."""
    wanted: set[Path] = set()
    kept: list[Step] = []
    for step in reversed(steps):
        if is_wanted(step) or wanted.intersection(step.outputs):
            kept.append(step)
            wanted.update(step.inputs)
    return tuple(reversed(kept))


def _there(*paths: Path | None) -> tuple[Path, ...]:
    return tuple(path for path in paths if path is not None)
