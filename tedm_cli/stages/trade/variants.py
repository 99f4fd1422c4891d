"""The variants of a trade as projects: with their own folder, their changed configuration, and their model made."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.config.nearest import project_in
from tedm_cli.config.overlay import overlay
from tedm_cli.config.project import Project, load_project
from tedm_cli.config.trade import ScriptTable, TradeConfig, VariantTable, load_trade
from tedm_cli.errors import ConfigError, InputError, TedmError
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.files.seal import sha256_of
from tedm_cli.files.store import replacing
from tedm_cli.stages.model_script import run_script
from tedm_cli.stages.trade.known_names import require_known

VARIANTS, CONFIGS = "variants", "configs"  # folders
_STAMP = "script.json"  # says by what the model of a variant was made


@dataclass(frozen=True)
class Variant:
    """A variant with its build folder; `project` is None where it has none, and then `failure` says why.

    `exit_code` is that of the failure.
    """

    table: VariantTable
    build_dir: Path
    project: Project | None
    failure: str = ""
    exit_code: int = 0

    @property
    def name(self) -> str:
        return self.table.name


@dataclass(frozen=True)
class OpenTrade:
    """The file of a trade as it was read, and its variants."""

    file: ConfigFile
    config: TradeConfig
    folder: Path
    variants: tuple[Variant, ...]


def open_trade(path: Path, folder: Path) -> OpenTrade:
    """Read the file of a trade, and write the configuration of its variants into the trade's `folder`.

    A variant whose project cannot be read says so; the others are there all the same.

    Raises
    ------
    InputError : there is no such file, or the folder cannot be written.
    ConfigError : what is wrong in it: also a project that is not there, a key that a project cannot have, and names of
        cases, outputs and requirements that no variant has.
    """
    file, config = load_trade(path)
    problems: list[tuple[str, str]] = []
    variants = []
    for number, table in enumerate(config.variants):
        build = folder / VARIANTS / table.name
        try:
            variants.append(Variant(table, build, _project(table, path.parent, build)))
        except _TradeProblemError as exc:
            problems += [(f"variant[{number}].{key}", fact) for key, fact in exc.problems]
        except TedmError as exc:
            variants.append(Variant(table, build, None, exc.placed.replace("\n", "; "), exc.exit_code))
    if problems:
        raise ConfigError(problems, where=str(path))
    require_known(path, config, [variant.project for variant in variants if variant.project is not None])
    return OpenTrade(file, config, folder, tuple(variants))


class _TradeProblemError(Exception):
    """What is wrong with a variant in the file of the trade."""

    def __init__(self, problems: list[tuple[str, str]]) -> None:
        super().__init__(problems)
        self.problems = problems


def _project(table: VariantTable, beside: Path, build: Path) -> Project:
    """The project of a variant; a changed one has files of its own in the build folder."""
    named = beside / table.project
    inside = project_in(named) if named.is_dir() else None
    found = named if inside is None else inside.file
    if not found.is_file():
        raise _TradeProblemError([("project", f"names {table.project!r}, but there is no project file {found}")])
    base = load_project(found, build)
    if not table.set:
        return base
    own = build / CONFIGS
    try:
        texts = overlay(base, table.set, own).texts
    except ConfigError as exc:
        if exc.where:
            raise
        raise _TradeProblemError([(f'set."{key}"', fact) for key, fact in exc.problems]) from None
    for name, text in texts.items():
        write_changed(own / name, text)
    return load_project(own / "tedm.toml", build)


def write_changed(path: Path, text: str) -> None:
    """Write a text, unless the file holds it: what is made from it is not older than it then."""
    if not _holds(path, text):
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="\n")


def _holds(path: Path, text: str) -> bool:
    return path.is_file() and path.read_bytes() == text.encode()


def make_models(trade: OpenTrade, allowed: bool, begun: Callable[[str, str], None]) -> OpenTrade:
    """Run the programs of variants whose models are not up to date, where that is `allowed`.

    A program that fails, or that would have to run and must not, is the failure of its variant. `begun` is told the
    variant and the program.
    """
    beside = trade.file.path.parent
    made = []
    for variant in trade.variants:
        script = variant.table.script
        if script is None or variant.project is None:
            made.append(variant)
            continue
        arguments = [a.replace("{build_dir}", str(variant.build_dir.resolve())) for a in script.arguments]
        outputs = [Path(a) for a, said in zip(arguments, script.arguments, strict=True) if "{build_dir}" in said]
        stamp, wanted = variant.build_dir / _STAMP, _fingerprint(script, arguments, beside)
        failure = ""
        is_made = _holds(stamp, wanted) and all(path.exists() for path in outputs)
        if not is_made and not allowed:
            failure = "nothing that a file names is run unless --scripts allows it"
        elif not is_made:
            begun(variant.name, script.file)
            stamp.unlink(missing_ok=True)
            variant.build_dir.mkdir(parents=True, exist_ok=True)
            failure = run_script((beside / script.file).resolve(), arguments, beside)
            if not failure:
                write_changed(stamp, wanted)
        what = f"{script.file} cannot make the model: {failure}" if failure else ""
        code = InputError.exit_code if what else 0
        made.append(Variant(variant.table, variant.build_dir, None if what else variant.project, what, code))
    return OpenTrade(trade.file, trade.config, trade.folder, tuple(made))


def _fingerprint(script: ScriptTable, arguments: Sequence[str], beside: Path) -> str:
    """What a model is made by: the arguments, and sums of the program, those beside it, and files that are named."""
    program = beside / script.file
    named = [beside / argument for argument in script.arguments if "{build_dir}" not in argument]
    files = dict.fromkeys([program, *sorted(program.parent.glob("*.py")), *named])
    sums = {os.path.relpath(file, beside): sha256_of(file) for file in files if file.is_file()}
    return json.dumps([arguments, sums], indent=1) + "\n"
