"""What the glass of plates does to the beams: against complex steps, formulas by hand, and sums that must cancel."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tedm_cli.arrays import FloatArray
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.optics.chain import optics_chain
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.layout import Beam, BeamPath, Element, OpticalLayout, Step
from tedm_cli.optics.plates import INDEX, THICKNESS, PlateEffect, plate_effect, plate_sensitivity
from tedm_cli.optics.sensitivity import optical_sensitivity
from tedm_cli.optics.trace import trace

STEP = 1e-30
GLASS = ("W1", "W2", "BS1", "BS2", "BS3", "BS4", "BS5", "BS6", "BS7", "BS8")


def plates_of(layout: OpticalLayout) -> tuple[Element, ...]:
    return tuple(e for e in layout.elements if e.thickness_m > 0.0)


def with_element(layout: OpticalLayout, name: str, **changes: Any) -> OpticalLayout:
    return replace(layout, elements=tuple(replace(e, **changes) if e.name == name else e for e in layout.elements))


def stepped(layout: OpticalLayout, plate: Element, what: int, step: complex) -> OpticalLayout:
    """With another index, or another thickness about the middle plane, of one plate."""
    if what == INDEX:
        return with_element(layout, plate.name, index=plate.index + step)
    return with_element(
        layout,
        plate.name,
        thickness_m=plate.thickness_m + step,
        front_offset_m=plate.front_offset_m + step / 2,
    )


def by_complex_step(layout: OpticalLayout, plates: tuple[Element, ...]) -> FloatArray:
    columns = [
        [np.imag(trace(stepped(layout, plate, what, 1j * STEP))).reshape(-1) / STEP for what in (INDEX, THICKNESS)]
        for plate in plates
    ]
    return np.moveaxis(np.array(columns), 2, 0)


def test_every_entry_agrees_with_a_complex_step(layout: OpticalLayout) -> None:
    plates = plates_of(layout)
    assert tuple(p.name for p in plates) == GLASS
    S = plate_sensitivity(layout, plates)
    assert np.abs(S - by_complex_step(layout, plates)).max() < 1e-14
    assert np.abs(S).max() > 0.01  # metres of glass per unit of index


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1))
def test_derivatives_hold_for_beams_that_do_not_recombine(layout: OpticalLayout, seed: int) -> None:
    """Glasses of any kind, elements turned by degrees, a plate met from behind, an index of one."""
    rng = np.random.default_rng(seed)
    elements = []
    for e in layout.elements:
        normal = np.array(e.normal) + (rng.normal(scale=0.003, size=3) if e.kind != "photodiode" else 0.0)
        glass: dict[str, Any] = (
            {"index": rng.uniform(1.3, 2.0), "thickness_m": rng.uniform(2e-3, 8e-3)} if e.thickness_m else {}
        )
        elements.append(replace(e, **glass, normal=tuple(normal / np.linalg.norm(normal))))
    other = with_element(replace(layout, elements=tuple(elements)), "BS3", index=1.0)
    plates = plates_of(other)
    assert np.abs(plate_sensitivity(other, plates) - by_complex_step(other, plates)).max() < 1e-12


def bench(*plates: Element, meas: tuple[str, ...], ref: tuple[str, ...]) -> OpticalLayout:
    """Two beams along x from one place to one photodiode, through plates; one test mass, which none meets."""
    ends = (
        Element("F1", "injector", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        Element("F2", "injector", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        Element("PD", "photodiode", (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), local_y=(0.0, 0.0, 1.0)),
        Element("TM", "test_mass", (2.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
    )
    through: dict[Beam, tuple[str, tuple[str, ...]]] = {"meas": ("F1", meas), "ref": ("F2", ref)}
    paths = tuple(
        BeamPath("PD", beam, (Step(source, "emit"), *(Step(name, "T") for name in names), Step("PD", "detect")))
        for beam, (source, names) in through.items()
    )
    return OpticalLayout("by hand", 1e-6, (*ends, *plates), paths, {"A": ("PD",)}, ("x",))


def plate(name: str, at: float, angle: float = 0.0, index: float = 1.5, thickness: float = 0.006) -> Element:
    normal = (-math.cos(angle), 0.0, math.sin(angle))
    return Element(name, "window", (at, 0.0, 0.0), normal, thickness / 2, thickness, index)


def test_normal_incidence_is_the_formula_of_the_textbooks() -> None:
    n, t = 1.607, 0.006
    layout = bench(plate("W", 0.4, index=n, thickness=t), meas=("W",), ref=())
    S = plate_sensitivity(layout, (layout.elements[layout.index("W")],)).reshape(2, 5, 2)
    wanted = np.zeros((5, 2))
    wanted[2] = t, n - 1.0
    assert np.abs(S[0] - wanted).max() < 1e-15
    assert not S[1].any()  # the other beam does not know of it


@pytest.mark.parametrize("degrees", [-50.0, 10.0, 45.0])
def test_slanted_plates_shift_the_beam_as_by_hand(degrees: float) -> None:
    """Shift across the beam t sin (1 - cos / r), path t (r - cos) with r = sqrt(n² - sin²); slopes never change."""
    n, t, a = 1.4496, 0.005, math.radians(degrees)
    layout = bench(plate("BS", 0.4, a, n, t), meas=("BS",), ref=())
    S = plate_sensitivity(layout, (layout.elements[layout.index("BS")],)).reshape(2, 5, 2)[0]
    r = math.sqrt(n**2 - math.sin(a) ** 2)
    assert S[2] == pytest.approx([t * n / r, r - math.cos(a)], rel=1e-12)
    across = [t * math.sin(a) * math.cos(a) * n / r**3, math.sin(a) * (1.0 - math.cos(a) / r)]
    spot = S[1]  # local_y is z, in whose direction the plate leans
    assert np.abs(S[0]).max() < 1e-15
    assert np.abs(spot) == pytest.approx(np.abs(across), rel=1e-12)
    assert np.sign(spot[0]) == np.sign(spot[1])
    assert np.abs(S[3:]).max() < 1e-15


def test_arms_that_pass_equal_glass_read_nothing() -> None:
    """However the plates stand, and at other places: one temperature of them all is no read-out."""
    layout = bench(
        plate("A1", 0.2, 0.7), plate("A2", 0.6, -0.3), plate("B1", 0.3, -0.3), plate("B2", 0.8, 0.7),
        meas=("A1", "A2"), ref=("B1", "B2"),
    )  # fmt: skip
    plates = plates_of(layout)
    S = plate_sensitivity(layout, plates)
    P = law_matrix(layout)
    per_kelvin = np.array([8.3e-6, 5.2e-7 * 0.006])
    laser = P @ np.einsum("rpc,c->r", S, per_kelvin)
    alone = np.abs(np.einsum("lr,rpc,c->lp", P, S, per_kelvin))
    assert alone[0].min() > 3e-8
    assert np.abs(laser).max() < 1e-15 * 3e-2
    one_arm = replace(layout, paths=(layout.paths[0], replace(layout.paths[1], steps=layout.paths[1].steps[::3])))
    assert abs((P @ np.einsum("rpc,c->r", plate_sensitivity(one_arm, plates), per_kelvin))[0]) > 3e-8


def effect(layout: OpticalLayout, n_areas: int = 3) -> tuple[OpticalLayout, PlateEffect]:
    areas = [f"a{i}" for i in range(n_areas)]
    glass = {name: areas[i % n_areas] for i, name in enumerate(GLASS)}
    warm = replace(
        layout,
        elements=tuple(
            replace(e, dn_dT_per_K=8.3e-6, expansion_per_K=5.2e-7, area=glass[e.name]) if e.name in glass else e
            for e in layout.elements
        ),
    )
    found = plate_effect(warm, areas, (), {})
    assert found is not None
    return warm, found


def test_parts_sum_to_the_read_out_and_the_laser_to_it(layout: OpticalLayout, S_BW: FloatArray) -> None:
    rng = np.random.default_rng(3)
    warm, plates = effect(layout)
    D_opt = 1e-9 * rng.normal(size=(3, len(layout.bench), 6))
    chain = optics_chain(warm, S_BW, D_opt, plates=plates)
    still = optics_chain(layout, S_BW, D_opt)
    for s, before in zip(chain.sets, still.sets, strict=True):
        assert np.abs(s.N_rigid + s.N_distortion + s.N_plates - s.N).max() < 1e-13 * np.abs(s.N).max()
        assert np.abs(s.N - s.inverse @ chain.D).max() < 1e-12 * np.abs(s.N).max()
        assert np.abs(s.N_distortion - before.N_distortion).max() < 1e-14 * np.abs(s.N).max()
        assert np.array_equal(s.N_rigid, before.N_rigid)
        assert np.abs(s.N_plates).max() > 1e-9
        assert not before.N_plates.any()


def test_windows_are_read_along_x_by_their_path_alone(layout: OpticalLayout) -> None:
    """Both passes count, and the read-out is less by the two cosines of the angle on the test mass: 2 / 1.9938.

    The windows stand parallel to their test mass, and the beam of X12 passes both; each is read on its own test mass.
    """
    n, t, dn, alpha = 1.607, 0.006, -5.46e-6, 1.01e-5
    warm = layout
    for i, name in enumerate(("W1", "W2")):
        warm = with_element(warm, name, dn_dT_per_K=dn, expansion_per_K=alpha, area=f"a{i}")
    plates = plate_effect(warm, ["a0", "a1"], (), {})
    chain = optics_chain(warm, optical_sensitivity(layout), np.zeros((2, 22, 6)), plates=plates)
    angle = math.asin(math.sin(math.radians(4.5)) / n)
    passed = t * dn / math.cos(angle) + alpha * t * (n * math.cos(angle) - math.cos(math.radians(4.5)))
    for s in chain.sets:
        by = dict(zip(("TM1_x", "TM1_eta", "TM1_phi", "TM2_x", "TM2_eta", "TM2_phi"), s.N_plates, strict=True))
        assert by["TM1_x"] == pytest.approx([-passed / math.cos(math.radians(4.5)), 0.0], rel=1e-9, abs=1e-20)
        assert by["TM2_x"] == pytest.approx([0.0, passed / math.cos(math.radians(4.5))], rel=1e-9, abs=1e-20)
        assert max(np.abs(by[k]).max() for k in by if not k.endswith("_x")) < 1e-18


@pytest.mark.parametrize(
    ("changes", "of_grid", "fact"),
    [
        ({"area": None}, (), "the plate W1 is not known: its grid 900003 is in no thermal area"),
        ({"area": None}, ("a0", "a1"), "its grid 900003 is in several thermal areas (a0, a1)"),
        ({"area": "a9"}, (), "follows the thermal area 'a9', which does not exist"),
        ({"area": "g"}, (), "follows 'g', which is a gradient in K/m"),
    ],
)
def test_temperatures_that_are_not_known(
    layout: OpticalLayout, changes: dict[str, Any], of_grid: tuple[str, ...], fact: str
) -> None:
    warm = with_element(layout, "W1", dn_dT_per_K=1e-6, **changes)
    with pytest.raises(InputError) as caught:
        plate_effect(warm, ["a0", "a1", "g"], ["g"], {"W1": of_grid})
    assert fact in caught.value.fact
    assert caught.value.where == "element W1"
    assert caught.value.hint


def test_the_area_of_the_grid_is_the_default_and_geometry_is_needed(layout: OpticalLayout) -> None:
    warm = with_element(layout, "W1", dn_dT_per_K=2e-6)
    found = plate_effect(warm, ["a0", "a1"], (), {"W1": ("a1",)})
    assert found is not None
    assert found.change.tolist() == [[[0.0, 2e-6], [0.0, 0.0]]]
    assert plate_effect(layout, ["a0"], (), {}) is None
    with pytest.raises(InputError, match="needs the geometry"):
        plate_effect(replace(warm, has_geometry=False), ["a0"], (), {"W1": ("a0",)})


@pytest.fixture
def written(layout_file: Path, tmp_path: Path) -> Callable[..., Path]:
    def write(name: str, lines: str) -> Path:
        text = layout_file.read_text(encoding="utf-8")
        assert text.count(f'name = "{name}"\n') == 1
        path = tmp_path / "optics.toml"
        path.write_text(text.replace(f'name = "{name}"\n', f'name = "{name}"\n{lines}\n'), encoding="utf-8")
        return path

    return write


def test_the_keys_are_read(written: Callable[..., Path]) -> None:
    found = load_layout(written("W1", 'dn_dT_1_K = -5.46e-6\nexpansion_1_K = 1.01e-5\narea = "IS1_WINDOW"'))[1]
    (plate,) = found.changing_plates
    assert (plate.name, plate.dn_dT_per_K, plate.expansion_per_K, plate.area) == ("W1", -5.46e-6, 1.01e-5, "IS1_WINDOW")


@pytest.mark.parametrize(
    ("name", "lines", "where", "fact"),
    [
        ("W1", "dn_dT_1_K = 8.3", "dn_dT_1_K", "change of the refractive index 8.3 is outside -0.01 to 0.01 1/K"),
        ("W1", "expansion_1_K = 10.1", "expansion_1_K", "coefficient of expansion 10.1 is outside"),
        ("W1", 'area = "a"', "area", "has no use: W1 gives neither dn_dT_1_K nor expansion_1_K"),
        ("M1", "expansion_1_K = 1e-6", "expansion_1_K", "mirror M1 has no substrate (thickness_m and index) to change"),
        ("FIM", "dn_dT_1_K = 1e-6", "dn_dT_1_K", "an injector (FIM) has no such key"),
        ("TM1", 'area = "a"', "area", "a test_mass (TM1) has no such key"),
        ("W1", "dn_dT_1_K = nan", "dn_dT_1_K", "finite number"),
    ],
)
def test_keys_that_are_wrong(
    written: Callable[..., Path], layout: OpticalLayout, name: str, lines: str, where: str, fact: str
) -> None:
    with pytest.raises(ConfigError) as caught:
        load_layout(written(name, lines))
    found = dict(caught.value.problems)
    assert fact in found[f"element[{layout.index(name)}].{where}"], found
    assert len(found) == 1


def test_what_the_sample_says_with_its_commented_lines(layout_file: Path, S_BW: FloatArray, tmp_path: Path) -> None:
    """The keys are there, commented out, for every window and beam splitter; what they do is in the guide."""
    text = layout_file.read_text(encoding="utf-8")
    for key in ("dn_dT_1_K", "expansion_1_K", "area"):
        assert text.count(f"\n# {key} = ") == len(GLASS)
        text = text.replace(f"\n# {key} = ", f"\n{key} = ")
    path = tmp_path / "optics.toml"
    path.write_text(text, encoding="utf-8")
    found = load_layout(path)[1]
    plates = found.changing_plates
    assert tuple(p.name for p in plates) == GLASS
    assert all(p.area and p.dn_dT_per_K and p.expansion_per_K for p in plates)
    areas = sorted({str(p.area) for p in plates})
    chain = optics_chain(found, S_BW, np.zeros((len(areas), 22, 6)), plates=plate_effect(found, areas, (), {}))
    for s in chain.sets:  # the numbers of how-to/optics.md
        assert np.linalg.norm(s.N_plates[[0, 3]], axis=1) == pytest.approx([5.524e-8, 5.143e-8], rel=1e-3)
        assert np.abs(s.N_plates[[1, 2, 4, 5]]).max() < 1e-18
        windows = s.N_plates[:, [areas.index(f"IS{i}_WINDOW") for i in (1, 2)]]
        assert windows[[0, 3], [0, 1]] == pytest.approx([-4.068e-9, 4.068e-9], rel=1e-3)
