"""Which outputs and areas of the cases that were run to show on the mesh; the weights of areas in a case's noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import CASE
from tedm_cli.errors import InputError, UsageError
from tedm_cli.files.build_folder import case_file_name
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.contributions import share_weights
from tedm_cli.noise.selection import listed
from tedm_cli.results.areas import read_areas
from tedm_cli.results.cases.effects import effect_rows
from tedm_cli.results.cases.file import read_case, read_correlation
from tedm_cli.results.thermal.case_shares import require_areas
from tedm_cli.stages.common import known_name


@dataclass(frozen=True)
class Worst:
    """The verdict with the largest ratio: its case, output, and the area with the largest share in it."""

    case: str
    output: str
    area: str
    ratio: float


def worst_of_cases(paths: Sequence[Path]) -> Worst | None:
    """The worst verdict of the case files `paths`; of cases without gradients within areas or thermal nodes, which move
    no mesh.
    """
    found: list[Worst] = []
    for path in paths:
        with open_checked(path, CASE) as file:
            case = read_case(file)
            if case.judged and not case.thermal and not case.areas.within.any():
                worst = max(case.judged, key=lambda j: j.ratio)
                area = str(case.areas.name[np.abs(worst.share).argmax()])
                found.append(Worst(case.id, worst.output, area, worst.ratio))
    return max(found, key=lambda w: w.ratio, default=None)


def case_files(build_dir: Path) -> dict[str, Path]:
    """Files of the cases that were run, by the id that a command takes."""
    files = {path.stem.removeprefix("case"): path for path in sorted(build_dir.glob("case*.h5"))}
    return {str(int(i)) if i.isdigit() else i: path for i, path in files.items()}


def case_file(build_dir: Path, case_id: str) -> Path:
    """The file of a case.

    Raises
    ------
    InputError : no case was run. UsageError : others were.
    """
    files = case_files(build_dir)
    if not files:
        path = build_dir / case_file_name(case_id)
        raise InputError("no such file", where=str(path), hint=f"make it with `tedm run-case {case_id}`, or `tedm run`")
    wanted = str(int(case_id)) if case_id.isdigit() else case_id
    return files[known_name("case that was run", wanted, list(files))]


def require_moving(path: Path) -> None:
    """Refuse the file of a case with thermal nodes or gradients within areas, as `case_weights` does."""
    with open_checked(path, CASE) as file:
        _require_areas(file)


def _require_areas(file: Reader) -> None:
    require_areas(file, "the displacements on the mesh are of areas")
    within = read_areas(file).within
    if within.any():
        names = listed(np.array(file.strings(CASE.AREA_NAME))[within].tolist())
        fact = f"case {file.string(CASE.CASE_ID)} has gradients within areas ({names}), which have no displacements"
        raise UsageError(fact, hint="name a case without, or the areas of the model")


def case_weights(file: Reader, label: str, g: FloatArray) -> tuple[FloatArray, float, float]:
    """Weights [k] that turn a term of an output into a share of the PSD, the frequency (Hz), the share of own effects.

    The frequency is that of the case's grid next to the output's binding frequency. g : [k], without the effects of the
    user's own. See `share_weights`.

    Raises
    ------
    UsageError : there is no such output; the case has gradients within areas, of which there are no displacements.
    """
    _require_areas(file)
    o = file.strings(CASE.OUTPUT_LABEL).index(
        known_name(f"output of {file.path.name}", label, file.strings(CASE.OUTPUT_LABEL))
    )
    frequency = file.array(CASE.FREQUENCY)
    at = int(np.abs(np.log(frequency / file.array(CASE.CONTRIBUTION_FREQUENCY)[o])).argmin())
    amplitude = file.array(CASE.TEMPERATURE_ASD)[file.array(CASE.TEMPERATURE_SPECTRUM), at]
    hz, found = float(frequency[at]), read_correlation(file)
    effects = sum(effect_rows(file, label).values(), np.zeros_like(g))
    weights = share_weights(g + effects, amplitude, found.matrix, found.delay_s, hz)
    return weights, hz, float(effects @ weights)
