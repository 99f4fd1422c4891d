"""Commands from the finite-element model to [D]. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tedm_cli.cli.app import answer, app, open_project
from tedm_cli.cli.headings import examples
from tedm_cli.cli.options import (
    DEFAULT_BUILD,
    DEFAULT_CONFIG,
    BuildDir,
    Config,
    Json,
    Output,
    Quiet,
    Verbose,
)
from tedm_cli.cli.streams import tell
from tedm_cli.errors import UsageError

if TYPE_CHECKING:
    from tedm_cli.fem.linear import MemoryNeed

Run = Annotated[
    str | None,
    typer.Option(
        "--run",
        metavar="COMMAND",
        help='Use your own Nastran: a command with {deck}, for example "nastran {deck} scr=yes".',
    ),
]


@app.command("write-deck", epilog=examples("tedm write-deck", "tedm write-deck --adjoint -o adjoint_loads.bdf"))
def write_deck(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    adjoint: Annotated[
        bool,
        typer.Option(
            "--adjoint",
            help="Write the deck of the adjoint instead, adjoint_loads.bdf beside the unit-load deck: one subcase of"
            " forces for each output of sensitivity.h5 and optics.h5.",
        ),
    ] = False,
    loads: Annotated[
        bool,
        typer.Option(
            "--loads",
            help="Write the deck of the loads of loads.toml instead, other_loads.bdf beside the unit-load deck: one"
            " subcase of SPCD, GRAV, FORCE and MOMENT for each.",
        ),
    ] = False,
    thermal_nodes: Annotated[
        bool,
        typer.Option(
            "--thermal-nodes",
            help="Write the deck of the thermal nodes of [map] in the thermal model's file instead, thermal_nodes.bdf"
            " beside the unit-load deck: one subcase of TEMP cards for each.",
        ),
    ] = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write the unit-load deck for any Nastran.

    One subcase of +1 K per thermal area (+1 K/m of one under a gradient), and one that warms all areas together, on the
    model's own bulk data and constraints. What it drops from the case control is listed. The results of a deck of
    --adjoint or --loads are taken by --op2 of `build-adjoint` or `build-loads`, those of --thermal-nodes by
    `build-thermal`, where [map] names them as its `results`.
    """
    chosen = [
        name for name, on in (("--adjoint", adjoint), ("--loads", loads), ("--thermal-nodes", thermal_nodes)) if on
    ]
    if len(chosen) > 1:
        raise UsageError(f"{' and '.join(chosen)} are {len(chosen)} decks", hint="write one after the other")
    if thermal_nodes:
        from tedm_cli.cli.printing.thermal import node_deck_dict, node_deck_lines
        from tedm_cli.stages.thermal.deck import write_node_deck

        of_nodes = write_node_deck(open_project(config, build_dir, verbose), output)
        answer(as_json, quiet, lambda: node_deck_lines(of_nodes), lambda: node_deck_dict(of_nodes))
        return
    if loads:
        from tedm_cli.cli.printing.loads import loads_deck_dict, loads_deck_lines
        from tedm_cli.stages.loads.deck import write_loads_deck

        of_loads = write_loads_deck(open_project(config, build_dir, verbose), output)
        answer(as_json, quiet, lambda: loads_deck_lines(of_loads), lambda: loads_deck_dict(of_loads))
        return
    if adjoint:
        from tedm_cli.cli.printing.adjoint import adjoint_deck_dict, adjoint_deck_lines
        from tedm_cli.stages.adjoint.deck import write_adjoint_deck

        written = write_adjoint_deck(open_project(config, build_dir, verbose), output)
        answer(as_json, quiet, lambda: adjoint_deck_lines(written), lambda: adjoint_deck_dict(written))
        return
    from tedm_cli.cli.printing.model import deck_dict, deck_lines
    from tedm_cli.stages.model.deck import write_deck as stage

    done = stage(open_project(config, build_dir, verbose), output)
    answer(as_json, quiet, lambda: deck_lines(done), lambda: deck_dict(done))


