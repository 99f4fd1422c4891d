"""export-extremal: the correlations that reach the bounds of a case, as files that a case of one's own can name."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.correlation.file import matrix_csv
from tedm_cli.contracts import CASE
from tedm_cli.errors import InputError, UsageError
from tedm_cli.files.build_folder import case_file_name, require_up_to_date
from tedm_cli.files.store import Reader, open_checked, replacing
from tedm_cli.noise.bounds import BOUNDS, extremal_matrix, matrix_at
from tedm_cli.noise.differences import no_output
from tedm_cli.results.cases.file import read_bound, read_correlation, read_psd
from tedm_cli.results.thermal.case_shares import require_areas

CASES = "cases.toml"


@dataclass(frozen=True)
class Extremal:
    """A correlation in a file, and the `id` of the case in CASES that names it.

    It makes `amplitude` of the output at `frequency_hz`, the case itself `of_case`, in `unit` per √Hz.
    """

    path: Path
    id: str
    output: str
    bound: str
    frequency_hz: float
    amplitude: float
    of_case: float
    unit: str


def export_extremal(build_dir: Path, case_id: str, wanted: Sequence[str], output: Path | None) -> list[Extremal]:
    """Write the correlation at every bound of the `wanted` outputs (the judged ones where none is named), and CASES.

    CASES holds a case for each, to be appended to a cases file.

    Raises
    ------
    UsageError : no such output.
    InputError : there is no case file, it is stale or breaks its contract; `output` is a file.
    """
    path = build_dir / case_file_name(case_id)
    if not path.exists():
        raise InputError("no such file", where=str(path), hint=f"make it with `tedm run-case {case_id}`, or `tedm run`")
    folder = output if output is not None else build_dir / "export" / f"{path.stem}_extremal"
    if folder.is_file():
        raise InputError("is a file; wanted a folder", where=str(folder))
    with open_checked(path, CASE) as file:
        require_up_to_date(file)
        require_areas(file, "an extremal correlation is a case of areas")
        labels = file.strings(CASE.OUTPUT_LABEL)
        unknown = [label for label in wanted if label not in labels]
        if unknown:
            raise UsageError(no_output(unknown[0], labels), where=str(path))
        chosen = list(dict.fromkeys(wanted or file.strings(CASE.VERDICT_OUTPUT) or labels))
        active = file.array(CASE.CASE_BLOCK) >= 0
        names = [n for n, a in zip(file.strings(CASE.AREA_NAME), active.tolist(), strict=True) if a]
        done = []
        for label in chosen:
            for bound in BOUNDS:
                found = _describe(file, case_id, labels.index(label), label, bound, folder)
                matrix = _matrix(file, labels.index(label), bound, found.frequency_hz)[np.ix_(active, active)]
                _write(found.path, matrix_csv(names, matrix))
                done.append(found)
    _write(folder / CASES, "\n".join(_case_text(e, case_id) for e in done))
    return done


def _describe(file: Reader, case_id: str, o: int, label: str, bound: str, folder: Path) -> Extremal:
    frequency = float(file.array(CASE.CONTRIBUTION_FREQUENCY)[o])
    f = int(np.abs(file.array(CASE.FREQUENCY) - frequency).argmin())
    psds = read_bound(file, bound, [label])[0], read_psd(file, [label])[0]
    amplitude, of_case = (float(np.sqrt(psd[f])) for psd in psds)
    unit = file.strings(CASE.OUTPUT_UNIT)[o]
    name = f"{label}_{bound}"
    return Extremal(folder / f"{name}.csv", f"{case_id}_{name}", label, bound, frequency, amplitude, of_case, unit)


def _matrix(file: Reader, o: int, bound: str, frequency_hz: float) -> FloatArray:
    """Correlation [k, k] that reaches the bound of output `o`; rows of silent areas mean nothing."""
    vectors = file.array(CASE.EXTREMAL.of(bound))[o]
    if not bound.startswith("known_blocks"):
        return extremal_matrix(vectors)
    found = read_correlation(file)
    inside = matrix_at(found.matrix.astype(np.complex128), found.delay_s, frequency_hz)
    return extremal_matrix(vectors, found.block, inside)


def _case_text(e: Extremal, case_id: str) -> str:
    title = f"Case {case_id} with the correlation at the bound {e.bound} of {e.output}"
    reason = f"Exact at {e.frequency_hz:g} Hz."
    return (
        f'[[case]]\nid = "{e.id}"\ntitle = {json.dumps(title)}\nrole = "diagnostic"\nreason = "{reason}"\n'
        f"matrix = {json.dumps(e.path.resolve().as_posix(), ensure_ascii=False)}\n"
    )


def _write(path: Path, text: str) -> None:
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
