"""The layout file: what it becomes, and every way in which it is refused."""

from __future__ import annotations

import copy
import tomllib
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from tedm_cli.config.base import OrthonormalAxes, validate
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.optics.tables import FrameTable
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.optics.layout import MassExpansion, OpticalLayout, Recombination
from tedm_cli.optics.layout_checks import check_layout, failures

ELEMENT = {
    name: i
    for i, name in enumerate(
        ["TM1", "TM2", "FIM", "FIR", "W1", "W2", "BS1", "BS2", "BS3", "BS4", "BS5", "BS6", "BS7", "BS8", "M1"]
    )
}


@pytest.fixture
def text(layout_file: Path) -> str:
    return layout_file.read_text()


def problems(text: str, tmp_path: Path) -> dict[str, str]:
    file = tmp_path / "optics.toml"
    file.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_layout(file)
    assert caught.value.where == str(file)
    return dict(caught.value.problems)


def test_the_shipped_layout(layout: OpticalLayout, layout_file: Path) -> None:
    file, again = load_layout(layout_file)
    assert again == layout
    assert file.text == layout_file.read_text()
    assert layout.sets == {"A": ("PD1A", "PD12A"), "B": ("PD1B", "PD12B")}
    kinds: list[str] = [e.kind for e in layout.elements]
    counts = {"test_mass": 2, "injector": 2, "window": 2, "beamsplitter": 8, "mirror": 6, "photodiode": 4}
    assert {kind: kinds.count(kind) for kind in counts} == counts
    assert max(abs(np.linalg.norm(e.normal) - 1) for e in layout.elements) < 5e-16
    assert [s.label for s in layout.paths[1].steps] == ["FIR", "M5:R", "BS7:T", "BS6:T", "BS4:R", "PD1A"]
    assert layout.paths[1].label == "PD1A ref"


def test_axes_of_rounded_digits_are_read_as_the_nearest() -> None:
    """To six decimals or more they are a rotation again, as near as its digits; exact ones stay to the bit."""
    rng = np.random.default_rng(3)
    for digits in (6, 7, 10, 16):
        for _ in range(20):
            exact = np.linalg.qr(rng.normal(size=(3, 3)))[0]
            exact *= np.linalg.det(exact)
            rows = exact.round(digits).tolist() if digits < 16 else exact.tolist()
            found = [TypeAdapter(OrthonormalAxes).validate_python(rows)]
            found.append(validate(FrameTable, {"origin_m": [0.0, 0.0, 0.0], "axes": rows}, where="").axes)
            for axes in np.array(found):
                assert np.abs(axes @ axes.T - np.eye(3)).max() < 1e-14
                assert np.abs(axes - exact).max() <= (0.0 if digits == 16 else 1.01 * 10.0**-digits)


def test_unit_vectors_of_seven_decimals_are_read(layout: OpticalLayout, text: str, tmp_path: Path) -> None:
    """They are of unit length and at right angles again, as near as their digits; four are too few."""
    exact = np.linalg.qr(np.array([[0.6, -0.4], [0.5, -0.2], [0.6, 0.7]]))[0].T
    old = "normal = [0.0, -1.0, 0.0]\nlocal_y = [0.0, 0.0, 1.0]"
    assert old in text

    def written(digits: int) -> Path:
        normal, local_y = exact.round(digits).tolist()
        file = tmp_path / "optics.toml"
        file.write_text(text.replace(old, f"normal = {normal}\nlocal_y = {local_y}", 1))
        return file

    found = next(e for e in load_layout(written(7))[1].elements if e.name == "PD1A")
    assert found.local_y is not None
    vectors = np.array([found.normal, found.local_y])
    assert np.abs(vectors @ vectors.T - np.eye(2)).max() < 1e-15
    assert 1e-9 < np.abs(vectors - exact).max() < 2e-7
    with pytest.raises(ConfigError, match=r"not a unit vector|not perpendicular"):
        load_layout(written(4))


