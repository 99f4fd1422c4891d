"""The paths of a layout through Optiland, an independent open ray tracer, surface by surface in the order of the steps.

Optiland works in millimetres and places a surface by its vertex and rotations about x, y, z in the fixed frame; its
optical path starts at zero. Only its geometry of planes, refraction and reflection is used.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from optiland.coordinate_system import CoordinateSystem
from optiland.geometries.plane import Plane
from optiland.interactions.refractive_reflective_model import RefractiveReflectiveModel
from optiland.materials import IdealMaterial
from optiland.rays import RealRays
from optiland.surfaces.standard_surface import Surface
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import BeamPath, Element, OpticalLayout

MM = 1e3


@dataclass(frozen=True)
class Placed:
    """An element after its motion: a rotation about its reference point, and the reference point."""

    element: Element
    rotation: Rotation
    ref: FloatArray

    def vector(self, v: Sequence[float] | FloatArray) -> FloatArray:
        return np.asarray(self.rotation.apply(v))

    def face(self, depth: float) -> CoordinateSystem:
        """Coordinates of the plane `depth` behind the front, their z axis along the normal."""
        normal = np.array(self.element.normal)
        vertex = self.ref + (self.element.front_offset_m - depth) * self.vector(normal)
        # x across z keeps the angle about y, where the three angles may degenerate, small
        x = np.cross(normal, [0.0, 0.0, 1.0] if abs(normal[2]) < 0.99 else [1.0, 0.0, 0.0])
        x /= np.linalg.norm(x)
        axes = self.rotation.as_matrix() @ np.stack([x, np.cross(normal, x), normal], axis=1)
        return CoordinateSystem(*(MM * vertex), *Rotation.from_matrix(axes).as_euler("xyz"))


def outputs(layout: OpticalLayout, motion: FloatArray) -> FloatArray:
    """x, y, opl (m), z1, z2 of all paths, [n_paths, 5], after the motions [n_elements, 6] (m, rad)."""
    placed = {
        e.name: Placed(e, Rotation.from_rotvec(m[3:]), np.array(e.ref_m) + m[:3])
        for e, m in zip(layout.elements, motion, strict=True)
    }
    return np.stack([_path_output(path, placed, layout.wavelength_m) for path in layout.paths])


def _path_output(path: BeamPath, placed: dict[str, Placed], wavelength_m: float) -> FloatArray:
    source = placed[path.steps[0].element]
    rays = RealRays(*(MM * source.ref), *source.vector(source.element.normal), 1.0, 1e6 * wavelength_m)
    last = Surface(None, IdealMaterial(1.0), Plane(CoordinateSystem()))
    direction = source.vector(source.element.normal)
    for step in path.steps[1:]:
        at = placed[step.element]
        glass = at.element.index
        from_front = direction @ at.vector(at.element.normal) < 0
        depths = (0.0, at.element.thickness_m)
        if step.op == "T":
            order = depths if from_front else depths[::-1]
            surfaces = [(order[0], glass, False), (order[1], 1.0, False)]
        elif step.op == "detect" or from_front:
            surfaces = [(0.0, 1.0, step.op == "R")]
        else:
            surfaces = [(depths[1], glass, False), (0.0, glass, True), (depths[1], 1.0, False)]
        for depth, behind, reflects in surfaces:
            model = RefractiveReflectiveModel(None, is_reflective=reflects)
            last = Surface(last, IdealMaterial(behind), Plane(at.face(depth)), interaction_model=model)
            last.trace(rays)
            direction = np.array([float(v[0]) for v in (rays.L, rays.M, rays.N)])
    ez, ey = at.vector(at.element.normal), at.vector(at.element.local_y or (0, 0, 0))
    ex = np.cross(ey, ez)
    spot = np.array([float(v[0]) for v in (rays.x, rays.y, rays.z)]) / MM - at.ref
    opl = source.element.opl_offset_m + float(rays.opd[0]) / MM
    return np.array([ex @ spot, ey @ spot, opl, ex @ direction, ey @ direction])
