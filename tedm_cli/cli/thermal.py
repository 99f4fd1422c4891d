"""Commands on the thermal model. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from tedm_cli.cli.app import answer, app, open_project
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
    of each does to the outputs.
    """
    from tedm_cli.cli.printing.thermal import thermal_dict, thermal_lines
    from tedm_cli.stages.thermal.build import build_thermal as stage

    done = stage(open_project(config, build_dir, verbose), output)
    answer(as_json, quiet, lambda: thermal_lines(done), lambda: thermal_dict(done))
