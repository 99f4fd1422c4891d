"""Command on variants of a design. Stages are imported inside, so that --help is quick."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from tedm_cli.cli.app import answer, app, begin, say
from tedm_cli.cli.headings import examples
from tedm_cli.cli.options import DEFAULT_BUILD, BuildDir, Json, Nastran, Quiet, Verbose, at_least

if TYPE_CHECKING:
    from tedm_cli.stages.trade.variants import OpenTrade

_FOLDER = "trade"  # in the build folder


@app.command(
    epilog=examples(
        "tedm trade variants.toml", "tedm trade variants.toml -j 1", "tedm trade variants.toml --best hexapod --by mass"
    )
)
def trade(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The file with variants and criteria.")],
    build_dir: BuildDir = DEFAULT_BUILD,
    jobs: Annotated[
        int | None,
        typer.Option(
            "-j",
            "--jobs",
            metavar="N",
            callback=at_least(1),
            help="Commands that may run at once, of all variants together. Default: as many as there are processors.",
        ),
    ] = None,
    best: Annotated[
        str | None,
        typer.Option(
            "--best",
            metavar="VARIANT",
            help="Exit with 5 unless this variant is on the Pareto front, or the best --by.",
        ),
    ] = None,
    by: Annotated[
        str | None,
        typer.Option("--by", metavar="CRITERION", help="With --best: the best by this criterion; ties count."),
    ] = None,
    reports: Annotated[
        bool, typer.Option("--reports", help="Run the whole chain of each variant, to its own report and page.")
    ] = False,
    scripts: Annotated[
        bool,
        typer.Option("--scripts", help="Run the programs by which the file says that models of variants are made."),
    ] = False,
    nastran: Nastran = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
) -> None:
    """Compare variants of a design by criteria.

    Runs the chain of each variant as far as the criteria need it and it is not up to date, reads the criteria, and
    writes trade.h5 and a page (trade.html, .pdf, .md) into the folder trade of the build folder: variants by criteria,
    Pareto front, what has changed and why. The build folders of the variants are there, too.
    Killed half way, it goes on from there when it is run again. A variant whose chain fails does not keep the others
    from being compared; the exit code is then that of the first that failed.

    The file may name Python programs that make the models of variants. They are run with --scripts only, where the
    model is not up to date.
    """
    from tedm_cli.cli.printing.trade import trade_dict, trade_lines
    from tedm_cli.errors import PhysicsError, UsageError
    from tedm_cli.progress import progress
    from tedm_cli.stages.common import known_name
    from tedm_cli.stages.trade.collect import collect
    from tedm_cli.stages.trade.page import write_page
    from tedm_cli.stages.trade.variants import open_trade

    begin(verbose, f"reading {file}")
    if by is not None and best is None:
        raise UsageError("--by says by what a variant is to be the best", hint="name it: --best VARIANT")
    opened = open_trade(file, build_dir / _FOLDER)
    criteria = [criterion.name for criterion in opened.config.criteria]
    if best is not None:
        known_name("variant", best, [variant.name for variant in opened.variants])
    place = None if by is None else criteria.index(known_name("criterion", by, criteria))
    say(quiet or as_json, f"{opened.config.title} ({file})")
    way = _Way(jobs, reports, scripts, nastran)
    failures, code = _run(opened, way, quiet, as_json, verbose)
    with progress(quiet) as step:
        found, path = collect(opened, failures, step)
    paths = [path, *write_page(path)]
    answer(as_json, quiet, lambda: trade_lines(found, paths, verbose), lambda: trade_dict(found, paths))
    if code:
        raise typer.Exit(code)
    if best is None:
        return
    if place is not None and best not in (first := found.best_by(place)):
        hint = f"the best is {' and '.join(first)}" if first else "no variant has it"
        raise PhysicsError(f"{best} is not the best by {by!r}", where=str(path), hint=hint)
    if place is None and best not in found.front:
        dominating = ", ".join(found.dominated_by(found.names.index(best)))
        hint = f"it is dominated by {dominating}" if dominating else "it has none of the criteria"
        raise PhysicsError(f"{best} is not on the Pareto front", where=str(path), hint=hint)


@dataclass(frozen=True)
class _Way:
    """What the command line says of how chains are run."""

    jobs: int | None
    reports: bool
    scripts: bool
    nastran: str | None


def _run(opened: OpenTrade, way: _Way, quiet: bool, as_json: bool, verbose: int) -> tuple[dict[str, str], int]:
    """Make the models of the variants and run their chains: by name why a variant failed, and the first exit code."""
    from tedm_cli.chain.graph import Step
    from tedm_cli.cli.printing.chain import noted_lines
    from tedm_cli.cli.printing.trade import failure_text, variant_step_line
    from tedm_cli.cli.streams import tell
    from tedm_cli.cli.worker import PROGRAM
    from tedm_cli.errors import TedmError
    from tedm_cli.progress import progress
    from tedm_cli.stages.chain.perform import Chain, Way, perform
    from tedm_cli.stages.chain.plan import plan_steps
    from tedm_cli.stages.chain.project_files import chain_files
    from tedm_cli.stages.chain.workers import Answer
    from tedm_cli.stages.trade.collect import wanted_steps
    from tedm_cli.stages.trade.variants import make_models

    silent = quiet or as_json
    made = make_models(opened, way.scripts, lambda name, file: say(silent, f"{name}: making the model by {file}"))
    failures: dict[str, str] = {}
    codes: dict[str, int] = {}

    def fail(name: str, why: str, code: int) -> None:
        failures[name], codes[name] = why, code
        tell([f"error: variant {name}: {why}"])

    chains: list[Chain] = []
    names: list[str] = []
    for variant in made.variants:
        if variant.project is None:
            fail(variant.name, variant.failure, variant.exit_code)
            continue
        try:
            wanted = wanted_steps(made, variant, whole=way.reports)
            plan = plan_steps(chain_files(variant.project), wanted)
        except TedmError as exc:
            fail(variant.name, failure_text(exc.placed), exc.exit_code)
            continue
        chains.append(Chain(plan, ("-c", str(variant.project.file.path), "-d", str(variant.build_dir))))
        names.append(variant.name)
        if not plan.stale:
            say(silent, f"{variant.name}: up to date")
    begun, told = [0] * len(chains), set[str]()  # variants share a model: what is to be known of it is told once

    def start(place: int, step: Step) -> None:
        begun[place] += 1
        say(silent, variant_step_line(names[place], begun[place], chains[place].plan, step))

    def end(place: int, step: Step, done: Answer) -> None:
        lines = done.out.splitlines()
        noted = [f"{names[place]}: {line.strip()}" for line in noted_lines(lines) if line not in told]
        told.update(noted_lines(lines))
        say(silent, *(lines if verbose else noted))
        if done.code:
            fail(names[place], failure_text(done.err), done.code)
        else:
            tell(done.err.splitlines())

    at_once = way.jobs if way.jobs is not None else len(os.sched_getaffinity(0))
    with progress(quiet) as of_all:
        perform(chains, Way(PROGRAM, way.nastran, at_once), start, end, of_all)
    return failures, next((codes[variant.name] for variant in made.variants if variant.name in codes), 0)
