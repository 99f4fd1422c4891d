"""Every number that users give has both bounds, and what is within them gives finite results."""

from __future__ import annotations

import copy
import math
import tomllib
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Union, get_args, get_origin

import numpy as np
import pytest
from annotated_types import Ge, Gt, Le, Lt
from border_tools import CONFIGS, Project, replace
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel

from tedm_cli import quantities
from tedm_cli.config.base import Bounded, Strict, load, validate
from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.dynamics.loop import DynamicsConfig
from tedm_cli.config.imported import LawTable, SensitivityTable
from tedm_cli.config.loads import LoadsConfig
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.optics.tables import OpticsTables
from tedm_cli.config.project import ProjectTable
from tedm_cli.config.thermal.file import ThermalConfig
from tedm_cli.contracts import KINDS, Dataset, FileKind
from tedm_cli.errors import ConfigError, PhysicsError
from tedm_cli.files.provenance import Provenance
from tedm_cli.files.store import create
from tedm_cli.quantities import Quantity

EXTREME = (1e308, -1e308, 1e-300, 5e-324, math.inf, -math.inf, math.nan, 10**30, -(10**30), 10**400, 2**63)
QUANTITIES = [q for q in vars(quantities).values() if isinstance(q, Quantity)]


def all_tables(base: type[BaseModel] = Strict) -> Iterator[type[BaseModel]]:
    for table in base.__subclasses__():
        yield table
        yield from all_tables(table)


def numbers(annotation: Any, metadata: tuple[Any, ...] = ()) -> Iterator[tuple[type, tuple[Any, ...]]]:
    """(int or float, what is said of it) of every number in an annotation, however deep."""
    if get_origin(annotation) is Annotated:
        inner, *more = get_args(annotation)
        yield from numbers(inner, (*metadata, *more))
    elif annotation in (int, float):
        yield annotation, metadata
    elif get_origin(annotation) in (Union, types.UnionType):
        for part in get_args(annotation):
            yield from numbers(part, metadata)
    else:
        for part in get_args(annotation):
            if not isinstance(part, str):
                yield from numbers(part)


def field_numbers() -> list[tuple[str, type, tuple[Any, ...]]]:
    found = []
    for table in dict.fromkeys(all_tables()):
        for name, field in table.model_fields.items():
            annotation = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
            found += [(f"{table.__name__}.{name}", kind, said) for kind, said in numbers(annotation)]
    return found


def bounds(said: tuple[Any, ...]) -> tuple[float, float]:
    low: list[Any] = [m.quantity.low for m in said if isinstance(m, Bounded)]
    low += [m.ge for m in said if isinstance(m, Ge)] + [m.gt for m in said if isinstance(m, Gt)]
    high: list[Any] = [m.quantity.high for m in said if isinstance(m, Bounded)]
    high += [m.le for m in said if isinstance(m, Le)] + [m.lt for m in said if isinstance(m, Lt)]
    return max(low, default=-math.inf), min(high, default=math.inf)


def test_every_number_of_every_table_has_both_bounds() -> None:
    found = field_numbers()
    assert len(found) > 50
    open_ended = [name for name, _, said in found if not all(map(math.isfinite, bounds(said)))]
    assert not open_ended, "give them a quantity of tedm_cli/quantities.py"


def test_the_search_for_numbers_finds_one_without_bounds() -> None:
    class _Table(Strict):
        bare: dict[str, list[float] | None] | None = None

    (found,) = [said for name, _, said in field_numbers() if name == "_Table.bare"]
    assert bounds(found) == (-math.inf, math.inf)
    Strict.__subclasses__().remove(_Table)
    del _Table


