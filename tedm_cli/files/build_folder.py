"""The files of a build folder: their names, where each comes from, and whether they were made from the same inputs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from tedm_cli.contracts import CASE, KINDS, Dataset
from tedm_cli.contracts.spec import AreaDatasets
from tedm_cli.errors import InputError
from tedm_cli.files.provenance import ConfigFile, InputFile, Provenance, command_line, input_files
from tedm_cli.files.seal import sha256_of
from tedm_cli.files.store import Reader, open_checked

(
    UNIT_LOADS_FILE,
    DISTORTION_FILE,
    SENSITIVITY_FILE,
    OPTICS_FILE,
    ADJOINT_FILE,
    DYNAMICS_FILE,
    IMPOSED_FILE,
    RELEASE_FILE,
    THERMAL_FILE,
    BALANCE_FILE,
    RETRIM_FILE,
    LOADS_FILE,
) = (
    "unit_loads.h5",
    "distortion.h5",
    "sensitivity.h5",
    "optics.h5",
    "adjoint.h5",
    "dynamics.h5",
    "figure_6_2.h5",
    "release.h5",
    "thermal.h5",
    "balance.h5",
    "retrim.h5",
    "loads.h5",
)
_AREAS = tuple(d for d in vars(AreaDatasets).values() if isinstance(d, Dataset))


def case_file_name(case_id: str) -> str:
    """`case03.h5` for case 3, `case4b.h5` for 4b."""
    return f"case{int(case_id):02d}.h5" if case_id.isdigit() else f"case{case_id}.h5"


def simulation_file_name(case_id: str) -> str:
    """`simulation03.h5` for case 3, `simulation4b.h5` for 4b."""
    return case_file_name(case_id).replace("case", "simulation", 1)


def series_file_name(name: str) -> str:
    return f"series_{name}.h5"


def simulated_series_file_name(name: str) -> str:
    """`simulation_warm.h5` for series warm in closed loop."""
    return f"simulation_{name}.h5"


def partial_file_names(results: Sequence[Path]) -> list[str]:
    """`partial_batch1.h5` for batch1.op2; with their numbers where results in different folders have one name."""
    stems = [path.stem for path in results]
    if len({stem.casefold() for stem in stems}) < len(stems):
        stems = [f"{number}_{stem}" for number, stem in enumerate(stems, start=1)]
    return [f"partial_{stem}.h5" for stem in stems]


def provenance(configs: Sequence[ConfigFile], inputs: Iterable[Path]) -> Provenance:
    """Origin of a file: `configs` as they were read, and the present contents of `inputs`."""
    paths = list(inputs)
    for path in paths:
        if not path.exists():
            kind = KINDS.get(path.stem)
            hint = f"make it with `{kind.made_by}`, or `tedm run`" if kind else ""
            raise InputError("no such file", where=str(path), hint=hint)
    return Provenance(tuple(configs), input_files(paths), command_line())


def require_same_input(name: str, *files: Reader) -> None:
    """Refuse files that were made from different contents of the input called `name`."""
    found: dict[str, Path] = {}
    for file in files:
        for item in file.provenance().inputs:
            if item.path.name == name:
                found.setdefault(item.sha256, file.path)
    if len(found) > 1:
        paths = " and ".join(str(p) for p in found.values())
        raise InputError(
            f"were made from different versions of {name}", where=paths, hint="rebuild them; see tedm check"
        )


def require_same_areas(first: Reader, *others: Reader) -> None:
    """Refuse files that do not say the same of the thermal areas, column by column."""
    for other in others:
        for path in _AREAS:
            one, two = (f.array(path).tolist() if path.dtype == "int" else f.strings(path) for f in (first, other))
            if one != two:
                raise _different_areas(first, other, path)


def _different_areas(first: Reader, other: Reader, path: str) -> InputError:
    return InputError(
        f"hold different thermal areas ({path})",
        where=f"{first.path} and {other.path}",
        hint="rebuild them; see tedm check",
    )


def require_areas_and_more(first: Reader, *others: Reader) -> None:
    """Refuse files that do not say the same of the thermal areas of the first; they may have more behind these."""
    for other in others:
        for path in _AREAS:
            one, two = (f.array(path).tolist() if path.dtype == "int" else f.strings(path) for f in (first, other))
            if one != two[: len(one)]:
                raise _different_areas(first, other, path)


def require_input(file: Reader, used: InputFile) -> None:
    """Refuse `file` when it was made from another version of the file `used` that this stage reads as well."""
    for item in file.provenance().inputs:
        if item.path.name == used.path.name and item.sha256 != used.sha256:
            raise InputError(
                f"is stale: made from another version of {used.path}",
                where=str(file.path),
                hint=f"rebuild it with `{file.kind.made_by}`, or `tedm run`",
            )


def require_configuration(file: Reader, config: Path) -> None:
    """Refuse `file` when it was made with another version of the project's `config`; what is gone proves nothing."""
    if config.is_file() and sha256_of(config) not in {c.sha256 for c in file.provenance().configs}:
        raise InputError(
            f"is stale: not made from {config} as it is now",
            where=str(file.path),
            hint=f"rebuild it with `{file.kind.made_by}`, or `tedm run`",
        )


def require_up_to_date(file: Reader) -> None:
    """Refuse `file` when its configurations or inputs have changed since, or its inputs stem from results that have.

    For commands that know the build folder alone. What is gone cannot be compared. The decks and OP2 files behind
    `unit_loads.h5`, which are large, and the configurations of other files are left to `tedm check`.
    """
    sums: dict[Path, str] = {}

    def require(one: Reader, used: Iterable[ConfigFile | InputFile]) -> None:
        there = [item for item in used if item.path.is_file()]
        for path in (item.path for item in there if item.path not in sums):
            sums[path] = sha256_of(path)
            if path.suffix == ".h5" and path.stem in KINDS:
                with open_checked(path, KINDS[path.stem]) as source:
                    require(source, source.provenance().inputs if source.kind is not KINDS["unit_loads"] else ())
        for item in there:
            if sums[item.path] != item.sha256:
                command = one.kind.made_by + (f" {one.string(CASE.CASE_ID)}" if one.has(CASE.CASE_ID) else "")
                raise InputError(
                    f"is stale: not made from {item.path} as it is now",
                    where=str(one.path),
                    hint=f"rebuild it with `{command}`; see tedm check",
                )

    made = file.provenance()
    require(file, (*made.configs, *made.inputs))