def test_axes_that_are_off_name_the_nearest() -> None:
    with pytest.raises(
        ValidationError, match=r"off by 2e-05, more than rounded digits leave .*nearest are \[\[1.0, 0.0, 0.0\], \[0"
    ):
        TypeAdapter(OrthonormalAxes).validate_python([[1.00001, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])


def test_axes_of_a_test_mass_are_in_the_layout_frame(layout: OpticalLayout, text: str, tmp_path: Path) -> None:
    file = tmp_path / "optics.toml"
    frame = "axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]"
    turned = text.replace(frame, "axes = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]")
    assert turned != text
    file.write_text(turned.replace('name = "TM2"', 'name = "TM2"\naxes = [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]', 1))
    found = load_layout(file)[1]
    assert not layout.has_own_axes
    assert found.has_own_axes
    assert found.test_mass_axes.tolist() == [np.eye(3).tolist(), np.diag([-1.0, -1.0, 1.0]).tolist()]
    # x of the layout is y of the model: so is x of TM1, and that of TM2 points the other way.
    assert found.test_mass_axes_basic[0].tolist() == [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
    assert found.test_mass_axes_basic[1].tolist() == [[0, -1, 0], [0, 0, -1], [1, 0, 0]]


@pytest.mark.parametrize(
    ("old", "new", "where", "fact"),
    [
        ('"M2:R", "BS4:T"', '"MM2:R", "BS4:T"', "path[0].steps[8]", "unknown element 'MM2'; did you mean M2?"),
        ('"M2:R", "BS4:T"', '"M2:X", "BS4:T"', "path[0].steps[8]", "does not say R"),
        ('"M2:R", "BS4:T"', '"M2", "BS4:T"', "path[0].steps[8]", "does not say R"),
        ('"M2:R", "BS4:T"', '"M2:T", "BS4:T"', "path[0].steps[8]", "mirror M2 cannot transmit"),
        ('"M2:R", "BS4:T"', '"PD1B:R", "BS4:T"', "path[0].steps[8]", "photodiode PD1B cannot stand inside a path"),
        ('["FIM", "BS1:T", "BS2:R", "BS3:T"', '["BS1:T", "BS2:R", "BS3:T"', "path[0].steps[0]", "begins with"),
        ('"BS4:T", "PD1A"]', '"BS4:T"]', "path[0].steps[9]", "ends with the plain name of a photodiode"),
        ('"BS4:T", "PD1A"]', '"BS4:T", "PD1B"]', "path[0].steps[10]", "ends on PD1B but the path's photodiode is PD1A"),
        ('"BS4:R", "PD1A"]', '"BS4:R", "PD1A"]\nwavefront_radius_m = 0', "path[1].wavefront_radius_m", "plane wave"),
        (
            'photodiode = "PD1A"\nbeam = "ref"',
            'photodiode = "PD9"\nbeam = "ref"',
            "path[1].photodiode",
            "unknown element 'PD9'",
        ),
        (
            'photodiode = "PD1A"\nbeam = "ref"',
            'photodiode = "PD1A"\nbeam = "meas"',
            "element[20]",
            "0 paths with beam ref",
        ),
        ('photodiode = "PD1A"\nbeam = "ref"', 'photodiode = "PD1A"\nbeam = "both"', "path[1].beam", "'meas' or 'ref'"),
        ('name = "W2"', 'name = "W1"', "element[5].name", "'W1' is already element[4]"),
        ('name = "W2"', 'name = "W 2"', "element[5].name", "letters without accents, digits, _ . and -, a"),
        ('kind = "window"\ngrid = 900003', 'kind = "lens"\ngrid = 900003', "element[4].kind", "test_mass"),
        ("grid = 900003\n", "", "element[4].grid", "missing; a window (W1) needs it"),
        ("grid = 900003\n", "grid = -3\n", "element[4].grid", "Nastran id -3 is outside 1 to 999,999,999"),
        (
            "thickness_m = 0.006\nindex = 1.607",
            "thickness_m = 0.006",
            "element[4].index",
            "missing; a window (W1) needs it",
        ),
        ("index = 1.607", "index = 0.9", "element[4].index", "refractive index 0.9 is outside 1 to 10"),
        ("thickness_m = 0.006", "thickness_m = -0.006", "element[4].thickness_m", "length -0.006 is outside 0 to"),
        (
            "thickness_m = 0.006",
            "thickness_mm = 6.0",
            "element[4].thickness_mm",
            "unknown key; did you mean thickness_m?",
        ),
        (
            "front_offset_m = 0.023",
            "front_offset_m = 0.023\ngrid = 5",
            "element[0].grid",
            "a test_mass (TM1) has no such key",
        ),
        ("front_offset_m = 0.023\n", "", "element[0].front_offset_m", "missing; a test_mass (TM1) needs it"),
        ('kind = "mirror"\n', 'kind = "mirror"\nindex = 1.5\n', "element[14]", "needs both thickness_m and index"),
        ("normal = [1.0, 0.0, 0.0]", "normal = [1.0, 0.001, 0.0]", "element[0].normal", "length is 1.0000005"),
        (
            "normal = [1.0, 0.0, 0.0]",
            "normal = [3.0, 0.0, 4.0]",
            "element[0].normal",
            "length is 5; TM1 may mean [0.6, 0.0, 0.8]",
        ),
        ("normal = [1.0, 0.0, 0.0]", "normal = [0.0, 0.0, 0.0]", "element[0].normal", "its length is 0"),
        ("normal = [1.0, 0.0, 0.0]", "normal = [1.0, 0.0]", "element[0].normal", "at least 3"),
        ("local_y = [0.0, 0.0, 1.0]", "local_y = [1.0, 0.0, 0.0]", "element[0].local_y", "not perpendicular"),
        ("local_y = [0.0, 0.0, 1.0]", "axes = [[1, 0, 0], [0, 0, 1], [0, 1, 0]]", "element[0].axes", "right-handed"),
        ("local_y = [0.0, 0.0, 1.0]", "axes = [[1, 0, 0], [0, 1, 1e-5], [0, 0, 1]]", "element[0].axes", "off by 1e-05"),
        (
            "local_y = [0.0, 0.0, 1.0]",
            'read_out = ["x", "y", "x"]',
            "element[0].read_out[2]",
            "is already element[0].read_out[0]",
        ),
        ("local_y = [0.0, 0.0, 1.0]", 'read_out = ["x", "psi"]', "element[0].read_out[1]", "found 'psi'"),
        (
            "local_y = [0.0, 0.0, 1.0]",
            'read_out = ["x", "y", "z", "eta"]',
            "sets.A",
            "6 laser outputs cannot give 7 read-outs",
        ),
        ("aperture_m = 0.018", 'read_out = ["x"]', "element[4].read_out", "has no such key"),
        ("aperture_m = 0.018", "axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "element[4].axes", "has no such key"),
        ("local_y = [0.0, 0.0, 1.0]", "local_y = [0.0, 0.0, 2.0]", "element[0].local_y", "length is 2"),
        ("ref_m = [0.088, -0.095, 0.0]", 'ref_m = [0.088, "a", 0.0]', "element[2].ref_m[1]", "valid number"),
        ("ref_m = [0.088, -0.095, 0.0]", "ref_m = [0.088, nan, 0.0]", "element[2].ref_m[1]", "finite"),
        ("axes = [[1.0, 0.0, 0.0]", "axes = [[-1.0, 0.0, 0.0]", "frame.axes", "right-handed"),
        ("axes = [[1.0, 0.0, 0.0]", "axes = [[1.0, 0.1, 0.0]", "frame.axes", "right-handed"),
        ('A = ["PD1A", "PD12A"]', 'A = ["PD1A", "M1"]', "sets.A[1]", "M1 is a mirror, not a photodiode"),
        ('A = ["PD1A", "PD12A"]', 'A = ["PD1A", "FIM"]', "sets.A[1]", "FIM is an injector, not a photodiode"),
        ("aperture_m = 0.004", "index = 1.5", "element[2].index", "an injector (FIM) has no such key"),
        ('A = ["PD1A", "PD12A"]', 'A = ["PD1A", "PD12C"]', "sets.A[1]", "unknown element 'PD12C'; did you mean PD12"),
        ('A = ["PD1A", "PD12A"]', 'A = ["PD1A", "PD1A"]', "sets.A[1]", "'PD1A' is already sets.A[0]"),
        ('A = ["PD1A", "PD12A"]', 'A = ["PD1A"]', "sets.A", "3 laser outputs cannot give 6 read-outs"),
        ('"x", "eta", "phi"', '"x", "eta", "psi"', "read_out[2]", "'phi'"),
        ('"x", "eta", "phi"', '"x", "eta", "eta"', "read_out[2]", "'eta' is already read_out[1]"),
        ("wavelength_m = 1.064e-6", "wavelength_m = 0", "wavelength_m", "wavelength 0 is outside 1e-12 to 1000 m"),
        ("wavelength_m = 1.064e-6", "", "wavelength_m", "missing"),
        ("aperture_m = 0.018", "aperture_m = [0.018]", "element[4].aperture_m", "at least 2"),
        (
            "aperture_m = 0.018",
            "aperture_m = -0.018",
            "element[4].aperture_m",
            "length -0.018 is outside 1e-09 to 10000 m",
        ),
        ("aperture_m = 0.018", "aperture_m = [0.018, 0.01]", "element[4].aperture_m", "W1 has no local_y"),
        ("aperture_m = 0.018", "local_y = [0, 0, 1]", "element[4].local_y", "no use for it without aperture_m"),
        ("aperture_m = 0.018", "beam_overlap_m = 1e-5", "element[4].beam_overlap_m", "window (W1) has no such key"),
        ("clearance_m = 0.0015", "clearance_m = -1", "tolerances.clearance_m", "length -1 is outside 0 to 10000 m"),
        ("clearance_m = 0.0015", "clearence_m = 1", "tolerances.clearence_m", "did you mean clearance_m?"),
        ("[tolerances]", "[grids]\nW1 = 7\n[tolerances]", "grids.W1", "element W1 gives its grid (900003) itself"),
        ("[tolerances]", "[grids]\nW9 = 7\n[tolerances]", "grids.W9", "unknown element 'W9'; did you mean W"),
        ("[tolerances]", "[grids]\nTM1 = 7\n[tolerances]", "grids.TM1", "it floats and has no grid"),
        ('kind = "test_mass"', 'kind = "mirror"\ngrid = 7', "element", "none is a test_mass"),
    ],
)
def test_each_problem_is_named_at_its_place(
    text: str, tmp_path: Path, old: str, new: str, where: str, fact: str
) -> None:
    count = -1 if 'kind = "test_mass"' in old else 1
    assert old in text
    assert fact in problems(text.replace(old, new, count), tmp_path)[where]


def test_grids_in_a_table_of_their_own_are_the_same_layout(text: str, tmp_path: Path, layout: OpticalLayout) -> None:
    own = [line for line in text.splitlines() if not line.startswith("grid = ")]
    table = "\n".join(f"{e.name} = {e.grid}" for e in layout.bench)
    file = tmp_path / "optics.toml"
    file.write_text("\n".join(own).replace("[tolerances]", f"[grids]\n{table}\n\n[tolerances]"))
    assert load_layout(file)[1] == layout
    file.write_text(file.read_text().replace("W1 = 900003\n", ""))
    with pytest.raises(ConfigError, match=r"a window \(W1\) needs it"):
        load_layout(file)


def test_a_photodiode_may_have_tolerances_of_its_own(text: str, tmp_path: Path, layout: OpticalLayout) -> None:
    file = tmp_path / "optics.toml"
    file.write_text(text.replace("aperture_m = 0.0025", "aperture_m = 0.0025\nbeam_angle_rad = 3e-3", 1))
    own, other = (load_layout(file)[1].elements[layout.index(name)].recombination for name in ("PD1A", "PD1B"))
    assert (own.overlap_m, own.angle_rad, own.path_mismatch_m) == (1e-4, 3e-3, 1e-3)
    assert other == layout.elements[layout.index("PD1A")].recombination == Recombination(1e-4, 1e-4, 1e-3)


def test_all_problems_come_at_once(text: str, tmp_path: Path) -> None:
    """A malformed key hides neither what else is wrong in its own table nor what is wrong in the others."""
    broken = (
        text.replace("thickness_m = 0.006", "thicknes_m = 0.006", 1)
        .replace(
            "normal = [1.0, 0.0, 0.0]\nfront_offset_m = 0.003", "normal = [2.0, 0.0, 0.0]\nfront_offset_m = 0.003", 1
        )
        .replace('"M2:R", "BS4:T"', '"MM2:R", "BS4:T"')
        .replace('beam = "ref"', 'beam = "ref"\nradius = 3.0', 1)
        .replace('"BS4:R", "PD1A"]', '"BS44:R", "PD1A"]')
        .replace('B = ["PD1B", "PD12B"]', 'B = ["PD1B", "PD12X"]\nC = 3')
        .replace("wavelength_m", "wavelength")
    )
    assert set(problems(broken, tmp_path)) == {
        "element[4].thicknes_m",
        "element[4].normal",
        "path[0].steps[8]",
        "path[1].radius",
        "path[1].steps[4]",
        "sets.B[1]",
        "sets.C",
        "wavelength",  # and with it that wavelength_m is missing
    }


def test_a_missing_file_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere\.toml"):
        load_layout(tmp_path / "nowhere.toml")


def test_a_nearly_unit_normal_is_made_unit(text: str, tmp_path: Path) -> None:
    file = tmp_path / "optics.toml"
    file.write_text(text.replace("normal = [1.0, 0.0, 0.0]", "normal = [1.0000000001, 0.0, 0.0]", 1))
    assert load_layout(file)[1].elements[0].normal == (1.0, 0.0, 0.0)


junk: st.SearchStrategy[Any] = st.sampled_from(
    [None, 3, -1.5, "PD1A", "", [], [1.0, 2.0], ["x"], {}, {"a": 1}, [{}], True, float("nan")]
)


def _toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f'"{k}" = {_toml(v)}' for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else repr(value)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_no_junk_gets_past_as_anything_but_a_configuration_error(
    layout_file: Path, tmp_path: Path, data: st.DataObject
) -> None:
    tables = copy.deepcopy(tomllib.loads(layout_file.read_text()))
    for _ in range(data.draw(st.integers(1, 3))):
        at: Any = tables
        for _ in range(data.draw(st.integers(0, 2))):
            inner = [
                k for k in (at if isinstance(at, dict) else range(len(at))) if isinstance(at[k], dict | list) and at[k]
            ]
            at = at[data.draw(st.sampled_from(inner))] if inner else at
        key = data.draw(st.sampled_from(sorted(at) if isinstance(at, dict) else range(len(at))))
        value = copy.deepcopy(data.draw(junk))
        if value is None:
            del at[key]
        else:
            at[key] = value
        if not tables:
            break
    file = tmp_path / "optics.toml"
    file.write_text("\n".join(f'"{k}" = {_toml(v)}' for k, v in tables.items()))
    with suppress(ConfigError):
        load_layout(file)


EXPANSION = """
[[test_mass_expansion]]
test_mass = "TM1"
expansion_per_K = 1.65e-5
area = "IS1_EH"
"""


def test_test_masses_may_expand(text: str, tmp_path: Path, layout: OpticalLayout) -> None:
    file = tmp_path / "optics.toml"
    file.write_text(text + EXPANSION + EXPANSION.replace("TM1", "TM2"))
    found = load_layout(file)[1]
    assert found.expansions == (MassExpansion("TM1", 1.65e-5, "IS1_EH"), MassExpansion("TM2", 1.65e-5, "IS1_EH"))
    assert layout.expansions == ()


@pytest.mark.parametrize(
    ("old", "new", "where", "fact"),
    [
        ("TM1", "TM3", "test_mass_expansion[0].test_mass", "no test_mass is called 'TM3'; did you mean TM"),
        ("TM1", "W1", "test_mass_expansion[0].test_mass", "no test_mass is called 'W1'"),
        ("1.65e-5", '"a"', "test_mass_expansion[0].expansion_per_K", "valid number"),
        ("area", "aera", "test_mass_expansion[0].aera", "unknown key; did you mean area, which is missing?"),
    ],
)
def test_expansions_that_are_wrong(text: str, tmp_path: Path, old: str, new: str, where: str, fact: str) -> None:
    assert fact in problems(text + EXPANSION.replace(old, new), tmp_path)[where]


def test_a_test_mass_follows_one_temperature(text: str, tmp_path: Path) -> None:
    found = problems(text + EXPANSION + EXPANSION, tmp_path)
    assert "'TM1' is already" in found["test_mass_expansion[1].test_mass"]


def test_a_layout_without_grids_is_judged_but_not_built(text: str, tmp_path: Path) -> None:
    """The bench is often designed before its finite-element model."""
    file = tmp_path / "optics.toml"
    file.write_text("\n".join(line for line in text.splitlines() if not line.startswith("grid = ")))
    bare = load_layout(file, needs_grids=False)[1]
    assert all(e.grid is None for e in bare.elements)
    assert not failures(check_layout(bare))
    with pytest.raises(ConfigError) as caught:
        load_layout(file)
    assert len(caught.value.problems) == len(bare.bench)
    assert ("element[2].grid", "missing; an injector (FIM) needs it") in caught.value.problems


def test_a_plate_may_be_thin_but_not_of_nearly_no_thickness(text: str, tmp_path: Path) -> None:
    file = tmp_path / "optics.toml"
    file.write_text(text.replace("thickness_m = 0.005", "thickness_m = 0.0", 1))
    layout = load_layout(file)[1]
    (thin,) = [e for e in layout.elements if e.is_plate and e.thickness_m == 0.0]
    assert thin.kind == "beamsplitter"
    file.write_text(text.replace("thickness_m = 0.005", "thickness_m = 1e-300", 1))
    with pytest.raises(ConfigError, match="neither 0 nor at least 1e-12 m"):
        load_layout(file)
