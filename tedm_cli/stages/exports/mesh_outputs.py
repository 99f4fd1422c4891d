"""Outputs as sums over grids: S_SG = -G [D] over all of them, the read-out over those that carry optical elements."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import OPTICS as OPTICS_KIND
from tedm_cli.contracts import SENSITIVITY as SENSITIVITY_KIND
from tedm_cli.errors import InputError, UsageError
from tedm_cli.files.build_folder import OPTICS, SENSITIVITY, require_input
from tedm_cli.files.provenance import InputFile
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.differences import terms
from tedm_cli.optics.layout import N_MOTIONS
from tedm_cli.optics.shares import motion_terms
from tedm_cli.stages.common import known_name

_SUM = 1e-9  # of the sum of the terms' sizes: sums of float64 agree far better, other files do not


@dataclass(frozen=True, eq=False)
class Output:
    """One output, g [k] per kelvin of each area, `unit` before "/K".

    rows : of self-gravity: coefficients and rows of the operator. elements : of the read-out: its terms [E, k] by
    optical element; those of the test masses (`elsewhere` [k], their own expansion) are at no grid.
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
                hint="its matrices do not belong together: run make all",
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
    if (build_dir / SENSITIVITY).exists():
        with open_checked(build_dir / SENSITIVITY, SENSITIVITY_KIND) as file:
            found += file.strings("/row/label")
    if (build_dir / OPTICS).exists():
        with open_checked(build_dir / OPTICS, OPTICS_KIND) as file:
            found += [f"{s}_{label}" for s in file.strings("/set/name") for label in file.strings("/label/read_out")]
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
        with open_checked(build_dir / SENSITIVITY, SENSITIVITY_KIND):
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
    path = build_dir / SENSITIVITY
    if path.exists():
        with open_checked(path, SENSITIVITY_KIND) as file:
            labels = file.strings("/row/label")
            if label in labels:
                require_input(file, distortion_file)
                row = labels.index(label)
                return Output(
                    label, file.strings("/row/unit")[row].removesuffix("/K"), file.array("/S")[row], ((1.0, row),)
                )
    with open_checked(build_dir / OPTICS, OPTICS_KIND) as file:
        require_input(file, distortion_file)
        names, reads = file.strings("/set/name"), file.strings("/label/read_out")
        chosen, row = next((s, i) for s in names for i, read in enumerate(reads) if f"{s}_{read}" == label)
        return _read_out(file, label, chosen, row, distortion.strings("/optical/name"))


def _read_out(file: Reader, label: str, chosen: str, row: int, optical: list[str]) -> Output:
    by_motion = motion_terms(file.array(f"/gain/{chosen}")[[row]], file.array("/motion"))[0]
    by_element = by_motion.reshape(-1, N_MOTIONS, by_motion.shape[1]).sum(axis=1)
    place = {name: i for i, name in enumerate(file.strings("/element/name"))}
    on_grid = [place[name] for name in optical]
    others = np.delete(by_element, on_grid, axis=0)
    return Output(
        label,
        file.strings("/label/read_out_unit")[row],
        file.array(f"/N/{chosen}")[row],
        elements=by_element[on_grid],
        elsewhere=others.sum(axis=0),
    )
