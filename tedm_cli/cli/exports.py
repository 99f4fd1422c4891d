"""Commands that write results for other programs. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from tedm_cli.cli import completion
from tedm_cli.cli.app import answer, app, begin, open_project
from tedm_cli.cli.headings import examples
from tedm_cli.cli.options import (
    DEFAULT_BUILD,
    DEFAULT_CONFIG,
    AnyCases,
    BuildDir,
    Case,
    CasesRun,
    Config,
    Format,
    Formats,
    Json,
    Matrices,
    Of,
    Quiet,
    Verbose,
)


@app.command(epilog=examples("tedm export", "tedm export optics --format csv -o matrices"))
def export(
    what: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="MATRICES",
            autocompletion=completion.matrices,
            help="optics, sensitivity, distortion. Default: all that are there.",
        ),
    ] = None,
    fmt: Formats = Format.mat,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Matrices = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write the matrices for other programs.

    With labels and units, as CSV, NPZ (NumPy) or MAT (MATLAB).

    optics: S_BW (beams per motion of an optical element), P (optics law: beams to photodiodes), O_ideal (photodiodes
    per motion of the test masses), D (photodiodes per kelvin of an area), N (read-outs per kelvin).

    sensitivity: S_SG (self-gravity per kelvin) and the stiffness matrices. distortion: D_opt (motion of the optical
    elements per kelvin).
    """
    from tedm_cli.cli.printing.exports import matrix_dict, matrix_lines
    from tedm_cli.stages.exports.matrices import export as stage

    begin(verbose, f"results in {build_dir}")
    done = stage(build_dir, what or [], fmt.value, output)
    answer(as_json, quiet, lambda: matrix_lines(done), lambda: matrix_dict(done))


@app.command("export-case", epilog=examples("tedm export-case 3 --format csv"))
def export_case(
    case: CasesRun = None,
    fmt: Formats = Format.mat,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Matrices = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write the results of cases for other programs.

    Spectra, bounds, requirements, correlation, contributions and verdicts, with labels and units.
    """
    from tedm_cli.stages.exports.case import export_cases

    begin(verbose, f"results in {build_dir}")
    paths = export_cases(build_dir, case or [], fmt.value, output)
    answer(as_json, quiet, lambda: [str(path) for path in paths], lambda: {"files": paths})


@app.command(
    "export-state-space", epilog=examples("tedm export-state-space 3 --rate-hz 1", "tedm export-state-space --loop")
)
def export_state_space(
    case: AnyCases = None,
    loop: Annotated[bool, typer.Option("--loop", help="The drag-free loop, from named inputs to outputs.")] = False,
    tolerance: Annotated[
        float,
        typer.Option("--tolerance", metavar="RATIO", help="Largest relative deviation of the spectra's amplitudes."),
    ] = 0.01,
    rate_hz: Annotated[
        float | None, typer.Option("--rate-hz", metavar="HZ", help="Also the sampled form at this rate.")
    ] = None,
    temperatures: Annotated[
        bool, typer.Option("--temperatures", help="Also the temperatures of the areas, C_T and D_T.")
    ] = False,
    fmt: Formats = Format.mat,
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Matrices = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write noise of cases, or the loop, as A, B, C, D.

    Linear systems driven by white noise, with the filters that shape it and the static gain, for end-to-end simulators.
    """
    from tedm_cli.cli.printing.exports import loop_dict, loop_lines, system_dict, system_lines
    from tedm_cli.errors import UsageError
    from tedm_cli.stages.exports.closed_loop import export_closed_loop
    from tedm_cli.stages.exports.state_space import Wanted
    from tedm_cli.stages.exports.state_space import export_state_space as stage

    if not case and not loop:
        raise UsageError("name a case, or all, or --loop", hint="tedm export-state-space 3")
    begin(verbose, f"results in {build_dir}")
    whole = export_closed_loop(build_dir, fmt.value, output, 1 + len(case or [])) if loop else None
    done = []
    if case:
        project = open_project(config, build_dir, verbose)
        done = list(stage(project, case, fmt.value, output, Wanted(tolerance, rate_hz, temperatures)))
    answer(
        as_json,
        quiet,
        lambda: [*(loop_lines(whole) if whole else []), *(line for one in done for line in system_lines(one))],
        lambda: {"loop": loop_dict(whole) if whole else None, "cases": [system_dict(one) for one in done]},
    )


@app.command("export-extremal", epilog=examples("tedm export-extremal 3 --of A_TM1_x"))
def export_extremal(
    case: Case,
    of: Of = None,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FOLDER", help="Default: export/caseNN_extremal, in the build folder."),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write the correlations at the bounds of a case.

    A CSV matrix for each bound and output, and cases.toml with cases that name them: append it to your own cases file,
    run them, and their noise is at the bounds. Of a case of the thermal network the matrices are of its nodes, with the
    spectra that the network gives them; no case takes these.
    """
    from tedm_cli.cli.printing.extremal import extremal_dict, extremal_lines
    from tedm_cli.stages.exports.extremal import export_extremal as stage

    begin(verbose, f"results in {build_dir}")
    done = stage(build_dir, case, of or [], output)
    answer(as_json, quiet, lambda: extremal_lines(done), lambda: extremal_dict(done))


@app.command("export-vtu", epilog=examples("tedm export-vtu", "tedm export-vtu --area STRUT_1 --of TM1_a_x --case 3"))
def export_vtu(
    area: Annotated[
        list[str] | None,
        typer.Option(
            "--area",
            metavar="AREA",
            autocompletion=completion.areas,
            help="Displacements per kelvin of this area, or uniform; may be repeated.",
        ),
    ] = None,
    of: Annotated[
        list[str] | None,
        typer.Option(
            "--of",
            metavar="OUTPUT",
            autocompletion=completion.outputs,
            help="What each grid has in TM1_a_x, A_TM1_x, ...; may be repeated.",
        ),
    ] = None,
    case: Annotated[
        list[str] | None,
        typer.Option(
            "--case",
            metavar="CASE",
            autocompletion=completion.cases,
            help="Shares in the noise of a case that was run; may be repeated.",
        ),
    ] = None,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="FILE", help="The .vtu file. Default: export/mesh.vtu, in the build folder."
        ),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Write the finite-element mesh for ParaView.

    Elements, areas, masses, compensation masses; displacements per kelvin; the gradient of an output, and what each
    grid contributes to it under an area or has in its noise; after build-adjoint, what a kelvin of each grid and
    element does to it. Without options: what the worst verdict is about.
    """
    from tedm_cli.cli.printing.mesh import mesh_dict, mesh_lines
    from tedm_cli.progress import progress
    from tedm_cli.stages.exports.mesh import WantedArrays, export_mesh

    begin(verbose, f"results in {build_dir}")
    with progress(quiet) as step:
        done = export_mesh(build_dir, output, WantedArrays(tuple(area or ()), tuple(of or ()), tuple(case or ())), step)
    answer(as_json, quiet, lambda: mesh_lines(done), lambda: mesh_dict(done))
