"""make-rules: what Make has to know of a project, so that it rebuilds what depends on a change and nothing else.

Make splits names at blanks, expands `$`, and reads `#`, `%`, `:` and others as its own signs, some of them twice on
their way from a variable to a rule; there is no way to write them all. So names with such signs are refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from tedm_cli.areas.configured import area_csv
from tedm_cli.config.cases import load_cases
from tedm_cli.config.compensation import compensation_file, compensation_masses
from tedm_cli.config.differences import require_parallel
from tedm_cli.config.dynamics import load_dynamics
from tedm_cli.config.halves import halves_of
from tedm_cli.config.model import load_model
from tedm_cli.config.optics import load_optics
from tedm_cli.config.project import Project
from tedm_cli.config.symmetry_plane import project_plane
from tedm_cli.config.temperature_tables import table_paths
from tedm_cli.errors import ConfigError
from tedm_cli.files.build_folder import (
    OPTICS_FILE,
    SENSITIVITY_FILE,
    case_file_name,
    series_file_name,
    simulated_series_file_name,
    simulation_file_name,
)
from tedm_cli.files.store import replacing
from tedm_cli.results.no_loop import why_no_loop
from tedm_cli.stages.temperature_series import series_files

_PLAIN = re.compile(r"[\w./+,@^-]*")  # letters and digits of any script
HALVES, SYMMETRY_PLANE, TIES = "halves", "symmetry_plane", "ties"
_RENAME = "letters, digits and _ - . / + , @ ^ are fine; the commands by themselves, without make, take any name"


class _Variables:
    """Variables of Make, and what cannot be said to it."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.problems: list[tuple[str, str]] = []

    def files(self, name: str, key: str, paths: Iterable[Path | None]) -> None:
        """A variable of file names; `key`: where the configuration names them."""
        words = [str(path) for path in paths if path is not None]
        for word in words:
            odd = _PLAIN.sub("", word)
            if odd or word.startswith("-"):
                what = "a blank" if odd[:1] == " " else repr(odd[0]) if odd else "'-' at its beginning"
                self.problems.append((key, f"the file name {word!r} has {what}, which Make cannot take"))
        self.lines.append(f"{name} := {' '.join(words)}".rstrip(" "))

    def word(self, name: str, value: str) -> None:
        """A variable with an identifier, numbers or nothing."""
        self.lines.append(f"{name} := {value}".rstrip(" "))


def make_rules(project: Project, output: Path | None) -> Path:
    """Write the variables of one project; `SOLVED_BY_TEDM` is empty where the user's own results are named.

    Beside them files say which halves of the chain the project has, which symmetry plane, and what compensation masses
    are tied to. Each is written only where it has changed.

    Raises
    ------
    ConfigError : a name that Make cannot take, all of them at once; a project with neither half of the chain, or with
        requirements on the half that it has not, or on a difference of test masses that has no meaning.
    """
    _, model = load_model(project.model)
    _, cases = load_cases(project.cases)
    halves = halves_of(project, model)
    halves.require_judgeable(cases.applied_requirements(), where=project.cases)
    require_parallel(project, cases.applied_requirements(), model)
    own = all("{build_dir}" in p for p in (model.model.deck, *model.model.op2))
    bdf = None if model.model.bdf is None else project.resolve(model.model.bdf)
    listed = area_csv(project, model)
    case_files = [project.build_dir / case_file_name(c) for c in cases.ids]
    make = _Variables()
    make.files("MODEL_TOML", "model", [project.model])
    make.files("OPTICS_TOML", "optics", [project.optics])
    make.files("CASES_TOML", "cases", [project.cases])
    make.files("MODEL_SOURCES", "model.bdf", [bdf, listed] if own else [])
    make.files("AREAS_CSV", "model.areas_csv", [listed])
    make.files("UNIT_DECK", "model.deck", [project.resolve(model.model.deck)])
    make.files("OP2", "model.op2", [project.resolve(p) for p in model.model.op2])
    make.word("SOLVED_BY_TEDM", "yes" if own else "")
    bodies = map(project.resolve, model.body_files())
    make.files("GRAVITY_SOURCES", "gravity.compensation_masses, stl", [compensation_file(project, model), *bodies])
    make.files("OPTICS_SOURCES", "imported", [] if project.optics is None else load_optics(project.optics).matrices)
    matrices = [SENSITIVITY_FILE] * halves.gravity + [OPTICS_FILE] * halves.read_out
    make.files("MATRICES", "the build folder", [project.build_dir / name for name in matrices])
    make.files("CASE_SOURCES", "requirement, case", [*cases.tables, *cases.matrices])
    make.files("SPECTRA", "temperature", table_paths(project, cases))
    dynamics = load_dynamics(project.dynamics)[1]
    beside = Path() if project.dynamics is None else project.dynamics.parent
    make.files("DYNAMICS_TOML", "dynamics", [project.dynamics])
    make.files("DYNAMICS_SOURCES", "dynamics", [beside / name for name in dynamics.file_names()])
    closed = not why_no_loop(project, model)
    simulations = [project.build_dir / simulation_file_name(c) for c in cases.ids] if closed else []
    make.files("SIMULATION_FILES", "the build folder", simulations)
    series = [project.build_dir / series_file_name(t.name) for t in cases.series]
    looped = [project.build_dir / simulated_series_file_name(t.name) for t in cases.series] if closed else []
    make.files("SERIES_FILES", "the build folder", series)
    make.files("SIMULATED_SERIES_FILES", "the build folder", looped)
    for table, path in [*zip(cases.series, series, strict=True), *zip(cases.series, looped, strict=False)]:
        make.word(f"SERIES_{path.name}", table.name)
        make.files(f"TABLE_{path.name}", f"series {table.name}", series_files(project, table))
    make.word("CASE_IDS", " ".join(cases.ids))
    make.files("CASE_FILES", "the build folder", case_files)
    for case_id, path in zip(cases.ids, case_files, strict=True):
        make.word(f"CASE_ID_{path.name}", case_id)
    for case_id, path in zip(cases.ids, simulations, strict=False):
        make.word(f"CASE_ID_{path.name}", case_id)
    if make.problems:
        raise ConfigError(list(dict.fromkeys(make.problems)), where=str(project.file.path), hint=_RENAME)
    ties = [f"{b.name}: {b.tie.words}\n" for b in compensation_masses(project, model) if b.tie is not None]
    out = output if output is not None else project.build_dir / "rules.mk"
    with replacing(out) as temporary:
        temporary.write_text("\n".join(make.lines) + "\n", encoding="utf-8", newline="\n")
    _write_changed(out.with_name(HALVES), " ".join(matrices) + "\n")
    _write_changed(out.with_name(SYMMETRY_PLANE), project_plane(project, model).plane.key + "\n")
    _write_changed(out.with_name(TIES), "".join(ties))
    return out


def _write_changed(path: Path, text: str) -> None:
    """Write a text, unless it is there already: what is made from the file is not older than it then."""
    if path.is_file() and path.read_bytes() == text.encode():
        return
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
