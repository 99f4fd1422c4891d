"""Wrong matrices are refused, and what is wrong with them is named."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from import_tools import ANGLES, imported, labelled, nodes_at
from random_layouts import axis_rows
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray as Matrix
from tedm_cli.errors import PhysicsError
from tedm_cli.optics.common_mode import rigid_motion
from tedm_cli.optics.diagnosis import explain_defect
from tedm_cli.optics.imported import ImportedSensitivity, MotionConventions, import_sensitivity
from tedm_cli.optics.labels import input_labels
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.matrix_checks import judge_matrix
from tedm_cli.optics.sensitivity import turned_about

# All elements of the shipped layout but its windows, which have no effect.
NAMES = (
    *("TM1", "TM2", "FIM", "FIR", *(f"BS{i}" for i in range(1, 9)), *(f"M{i}" for i in range(1, 7))),
    *("PD1A", "PD1B", "PD12A", "PD12B"),
)


@pytest.fixture(scope="module")
def nodes(layout: OpticalLayout) -> Matrix:
    return nodes_at(layout, 0.01)


def refused(layout: OpticalLayout, found: ImportedSensitivity, nodes: Matrix) -> bool:
    try:
        judged = judge_matrix(layout, found.S_BW, law_matrix(layout), nodes, found.error)
    except PhysicsError:
        return True
    return not all(j.passed for j in judged)


def named(layout: OpticalLayout, S: Matrix, nodes: Matrix, points: str = "layout") -> str:
    """The defect that is found in a matrix that must be refused."""
    found = imported(layout, S, nodes, points)
    assert refused(layout, found, nodes)
    return explain_defect(layout, found, nodes)


def test_a_sound_matrix_has_no_defect(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix) -> None:
    found = imported(layout, S_BW, nodes)
    assert not refused(layout, found, nodes)
    assert explain_defect(layout, found, nodes) == ""


@settings(max_examples=15, deadline=None)
@given(
    name=st.sampled_from(NAMES),
    factor=st.floats(1e-6, 1e6).filter(lambda f: abs(np.log(f)) > 0.01),
    sign=st.sampled_from([1, -1]),
)
def test_scaled_columns_of_any_element(
    layout: OpticalLayout, S_BW: Matrix, nodes: Matrix, name: str, factor: float, sign: int
) -> None:
    wrong = S_BW.copy()
    wrong[:, layout.columns(name)] *= sign * factor
    text = named(layout, wrong, nodes)
    match = re.fullmatch(rf"columns of {name} look scaled by (\S+)( \(.*\?\))?", text)
    assert match, text
    assert float(match[1]) == pytest.approx(sign * factor, rel=1e-4, abs=0)


@pytest.mark.parametrize("name", NAMES)
def test_millimetres_of_one_element(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix, name: str) -> None:
    """Translations in mm, rotations as declared; where there are no effects of translations nothing is wrong."""
    wrong = S_BW.copy()
    wrong[:, layout.columns(name)][:, :3] *= 1e-3
    if name in ("BS1", "BS7"):  # only transmit
        np.testing.assert_allclose(wrong, S_BW, atol=1e-12)
        return
    text = named(layout, wrong, nodes)
    assert f"of {name} " in text or f" {name}_" in text
    assert "scaled by 0.001 (mm or mrad given as m or rad?)" in text


@settings(max_examples=25, deadline=None)
@given(path=st.integers(0, 7), factor=st.floats(1e-6, 1e6).filter(lambda f: abs(np.log(f)) > 0.01))
def test_scaled_rows_of_any_path(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix, path: int, factor: float) -> None:
    """No rigid motion shows these: the photodiode's own columns do."""
    wrong, of = S_BW.copy(), layout.paths[path]
    wrong[layout.rows(of)] *= factor
    text = named(layout, wrong, nodes)
    match = re.match(rf"all rows of {of.photodiode}_{of.beam} look scaled by (\S+)", text)
    assert match, text
    assert float(match[1]) == pytest.approx(factor, rel=1e-4, abs=0)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(columns=st.lists(st.integers(0, 143), min_size=2, max_size=2, unique=True))
