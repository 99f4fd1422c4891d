"""Commands on the optical metrology. Stages are imported inside, so that --help is quick."""

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
    from tedm_cli.say import optics_lines
    from tedm_cli.stages.optics import build_optics as stage

    done = stage(open_project(config, build_dir, verbose), output)
    say(quiet, *optics_lines(done))
