"""Names and units of the rows and columns of the optical matrices, in the order the matrices have them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from tedm_cli.optics.layout import Beam, Element, OpticalLayout

_OUTPUTS = {"x": "m", "y": "m", "opl": "m", "z1": "rad", "z2": "rad"}
_MOTIONS = {"ux": "m", "uy": "m", "uz": "m", "rx": "rad", "ry": "rad", "rz": "rad"}
_LASER = {"OPD": "m", "WFT1": "rad", "WFT2": "rad"}
_DOFS = {"x": "m", "y": "m", "z": "m", "theta": "rad", "eta": "rad", "phi": "rad"}


@dataclass(frozen=True)
class Labels:
    """Names along one axis of a matrix and the unit of each."""

    names: tuple[str, ...]
    units: tuple[str, ...]


def output_labels(layout: OpticalLayout, beams: Mapping[Beam, str] | None = None) -> Labels:
    """Rows of S_BW and columns of P, e.g. ``PD1A_meas_x``; `beams` gives the two beams other names."""
    return _product((f"{p.photodiode}_{beams[p.beam] if beams else p.beam}" for p in layout.paths), _OUTPUTS)


def input_labels(layout: OpticalLayout, elements: tuple[Element, ...] | None = None) -> Labels:
    """Columns of S_BW, e.g. ``TM1_ux``; of `elements` only, where given (O_ideal: the test masses)."""
    return _product((e.name for e in (layout.elements if elements is None else elements)), _MOTIONS)


def laser_labels(layout: OpticalLayout, photodiodes: tuple[str, ...] | None = None) -> Labels:
    """Rows of P, O_ideal and D, e.g. ``PD1A_OPD``; of `photodiodes` only, where given (the rows of one set)."""
    return _product(layout.photodiodes if photodiodes is None else photodiodes, _LASER)


def read_out_labels(layout: OpticalLayout) -> Labels:
    """Rows of N, e.g. ``TM1_eta``."""
    found = [(f"{e.name}_{dof}", _DOFS[dof]) for e in layout.test_masses for dof in layout.measured(e)]
    return Labels(tuple(name for name, _ in found), tuple(unit for _, unit in found))


def _product(owners: Iterable[str], quantities: dict[str, str]) -> Labels:
    owned = tuple(owners)
    return Labels(
        tuple(f"{owner}_{quantity}" for owner in owned for quantity in quantities),
        tuple(quantities.values()) * len(owned),
    )