def test_exchanged_columns(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix, columns: list[int]) -> None:
    """Either nothing changes under any motion of everything, or the two are named, or no slip is claimed wrongly."""
    a, b = sorted(columns)
    wrong = S_BW.copy()
    wrong[:, [a, b]] = wrong[:, [b, a]]
    found = imported(layout, wrong, nodes)
    if np.abs(wrong - S_BW).max() == 0 or not refused(layout, found, nodes):
        return  # columns that do the same
    labels = input_labels(layout).names
    text = explain_defect(layout, found, nodes)
    # An empty column in the place of another is one that is missing, too; at 45 degrees ux for uy is a change of sign.
    accepted = [*(labels[k] for k in (a, b)), *(f"of {layout.elements[k // 6].name} look" for k in (a, b))]
    if a % 6 >= 3 and b % 6 == a % 6:
        # All elements turn alike: a rotation about the same axis only shows by the other matrix entries.
        return
    if match := re.fullmatch(r"columns (of )?(\S+) and (\S+) look exchanged", text):
        # Another pair may explain it as well, such as those of two parallel mirrors: it must mend the matrix.
        one, other = match[2], match[3]
        places = [layout.columns(n) if match[1] else slice(k := labels.index(n), k + 1) for n in (one, other)]
        mended = wrong.copy()
        mended[:, places[0]], mended[:, places[1]] = wrong[:, places[1]], wrong[:, places[0]]
        rigid = [
            float(np.abs(matrix.S_BW @ rigid_motion(layout, nodes)).max())
            for matrix in (found, imported(layout, mended, nodes))
        ]
        assert rigid[1] < 1e-3 * rigid[0], text
        return
    assert any(piece in text for piece in accepted), text


SLIPS: dict[str, tuple[Callable[[OpticalLayout, Matrix], Matrix], str]] = {}


def slip(expected: str) -> Callable[[Callable[[OpticalLayout, Matrix], Matrix]], None]:
    def add(make: Callable[[OpticalLayout, Matrix], Matrix]) -> None:
        SLIPS[make.__name__] = (make, expected)

    return add


def by_element(S: Matrix) -> Matrix:
    return S.reshape(len(S), -1, 6)


@slip(r"columns of all rotations, against those of all translations, look scaled by 1000\S* ")
def translations_per_millimetre(_: OpticalLayout, S: Matrix) -> Matrix:
    by_element(S)[:, :, :3] *= 1e-3
    return S


@slip(r"columns of all rotations, against those of all translations, look scaled by 0.001 ")
def millimetres_and_microradians(_: OpticalLayout, S: Matrix) -> Matrix:
    """Outputs and motions alike; entries of lengths by lengths and angles by angles are right."""
    by_element(S)[:, :, :3] *= 1e-3
    by_element(S)[:, :, 3:] *= 1e-6
    S.reshape(8, 5, -1)[:, :3] *= 1e3
    S.reshape(8, 5, -1)[:, 3:] *= 1e6
    return S


@slip(r"columns of all rotations, .* scaled by -1 \(the other sign\?\)")
def left_handed_rotations(_: OpticalLayout, S: Matrix) -> Matrix:
    by_element(S)[:, :, 3:] *= -1
    return S


@slip(r"columns of the test masses, against those of the bench, look scaled by 1000 ")
def test_masses_alone(layout: OpticalLayout, S: Matrix) -> Matrix:
    S[:, layout.columns_of(layout.test_masses)] *= 1e3
    return S


@slip(r"column M3_rz looks scaled by -1 ")
def sign_of_one_rotation(layout: OpticalLayout, S: Matrix) -> Matrix:
    S[:, layout.columns("M3")][:, 5] *= -1
    return S


@slip(r"columns of BS4 and M2 look exchanged")
def two_elements(layout: OpticalLayout, S: Matrix) -> Matrix:
    one, other = S[:, layout.columns("BS4")].copy(), S[:, layout.columns("M2")].copy()
    S[:, layout.columns("BS4")], S[:, layout.columns("M2")] = other, one
    return S


@slip(r"columns of every element look to be in the order rx ry rz ux uy uz")
def rotations_first(_: OpticalLayout, S: Matrix) -> Matrix:
    return by_element(S)[:, :, [3, 4, 5, 0, 1, 2]].reshape(S.shape)


@slip(r"columns of M1 look to be in the order uy uz ux rx ry rz")
def order_of_one_element(layout: OpticalLayout, S: Matrix) -> Matrix:
    S[:, layout.columns("M1")] = S[:, layout.columns("M1")][:, [1, 2, 0, 3, 4, 5]]
    return S


@slip(r"in another frame, with its axes along y, -x, z of the declared one")
def another_frame(_: OpticalLayout, S: Matrix) -> Matrix:
    # Motions along a = y, b = -x, c = z: u = a e_y - b e_x + c e_z.
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return (S.reshape(len(S), -1, 3) @ turn).reshape(S.shape)


