"""make-rules: what Make has to know of a project, so that it rebuilds what depends on a change and nothing else.

Make splits names at blanks, expands `$`, and reads `#`, `%`, `:` and others as its own signs, some of them twice on
their way from a variable to a rule; there is no way to write them all. So names with such signs are refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from tedm_cli.config.project import Project
from tedm_cli.errors import ConfigError
from tedm_cli.files.store import replacing
from tedm_cli.stages.chain.project_files import chain_files

_PLAIN = re.compile(r"[\w./+,@^-]*")  # letters and digits of any script
_RENAME = "letters, digits and _ - . / + , @ ^ are fine; `tedm run`, and the commands by themselves, take any name"


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
    are tied to (`remember`).

    Raises
    ------
    ConfigError : a name that Make cannot take, all of them at once; what `chain_files` refuses.
    """
    files = chain_files(project)
    own = files.solved_here
    make = _Variables()
    make.files("MODEL_TOML", "model", [files.model])
    make.files("OPTICS_TOML", "optics", [files.optics])
    make.files("CASES_TOML", "cases", [files.cases])
    make.files("MODEL_SOURCES", "model.bdf", [files.bdf, files.areas, *files.superelements] if own else [])
    make.files("AREAS_CSV", "model.areas_csv", [files.areas])
    make.files("SUPERELEMENTS", "superelement", files.superelements)
    make.files("UNIT_DECK", "model.deck", [files.deck])
    make.files("OP2", "model.op2", files.results)
    make.word("SOLVED_BY_TEDM", "yes" if own else "")
    make.files("GRAVITY_SOURCES", "gravity.compensation_masses, stl", files.gravity_sources)
    make.files("EFFECTS", "effect", files.effects)
    make.files("OPTICS_SOURCES", "imported", files.optics_sources)
    make.files("MATRICES", "the build folder", files.matrices)
    make.files("ADJOINT", "the build folder", [files.adjoint])
    make.files("ADJOINT_OP2", "model.adjoint_op2", files.adjoint_results)
    make.files("CASE_ADJOINT", "the build folder", [files.case_adjoint])
    make.files("CASE_SOURCES", "requirement, case", files.case_sources)
    make.files("SPECTRA", "temperature", files.spectra)
    make.files("UNCERTAINTY_SOURCES", "uncertainty.mesh", files.uncertainty_sources)
    make.files("DYNAMICS_TOML", "dynamics", [files.dynamics])
    make.files("DYNAMICS_SOURCES", "dynamics", files.dynamics_sources)
    make.files("THERMAL_TOML", "thermal", [files.thermal])
    make.files("THERMAL_SOURCES", "thermal", files.thermal_sources)
    make.files("THERMAL", "the build folder", [files.network])
    make.files("LOADS_TOML", "loads", [files.loads])
    make.files("LOADS", "the build folder", [files.other_loads])
    make.files("SIMULATION_FILES", "the build folder", [run.file for run in files.simulations])
    make.files("SERIES_FILES", "the build folder", [run.file for run in files.series])
    make.files("SIMULATED_SERIES_FILES", "the build folder", [run.file for run in files.simulated_series])
    for run in (*files.runs, *files.simulations):
        make.files(f"TABLE_{run.file.name}", "the build folder", run.tables)
    for run in (*files.series, *files.simulated_series):
        make.word(f"SERIES_{run.file.name}", run.name)
        make.files(f"TABLE_{run.file.name}", f"series {run.name}", run.tables)
    make.word("CASE_IDS", " ".join(run.name for run in files.runs))
    make.files("CASE_FILES", "the build folder", [run.file for run in files.runs])
    for run in (*files.runs, *files.simulations):
        make.word(f"CASE_ID_{run.file.name}", run.name)
    if make.problems:
        raise ConfigError(list(dict.fromkeys(make.problems)), where=str(project.file.path), hint=_RENAME)
    out = output if output is not None else project.build_dir / "rules.mk"
    with replacing(out) as temporary:
        temporary.write_text("\n".join(make.lines) + "\n", encoding="utf-8", newline="\n")
    remember({out.with_name(path.name): text for path, text in files.remembered().items()})
    return out


def remember(texts: Mapping[Path, str]) -> None:
    """Write each text, unless it is there already: what is made from the file is not older than it then."""
    for path in changed(texts):
        with replacing(path) as temporary:
            temporary.write_text(texts[path], encoding="utf-8", newline="\n")


def changed(texts: Mapping[Path, str]) -> list[Path]:
    """The files that do not hold their texts."""
    return [p for p, text in texts.items() if not p.is_file() or p.read_bytes() != text.encode()]