@pytest.mark.parametrize("quantity", QUANTITIES, ids=lambda q: f"{q.name}-{q.unit}-{q.high:g}".replace("/", "_"))
def test_a_quantity_says_name_value_bounds_and_unit(quantity: Quantity) -> None:
    assert quantity.low < quantity.high
    assert not quantity.fact(quantity.low)
    assert not quantity.fact(quantity.high)
    for value in EXTREME:
        fact = quantity.fact(value)
        if quantity.low <= value <= quantity.high:
            continue
        assert fact.startswith(f"{quantity.name} ")
        assert "outside" in fact
        assert fact.endswith(quantity.unit)
        assert len(fact) < 130
    numbers = np.array([quantity.low, quantity.high, float(quantity.high)])
    assert quantity.first_outside(numbers) is None
    for value in (math.nan, math.inf, -math.inf, 2 * abs(quantity.high) + 1):
        numbers[1] = value
        assert quantity.first_outside(numbers) == (1,)


@given(st.sampled_from(QUANTITIES), st.floats())
def test_one_number_and_an_array_are_judged_alike(quantity: Quantity, value: float) -> None:
    assert bool(quantity.fact(value)) == (quantity.first_outside(np.array([value])) is not None)


FULL: dict[str, tuple[type[Strict], dict[str, Any]]] = {
    "model": (
        ModelConfig,
        tomllib.loads(
            """
            [model]
            reference_temperature_K = 293.15
            constraints_of_subcase = 1
            subcases = { A = 1 }
            [areas]
            mid_half_width_m = 0.001
            rule = [{ match = "*", group = "g", shield = "inside" }]
            [[areas.define]]
            name = "A"
            set = 1
            property = [1, 2]
            [[areas.define]]
            name = "B"
            box = { frame = 0, x_m = [0.0, 1.0], theta_deg = [0.0, 90.0] }
            [[test_mass]]
            name = "TM1"
            position_m = [0.1, 0.2, 0.3]
            side_m = 0.046
            mass_kg = 1.96
            axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            model_parts = { elements = [1], properties = [1], grids = [1] }
            [[test_mass]]
            name = "TM2"
            position_m = [0.4, 0.2, 0.3]
            side_m = [0.046, 0.05, 0.04]
            chamfer_m = 0.002
            density_kg_m3 = 19800.0
            pocket = [
                { face = "+z", centre_m = [0.001, 0.002], diameter_m = 0.01, depth_m = 0.003 },
                { face = "-x", size_m = [0.01, 0.02], depth_m = 0.003 },
            ]
            [[test_mass]]
            name = "TM3"
            position_m = [0.7, 0.2, 0.3]
            shape = "cylinder"
            radius_m = 0.02
            inner_radius_m = 0.01
            height_m = 0.05
            axis = [0.0, 1.0, 0.0]
            mass_kg = 1.0
            [gravity]
            gravitational_constant_m3_kg_s2 = 6.6743e-11
            quadrature_tolerance = 1e-4
            other_test_mass_points = 8
            compensation_tolerance = 1e-9
            [[compensation_mass]]
            name = "C"
            centre_m = [1.0, 1.0, 1.0]
            size_m = [0.1, 0.1, 0.1]
            density_kg_m3 = 19300.0
            rotation_rad = [0.1, 0.2, 0.3]
            [[compensation_mass]]
            name = "D"
            centre_m = [1.0, 1.0, 1.0]
            size_m = 0.1
            mass_kg = 0.5
            """
        ),
    ),
    "dynamics": (
        DynamicsConfig,
        tomllib.loads(
            """
            [spacecraft]
            mass_kg = 422.7
            inertia_kg_m2 = [202.5, 209.7, 191.7]
            centre_of_mass_m = [0.0, 0.0, 0.1]
            [stiffness.electrostatic]
            TM1 = [1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6]
            TM2 = [1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-6]
            [controller]
            shape = { integral = 15.0, lead = 3.5, roll_off = 10.0 }
            [[controller.loop]]
            name = "x12"
            crossover_hz = 1e-3
            delay_s = 0.4
            [[controller.loop]]
            name = "TM1_x"
            numerator = [1.0, 2.0]
            denominator = [1.0, 2.0, 3.0]
            [noise]
            actuation_stability = 5e-6
            [[noise.source]]
            name = "own"
            level = 1e-12
            corner_hz = 1e-3
            slope = 1.0
            gains = { n_TM1_x = 1.0 }
            [[noise.thruster]]
            level = 1e-7
            position_m = [1.0, 0.0, 0.0]
            direction = [0.0, 1.0, 0.0]
            [time]
            rate_hz = 0.5
            samples = 10000
            seed = 1
            """
        ),
    ),
    "cases": (
        CasesConfig,
        tomllib.loads(
            """
            safety_factor = 2.0
            [temperature]
            outside_K = 1e-3
            inside_K = 1e-4
            reference_hz = 1e-3
            order = 2
            corner_hz = 1e-3
            [[temperature.override]]
            areas = ["A"]
            level_K = 1e-3
            [frequency]
            min_hz = 1e-4
            max_hz = 0.1
            points = 10
            [realisation]
            seed = 1
            rate_hz = 0.5
            lowest_hz = 1e-3
            confidence = 0.9
            samples = 10000000
            [[series]]
            name = "s"
            file = "s.csv"
            remove = "mean"
            resample_s = 1.0
            method = "linear"
            max_gap_s = 3.0
            lowest_hz = 1e-3
            confidence = 0.9
            [[requirement]]
            name = "r"
            table = "r.csv"
            quantity = "acceleration"
            outputs = ["TM1_a_x"]
            band_hz = [1e-3, 1e-2]
            [[case]]
            id = "1"
            title = "t"
            blocks = [{ areas = ["*"], rho = 0.5 }]
            delays = [{ areas = ["A"], delay_s = 1.0 }]
            """
        ),
    ),
    "loads": (LoadsConfig, tomllib.loads((CONFIGS / "loads.toml").read_text(encoding="utf-8"))),
    "thermal": (
        ThermalConfig,
        tomllib.loads(
            """
            [network]
            tmd = "model.TMD"
            time_s = 10.0
            [frequency]
            list_hz = [1e-4, 1e-3]
            [[disturbance]]
            name = "sun"
            nodes = ["A", "B"]
            kind = "power"
            weights = [0.4, 0.6]
            preset = "thesis"
            level_W = 1e-3
            reference_hz = 1e-3
            order = 1
            corner_hz = 1e-3
            [[disturbance]]
            name = "panel"
            nodes = ["C"]
            kind = "temperature"
            preset = "white"
            level_K = 1e-3
            [[correlation]]
            disturbances = ["sun", "panel"]
            rho = 0.5
            """
        ),
    ),
    "optics": (OpticsTables, tomllib.loads((CONFIGS / "optics.toml").read_text())),
}