@slip(r"reference point of M1 looks to be \(4\.553, -4\.209, 0\) mm off the declared one")
def one_reference_point(layout: OpticalLayout, S: Matrix) -> Matrix:
    """Moved along the mirror's normal and across: what lies along the normal has no effect and is not reported."""
    offset = -(0.0062 * np.array([0.7343225, -0.6788007, 0.0]) + 0.01 * np.array([0.6788007, 0.7343225, 0.0]))
    S[:, layout.columns("M1")] = turned_about(S[:, layout.columns("M1")], offset[None])
    return S


@slip(r"columns of BS5 are all zero")
def a_missing_element(layout: OpticalLayout, S: Matrix) -> Matrix:
    S[:, layout.columns("BS5")] = 0
    return S


@slip(r"column BS5_uy looks wrong or missing")
def a_missing_column(layout: OpticalLayout, S: Matrix) -> Matrix:
    S[:, layout.columns("BS5")][:, 1] = 0
    return S


@slip(r"rows opl of all paths look scaled by 1000 ")
def path_length_in_millimetres(_: OpticalLayout, S: Matrix) -> Matrix:
    S.reshape(8, 5, -1)[:, 2] *= 1e3
    return S


@slip(r"rows z1, z2 of all paths look scaled by 0.001 .*\(Zernike tilts declared as slopes")
def zernike_tilts(_: OpticalLayout, S: Matrix) -> Matrix:
    S.reshape(8, 5, -1)[:, 3:] *= 0.001
    return S


@slip(r"rows opl of PD12A_ref look scaled by -1 ")
def sign_of_one_path_length(_: OpticalLayout, S: Matrix) -> Matrix:
    S[27] *= -1
    return S


@slip(r"rows x of PD1A_meas look scaled by -1 ")
def sign_of_one_spot(_: OpticalLayout, S: Matrix) -> Matrix:
    S[0] *= -1
    return S


@slip(r"rows of PD1A_meas do not respond to PD1A as to a photodiode \(x and y exchanged")
def spots_exchanged(_: OpticalLayout, S: Matrix) -> Matrix:
    S[[0, 1]] = S[[1, 0]]
    return S


@slip(r"rows of PD1A_meas and PD1A_ref look exchanged")
def beams_exchanged(_: OpticalLayout, S: Matrix) -> Matrix:
    S[:10] = S[[5, 6, 7, 8, 9, 0, 1, 2, 3, 4]]
    return S


@slip(r"rows of PD1A_meas respond to the photodiode PD12B instead")
def photodiodes_exchanged(_: OpticalLayout, S: Matrix) -> Matrix:
    S[:5], S[30:35] = S[30:35].copy(), S[:5].copy()
    return S


@pytest.mark.parametrize("name", SLIPS)
def test_slips_are_named(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix, name: str) -> None:
    make, expected = SLIPS[name]
    text = named(layout, make(layout, S_BW.copy()), nodes)
    assert re.search(expected, text), text


@pytest.mark.parametrize("name", ["translations_per_millimetre", "two_elements", "sign_of_one_rotation"])
def test_slips_are_named_in_few_digits(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix, name: str) -> None:
    make, expected = SLIPS[name]
    printed = np.array([[float(f"{v:.4e}") for v in row] for row in make(layout, S_BW.copy())])
    assert re.search(expected, named(layout, printed, nodes))


def test_points_declared_as_grids_that_are_those_of_the_layout(
    layout: OpticalLayout, S_BW: Matrix, nodes: Matrix
) -> None:
    assert named(layout, S_BW, nodes, "grid") == "rotations look to be about the ref_m of the layout"


def test_frame_declared_as_basic_that_is_that_of_the_layout(layout: OpticalLayout, S_BW: Matrix) -> None:
    placed = replace(
        layout,
        frame_axes=axis_rows(Rotation.from_rotvec([0.3, -0.7, 1.1]).as_matrix()),
        frame_origin_m=(0.4, -0.2, 1.0),
    )
    nodes = nodes_at(placed, 0.01)
    found = import_sensitivity(placed, labelled(placed, S_BW), ANGLES, MotionConventions("basic", "layout"), nodes)
    assert refused(placed, found, nodes)
    assert "with the axes of the layout in place of the basic ones" in explain_defect(placed, found, nodes)


def test_two_slips_at_once_are_not_taken_for_one(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix) -> None:
    wrong = S_BW.copy()
    wrong[:, layout.columns("M1")] *= 2
    wrong[:, layout.columns("BS3")] *= 0.3
    assert named(layout, wrong, nodes) == ""
