"""Random valid layouts, built along their beams so that measurement and reference beam of every photodiode coincide.

The ray is followed by geometry of its own, written otherwise than in the package: Snell's law for the tangential part
of the direction. The reference beams are followed backwards from the photodiodes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from dataclasses import replace as changed

import numpy as np
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.optics.layout import Beam, BeamPath, Element, Operation, OpticalLayout, Recombination, Step, Vec3

X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def vector(v: FloatArray) -> Vec3:
    x, y, z = (float(c) for c in v)
    return x, y, z


def axis_rows(matrix: FloatArray) -> tuple[Vec3, Vec3, Vec3]:
    """A rotation as a layout keeps the axes of its frame."""
    x, y, z = (vector(row) for row in matrix)
    return x, y, z


def unit(v: FloatArray) -> FloatArray:
    return v / np.linalg.norm(v)


def angle(a: FloatArray, b: FloatArray) -> float:
    return float(np.degrees(np.arccos(np.clip(a @ b, -1, 1))))


@dataclass
class Ray:
    """A beam as far as it has been followed: place, direction, optical path, and the steps it took."""

    point: FloatArray
    direction: FloatArray
    path: float = 0.0
    steps: list[Step] = field(default_factory=list)

    def split(self) -> Ray:
        return Ray(self.point, self.direction, self.path, list(self.steps))

    def follow(self, e: Element, op: str) -> None:
        """Take one step through the element's faces, from whichever side the ray comes."""
        n, index = np.array(e.normal), e.index
        front = np.array(e.ref_m) + e.front_offset_m * n
        back = front - e.thickness_m * n
        if op == "detect":
            self._to(front, n, 1.0)
        elif op == "T":
            faces = (front, back) if self.direction @ n < 0 else (back, front)
            self._to(faces[0], n, 1.0)
            self._bend(n, 1 / index)
            self._to(faces[1], n, index)
            self._bend(n, index)
        elif self.direction @ n < 0:
            self._to(front, n, 1.0)
            self.direction = self.direction - 2 * (self.direction @ n) * n
        else:
            self._to(back, n, 1.0)
            self._bend(n, 1 / index)
            self._to(front, n, index)
            self.direction = self.direction - 2 * (self.direction @ n) * n
            self._to(back, n, index)
            self._bend(n, index)
        self.steps.append(Step(e.name, op))  # type: ignore[arg-type]

    def _to(self, plane: FloatArray, n: FloatArray, index: float) -> None:
        way = ((plane - self.point) @ n) / (self.direction @ n)
        assert way > 0, "the generator sent a ray backwards"
        self.point = self.point + way * self.direction
        self.path += float(index * way)

    def _bend(self, n: FloatArray, ratio: float) -> None:
        normal = (self.direction @ n) * n
        tangential = ratio * (self.direction - normal)
        self.direction = tangential + np.sqrt(1 - tangential @ tangential) * unit(normal)


