"""Commands on a project as a whole: begin one, run its chain. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from tedm_cli.cli import completion
from tedm_cli.cli.app import answer, app, begin, open_project, say
from tedm_cli.cli.headings import examples
from tedm_cli.cli.options import (
    DEFAULT_BUILD,
    DEFAULT_CONFIG,
    BuildDir,
    Config,
    Json,
    Nastran,
    Quiet,
    Verbose,
    at_least,
    was_given,
)


class _Sample(Enum):
    minimal = "minimal"
    ltp = "ltp"
    spacecraft = "spacecraft"
    lisa = "lisa"


@app.command(epilog=examples("tedm init demo", "tedm init mission --from lisa"))
def init(
    folder: Annotated[
        Path, typer.Argument(metavar="FOLDER", help="A new or empty folder. Default: this one.", show_default=False)
    ] = Path(),
    sample: Annotated[
        _Sample,
        typer.Option(
            "--from",
            help="minimal: a coarse model with its results, whose chain takes half a minute; ltp: a synthetic LISA"
            " Technology Package of 9,000 nodes; spacecraft: the same within a spacecraft; lisa: two benches at 60"
            " degrees.",
        ),
    ] = _Sample.minimal,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Begin a project: configuration files and a model.

    All that `tedm run` needs is in the folder, to be changed or replaced by your own. Nothing is overwritten; names
    that begin with a dot are left alone.
    """
    from tedm_cli.cli.printing.chain import begun_dict, begun_lines
    from tedm_cli.progress import waiting
    from tedm_cli.stages.chain.init import begin_project

    begin(verbose, f"a project from the sample {sample.value}, in {folder.resolve()}")
    with waiting(quiet, f"{sample.value}: writing"):
        names = begin_project(sample.value, folder)
    answer(
        as_json,
        quiet,
        lambda: begun_lines(folder, names, sample.value),
        lambda: begun_dict(folder, sample.value, names),
    )


@app.command(epilog=examples("tedm run", "tedm run build-optics", "tedm run -n", "tedm run -j 2"))
def run(
    ctx: typer.Context,
    stage: Annotated[
        str | None,
        typer.Argument(
            metavar="STAGE",
            autocompletion=completion.stages,
            help="Stop after this stage (build-optics, run-case, ...). Default: the whole chain.",
        ),
    ] = None,
    config: Config = DEFAULT_CONFIG,
    build_dir: BuildDir = DEFAULT_BUILD,
    jobs: Annotated[
        int,
        typer.Option("-j", "--jobs", metavar="N", callback=at_least(1), help="Commands that may run at once."),
    ] = 1,
    dry_run: Annotated[
        bool, typer.Option("-n", "--dry-run", help="Say what would be run and why, and run nothing.")
    ] = False,
    nastran: Nastran = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Run what is not up to date.

    Runs every stage whose files are missing, older than what they are made of, or made of other contents or by another
    version. Killed or refused half way, it goes on from there when it is run again. Of what the stages print, warnings
    and notes are shown; with -v all of it.

    \b
    The stages, in order: write-deck, solve, ingest, build-distortion,
    build-sensitivity, build-optics, build-adjoint, build-thermal, run-case,
    run-series, build-dynamics, simulate, plot, report, view, build-loads.

    A project has the stages of what it describes: without optics the chain has no build-optics, without a thermal model
    no build-thermal, and where model.toml names a solved deck no solve.
    build-loads runs only where it is named.
    """
    from tedm_cli.chain.graph import Step
    from tedm_cli.cli.printing.chain import ended_line, noted_lines, plan_dict, plan_lines, step_line, up_to_date_line
    from tedm_cli.cli.streams import tell
    from tedm_cli.cli.worker import PROGRAM
    from tedm_cli.progress import progress
    from tedm_cli.stages.chain.perform import Chain, Way, perform
    from tedm_cli.stages.chain.plan import plan_chain
    from tedm_cli.stages.chain.workers import Answer

    project = open_project(config, build_dir, verbose)
    plan = plan_chain(project, stage)
    silent = quiet or as_json
    codes: dict[Step, int] = {}
    say(silent, f"{project.title} ({config})")
    if not plan.stale or dry_run:
        lines = plan_lines(plan) if plan.stale else [up_to_date_line(plan, build_dir)]
        answer(as_json, quiet, lambda: lines, lambda: plan_dict(project.title, plan, build_dir, codes))
        return
    given = {"config": ("-c", str(config)), "build_dir": ("-d", str(build_dir))}
    options = tuple(word for name, words in given.items() if was_given(ctx, name) for word in words)
    at_once = min(jobs, len(plan.stale))
    way = Way(PROGRAM, nastran, at_once, alone=at_once == 1)
    begun: list[Step] = []

    def start(_: int, step: Step) -> None:
        begun.append(step)
        say(silent, step_line(len(begun), plan, step))

    def end(_: int, step: Step, done: Answer) -> None:
        codes[step] = done.code
        lines = done.out.splitlines()
        say(silent, *(lines if verbose else noted_lines(lines)))
        tell(done.err.splitlines())

    with progress(quiet or jobs == 1) as of_all:
        (refused,) = perform([Chain(plan, options)], way, start, end, of_all)
    ended = [] if refused is not None else [ended_line(plan, build_dir)]
    answer(as_json, quiet, lambda: ended, lambda: plan_dict(project.title, plan, build_dir, codes))
    if refused is not None:
        raise typer.Exit(refused.code)
