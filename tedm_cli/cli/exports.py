"""Commands that write results for other programs. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from tedm_cli.cli.app import DEFAULT_BUILD, DEFAULT_CONFIG, BuildDir, Config, Quiet, app, open_project, say


class _Format(Enum):
    csv = "csv"
    npz = "npz"
    mat = "mat"


_FormatOption = Annotated[_Format, typer.Option("--format", help="csv: a file per matrix; npz, mat: all in one.")]
_Folder = Annotated[
    Path | None, typer.Option("-o", "--output", help="Folder, or a .npz or .mat file. Default: BUILD_DIR/export.")
]


@app.command()
def export(
    what: Annotated[
        list[str] | None, typer.Argument(help="optics, sensitivity, distortion; all that are there, if none is named.")
    ] = None,
    fmt: _FormatOption = _Format.mat,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: _Folder = None,
    quiet: Quiet = False,
) -> None:
    """Write the matrices for other programs.

    S_BW, P, O_ideal, D, N; S_SG, stiffness; D_opt: with labels and units, as CSV, NPZ (NumPy) or MAT (MATLAB).
    """
    from tedm_cli.stages.exports.matrices import export as stage

    done = stage(build_dir, what or [], fmt.value, output)
    held = [f"{m.name} {m.values.shape[0]} x {m.values.shape[1]}: {m.description}" for m in done.matrices]
    say(quiet, *(str(path) for path in done.paths), *held)


@app.command("export-case")
def export_case(
    case: Annotated[
        list[str] | None, typer.Argument(metavar="[CASE]...", help="All that were run, if none is named.")
    ] = None,
    fmt: _FormatOption = _Format.mat,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: _Folder = None,
    quiet: Quiet = False,
) -> None:
    """Write the results of cases for other programs.

    Spectra, bounds, requirements, correlation, contributions and verdicts, with labels and units.
    """
    from tedm_cli.stages.exports.case import export_cases

    say(quiet, *(str(path) for path in export_cases(build_dir, case or [], fmt.value, output)))


@app.command("export-state-space")
def export_state_space(
    case: Annotated[list[str] | None, typer.Argument(metavar="[CASE]...", help="Cases, or all.")] = None,
    loop: Annotated[bool, typer.Option("--loop", help="The drag-free loop, from named inputs to outputs.")] = False,
    tolerance: Annotated[
        float, typer.Option("--tolerance", help="Largest relative deviation of the spectra's amplitudes.")
    ] = 0.01,
    rate_hz: Annotated[float | None, typer.Option("--rate-hz", help="Also the sampled form at this rate.")] = None,
    temperatures: Annotated[
        bool, typer.Option("--temperatures", help="Also the temperatures of the areas, C_T and D_T.")
    ] = False,
    fmt: _FormatOption = _Format.mat,
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: _Folder = None,
    quiet: Quiet = False,
) -> None:
    """Write the noise of cases, or the drag-free loop, as A, B, C, D.

    Linear systems driven by white noise, with the filters that shape it and the static gain, for end-to-end simulators.
    """
    from tedm_cli.errors import UsageError
    from tedm_cli.results.wording import count
    from tedm_cli.stages.exports.state_space import Wanted
    from tedm_cli.stages.exports.state_space import export_state_space as stage

    if not case and not loop:
        raise UsageError("name a case, or all, or --loop", hint="tedm export-state-space 3")
    if loop:
        from tedm_cli.stages.exports.closed_loop import export_closed_loop

        whole = export_closed_loop(build_dir, fmt.value, output, 1 + len(case or []))
        size = f"{whole.states} states, {whole.inputs} inputs, {whole.outputs} outputs"
        say(quiet, *(str(path) for path in whole.paths), f"drag-free loop: {size}")
    if not case:
        return
    project = open_project(config, build_dir, 0)
    for done in stage(project, case, fmt.value, output, Wanted(tolerance, rate_hz, temperatures)):
        say(
            quiet,
            *(str(path) for path in done.paths),
            f"case {done.case_id}: {count(done.states, 'state')}, {count(done.inputs, 'white noise')} of one-sided PSD"
            f" 1/Hz; amplitudes within {done.filter_deviation:.2g} of the configured ones, outputs within"
            f" {done.output_deviation:.2g} of"
            f" {done.compared_with}",
        )


@app.command("export-extremal")
def export_extremal(
    case: Annotated[str, typer.Argument(metavar="CASE", help="A case that was run.")],
    of: Annotated[
        list[str] | None,
        typer.Option("--of", metavar="OUTPUT", help="TM1_a_x, A_TM1_x, ...; repeatable. Default: what is judged."),
    ] = None,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Folder. Default: BUILD_DIR/export/caseNN_extremal.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write the correlations at the bounds of a case.

    A CSV matrix for each bound and output, and cases.toml with cases that name them: append it to your own cases file,
    run them, and their noise is at the bounds.
    """
    from tedm_cli.cli.printing.extremal import extremal_lines
    from tedm_cli.stages.exports.extremal import export_extremal as stage

    say(quiet, *extremal_lines(stage(build_dir, case, of or [], output)))


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

    Elements, areas, masses, compensation masses; displacements per kelvin; the gradient of an output, and what each
    grid contributes to it under an area or has in its noise. Without options: what the worst verdict is about.
    """
    from tedm_cli.cli.printing.mesh import mesh_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.exports.mesh import WantedArrays, export_mesh

    with progress(quiet) as step:
        done = export_mesh(build_dir, output, WantedArrays(tuple(area or ()), tuple(of or ()), tuple(case or ())), step)
    say(quiet, *mesh_lines(done))