def number_places(data: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if isinstance(data, bool):
        return
    if isinstance(data, int | float):
        yield at
    for key, inner in data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ():
        yield from number_places(inner, (*at, key))


PLACES = [(name, place) for name, (_, data) in FULL.items() for place in number_places(data)]


def dotted(place: tuple[Any, ...]) -> str:
    return "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in place).removeprefix(".")


@settings(max_examples=400, deadline=None)
@given(st.sampled_from(PLACES), st.sampled_from(EXTREME))
def test_extreme_numbers_are_refused_by_name_or_harmless(where: tuple[str, tuple[Any, ...]], value: float) -> None:
    """What is not refused is what bounds let pass: nearly nothing in place of a coordinate or an angle, an open end."""
    name, place = where
    table, data = FULL[name]
    changed = copy.deepcopy(data)
    inner = changed
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    path, reported = dotted(place), set[str]()
    try:
        validate(table, changed, where="x.toml")
    except ConfigError as exc:
        reported = {at for at, _ in exc.problems}
    assert reported <= {path, *(dotted(place[:n]) for n in range(len(place)))}
    if not reported:
        is_end = math.isinf(value) and "box" in place
        assert abs(value) < 1e-200 or is_end, (path, value)


@pytest.mark.parametrize("name", ["model", "cases", "optics"])
def test_the_shipped_configuration_is_within_the_bounds(name: str) -> None:
    load(FULL[name][0], CONFIGS / f"{name}.toml")
    validate(*FULL[name], where="full.toml")


MISSIONS = [
    ("a levitated sphere", {"side_m": 1e-6, "mass_kg": 2e-15}),
    ("LISA", {"side_m": 0.046, "mass_kg": 1.928}),
    ("TianQin", {"side_m": 0.05, "mass_kg": 2.45}),
    ("GRACE", {"side_m": [0.04, 0.04, 0.01], "mass_kg": 0.072}),
    ("a torsion balance", {"side_m": 0.3, "mass_kg": 70.0}),
]


@pytest.mark.parametrize(("mission", "keys"), MISSIONS)
def test_test_masses_that_exist_are_not_refused(mission: str, keys: dict[str, Any]) -> None:
    table, data = FULL["model"]
    changed = copy.deepcopy(data)
    changed["test_mass"][0] |= keys
    validate(table, changed, where=mission)


def test_tables_that_declare_matrices_are_searched_as_well() -> None:
    assert {LawTable, SensitivityTable, ProjectTable} <= set(all_tables())


@pytest.mark.parametrize(
    ("file", "old", "new", "fact"),
    [
        (
            "cases.toml",
            "outside_K = 1e-3",
            "outside_K = 1e308",
            "temperature.outside_K: temperature level 1e+308 is outside",
        ),
        (
            "cases.toml",
            "corner_hz = 1e-3",
            "corner_hz = 1e-300",
            "temperature.corner_hz: frequency 1e-300 is outside 1e-09",
        ),
        (
            "cases.toml",
            "safety_factor = 2.0",
            "safety_factor = 1e308",
            "safety_factor: safety factor 1e+308 is outside",
        ),
        ("cases.toml", "order = 2", "order = 12", "temperature.order: order 12 beyond 1e-09 Hz falls by 168 decades"),
    ],
)
def test_noise_of_implausible_numbers_is_refused(small: Project, file: str, old: str, new: str, fact: str) -> None:
    if new == "order = 12":
        replace(small.folder / file, "corner_hz = 1e-3", "corner_hz = 1e-9")
        replace(small.folder / file, "max_hz = 0.1", "max_hz = 1e5")
    replace(small.folder / file, old, new)
    small.run("run-case", "3").refused(3, fact)


# --- the last line of defence ----------------------------------------------------------------------------------------


def _write(path: Path, kind: FileKind, numbers: np.ndarray, in_blocks: bool = False) -> None:
    with create(path, kind, Provenance((), (), "test")) as writer:
        if in_blocks:
            writer.allocate("/a", (3,))[:] = numbers
        else:
            writer.write("/a", numbers)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_no_file_is_written_with_numbers_that_are_not_finite(tmp_path: Path, value: float) -> None:
    """Whole datasets and those filled in blocks; the file that was there stays as it was."""
    kind = FileKind("test", 1, "test", {"/a": Dataset("/a", ("n",), "float", "m", "lengths")})
    open_kind = FileKind("test", 1, "test", {"/a": Dataset("/a", ("n",), "float", "m", "NaN: none", open_ended=True)})
    path, numbers = tmp_path / "test.h5", np.array([1.0, 2.0, 3.0])
    _write(path, kind, numbers)
    before, numbers[1] = path.read_bytes(), value
    for in_blocks in (False, True):
        with pytest.raises(PhysicsError, match="1 of 3 numbers are not finite") as caught:
            _write(path, kind, numbers, in_blocks)
        assert caught.value.where == str(path)
        assert path.read_bytes() == before
        assert list(tmp_path.iterdir()) == [path]
    _write(path, open_kind, numbers)
    assert path.read_bytes() != before


def test_the_meaning_of_what_may_be_no_number_is_said() -> None:
    named = {path: d.long_name for kind in KINDS.values() for path, d in kind.datasets.items() if d.open_ended}
    assert named
    assert all("nan" in text.lower() or "infinite" in text for text in named.values()), named
