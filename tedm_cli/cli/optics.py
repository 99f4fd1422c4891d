"""Commands on the optical metrology. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

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


@app.command("check-layout")
def check_layout(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Judge the optical layout alone.

    Beams within apertures, together on the photodiodes, met from the right side, and nothing in their way: a table of
    margins. The test masses are compared with those of the model's configuration, if that is there; no other file is
    needed. build-optics judges the same.
    """
    import json

    from tedm_cli.cli.printing.layout import layout_dict, layout_lines
    from tedm_cli.stages.optics.layout import inspect_layout, refuse_failures

    done = inspect_layout(open_project(config, build_dir, verbose))
    say(quiet, *([json.dumps(layout_dict(done), indent=2)] if as_json else layout_lines(done)))
    if done.match is not None:
        done.match.require()
    refuse_failures(done.findings, done.path)


@app.command("build-optics")
def build_optics(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Ray trace, optics law and read-out matrices.

    S_BW by the analytic derivative of the ray trace, P, O_ideal, and the read-out per kelvin of every area.
    """
    from tedm_cli.cli.printing.layout import warning_lines
    from tedm_cli.cli.printing.optics import optics_lines
    from tedm_cli.stages.optics.build import build_optics as stage

    done = stage(open_project(config, build_dir, verbose), output)
    say(quiet, *optics_lines(done), *warning_lines(done.warnings), *(f"warning: {note}" for note in done.notes))


@app.command()
def explain(
    read_out: Annotated[
        str | None, typer.Argument(metavar="READOUT", help="TM1_x, TM2_eta, ...; all unless given.")
    ] = None,
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    set_name: Annotated[str | None, typer.Option("--set", help="Set of photodiodes; the first unless given.")] = None,
    area: Annotated[str | None, typer.Option("--area", help="One thermal area instead of all of them.")] = None,
    uniform: Annotated[bool, typer.Option("--uniform", help="All areas together by one kelvin.")] = False,
    distortion: Annotated[bool, typer.Option("--distortion", help="Without the rigid motion of each bench.")] = False,
    most: Annotated[int, typer.Option("-n", "--most", min=1, help="Entries per table.")] = 10,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """What a read-out is made of.

    The largest areas, elements, motions and beams, the bench moving as one against its distortion, and what each
    redundant set adds.
    """
    import json

    from tedm_cli.cli.printing.explain import explain_dict, explain_lines
    from tedm_cli.stages.optics.explain import explain as stage

    project = open_project(config, build_dir, verbose)
    done = stage(project, read_out, set_name, area, uniform=uniform, distortion_only=distortion)
    say(quiet, *([json.dumps(explain_dict(done, most), indent=2)] if as_json else explain_lines(done, most)))
