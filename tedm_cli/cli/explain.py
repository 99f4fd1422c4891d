"""The command on what a name stands for. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

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
    Quiet,
    Top,
    Verbose,
    rows,
)


@app.command(
    epilog=examples(
        "tedm explain",
        "tedm explain A_TM1_x",
        "tedm explain A_TM1_x --area STRUT_1",
        "tedm explain TM1_a_x --grids",
        "tedm explain STRUT_1",
    )
)
def explain(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME",
            autocompletion=completion.names,
            help="TM1_a_x, A_TM1_x, TM1_x, a requirement, an area, ... Default: all outputs.",
        ),
    ] = None,
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    set_name: Annotated[
        str | None,
        typer.Option(
            "--set",
            metavar="SET",
            autocompletion=completion.sets,
            help="Of a read-out: set of photodiodes. Default: the first.",
        ),
    ] = None,
    area: Annotated[
        str | None,
        typer.Option(
            "--area",
            metavar="AREA",
            autocompletion=completion.areas,
            help="Of a read-out: one thermal area instead of all of them.",
        ),
    ] = None,
    uniform: Annotated[
        bool, typer.Option("--uniform", help="Of a read-out: all areas together by one kelvin.")
    ] = False,
    distortion: Annotated[
        bool, typer.Option("--distortion", help="Of a read-out: without the rigid motion of each bench.")
    ] = False,
    grids: Annotated[
        bool, typer.Option("--grids", help="Of an output: the places and grids of the model that it feels most.")
    ] = False,
    top: Top = DEFAULT_TOP,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """What a name stands for, and what it is made of.

    Takes every name that report and prints use. Outputs of the self-gravity (TM1_a_x, TM2_omegadot_y), read-outs
    (A_TM1_x of set A, or TM1_x) and differences (TM2_a_x-TM1_a_x): the areas, groups, elements and beams that they come
    from, and the field at rest. Requirements: what they judge. Areas, groups, test masses, compensation masses, optical
    elements and effects of your own: what they do to every output. Outputs and noise of the drag-free loop, subsystems,
    cases. With --grids (after build-adjoint): where on the model an output feels temperatures, whatever the areas.
    """
    from tedm_cli.cli.printing.explain import explain_dict, explain_lines
    from tedm_cli.cli.printing.explained import told_dict, told_lines
    from tedm_cli.results.explained import Told
    from tedm_cli.stages.explain.name import Load, explain_name, explain_places

    project, load = open_project(config, build_dir, verbose), Load(set_name, area, uniform, distortion)
    done = [explain_places(project, name, load)] if grids else explain_name(project, name, load)
    most = rows(top)

    def lines() -> list[str]:
        parts = [told_lines(one, most) if isinstance(one, Told) else explain_lines(one, most) for one in done]
        return [line for i, part in enumerate(parts) for line in ([""] * (i > 0) + part)]

    def as_dict() -> object:
        found = [told_dict(one, most) if isinstance(one, Told) else explain_dict(one, most) for one in done]
        return found[0] if name is not None else found

    answer(as_json, quiet, lines, as_dict)