class Builder:
    """One layout in the making; `planar` keeps all of it in the plane z = 0."""

    def __init__(self, seed: int, planar: bool) -> None:
        self.rng = np.random.default_rng(seed)
        self.planar = planar
        self.elements: list[Element] = []
        self.paths: list[BeamPath] = []

    def add(self, kind: str, name: str, **keys: object) -> Element:
        vectors = {k: tuple(map(float, v)) for k, v in keys.items() if isinstance(v, np.ndarray)}
        grid = None if kind == "test_mass" else 1000 + len(self.elements)
        element = Element(name=name, kind=kind, grid=grid, aperture_m=0.02, **(keys | vectors))  # type: ignore[arg-type]
        self.elements.append(element)
        return element

    def name(self, letters: str) -> str:
        return f"{letters}{sum(e.name.startswith(letters) for e in self.elements) + 1}"

    def tilted(self, axis: FloatArray, low: float, high: float) -> FloatArray:
        """A unit vector between `low` and `high` degrees from `axis`."""
        if self.planar:
            across = np.cross(Z, axis) * self.rng.choice([-1, 1])
        else:
            across = unit(np.cross(axis, self.rng.normal(size=3)))
        tilt = np.radians(self.rng.uniform(low, high))
        return unit(np.cos(tilt) * axis + np.sin(tilt) * across)

    def tangential(self, n: FloatArray) -> FloatArray:
        """Where the reference point lies beside the beam: some millimetres in the surface, in all directions."""
        v = self.rng.uniform(-3e-3, 3e-3, size=3) * ([1, 1, 0] if self.planar else [1, 1, 1])
        return v - (v @ n) * n

    def distance(self) -> float:
        return float(self.rng.uniform(0.06, 0.2))

    def mirror_to(self, ray: Ray, direction: FloatArray, distance: float) -> None:
        n = unit(direction - ray.direction)
        offset = self.rng.uniform(0, 4e-3)
        ref = ray.point + distance * ray.direction - offset * n + self.tangential(n)
        ray.follow(self.add("mirror", self.name("M"), ref_m=ref, normal=n, front_offset_m=offset), "R")

    def mirror(self, ray: Ray) -> None:
        n = self.tilted(-ray.direction, 15, 50)
        self.mirror_to(ray, ray.direction - 2 * (ray.direction @ n) * n, self.distance())

    def plate(self, ray: Ray, letters: str, kind: str = "beamsplitter") -> Element:
        """A plate whose first face the ray meets after some distance, from the front or from the back."""
        n = self.tilted(-ray.direction, 15, 50)
        thickness, offset = self.rng.uniform(2e-3, 8e-3), self.rng.uniform(0, 4e-3)
        hit = ray.point + self.distance() * ray.direction
        if self.rng.random() < 0.5:
            ref = hit - offset * n
        else:
            n = -n
            ref = hit - (offset - thickness) * n
        glass = {"thickness_m": thickness, "index": self.rng.uniform(1.3, 2.0), "front_offset_m": offset}
        return self.add(kind, self.name(letters), ref_m=ref + self.tangential(n), normal=n, **glass)

    def visit(self, ray: Ray, mass: Element, window: Element) -> None:
        """Two mirrors send the ray to some point of the mass's face, through its window and back."""
        n = np.array(mass.normal)
        target = np.array(mass.ref_m) + mass.front_offset_m * n + self.tangential(n)
        for attempt in range(1, 1000):
            arriving, turn_at = -self.tilted(n, 2, 12), ray.point + self.distance() * ray.direction
            last = target - self.rng.uniform(0.1, 0.2) * arriving
            way = unit(last - turn_at)
            if all(40 < a < 140 for a in (angle(ray.direction, way), angle(way, arriving))):
                break
            if attempt % 10 == 0:
                self.mirror(ray)  # look from elsewhere
        else:
            raise AssertionError("no way to the test mass")
        self.mirror_to(ray, way, float(np.linalg.norm(turn_at - ray.point)))
        self.mirror_to(ray, arriving, float((last - ray.point) @ ray.direction))
        for element, op in ((window, "T"), (mass, "R"), (window, "T")):
            ray.follow(element, op)

    def photodiode(self, ray: Ray, name: str) -> Element:
        n = -ray.direction
        y = Z if self.planar else unit(np.cross(n, self.rng.normal(size=3)))
        ref = ray.point + self.distance() * ray.direction + 0.1 * self.tangential(n)
        return self.add(
            "photodiode", name, ref_m=ref, normal=n, local_y=y, recombination=Recombination(1e-9, 1e-9, 1e-9)
        )

    def interferometer(self, ray: Ray, number: int) -> None:
        """Recombiner, two photodiodes, and a reference beam of its own from the photodiodes back to its injector."""
        self.mirror(ray)
        recombiner = self.plate(ray, "RC")
        beams = {"A": ray.split(), "B": ray.split()}
        for letter, op in (("A", "T"), ("B", "R")):
            beams[letter].follow(recombiner, op)
            beams[letter].follow(self.photodiode(beams[letter], f"PD{number}{letter}"), "detect")
        back = Ray(beams["A"].point, -beams["A"].direction)
        back.follow(recombiner, "R")
        for _ in range(self.rng.integers(1, 3)):
            self.mirror(back)
        back.follow(self.plate(back, "BS"), "T")
        way = self.distance()
        offset = beams["A"].path - back.path - way
        source = back.point + way * back.direction
        injector = self.add("injector", f"FR{number}", ref_m=source, normal=-back.direction, opl_offset_m=offset)
        turns: tuple[tuple[str, Operation], ...] = (("A", "R"), ("B", "T"))
        for letter, op in turns:
            name = f"PD{number}{letter}"
            self._path(name, "meas", beams[letter].steps)
            between = [changed(s, op=op) if s.element == recombiner.name else s for s in reversed(back.steps)]
            self._path(name, "ref", [Step(injector.name, "emit"), *between, Step(name, "detect")])

    def _path(self, photodiode: str, beam: Beam, steps: list[Step]) -> None:
        self.paths.append(BeamPath(photodiode, beam, tuple(steps)))

    def masses(self, number: int) -> list[tuple[Element, Element]]:
        """Test masses along a rough line, faces along x either way, each with a window parallel to its face."""
        out = []
        for i in range(number):
            place = np.array([0.4 * i, *self.rng.uniform(-0.1, 0.1, size=2)]) * ([1, 1, 0] if self.planar else 1)
            n = X * (1.0 if i == 0 else self.rng.choice([-1.0, 1.0]))
            mass = self.add("test_mass", f"TM{i + 1}", ref_m=place, normal=n, front_offset_m=0.023)
            glass = {"thickness_m": self.rng.uniform(3e-3, 8e-3), "index": self.rng.uniform(1.4, 1.8)}
            ref = place + 0.05 * n + self.tangential(n)
            out.append((mass, self.add("window", f"W{i + 1}", ref_m=ref, normal=n, front_offset_m=0.003, **glass)))
        return out


