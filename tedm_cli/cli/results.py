"""Commands on what has been computed: figures, report, files. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

import json
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from tedm_cli.cli.app import (
    DEFAULT_BUILD,
    DEFAULT_CONFIG,
    BuildDir,
    Config,
    Json,
    Output,
    Quiet,
    Verbose,
    app,
    open_project,
    say,
)


class _Format(Enum):
    csv = "csv"
    npz = "npz"
    mat = "mat"


@app.command()
def plot(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder of the figures.")] = None,
    area: Annotated[
        list[str] | None,
        typer.Option("--area", metavar="NAME", help="Only the bench under 1 K of this thermal area; may be repeated."),
    ] = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Draw the figures of all cases run, of the optics, and of the bench under its worst areas."""
    from tedm_cli.progress import progress
    from tedm_cli.stages.plot import plot as stage

    project = open_project(config, build_dir, verbose)
    with progress(quiet) as step:
        paths = stage(project, output, step, area or ())
    say(quiet, f"{paths[0].parent}: {len(paths)} figure{'s' if len(paths) > 1 else ''}")


@app.command()
def report(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write the self-contained report.html."""
    from tedm_cli.stages.report import report as stage

    path = stage(open_project(config, build_dir, verbose), output)
    say(quiet, f"{path}: {path.stat().st_size / 1e6:.1f} MB")


@app.command()
def show(
    file: Annotated[Path, typer.Argument(help="An HDF5 file of tedm.")],
    as_json: Json = False,
) -> None:
    """Show what a file holds.

    Datasets with their units, what it was made from, and its main numbers.
    """
    from tedm_cli.stages.show import show_dict, show_lines

    if as_json:
        print(json.dumps(show_dict(file), indent=1))
    else:
        print("\n".join(show_lines(file)))


@app.command()
def check(
    build_dir: BuildDir = DEFAULT_BUILD,
    as_json: Json = False,
) -> None:
    """Check that all files are up to date.

    Every HDF5 file of the build folder: its contract, its version, and whether its inputs are still the same.
    """
    from tedm_cli.errors import InputError
    from tedm_cli.stages.check import check_folder

    results = check_folder(build_dir)
    if as_json:
        print(json.dumps([r.as_dict() for r in results], indent=1))
    else:
        for r in results:
            print("\n".join(r.lines()))
    bad = [r.path.name for r in results if r.problems]
    if bad:
        raise InputError(
            f"{len(bad)} of {len(results)} files are not up to date: {', '.join(bad)}",
            where=str(build_dir),
            hint="run make all",
        )


@app.command()
def export(
    what: Annotated[
        list[str] | None, typer.Argument(help="optics, sensitivity, distortion; all that are there, if none is named.")
    ] = None,
    fmt: Annotated[
        _Format, typer.Option("--format", help="csv: a file per matrix; npz, mat: all in one.")
    ] = _Format.mat,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder, or a .npz or .mat file. Default: BUILD_DIR/export.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write the matrices for other programs.

    S_BW, P, O_ideal, D, N; S_SG, stiffness; D_opt: with labels and units, as CSV, NPZ (NumPy) or MAT (MATLAB).
    """
    from tedm_cli.stages.export import export as stage

    done = stage(build_dir, what or [], fmt.value, output)
    held = [f"{m.name} {m.values.shape[0]} x {m.values.shape[1]}: {m.description}" for m in done.matrices]
    say(quiet, *(str(path) for path in done.paths), *held)


@app.command("export-vtu")
def export_vtu(
    area: Annotated[
        list[str] | None,
        typer.Option("--area", metavar="NAME", help="Displacements per kelvin of this area, or uniform; repeatable."),
    ] = None,
    of: Annotated[
        list[str] | None,
        typer.Option("--of", metavar="OUTPUT", help="What each grid has in TM1_a_x, A_TM1_x, ...; repeatable."),
    ] = None,
    case: Annotated[
        list[str] | None,
        typer.Option("--case", metavar="CASE", help="Shares in the noise of a case that was run; repeatable."),
    ] = None,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="The .vtu file. Default: BUILD_DIR/export/mesh.vtu.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write the finite-element mesh for ParaView.

    Elements, areas, masses; displacements per kelvin; the gradient of an output, and what each grid contributes to it
    under an area or has in its noise. Without options: what the worst verdict is about.
    """
    from tedm_cli.cli.say.mesh import mesh_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.export_mesh import Asked, export_mesh

    with progress(quiet) as step:
        done = export_mesh(build_dir, output, Asked(tuple(area or ()), tuple(of or ()), tuple(case or ())), step)
    say(quiet, *mesh_lines(done))


@app.command("make-rules", hidden=True)
def make_rules(config: Config = DEFAULT_CONFIG, build_dir: BuildDir = DEFAULT_BUILD, output: Output = None) -> None:
    """Write the Make variables of a project: its inputs and its cases."""
    from tedm_cli.stages.make_rules import make_rules as stage

    stage(open_project(config, build_dir, 0), output)
