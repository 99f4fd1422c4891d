"""What adjoint.h5 says of the areas and of materials; the sensitivities of grids are left in the file."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray
from tedm_cli.contracts import ADJOINT
from tedm_cli.files.store import Reader
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.adjoint.materials import MaterialEffect, material_effects
from tedm_cli.results.areas import read_areas

_LEAST = 1e-3  # of the largest output of a block: what is less is zero by symmetry
_ALTOGETHER = 1e8  # from here on a sum is the rounding of its terms
_MATTERS = 1e-2  # of the largest terms of an output


@dataclass(frozen=True, eq=False)
class ActingAreas:
    """The areas of mean temperatures that act most on an output: by their mean, and by a gradient within them.

    by_mean : per kelvin. by_gradient : size of the sensitivity to a gradient along x, y, z, per K/m; of the output in
    `unit` less /K.
    """

    output: str
    unit: str
    mean_area: str
    by_mean: float
    gradient_area: str
    by_gradient: float


@dataclass(frozen=True, eq=False)
class FieldError:
    """How the areas tell r outputs of even temperature fields of L correlation lengths.

    length_m : [L]. ratio, left_out : [L, r], as in adjoint.h5.
    """

    length_m: FloatArray
    ratio: FloatArray
    left_out: FloatArray


@dataclass(frozen=True)
class Cancelling:
    """A sum over an area in which terms cancel, and how far: the sizes of its terms over that of their sum."""

    area: str
    output: str
    factor: float


@dataclass(frozen=True, eq=False)
class AdjointResults:
    """The adjoint by its areas; r outputs, k areas.

    label, unit : of the outputs. n_grids, n_elements : how many temperatures there are of grids, and of elements that
    may have their own. value : [r, k], S_SG and N. cancellation, difference, allowed : [r, k], and gradient :
    [r, k, 3], as in adjoint.h5. materials : effects of materials and of thicknesses, largest first. moduli_together :
    the largest change by a factor common to all moduli, over the largest of its block: none, but for rounding, where
    displacements are those of the stiffness here. block : [r], rows that are compared with each other. field : None
    where the areas were not held against one.
    """

    label: list[str]
    unit: list[str]
    areas: AreaTable
    n_grids: int
    n_elements: int
    value: FloatArray
    cancellation: FloatArray
    gradient: FloatArray
    difference: FloatArray
    allowed: FloatArray
    materials: list[MaterialEffect]
    moduli_together: float
    block: list[str]
    field: FieldError | None

    @property
    def mean_cancellation(self) -> FloatArray:
        """The cancellations of all areas of a mean temperature in all outputs, of those where anything acts."""
        found = self.cancellation[:, ~self.areas.gradient]
        return np.asarray(found[~np.isnan(found)])

    @property
    def felt(self) -> BoolArray:
        """Outputs [r] that areas of mean temperatures do act on: others of a block are zero by symmetry."""
        size = np.linalg.norm(self.value[:, ~self.areas.gradient], axis=1)
        block = np.array(self.block)
        return np.array([one > _LEAST * size[block == of].max() for one, of in zip(size, block, strict=True)])

    @property
    def cancelling_most(self) -> list[Cancelling]:
        """The sums of mean temperatures in which terms cancel most, the worst first.

        Of those that matter: the sizes of the terms are a hundredth or more of the largest of that output. What is
        zero by symmetry cancels altogether, and is left out.
        """
        means = np.flatnonzero(~self.areas.gradient)
        factor = self.cancellation[:, means]
        with np.errstate(invalid="ignore"):
            sizes = factor * np.abs(self.value[:, means])
        sizes = np.where(np.isfinite(sizes), sizes, 0.0)
        counts = self.felt[:, None] & (sizes >= _MATTERS * sizes.max(axis=1, keepdims=True)) & (factor < _ALTOGETHER)
        rows, columns = np.nonzero(counts)
        order = np.argsort(-factor[rows, columns], kind="stable")
        names = self.areas.name[means].tolist()
        places = [(int(rows[i]), int(columns[i])) for i in order]
        return [Cancelling(names[column], self.label[row], float(factor[row, column])) for row, column in places]

    @property
    def acting_most(self) -> list[ActingAreas]:
        """Of each output the areas with the largest sensitivities."""
        means = np.flatnonzero(~self.areas.gradient)
        names, size = self.areas.name[means].tolist(), np.linalg.norm(self.gradient[:, means], axis=2)
        out = []
        for row, (label, unit) in enumerate(zip(self.label, self.unit, strict=True)):
            value = self.value[row, means]
            one, two = int(np.abs(value).argmax()), int(size[row].argmax())
            out.append(ActingAreas(label, unit, names[one], float(value[one]), names[two], float(size[row, two])))
        return out


def read_field_error(file: Reader) -> FieldError | None:
    """How the areas tell an even field, where adjoint.h5 has it."""
    if not file.has(ADJOINT.FIELD_RATIO):
        return None
    datasets = (ADJOINT.FIELD_LENGTH, ADJOINT.FIELD_RATIO, ADJOINT.FIELD_LEFT_OUT)
    return FieldError(*(file.array(dataset) for dataset in datasets))


def field_ratio(file: Reader, label: str) -> tuple[FloatArray, FloatArray] | None:
    """Correlation lengths [L] and the ratio [L] of an output; None where it has none, as differences do."""
    field = read_field_error(file)
    if field is None or label not in (labels := file.strings(ADJOINT.ROW_LABEL)):
        return None
    ratio = field.ratio[:, labels.index(label)]
    return None if np.isnan(ratio).any() else (field.length_m, ratio)


def read_adjoint(file: Reader) -> AdjointResults | str:
    """What adjoint.h5 says, or why there is no adjoint."""
    if file.has(ADJOINT.REFUSAL):
        return "; ".join(file.strings(ADJOINT.REFUSAL))
    areas = read_areas(file)
    value = np.asarray(file.array(ADJOINT.AREA_SUM) + file.array(ADJOINT.DIRECT), dtype=np.float64)
    block = file.strings(ADJOINT.CHECK_BLOCK)
    return AdjointResults(
        label=file.strings(ADJOINT.ROW_LABEL),
        unit=file.strings(ADJOINT.ROW_UNIT),
        areas=areas,
        n_grids=file.dataset(ADJOINT.GRID_ID).shape[0],
        n_elements=file.dataset(ADJOINT.ELEMENT_ID).shape[0],
        value=value,
        cancellation=file.array(ADJOINT.AREA_CANCELLATION),
        gradient=file.array(ADJOINT.AREA_GRADIENT),
        difference=file.array(ADJOINT.CHECK_DIFFERENCE),
        allowed=file.array(ADJOINT.CHECK_ALLOWED),
        materials=material_effects(file, value, block, ~areas.gradient),
        moduli_together=_moduli_together(file.array(ADJOINT.DS_DLNE), value, block, areas.gradient),
        block=block,
        field=read_field_error(file),
    )


def _moduli_together(dlne: FloatArray, value: FloatArray, block: list[str], gradient: BoolArray) -> float:
    """Largest |Σ_m ∂S/∂ln E_m| over the largest |S| of the block, areas in K and in K/m apart."""
    together = np.abs(dlne.sum(axis=0))
    names, worst = np.array(block), 0.0
    for name in dict.fromkeys(block):
        for kind in (False, True):
            part = np.ix_(names == name, gradient == kind)
            size = np.abs(value[part]).max(initial=0.0)
            if size > 0.0:
                worst = max(worst, float(together[part].max() / size))
    return worst
