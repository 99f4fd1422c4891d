"""The read-outs as optics.h5 tells them, and the motion of the bench that they come from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import DISTORTION, OPTICS
from tedm_cli.files.store import Reader
from tedm_cli.optics.layout import N_MOTIONS, N_OUTPUTS
from tedm_cli.optics.shares import motion_terms
from tedm_cli.results.areas import AreaMap
from tedm_cli.results.units import units_of
from tedm_cli.results.wording import READ_OUT_UNIT

AREA_COMMA = ", "  # between the areas of one grid


@dataclass(frozen=True, eq=False)
class Plates:
    """The p plates whose glass changes with temperature.

    name : of the plates. outputs : [5 n, p, 2, k], m and rad per kelvin, outputs of the n beams by the index and by the
    thickness of each. law : by set, [r, 5 n] (m, rad by m, rad), outputs of the beams to read-outs.
    """

    name: list[str]
    outputs: FloatArray
    law: dict[str, FloatArray]

    @property
    def changes(self) -> list[str]:
        """Names [2 p] of what changes of the plates: `W1_index`, `W1_thickness`."""
        return [f"{name}_{what}" for name in self.name for what in ("index", "thickness")]

    def terms(self, set_name: str) -> FloatArray:
        """Terms [r, p, 2, k] of the read-outs of a set by the index and by the thickness of each plate."""
        return np.asarray(np.einsum("ro,opck->rpck", self.law[set_name], self.outputs))


@dataclass(frozen=True, eq=False)
class ReadOuts:
    """The r read-outs of every set of photodiodes, m and rad per kelvin of each of the k areas.

    Parameters
    ----------
    label, unit : of the read-outs, the same of every set.
    element : the E optical elements and test masses, in the order of the motions.
    benches : elements of each bench by its name; test masses are on none.
    axes : by test mass, its x, y, z [3, 3] as rows, layout frame.
    N, gain : by set, [r, k] and [r, 6 E] (by m and rad): N = gain motion + N_plates.
    plates : those whose glass changes with temperature, which is no motion; None where none does.
    motion, rigid_motion : [6 E, k], motion of the elements at their grids, and the part of it in which each bench
        moves as one; layout frame.
    """

    label: list[str]
    unit: list[str]
    element: list[str]
    benches: dict[str, list[str]]
    axes: dict[str, FloatArray]
    N: dict[str, FloatArray]
    gain: dict[str, FloatArray]
    motion: FloatArray
    rigid_motion: FloatArray
    plates: Plates | None = None

    @property
    def sets(self) -> list[str]:
        """Names of the sets, the first one first."""
        return list(self.N)

    @property
    def names(self) -> list[str]:
        """Names of all read-outs as outputs, set by set: `A_TM1_x`."""
        return [f"{name}_{label}" for name in self.sets for label in self.label]

    def by_element(self, name: str) -> FloatArray:
        """Terms [r, E, k] of the read-outs of a set by the element that moves; they and the plates sum to N."""
        return np.asarray(self.by_motion(name, self.motion).sum(axis=2))

    def by_plate(self, name: str) -> FloatArray:
        """Terms [r, p, 2, k] by the index and the thickness of each plate whose glass changes; p may be 0."""
        if self.plates is None:
            return np.zeros((len(self.label), 0, 2, self.motion.shape[1]))
        return self.plates.terms(name)

    @property
    def plate_names(self) -> list[str]:
        """Names of the plates whose glass changes, as parts of a read-out beside the motion of elements."""
        return [] if self.plates is None else [f"{name} glass" for name in self.plates.name]

    @property
    def part_names(self) -> list[str]:
        """Names [E + p] of all that a read-out is made of: elements that move, and plates whose glass changes."""
        return self.element + self.plate_names

    def by_part(self, name: str) -> FloatArray:
        """Terms [r, E + p, k] of the read-outs of a set by its parts; they sum to N."""
        return np.concatenate([self.by_element(name), self.by_plate(name).sum(axis=2)], axis=1)

    def N_plates(self, name: str) -> FloatArray:
        """The part [r, k] of the read-outs of a set that is by the glass of plates."""
        return np.asarray(self.by_plate(name).sum(axis=(1, 2)))

    def by_motion(self, name: str, motion: FloatArray) -> FloatArray:
        """Terms [r, E, 6, k] of the read-outs of a set by each motion of each element, for motions [6 E, k]."""
        terms = motion_terms(self.gain[name], motion)
        return np.asarray(terms.reshape(len(self.label), len(self.element), N_MOTIONS, -1))


def read_read_outs(file: Reader) -> ReadOuts:
    """All that optics.h5 says of the read-outs; `InputError` where a unit is not of its read-out."""
    sets, label = file.strings(OPTICS.SET_NAME), file.strings(OPTICS.LABEL_READ_OUT)
    on = list(zip(file.strings(OPTICS.ELEMENT_NAME), file.strings(OPTICS.ELEMENT_BENCH), strict=True))
    wanted = ["m" if name.endswith(("_x", "_y", "_z")) else "rad" for name in label]
    return ReadOuts(
        label=label,
        unit=units_of(file, OPTICS.LABEL_READ_OUT_UNIT, label, wanted),
        element=[label.rpartition("_")[0] for label in file.strings(OPTICS.LABEL_ELEMENT_DOF)[::N_MOTIONS]],
        benches={bench: [e for e, b in on if b == bench] for bench in file.strings(OPTICS.BENCH_NAME)},
        axes=dict(zip(file.strings(OPTICS.TEST_MASS_NAME), file.array(OPTICS.TEST_MASS_AXES), strict=True)),
        N={name: file.array(OPTICS.N.of(name)) for name in sets},
        gain={name: file.array(OPTICS.GAIN.of(name)) for name in sets},
        motion=file.array(OPTICS.MOTION),
        rigid_motion=file.array(OPTICS.RIGID_MOTION),
        plates=_read_plates(file, sets) if file.has(OPTICS.PLATE_NAME) else None,
    )


def _read_plates(file: Reader, sets: list[str]) -> Plates:
    by = np.stack([file.array(OPTICS.PLATE_BY_INDEX), file.array(OPTICS.PLATE_BY_THICKNESS)], axis=2)
    change = np.stack([file.array(OPTICS.PLATE_INDEX_CHANGE), file.array(OPTICS.PLATE_THICKNESS_CHANGE)], axis=1)
    P = file.array(OPTICS.P)
    return Plates(
        name=file.strings(OPTICS.PLATE_NAME),
        outputs=by[..., None] * change,
        law={name: np.asarray(file.array(OPTICS.INVERSE.of(name)) @ P, dtype=np.float64) for name in sets},
    )


@dataclass(frozen=True, eq=False)
class Beams:
    """What carries the motion of the elements to the read-outs of one set: gain = inverse P S_BW.

    label : of the beams on photodiodes, five rows of S_BW each. motion : of the columns of S_BW. Units and frames as in
    optics.h5.
    """

    label: list[str]
    motion: list[str]
    inverse: FloatArray
    P: FloatArray
    S_BW: FloatArray


def read_beams(file: Reader, set_name: str) -> Beams:
    """The matrices of one set."""
    return Beams(
        label=[" ".join(label.rsplit("_", 2)[:2]) for label in file.strings(OPTICS.LABEL_RAY_OUTPUT)[::N_OUTPUTS]],
        motion=file.strings(OPTICS.LABEL_ELEMENT_DOF),
        inverse=file.array(OPTICS.INVERSE.of(set_name)),
        P=file.array(OPTICS.P),
        S_BW=file.array(OPTICS.S_BW),
    )


def read_out_maps(file: Reader) -> list[AreaMap]:
    """N of all photodiode sets, a panel for each unit, read-outs of the sets beside each other."""
    r = read_read_outs(file)
    maps = []
    for unit in dict.fromkeys(r.unit):
        shown, factor = READ_OUT_UNIT[unit]
        chosen = [(i, name) for i, u in enumerate(r.unit) if u == unit for name in r.sets]
        value = factor * np.array([r.N[name][i] for i, name in chosen])
        maps.append(AreaMap("N", f"{shown}/K", [f"{name}_{r.label[i]}" for i, name in chosen], value))
    return maps


@dataclass(frozen=True, eq=False)
class OpticsQuality:
    """How good the optical matrices are.

    shape : rows and columns of S_BW. rank, singular_value : of O_ideal (m, rad). condition : by set, of O (m, rad).
    element : the n on the benches. reference_offset_m : [n, 3], their reference points in the layout minus their grids,
        layout frame.
    residual : by invariance, dimensionless. notes : what is odd in the layout, or between it and the model.
    """

    shape: tuple[int, int]
    rank: int
    singular_value: FloatArray
    condition: dict[str, float]
    element: list[str]
    reference_offset_m: FloatArray
    residual: dict[str, float]
    notes: list[str]


def read_quality(file: Reader) -> OpticsQuality:
    """Rank, conditions and residuals in optics.h5."""
    rows, columns = file.dataset(OPTICS.S_BW).shape
    return OpticsQuality(
        shape=(rows, columns),
        rank=int(file.number(OPTICS.RANK)),
        singular_value=file.array(OPTICS.SINGULAR_VALUES),
        condition=dict(zip(file.strings(OPTICS.SET_NAME), file.array(OPTICS.SET_CONDITION).tolist(), strict=True)),
        element=file.strings(OPTICS.OPTICAL_NAME),
        reference_offset_m=file.array(OPTICS.REFERENCE_POINT_OFFSET),
        residual=dict(zip(file.strings(OPTICS.RESIDUAL_NAME), file.array(OPTICS.RESIDUAL_VALUE).tolist(), strict=True)),
        notes=file.strings(OPTICS.NOTE) if file.has(OPTICS.NOTE) else [],
    )


@dataclass(frozen=True, eq=False)
class OpticsResults:
    """What a report says of optics.h5: how good the matrices are, and the read-outs."""

    quality: OpticsQuality
    read_outs: ReadOuts


def read_optics(file: Reader) -> OpticsResults:
    """Both."""
    return OpticsResults(read_quality(file), read_read_outs(file))


@dataclass(frozen=True, eq=False)
class BenchMotion:
    """The n optical elements as distortion.h5 tells them: names, positions [n, 3] m of their grids, and motion
    [k, n, 6] (m/K, rad/K) of these per kelvin of every area; basic frame. `areas`: by element, those of a mean
    temperature that its grid is in."""

    element: list[str]
    position_m: FloatArray
    motion: FloatArray
    areas: dict[str, tuple[str, ...]]


def read_bench_motion(distortion: Reader) -> BenchMotion:
    """Motion of the grids that carry the optical elements; of none, where the project has no optics."""
    if not distortion.has(DISTORTION.OPTICAL_NAME):
        areas = len(distortion.strings(DISTORTION.AREA_NAME))
        return BenchMotion([], np.zeros((0, 3)), np.zeros((areas, 0, 6)), {})
    parts = [distortion.array(DISTORTION.D_OPT_TRANSLATION), distortion.array(DISTORTION.D_OPT_ROTATION)]
    return BenchMotion(
        distortion.strings(DISTORTION.OPTICAL_NAME),
        distortion.array(DISTORTION.OPTICAL_POSITION),
        np.concatenate(parts, axis=2),
        _areas_of_optics(distortion),
    )


def _areas_of_optics(distortion: Reader) -> dict[str, tuple[str, ...]]:
    if not distortion.has(DISTORTION.OPTICAL_AREA):  # the file is of an older version of the program
        return {}
    known = set(distortion.strings(DISTORTION.AREA_NAME))
    pairs = zip(distortion.strings(DISTORTION.OPTICAL_NAME), distortion.strings(DISTORTION.OPTICAL_AREA), strict=True)
    return {name: (own,) if own in known else tuple(filter(None, own.split(AREA_COMMA))) for name, own in pairs}
