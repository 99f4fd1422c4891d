"""Outputs as sums over grids: S_SG = -G [D] over all of them, the read-out over those that carry optical elements."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import OPTICS, SENSITIVITY
from tedm_cli.errors import InputError, UsageError
from tedm_cli.files.build_folder import OPTICS_FILE, SENSITIVITY_FILE, require_input
from tedm_cli.files.provenance import InputFile
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.differences import terms
from tedm_cli.results.gravity.self_gravity import read_self_gravity
from tedm_cli.results.optics import ReadOuts, read_bench_motion, read_read_outs
from tedm_cli.stages.common import known_name

_SUM = 1e-9  # of the sum of the terms' sizes: sums of float64 agree far better, other files do not


@dataclass(frozen=True, eq=False)
class Output:
    """One output, g [k] per kelvin of each area, `unit` before "/K".

    rows : of self-gravity: coefficients and rows of the operator. elements : of the read-out: its terms [E, k] by
    optical element; those of the test masses and of the glass of plates (`elsewhere` [k]) are at no grid.
    """

    label: str
    unit: str
    g: FloatArray
    rows: tuple[tuple[float, int], ...] = ()
    elements: FloatArray | None = None
    elsewhere: FloatArray | None = None

    def require_sum(self, found: FloatArray, weights: FloatArray, where: Path) -> None:
        """Refuse terms [N] that do not add up to the output under `weights` [k] of the areas.

        Raises
        ------
        InputError : they do not, so the matrices in the files do not belong together.
        """
        wanted = float(self.g @ weights)
        rest = 0.0 if self.elsewhere is None else float(self.elsewhere @ weights)
        room = float(np.abs(found).sum()) + abs(rest) + float(np.abs(self.g) @ np.abs(weights))
        total = float(found.sum()) + rest
        if not abs(total - wanted) <= _SUM * room:
            raise InputError(
                f"the grids' parts of {self.label} add up to {total:.9g}, the matrix says {wanted:.9g}",
                where=str(where),
                hint="its matrices do not belong together: `tedm run` makes them anew",
            )

    def minus(self, other: Output) -> Output:
        """The difference of two outputs of one kind."""
        rows = (*self.rows, *((-c, r) for c, r in other.rows))
        if self.elements is None or other.elements is None or self.elsewhere is None or other.elsewhere is None:
            return Output(f"{self.label}-{other.label}", self.unit, self.g - other.g, rows)
        return Output(
            f"{self.label}-{other.label}",
            self.unit,
            self.g - other.g,
            (),
            self.elements - other.elements,
            self.elsewhere - other.elsewhere,
        )


def output_labels(build_dir: Path) -> list[str]:
    """Names of the outputs in the files that are there: self-gravity, then the read-out by set."""
    found: list[str] = []
    if (build_dir / SENSITIVITY_FILE).exists():
        with open_checked(build_dir / SENSITIVITY_FILE, SENSITIVITY) as file:
            found += read_self_gravity(file).label
    if (build_dir / OPTICS_FILE).exists():
        with open_checked(build_dir / OPTICS_FILE, OPTICS) as file:
            found += read_read_outs(file).names
    return found


def read_output(build_dir: Path, label: str, distortion: Reader, distortion_file: InputFile) -> Output:
    """An output, or the difference of two (`TM1_a_x-TM2_a_x`), of files made from `distortion_file`.

    Raises
    ------
    UsageError : there is none of that name, or the difference is of different quantities.
    InputError : the file it is in is missing, stale, or breaks its contract.
    """
    known = output_labels(build_dir)
    if not known:
        with open_checked(build_dir / SENSITIVITY_FILE, SENSITIVITY):
            pass  # says how to make it
    pair = terms(label)
    if label in known or pair is None:
        return _single(build_dir, known_name("output", label, known), distortion, distortion_file)
    first, second = (
        _single(build_dir, known_name("output", name, known), distortion, distortion_file) for name in pair
    )
    if first.unit != second.unit:
        raise UsageError(f"{label} is a difference of {first.unit} and {second.unit}")
    return first.minus(second)


def _single(build_dir: Path, label: str, distortion: Reader, distortion_file: InputFile) -> Output:
    path = build_dir / SENSITIVITY_FILE
    if path.exists():
        with open_checked(path, SENSITIVITY) as file:
            gravity = read_self_gravity(file)
            if label in gravity.label:
                require_input(file, distortion_file)
                row = gravity.label.index(label)
                return Output(label, gravity.unit[row].removesuffix("/K"), gravity.S[row], ((1.0, row),))
    with open_checked(build_dir / OPTICS_FILE, OPTICS) as file:
        require_input(file, distortion_file)
        return _read_out(read_read_outs(file), label, read_bench_motion(distortion).element)


def _read_out(r: ReadOuts, label: str, optical: list[str]) -> Output:
    """The read-out called `label`; `optical` names the elements that ride on grids."""
    number, row = divmod(r.names.index(label), len(r.label))
    chosen = r.sets[number]
    by_element = r.by_element(chosen)[row]
    on_grid = [r.element.index(name) for name in optical]
    elsewhere = np.delete(by_element, on_grid, axis=0).sum(axis=0) + r.N_plates(chosen)[row]
    return Output(label, r.unit[row], r.N[chosen][row], elements=by_element[on_grid], elsewhere=elsewhere)
