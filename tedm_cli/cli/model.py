"""Commands from the finite-element model to [D]. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

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


@app.command("write-deck")
def write_deck(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write the unit-load deck for any Nastran.

    One subcase of +1 K per thermal area, and one that warms all areas together.
    """
    from tedm_cli.stages.deck import write_deck as stage

    done = stage(open_project(config, build_dir, verbose), output)
    say(quiet, f"{done.path}: {done.areas} unit loads and the uniform load on {done.grids:,} grids")


@app.command()
def solve(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Solve the unit-load deck, write an OP2.

    The embedded solver takes solids, shells, bars, rods, rigid elements, equations and grids in any frame; anything
    else is refused by name: run Nastran on the deck then.
    """
    from tedm_cli.progress import progress
    from tedm_cli.say import solve_lines
    from tedm_cli.stages.solve import solve as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        path, done = stage(project, output, step)
    say(quiet, *solve_lines(path, done))


@app.command()
def ingest(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Deck and OP2 results to unit_loads.h5.

    Geometry, masses, thermal areas and displacements, in SI and the basic frame.
    """
    from tedm_cli.progress import progress
    from tedm_cli.say import partial_lines
    from tedm_cli.stages.ingest import ingest as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    x, y, z = done.centre_of_gravity_m
    say(
        quiet,
        f"{done.path}: {done.grids:,} grids, {done.elements:,} elements, {done.areas} thermal areas",
        f"mass {done.total_kg:.9g} kg (elements: {done.reference_kg:.9g} kg), centre of gravity"
        f" ({x:.6g}, {y:.6g}, {z:.6g}) m in the basic frame",
        *([] if done.has_uniform else ["no uniform load: superposition will not be checked"]),
        *partial_lines(done.partial),
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

    Per kelvin of every thermal area, for all grids and for the optical elements, with superposition checked.
    """
    from tedm_cli.progress import progress
    from tedm_cli.stages.distortion import build_distortion as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    check = "not checked (no uniform load)" if done.superposition is None else f"{done.superposition:.1e}"
    say(
        quiet,
        f"{done.path}: D for {done.areas} areas, {done.grids:,} grids, {done.optical} optical elements",
        f"superposition residual {check}; largest translation {done.largest_m_per_K:.3g} m/K ({done.largest_area}),"
        f" largest rigid-body part {done.largest_rigid_m_per_K:.3g} m/K",
    )