@app.command(
    epilog=examples(
        "tedm solve", 'tedm solve --run "nastran {deck} scr=yes batch=no"', "tedm solve --deck loads.bdf -o loads.op2"
    )
)
def solve(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    run: Run = None,
    deck: Annotated[
        Path | None,
        typer.Option(
            "--deck",
            metavar="FILE",
            help="Solve this SOL 101 deck instead, in the units of the model. Its subcases may have forces, moments,"
            " accelerations and motions of supports (FORCE, MOMENT, GRAV, SPCD, LOAD) as well as temperatures. The OP2"
            " goes beside it.",
        ),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Solve the unit-load deck, write an OP2.

    The embedded solver takes solids, shells, bars, rods, rigid elements, equations and grids in any frame; anything
    else is refused by name: run Nastran on the deck then, yourself or with --run. The command runs in the folder of the
    deck, without a shell, has to wait for the end (MSC Nastran: batch=no), and its OP2 goes where model.op2 says, or
    its HDF5 where that ends in .h5; -v shows what it prints.
    """
    from tedm_cli.cli.printing.model import elsewhere_dict, elsewhere_lines, solve_dict, solve_lines
    from tedm_cli.progress import progress, waiting
    from tedm_cli.stages.model.solve import solve as stage
    from tedm_cli.stages.model.solve import solve_elsewhere, solve_other

    if run is not None and deck is not None:
        raise UsageError("--run is for the unit-load deck, and --deck is another one", hint="run your Nastran on it")
    project = open_project(config, build_dir, verbose)
    if run is not None:
        with waiting(quiet, run):
            found = solve_elsewhere(project, output, run, _log if verbose else _silence)
        answer(as_json, quiet, lambda: elsewhere_lines(*found, run), lambda: elsewhere_dict(*found, run))
        return
    with progress(quiet) as step:
        told = _need if verbose else None
        if deck is None:
            path, done = stage(project, output, step, told)
        else:
            path, done = solve_other(project, deck, output, step, told)
    answer(as_json, quiet, lambda: solve_lines(path, done), lambda: solve_dict(path, done))


def _need(memory: MemoryNeed) -> None:
    tell([str(memory)])


def _log(line: str) -> None:
    tell([line])


def _silence(line: str) -> None:
    """What a solver prints is shown on request only."""


@app.command(epilog=examples("tedm reduce --interface 101,102,103 --part 700001 -o spacecraft.op4"))
def reduce(
    interface: Annotated[
        str,
        typer.Option("--interface", metavar="GRIDS", help="Grids where the part is joined to the rest."),
    ],
    part: Annotated[
        int, typer.Option("--part", metavar="N", help="Id of any grid of the part, to tell it from the rest.")
    ],
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Reduce a part of the unit-load deck to its interface.

    Writes what a table [[superelement]] of another project reads: stiffness, thermal loads of the areas and motions of
    the grids with mass as OUTPUT4 (.op4) or DMIG cards (.bdf), and lists of areas and masses beside them. The part is
    all that hangs together with the grid of --part when the interface grids are taken out. Static condensation is
    exact.
    """
    from tedm_cli.cli.printing.model import reduce_dict, reduce_lines
    from tedm_cli.errors import UsageError
    from tedm_cli.stages.model.reduce import reduce as stage

    words = [word.strip() for word in interface.split(",")]
    if not all(word.isascii() and word.isdigit() and 0 < int(word) < 10**9 for word in words) or len(set(words)) < len(
        words
    ):
        raise UsageError(f"--interface: {interface[:60]!r} is no list of grids", hint="write --interface 101,102,103")
    done = stage(open_project(config, build_dir, verbose), [int(word) for word in words], part, output)
    answer(as_json, quiet, lambda: reduce_lines(done), lambda: reduce_dict(done))


@app.command()
def ingest(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Read deck and results into unit_loads.h5.

    Geometry, masses, thermal areas and displacements, in SI and the basic frame. Results are OP2 files or MSC Nastran's
    HDF5 (MDLPRM,HDF5); which of them a file is, its contents tell.
    """
    from tedm_cli.cli.printing.ingest import ingest_dict, ingest_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.model.ingest import ingest as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    answer(as_json, quiet, lambda: ingest_lines(done), lambda: ingest_dict(done))


@app.command("build-distortion")
def build_distortion(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Distortion matrix [D] of the unit loads.

    Per kelvin of every thermal area (kelvin per metre of a gradient), for all grids and for the optical elements, with
    superposition of the means checked. The layout must fit the model: the same test masses as in its configuration,
    elements near their grids.
    """
    from tedm_cli.cli.printing.model import distortion_dict, distortion_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.model.distortion import build_distortion as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    answer(as_json, quiet, lambda: distortion_lines(done), lambda: distortion_dict(done))
