"""Commands on the thermal model. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tedm_cli.cli import completion
from tedm_cli.cli.app import answer, app, open_project
from tedm_cli.cli.headings import examples
from tedm_cli.cli.options import (
    DEFAULT_BUILD,
    DEFAULT_CONFIG,
    DEFAULT_TOP,
    BuildDir,
    Config,
    Json,
    Output,
    Quiet,
    Top,
    Verbose,
    rows,
)


@app.command("build-thermal")
def build_thermal(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Steady state, gains and spectra of the thermal network.

    From its nodes and conductors, with radiation, and the spectra of what disturbs it: boundary temperatures and
    powers. Each gain has the low-pass that fits it best. Where the thermal nodes lie on the model, also what a kelvin
    of each does to the outputs, and to every grid: the displacements under each node.
    """
    from tedm_cli.cli.printing.thermal import thermal_dict, thermal_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.thermal.build import build_thermal as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, output, step)
    answer(as_json, quiet, lambda: thermal_lines(done), lambda: thermal_dict(done))


@app.command(
    "map-temperatures",
    epilog=examples(
        "tedm map-temperatures tau.csv",
        "tedm map-temperatures tau.csv -o grids.bdf --figure field.png",
        "tedm map-temperatures --case T --of A_TM1_x -o field.vtu",
    ),
)
def map_temperatures(
    given: Annotated[
        Path | None,
        typer.Argument(metavar="FILE", help="CSV set,NODE...: temperatures of thermal nodes above the reference, K."),
    ] = None,
    case: Annotated[
        str | None,
        typer.Option(
            "--case",
            metavar="CASE",
            autocompletion=completion.cases,
            help="In place of FILE: temperatures that go with the noise of an output in a case of the thermal network.",
        ),
    ] = None,
    of: Annotated[
        str | None,
        typer.Option(
            "--of",
            metavar="OUTPUT",
            autocompletion=completion.outputs,
            help="The output of --case: TM1_a_x, A_TM1_x, ... Default: that of the worst verdict.",
        ),
    ] = None,
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help="Write the temperatures of grids: a CSV grid,SET..., TEMP cards (.bdf), HDF5 (.h5), a mesh (.vtu).",
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option("--figure", metavar="FILE", help="Draw the model coloured by temperature (.svg or .png)."),
    ] = None,
    shown: Annotated[
        str | None, typer.Option("--draw", metavar="ROW", help="The set that the figure shows. Default: the first.")
    ] = None,
    top: Top = DEFAULT_TOP,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Temperatures of grids from those of thermal nodes.

    Each thermal node keeps its temperature as the average over its elements. Of all fields with these averages the
    grids get the one that conduction chooses. Printed are the nodes with fewest elements, how well averages are kept,
    and how much the field changes across one element. Of a FILE it reads the model and [map] of the thermal model's
    file alone.

    With --case the sets are the temperatures that go with one amplitude of an output on average (`typical`), in K per
    sqrt(Hz), and the part of each disturbance in them; their sum is `typical`.
    """
    from tedm_cli.cli.printing.mapped import mapped_lines
    from tedm_cli.errors import UsageError
    from tedm_cli.stages.thermal.map_case import OfCase
    from tedm_cli.stages.thermal.map_temperatures import map_temperatures as stage

    if (given is None) == (case is None):
        found = "both" if case is not None else "neither"
        raise UsageError(f"give a FILE or --case, found {found}", hint="tedm map-temperatures tau.csv")
    if case is None and of is not None:
        raise UsageError("--of is of --case: it names an output of a case")
    sets = OfCase(case, of) if case is not None else given
    assert sets is not None
    done = stage(open_project(config, build_dir, verbose), sets, output, figure, shown)
    answer(as_json, quiet, lambda: mapped_lines(done, rows(top)), done.as_dict)


@app.command(
    "simulate-thermal",
    epilog=examples(
        "tedm simulate-thermal disturbances.csv -o temperatures.csv",
        "tedm simulate-thermal --duration 1e6 --seed 2 -o temperatures.h5",
    ),
)
def simulate_thermal(
    given: Annotated[
        Path | None,
        typer.Argument(
            metavar="FILE", help="CSV or HDF5 time_s,DISTURBANCE...: changes about the steady state, K or W."
        ),
    ] = None,
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE", help="Write the temperatures of nodes over time (.csv or .h5)."),
    ] = None,
    duration: Annotated[
        float | None, typer.Option("--duration", metavar="SECONDS", help="In place of FILE: length of a realisation.")
    ] = None,
    sample: Annotated[
        float | None,
        typer.Option(
            "--step",
            metavar="SECONDS",
            help="Step of a realisation. Default: a fifth of a period of the highest frequency.",
        ),
    ] = None,
    seed: Annotated[int | None, typer.Option("--seed", metavar="N", help="Seed of a realisation. Default: 1.")] = None,
    top: Top = DEFAULT_TOP,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """The thermal network in time.

    Steps the network of thermal.h5 about its steady state, by disturbances of a table or by a realisation of their
    spectra. The temperatures that it writes are a time series of nodes, which run-series takes to the outputs. Of a
    realisation the spectra of the nodes are compared with those of thermal.h5.
    """
    from tedm_cli.cli.printing.thermal_in_time import in_time_dict, in_time_lines
    from tedm_cli.errors import UsageError
    from tedm_cli.progress import progress
    from tedm_cli.quantities import SEED
    from tedm_cli.stages.thermal.simulate import Realise
    from tedm_cli.stages.thermal.simulate import simulate_thermal as stage

    options = {"--duration": duration, "--step": sample, "--seed": seed}
    stray = [name for name, value in options.items() if value is not None]
    if given is not None and stray:
        raise UsageError(f"{stray[0]} is of a realisation, and {given} gives the disturbances")
    if seed is not None and (fact := SEED.fact(seed)):
        raise UsageError(f"--seed: {fact}")
    realise = None if duration is None else Realise(duration, sample, 1 if seed is None else seed)
    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        done = stage(project, given, realise, output, step)
    answer(as_json, quiet, lambda: in_time_lines(done, rows(top)), lambda: in_time_dict(done, rows(top)))