def random_layout(
    seed: int, n_masses: int, *, planar: bool = False, sets: tuple[str, ...] = ("A", "B")
) -> OpticalLayout:
    """A layout with an interferometer per test mass; the last of several measures its mass against the first."""
    builder = Builder(seed, planar)
    masses = builder.masses(n_masses)
    start = builder.rng.uniform(-0.3, 0.3, size=3) * ([1, 1, 0] if planar else 1)
    main = Ray(start, builder.tilted(X, 20, 160))
    main.steps.append(Step(builder.add("injector", "FM", ref_m=main.point, normal=main.direction).name, "emit"))
    for number, (mass, window) in enumerate(masses, start=1):
        ray = main
        if number < n_masses:
            splitter = builder.plate(main, "BS")
            ray = main.split()
            ray.follow(splitter, "R")
            main.follow(splitter, "T")
        if number == n_masses > 1:
            builder.visit(ray, *masses[0])
        builder.visit(ray, mass, window)
        builder.interferometer(ray, number)
    diodes = [f"PD{i + 1}" for i in range(n_masses)]
    return OpticalLayout(
        title=f"random {seed}",
        wavelength_m=1.064e-6,
        elements=tuple(builder.elements),
        paths=tuple(builder.paths),
        sets={letter: tuple(d + letter for d in diodes) for letter in sets},
        read_out=("x", "eta", "phi"),
    )


def with_tilted_photodiodes(layout: OpticalLayout, seed: int) -> OpticalLayout:
    """The layout with every photodiode turned about its reference point by 10 to 40 degrees; a planar one stays so."""
    rng = np.random.default_rng(seed)
    planar = all(e.ref_m[2] == 0 == e.normal[2] for e in layout.elements)
    elements = []
    for e in layout.elements:
        if e.kind == "photodiode":
            axis = Z * rng.choice([-1, 1]) if planar else unit(np.cross(e.normal, rng.normal(size=3)))
            turn = Rotation.from_rotvec(np.radians(rng.uniform(10, 40)) * axis)
            e = changed(e, normal=tuple(turn.apply(e.normal)), local_y=tuple(turn.apply(e.local_y)))
        elements.append(e)
    return changed(layout, elements=tuple(elements))
