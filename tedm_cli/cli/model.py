"""Commands from the finite-element model to [D]. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from typing import Annotated

import typer

from tedm_cli.cli.app import (
    DEFAULT_BUILD,
    DEFAULT_CONFIG,
    BuildDir,
    Config,
    Output,
    Quiet,
    Verbose,
    app,
    open_project,
    say,
)
from tedm_cli.cli.streams import tell

Run = Annotated[
    str | None,
    typer.Option("--run", help='Use your own Nastran: a command with {deck}, for example "nastran {deck} scr=yes".'),
]


@app.command("write-deck")
def write_deck(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write the unit-load deck for any Nastran.

    One subcase of +1 K per thermal area (+1 K/m of one under a gradient), and one that warms all areas together, on the
    model's own bulk data and constraints. What is dropped from its case control is listed (docs/how-to/write-deck.md).
    """
    from tedm_cli.cli.printing.areas import mean_step_lines
    from tedm_cli.stages.model.deck import write_deck as stage

    done = stage(open_project(config, build_dir, verbose), output)
    say(
        quiet,
        f"{done.path}: {done.areas} unit loads and the uniform load on {done.grids:,} grids,"
        f" from {done.reference:.12g} {done.temperature}",
        *mean_step_lines(done.mean_step),
        *(f"note: {note}" for note in done.notes),
    )


@app.command()
def solve(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    run: Run = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Solve the unit-load deck, write an OP2.

    The embedded solver takes solids, shells, bars, rods, rigid elements, equations and grids in any frame; anything
    else is refused by name: run Nastran on the deck then, yourself or with --run. The command runs in the folder of the
    deck, without a shell, has to wait for the end (MSC Nastran: batch=no), and its OP2 goes where model.op2 says, or
    its HDF5 where that ends in .h5; -v shows what it prints.
    """
    from tedm_cli.cli.printing.model import solve_lines
    from tedm_cli.progress import progress, waiting
    from tedm_cli.stages.model.solve import solve as stage
    from tedm_cli.stages.model.solve import solve_elsewhere

    project = open_project(config, build_dir, verbose)
    if run is not None:
        with waiting(quiet, run):
            path, subcases = solve_elsewhere(project, output, run, _log if verbose else _silence)
        say(quiet, f"{path}: {subcases} subcases by {run}")
        return
    with progress(quiet) as step:
        path, done = stage(project, output, step)
    say(quiet, *solve_lines(path, done))


def _log(line: str) -> None:
    tell([line])


def _silence(line: str) -> None:
    """What a solver prints is shown on request only."""


@app.command()
def ingest(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Deck and results to unit_loads.h5.

    Geometry, masses, thermal areas and displacements, in SI and the basic frame. Results are OP2 files or MSC Nastran's
    HDF5 (MDLPRM,HDF5); which of them a file is, its contents tell.
    """
    from tedm_cli.cli.printing.areas import mean_step_lines, plane_line
    from tedm_cli.cli.printing.model import mass_lines, partial_lines, step_lines, unit_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.model.ingest import ingest as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    say(
        quiet,
        f"{done.path}: {done.grids:,} grids, {done.elements:,} elements, {done.areas} thermal areas"
        + (f", {done.gradients} of them under a gradient" if done.gradients else "")
        + f", displacements in {done.precision} precision",
        *unit_lines(done.units),
        plane_line(done.plane),
        *mass_lines(done.masses),
        *([] if done.has_uniform else ["no uniform load: superposition will not be checked"]),
        *partial_lines(done.partial),
        *mean_step_lines(done.mean_step),
        *(f"note: {note}" for note in done.notes),
        *step_lines(done.coarsest),
    )


@app.command("build-distortion")
def build_distortion(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Unit loads to the distortion matrix [D].

    Per kelvin of every thermal area (kelvin per metre of a gradient), for all grids and for the optical elements, with
    superposition of the means checked. The layout must fit the model: the same test masses as in its configuration,
    elements near their grids.
    """
    from tedm_cli.progress import progress
    from tedm_cli.stages.model.distortion import build_distortion as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    check = "not checked (no uniform load)"
    if done.superposition is not None:
        check = f"{done.superposition:.1e} (results in {done.precision} precision)"
    bent = (
        "" if done.largest_gradient is None else "; under a gradient {:.3g} m/(K/m) ({})".format(*done.largest_gradient)
    )
    optical = f"{done.optical} optical elements" if done.optical else "no optical elements: the project has no optics"
    say(
        quiet,
        f"{done.path}: D for {done.areas} areas, {done.grids:,} grids, {optical}",
        f"superposition residual {check}; largest translation {done.largest_m_per_K:.3g} m/K ({done.largest_area}),"
        f" largest rigid-body part {done.largest_rigid_m_per_K:.3g} m/K{bent}",
        *(f"warning: {note}" for note in done.notes),
    )
