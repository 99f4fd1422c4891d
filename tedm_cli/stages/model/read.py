"""The model as its unit-load deck tells it, checked: all of unit_loads.h5 but displacements, and the way to these."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.areas.attributes import area_attributes
from tedm_cli.areas.configured import area_csv, configured_areas, defines_areas, require_agreement
from tedm_cli.areas.materials import judge_materials
from tedm_cli.areas.mean_step import MeanStep, mean_steps
from tedm_cli.areas.places import area_centroids, area_masses, area_points
from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.model.compensation import compensation_masses
from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.model.superelement import superelement_files
from tedm_cli.config.project import Project
from tedm_cli.config.symmetry_plane import ProjectPlane, project_plane
from tedm_cli.deck_units import DeckUnits
from tedm_cli.errors import ConfigError, PhysicsError
from tedm_cli.files.build_folder import provenance
from tedm_cli.files.provenance import ConfigFile, Provenance
from tedm_cli.gravity.mass_properties import MassProperties
from tedm_cli.nastran.displacements import Findings, unit_load_displacements
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.loads.unit_loads import UnitLoad, UnitLoads, deck_unit_loads
from tedm_cli.nastran.masses.audit import SampleCheck, check_sample
from tedm_cli.nastran.parameter_values import number_parameter
from tedm_cli.nastran.plausible import is_mass_tensor, light_elements
from tedm_cli.nastran.reading import deck_files, passed_over, read_deck
from tedm_cli.nastran.rigid import RigidLinks, check_rigidity, rigid_links
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.gravity.ties import Ties
from tedm_cli.stages.common import check_test_masses
from tedm_cli.stages.model.masses import check_grids_outside, check_weight_tables, properties_of, without_test_masses
from tedm_cli.stages.model.superelements import AreasElsewhere, Recovery, reduced_on, require_own_areas
from tedm_cli.stages.model.ties import ties_on


@dataclass(frozen=True)
class MassSummary:
    """Mass properties of the structure, what they were checked against, and the test masses' own parts of the model.

    weight_tables : files whose grid point weight table agrees; test_mass_kg : by test mass with parts in the model.
    """

    properties: MassProperties
    sample: SampleCheck
    weight_tables: list[Path]
    test_mass_kg: dict[str, float]


@dataclass(frozen=True, eq=False)
class DisplacementsOf:
    """What displacements of result files are read for, by themselves: no deck is needed, and it can be sent elsewhere.

    wanted : the unit loads, the uniform one last where there is one; `uniform` : whether there is. deck : for messages.
    """

    deck: Path
    geometry: ModelGeometry
    wanted: list[UnitLoad]
    uniform: bool
    subcases: Mapping[str, int]
    scalar_points: list[int]
    recoveries: list[Recovery]
    links: RigidLinks

    @property
    def areas(self) -> list[UnitLoad]:
        return self.wanted[:-1] if self.uniform else self.wanted

    def motions(
        self, results: Sequence[Path], findings: Findings, *, whole: bool = True
    ) -> Iterator[tuple[UnitLoad, FloatArray, FloatArray]]:
        """(unit load, translation [N,3] m, rotation [N,3] rad) as `unit_load_displacements`, of superelements too.

        Raises
        ------
        InputError : what that refuses. PhysicsError : motions that the rigid elements of the deck do not allow.
        """
        means = [load.label for load in self.areas if load.kind == "mean"]
        for load, t, r in unit_load_displacements(
            results, self.wanted, self.geometry, self.subcases, self.scalar_points, findings, whole=whole
        ):
            labels = means if self.uniform and load is self.wanted[-1] else [load.label]
            for recovery in self.recoveries:
                recovery.put_into(labels, load.load_K, t, r, single=findings.single)
            where = f"{self.deck}: subcase {load.subcase} (area '{load.label}')"
            check_rigidity(self.links, self.geometry.grid_id, t, r, where=where)
            yield load, t, r


@dataclass(frozen=True, eq=False)
class ModelRead:
    """The model of a project: geometry, masses, ties and areas; what `displacements` are read for; where it is from.

    trace : without results, which are not read yet.
    centroids, area_kg, members : by area, those of superelements among them. notes : remarks, those on units first.
    """

    config_file: ConfigFile
    config: ModelConfig
    plane: ProjectPlane
    units: DeckUnits
    geometry: ModelGeometry
    masses: MassSummary
    ties: Ties
    loads: UnitLoads
    table: AreaTable
    centroids: FloatArray
    area_kg: FloatArray
    members: list[IntArray]
    steps: list[MeanStep]
    displacements: DisplacementsOf
    trace: Provenance
    notes: list[str]

    @property
    def wanted(self) -> list[UnitLoad]:
        return self.displacements.wanted


def read_model(project: Project, results: Sequence[Path]) -> ModelRead:
    """Read the unit-load deck of a project and check it, also against what is beside its `results`.

    Raises
    ------
    ConfigError, InputError, PhysicsError : what is wrong with configuration, deck, masses or areas.
    """
    config_file, config = load_model(project.model)
    plane = project_plane(project, config)
    deck = project.resolve(config.model.deck)
    units = config.model.deck_units()
    model = read_deck(deck, allow_missing_enddata=config.model.allow_missing_enddata, units=units)
    files = deck_files(model, deck)
    listed = area_csv(project, config)
    given = superelement_files(project, config.superelement)
    trace = provenance([config_file], [*files, *([listed] if listed else []), *given])
    geometry, masses, whole = _masses(model, files, results, config, project.model)
    ties, tie_notes = ties_on(compensation_masses(project, config), config, model, whole)
    check_test_masses(config.test_masses(), geometry.position_m[geometry.lumped_kg > 0], where=str(project.model))
    check_grids_outside(config.test_masses(), geometry)
    reduced = reduced_on(project, config, geometry)
    elsewhere = AreasElsewhere.of([one.given for one in reduced])
    loads = deck_unit_loads(model, geometry, config.model.uniform_label, elsewhere.own if reduced else None)
    areas = loads.areas
    on = {a.label: a.area_load(geometry) for a in areas}
    elsewhere.require(on, str(deck))
    selected: dict[str, IntArray] = {}
    if defines_areas(config):
        defined = configured_areas(project, config, model, geometry)
        there = {name: load for name, load in on.items() if name.upper() not in elsewhere.own}
        require_own_areas(reduced, there, str(deck))
        require_agreement(defined, there, geometry, where=str(deck))
        labels = {a.label.upper(): a.label for a in areas}
        selected = {labels[name.upper()]: ids for name, ids in defined.selected.items()}
    wanted = [*areas, *([loads.uniform] if loads.uniform else [])]
    _check_subcase_table(config.model.subcases, [load.label for load in wanted], where=str(project.model))
    centroids = elsewhere.placed(on, area_centroids(geometry, on.values()))
    kinds = {a.label: a.kind for a in areas}
    return ModelRead(
        config_file=config_file,
        config=config,
        plane=plane,
        units=units,
        geometry=geometry,
        masses=masses,
        ties=ties,
        loads=loads,
        table=area_attributes(kinds, centroids, config.areas, plane.plane, where=str(project.model)),
        centroids=centroids,
        area_kg=elsewhere.weighed(on, area_masses(geometry, on.values())),
        members=list(elsewhere.members(areas, geometry.grid_id)),
        steps=mean_steps(geometry, on, selected),
        displacements=DisplacementsOf(
            deck=deck,
            geometry=geometry,
            wanted=wanted,
            uniform=loads.uniform is not None,
            subcases=config.model.subcases,
            scalar_points=sorted(model.spoints),
            recoveries=[Recovery.of(one, geometry) for one in reduced],
            links=rigid_links(model, geometry),
        ),
        trace=trace,
        notes=[
            *config.model.unit_notes(),
            *_scale_notes(wanted, units),
            *plane.notes(area_points(geometry, on.values())),
            *passed_over(model),
            *light_elements(geometry.elements),
            *judge_materials(model, geometry, on).lines,
            *tie_notes,
        ],
    )


def _masses(
    model: Any, files: list[Path], results: Sequence[Path], config: ModelConfig, where: Path
) -> tuple[ModelGeometry, MassSummary, ModelGeometry]:
    """Geometry and masses, checked against pyNastran and the solver, and then without the test masses' own parts; with
    them too."""
    whole = model_geometry(model, files)
    sample = check_sample(model, whole)
    wtmass = number_parameter(model, "WTMASS", 1.0, str(files[0]))
    tables = check_weight_tables(results, whole, wtmass)
    geometry, removed = without_test_masses(whole, config, where)
    properties = properties_of(geometry)
    if not is_mass_tensor(properties.inertia_kg_m2):
        values = ", ".join(f"{v:.4g}" for v in np.linalg.eigvalsh(properties.inertia_kg_m2))
        raise PhysicsError(
            f"no body can have its moments of inertia: {values} kg m2 about the principal axes",
            where=str(files[0]),
            hint="are concentrated or non-structural masses negative?",
        )
    names = [t.name for t in config.test_mass]
    parts = {name: kg for name, kg in zip(names, removed.tolist(), strict=True) if kg}
    return geometry, MassSummary(properties, sample, [t.file for t in tables], parts), whole


def _check_subcase_table(table: Mapping[str, int], labels: Sequence[str], *, where: str) -> None:
    """The explicit map of areas to subcases: every name is a unit load of the deck, every number is used once."""
    known = {label.upper() for label in labels}
    first: dict[int, str] = {}
    problems = []
    for area, number in table.items():
        path = f"model.subcases.{area}"
        if area.upper() not in known:
            near = difflib.get_close_matches(area.upper(), known, n=1)
            problems.append((path, "the deck has no such unit load" + (f"; did you mean {near[0]}?" if near else "")))
        if first.setdefault(number, path) != path:
            problems.append((path, f"subcase {number} is that of {first[number]} already"))
    if problems:
        raise ConfigError(problems, where=where)


def _scale_notes(loads: Sequence[UnitLoad], units: DeckUnits) -> list[str]:
    """A remark on steps that would be of 1 K in another scale: expansions may be per degree of it too."""
    steps = np.array([load.load_K for load in loads])
    per_kelvin = float(units.degrees_per_kelvin)
    if per_kelvin != 1.0 and np.allclose(per_kelvin * steps, 1.0, rtol=1e-9):
        return [
            f"every step is 1 {units.temperature} ({steps[0]:.3g} K): are the temperatures of the deck in kelvin? then"
            ' set temperature = "K"'
        ]
    if per_kelvin == 1.0 and np.allclose(steps, 1.8, rtol=1e-9):
        return [
            'every step is 1.8 K: are the temperatures of the deck in degrees Fahrenheit? then set temperature = "degF"'
        ]
    return []
