"""Commands on the optical metrology. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from tedm_cli.cli.app import answer, app, open_project
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
    margins. The test masses are compared with those of the model's configuration, and the elements with the grids of
    the model, if that is there. No other file is needed. What does not fit the model is refused before it is solved,
    and all else by build-optics.
    """
    from tedm_cli.cli.printing.layout import layout_dict, layout_lines
    from tedm_cli.stages.optics.layout import inspect_layout, refuse_failures

    done = inspect_layout(open_project(config, build_dir, verbose))
    answer(as_json, quiet, lambda: layout_lines(done), lambda: layout_dict(done))
    if done.match is not None:
        done.match.require()
    refuse_failures(done.findings, done.path)


@app.command("build-optics")
def build_optics(
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    output: Output = None,
    top: Top = DEFAULT_TOP,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Ray trace, optics law and read-out matrices.

    S_BW, what each motion of an optical element does to the beams, is the analytic derivative of the ray trace. P, the
    optics law, makes path differences and tilts of the beams. O_ideal is what the photodiodes read of motions of the
    test masses, D what they read per kelvin of every thermal area. N says which motion of the test masses would read
    the same: what is read per kelvin.
    """
    from tedm_cli.cli.printing.optics import optics_dict, optics_lines
    from tedm_cli.stages.optics.build import build_optics as stage

    done = stage(open_project(config, build_dir, verbose), output)
    answer(as_json, quiet, lambda: optics_lines(done, rows(top)), lambda: optics_dict(done))
