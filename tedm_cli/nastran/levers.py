"""Where the mass of an element or a CONM2 lies off its grids: bar and plate offsets, composites, offset masses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tedm_cli.errors import InputError

FloatArray = NDArray[np.float64]

_LEVEL = 1e-9  # of a laminate's thickness: rounding of its ply positions


def element_levers(
    element: Any, nodes: int, to_basic: Callable[[int, FloatArray], FloatArray], where: str
) -> FloatArray:
    """Offset of an element's mass from each of its first `nodes` grids, [nodes, 3], basic frame, m.

    Parameters
    ----------
    element : cross-referenced pyNastran element.
    to_basic : turns a vector [3] given in the displacement frame (CD) of a grid, by its id, into the basic frame.

    Raises
    ------
    InputError : an offset of a kind that is not read.
    """
    if element.type in ("CBAR", "CBEAM"):
        return _bar(element, to_basic, where)
    shift = _plate_shift(element)
    out = np.zeros((nodes, 3))
    if shift != 0.0:
        out[:] = shift * _normal(element)
    return out


def _bar(element: Any, to_basic: Callable[[int, FloatArray], FloatArray], where: str) -> FloatArray:
    prop = element.pid_ref
    if element.type == "CBEAM" and prop.type == "PBEAM":
        neutral = [prop.n1a, prop.n2a, prop.n1b, prop.n2b]
        loads = [prop.m1a, prop.m2a, prop.m1b, prop.m2b] if np.any(np.asarray(prop.nsm)) else []
        if any(value for value in [*neutral, *loads]):
            raise InputError(
                f"PBEAM {prop.pid}: mass off the shear centre (M1, M2, N1, N2) is not read",
                where=where,
                hint="give the beam's offset as WA and WB on its elements",
            )
    ends = np.array([element.wa, element.wb], dtype=float)
    if not ends.any():
        return ends
    code = str(element.offt) if element.offt is not None else "GGG"
    if code[1:] != "GG":
        raise InputError(
            f"{element.type} {element.eid}: offsets in the element's own frame (OFFT {code}) are not read",
            where=where,
            hint="give WA and WB in the displacement frames of its grids (OFFT GGG)",
        )
    return np.array([to_basic(int(grid), end) for grid, end in zip(element.node_ids, ends, strict=True)])


def _plate_shift(element: Any) -> float:
    """Distance of a plate's mass from its grids along its normal, m: ZOFFS, and where a laminate's mass lies."""
    shift = float(getattr(element, "zoffset", 0.0) or 0.0)
    prop = getattr(element, "pid_ref", None)
    if prop is None or prop.type not in ("PCOMP", "PCOMPG"):
        return shift
    level = np.asarray(prop.get_z_locations(), dtype=float)
    weight = np.array([prop.get_density(i) for i in range(len(level) - 1)]) * np.diff(level)
    if not weight.any():
        return shift
    centre = float(weight @ (level[1:] + level[:-1]) / 2.0 / weight.sum())
    return shift + (centre if abs(centre) > _LEVEL * float(np.ptp(level)) else 0.0)


def _normal(element: Any) -> FloatArray:
    corner = [np.asarray(node.get_position(), dtype=float) for node in element.nodes_ref if node is not None]
    four = not element.type.startswith("CTRIA")
    normal = (
        np.cross(corner[2] - corner[0], corner[3] - corner[1])
        if four
        else np.cross(corner[1] - corner[0], corner[2] - corner[0])
    )
    return np.asarray(normal / np.linalg.norm(normal))


def conm2_lever(mass: Any, where: str) -> FloatArray:
    """Offset of a CONM2 from its grid, [3], basic frame, m.

    Raises
    ------
    InputError : an offset in a cylindrical or spherical frame.
    """
    lever = np.array(mass.X, dtype=float)
    cid = int(mass.Cid())
    if cid == -1:
        return np.asarray(lever - np.asarray(mass.nid_ref.get_position(), dtype=float))
    if cid == 0 or not lever.any():
        return lever
    if mass.cid_ref.Type != "R":
        raise InputError(
            f"CONM2 {mass.eid}: an offset in the curvilinear frame {cid} is not read",
            where=where,
            hint="give the offset in a rectangular frame",
        )
    return np.asarray(lever @ np.array(mass.cid_ref.beta(), dtype=float))
