"""Matrices of another program: any order, units, frame, reference points and slope convention give the traced one."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from import_tools import ANGLES, imported, labelled, nodes_at, with_units
from random_layouts import axis_rows
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray as Matrix
from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.optics.chain import optics_chain
from tedm_cli.optics.diagnosis import explain_defect
from tedm_cli.optics.imported import (
    Conventions,
    Frame,
    LabelledMatrix,
    MotionConventions,
    import_law,
    import_sensitivity,
    printed_accuracy,
)
from tedm_cli.optics.labels import Labels, input_labels, laser_labels, output_labels
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.layout import Beam, OpticalLayout
from tedm_cli.optics.matrix_checks import block_differences, judge_matrix, row_factors
from tedm_cli.optics.sensitivity import move_reference_points, turned_about

ABOUT_GRIDS = MotionConventions("layout", "grid")


@pytest.fixture(scope="module")
def nodes(layout: OpticalLayout) -> Matrix:
    return nodes_at(layout, 0.01)


@pytest.fixture(scope="module")
def about_grids(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix) -> Matrix:
    return move_reference_points(S_BW, layout, nodes)


def test_rows_and_columns_in_any_order_and_units(layout: OpticalLayout, about_grids: Matrix, nodes: Matrix) -> None:
    rows = with_units(output_labels(layout), {"x": "mm", "y": "um", "opl": "pm", "z1": "urad", "z2": "arcsec"})
    columns = with_units(
        input_labels(layout), {"ux": "mm", "uy": "um", "uz": "nm", "rx": "mrad", "ry": "deg", "rz": "nrad"}
    )
    size = {"mm": 1e-3, "um": 1e-6, "nm": 1e-9, "pm": 1e-12, "mrad": 1e-3, "urad": 1e-6, "nrad": 1e-9}
    size |= {"deg": np.pi / 180, "arcsec": np.pi / 180 / 3600}
    values = about_grids / np.array([size[u] for u in rows.units])[:, None] * np.array([size[u] for u in columns.units])
    random = np.random.default_rng(1)
    i, j = random.permutation(len(rows.names)), random.permutation(len(columns.names))
    shuffled = LabelledMatrix(
        values[np.ix_(i, j)],
        Labels(tuple(rows.names[k] for k in i), tuple(rows.units[k] for k in i)),
        Labels(tuple(columns.names[k] for k in j), tuple(columns.units[k] for k in j)),
    )
    found = import_sensitivity(layout, shuffled, ANGLES, ABOUT_GRIDS, nodes)
    np.testing.assert_allclose(found.S_BW, about_grids, rtol=1e-14, atol=0)
    assert found.digits == "double precision"


@pytest.mark.parametrize(("slopes", "tilt"), [("zernike", 1.0), ("noll", 0.5)])
def test_zernike_tilts_become_slopes(
    layout: OpticalLayout, about_grids: Matrix, nodes: Matrix, slopes: str, tilt: float
) -> None:
    """Tilt of a pupil of 2 mm: the coefficient is R z, or R z / 2 with Noll's norm."""
    radius = 0.002
    is_slope = np.array([u == "rad" for u in output_labels(layout).units])
    values = np.where(is_slope[:, None], tilt * radius * about_grids, about_grids)
    rows = with_units(output_labels(layout), dict.fromkeys(("x", "y", "opl", "z1", "z2"), "m"))
    how = Conventions(ANGLES.beams, slopes, radius)  # type: ignore[arg-type]
    matrix = LabelledMatrix(values, rows, input_labels(layout))
    found = import_sensitivity(layout, matrix, how, ABOUT_GRIDS, nodes)
    np.testing.assert_allclose(found.S_BW, about_grids, rtol=1e-14, atol=0)
    # The law acts on the same outputs: read through it, nothing changes.
    P = law_matrix(layout)
    law = LabelledMatrix(np.where(is_slope, P / (tilt * radius), P), laser_labels(layout), rows)
    np.testing.assert_allclose(import_law(layout, law, how), P, rtol=1e-14, atol=0)


def test_beams_may_have_other_names(layout: OpticalLayout, about_grids: Matrix, nodes: Matrix) -> None:
    names: dict[Beam, str] = {"meas": "M", "ref": "LO"}
    matrix = LabelledMatrix(about_grids, output_labels(layout, names), input_labels(layout))
    assert matrix.rows.names[5] == "PD1A_LO_x"
    found = import_sensitivity(layout, matrix, Conventions(names, "angle"), ABOUT_GRIDS, nodes)
    np.testing.assert_array_equal(found.S_BW, about_grids)


def test_reference_points_of_the_layout_the_grids_or_given(
    layout: OpticalLayout, S_BW: Matrix, about_grids: Matrix, nodes: Matrix
) -> None:
    largest = np.abs(about_grids).max()
    np.testing.assert_allclose(imported(layout, S_BW, nodes).S_BW, about_grids, atol=1e-15 * largest)
    np.testing.assert_array_equal(imported(layout, about_grids, nodes, "grid").S_BW, about_grids)
    # Each element about a point of its own, a test mass among them; the rest as in the layout.
    offset = {"TM1": (0.0, 0.01, 0.0), "BS3": (0.02, -0.01, 0.005)}
    new = np.array([np.array(e.ref_m) + np.array(offset.get(e.name, (0, 0, 0))) for e in layout.elements])
    moved = turned_about(S_BW, layout.refs_m - new)
    points = {e.name: tuple(p) if e.name in offset else "layout" for e, p in zip(layout.elements, new, strict=True)}
    found = import_sensitivity(layout, labelled(layout, moved), ANGLES, MotionConventions("layout", points), nodes)
    np.testing.assert_allclose(found.S_BW, about_grids, atol=1e-14 * largest)
    with pytest.raises(InputError, match=r"points missing: TM2; reference points of unknown elements: TM3"):
        import_sensitivity(
            layout,
            labelled(layout, moved),
            ANGLES,
            MotionConventions("layout", {("TM3" if k == "TM2" else k): v for k, v in points.items()}),
            nodes,
        )


def test_motions_along_the_basic_axes(layout: OpticalLayout, S_BW: Matrix) -> None:
    """A layout turned and shifted in the model; the other program works in the basic frame, about given points."""
    axes = Rotation.from_rotvec([0.3, -0.7, 1.1]).as_matrix()
    placed = replace(layout, frame_axes=axis_rows(axes), frame_origin_m=(0.4, -0.2, 1.0))
    nodes = nodes_at(placed, 0.01)
    about_grids = move_reference_points(S_BW, placed, nodes)
    in_basic = (S_BW.reshape(len(S_BW), -1, 3) @ axes).reshape(S_BW.shape)
    refs = {e.name: tuple(np.array(e.ref_m) @ axes + (0.4, -0.2, 1.0)) for e in layout.elements}
    for points in ("layout", refs):
        found = import_sensitivity(
            placed, labelled(layout, in_basic), ANGLES, MotionConventions("basic", points), nodes
        )
        np.testing.assert_allclose(found.S_BW, about_grids, atol=2e-14)
        assert all(j.passed for j in judge_matrix(placed, found.S_BW, law_matrix(layout), nodes, found.error))


@pytest.mark.parametrize("frame", ["layout", "basic"])
def test_columns_of_test_masses_along_their_own_axes(layout: OpticalLayout, S_BW: Matrix, frame: Frame) -> None:
    """Each test mass turned otherwise; what is imported is the matrix on the layout's axes, and so are its digits."""
    axes = Rotation.from_rotvec([0.3, -0.7, 1.1]).as_matrix()
    own = {"TM1": Rotation.from_rotvec([0.4, 0.0, 0.0]), "TM2": Rotation.from_rotvec([np.pi - 0.2, 0.0, 0.0])}
    placed = replace(
        layout,
        elements=tuple(
            replace(e, axes=axis_rows(own[e.name].as_matrix().T)) if e.name in own else e for e in layout.elements
        ),
        frame_axes=axis_rows(axes),
    )
    nodes = nodes_at(placed, 0.01)
    given = S_BW.copy()
    for e in placed.elements:
        columns = given[:, placed.columns(e.name)].reshape(len(S_BW), 2, 3)  # a view
        turn = np.array(e.axes).T if e.kind == "test_mass" else np.eye(3) if frame == "layout" else axes
        columns[:] = columns @ turn
    how = MotionConventions(frame, "layout", "own")
    found = import_sensitivity(placed, labelled(placed, given), ANGLES, how, nodes)
    np.testing.assert_allclose(found.S_BW, move_reference_points(S_BW, placed, nodes), atol=2e-14)
    assert all(j.passed for j in judge_matrix(placed, found.S_BW, law_matrix(placed), nodes, found.error))
    # Declared otherwise, or not at all.
    wrong = import_sensitivity(placed, labelled(placed, given), ANGLES, replace(how, test_mass_axes="frame"), nodes)
    assert not all(j.passed for j in judge_matrix(placed, wrong.S_BW, law_matrix(placed), nodes, wrong.error))
    assert explain_defect(placed, wrong, nodes) == "columns of the test masses look to be along their own axes"
    if frame == "layout":
        wrong = import_sensitivity(placed, labelled(placed, S_BW), ANGLES, how, nodes)
        named = "columns of the test masses look to be along the axes of the layout frame"
        assert explain_defect(placed, wrong, nodes) == named
    with pytest.raises(InputError, match="which axes their columns are along is not declared"):
        import_sensitivity(placed, labelled(placed, given), ANGLES, replace(how, test_mass_axes=None), nodes)


@pytest.mark.parametrize(
    ("rows", "columns", "message"),
    [
        (
            {"PD1A_meas_x": "PD1A_meas_X"},
            {},
            r"rows missing: PD1A_meas_x; rows unknown: PD1A_meas_X \(is .* meant to be",
        ),
        (
            {},
            {"M6_rz": "M7_rz", "M6_ux": "M5_ux"},
            r"columns given twice: M5_ux; .*missing: M6_ux, M6_rz; .*unknown: M7_rz",
        ),
        ({"PD1B_ref_z2": "PD1B_ref_z1"}, {"TM1_ux": "t"}, r"rows given twice: PD1B_ref_z1.*columns missing: TM1_ux"),
    ],
)
def test_labels_must_be_those_of_the_layout(
    layout: OpticalLayout, S_BW: Matrix, nodes: Matrix, rows: dict[str, str], columns: dict[str, str], message: str
) -> None:
    outputs, inputs = output_labels(layout), input_labels(layout)
    matrix = LabelledMatrix(
        S_BW,
        Labels(tuple(rows.get(n, n) for n in outputs.names), outputs.units),
        Labels(tuple(columns.get(n, n) for n in inputs.names), inputs.units),
    )
    with pytest.raises(InputError, match=message):
        import_sensitivity(layout, matrix, ANGLES, ABOUT_GRIDS, nodes)


@pytest.mark.parametrize(
    ("unit", "message"), [("inch", "unknown unit 'inch'"), ("mrad", "is not the unit of a length")]
)
def test_units_must_fit(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix, unit: str, message: str) -> None:
    rows = with_units(output_labels(layout), {"x": unit, "y": "m", "opl": "m", "z1": "rad", "z2": "rad"})
    with pytest.raises(InputError, match=message):
        import_sensitivity(layout, LabelledMatrix(S_BW, rows, input_labels(layout)), ANGLES, ABOUT_GRIDS, nodes)


@settings(max_examples=60, deadline=None)
@given(
    digits=st.integers(3, 9),
    seed=st.integers(0, 2**32 - 1),
    spread=st.floats(0.1, 4),
)
def test_digits_of_printed_numbers_are_found(digits: int, seed: int, spread: float) -> None:
    """The bound holds and is no wider than one unit of the last digit."""
    exact = np.random.default_rng(seed).normal(size=(20, 30)) * 10 ** np.random.default_rng(seed + 1).uniform(
        -spread, spread, (20, 30)
    )
    printed = np.array([[float(f"{v:.{digits - 1}e}") for v in row] for row in exact])
    error, words = printed_accuracy(printed)
    assert words == f"{digits} significant digits"
    assert (np.abs(printed - exact) <= error * (1 + 1e-6)).all()
    assert (error <= 0.5 * 10.0 ** (1 - digits) * np.abs(printed) * (1 + 1e-9)).all()
    fixed = np.array([[float(f"{v:.{digits}f}") for v in row] for row in np.clip(exact, -9, 9) / 10])
    error, words = printed_accuracy(fixed)
    assert words == f"{digits} decimals"
    assert (error == 0.5 * 10.0**-digits).all()


def test_precision_of_binary_numbers_is_found(S_BW: Matrix) -> None:
    assert printed_accuracy(S_BW)[1] == "double precision"
    single = S_BW.astype(np.float32).astype(float)
    error, words = printed_accuracy(single)
    assert words == "single precision"
    assert (np.abs(single - S_BW) <= error).all()
    assert printed_accuracy(np.array([[1.0, 0.0, -0.5]]))[1] == "double precision"


@pytest.mark.parametrize("form", [".2e", ".3e", ".6e", ".3f", ".5f", ".8f", "single"])
def test_few_digits_are_accepted_with_an_honest_residual(
    layout: OpticalLayout, S_BW: Matrix, nodes: Matrix, form: str
) -> None:
    """The residual is that of the digits: below what they can make, and not below a thousandth of it."""
    if form == "single":
        printed = S_BW.astype(np.float32).astype(float)
    else:
        printed = np.array([[float(format(v, form)) for v in row] for row in S_BW])
    found = imported(layout, printed, nodes)
    rigid = judge_matrix(layout, found.S_BW, law_matrix(layout), nodes, found.error)
    assert all(j.passed for j in rigid)
    assert 1e-3 * rigid[0].limit < rigid[0].value < rigid[0].limit


def test_more_error_than_digits_must_be_declared(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix) -> None:
    """Finite differences: all digits printed, six good."""
    noisy = S_BW + 1e-6 * np.random.default_rng(0).normal(size=S_BW.shape)
    P = law_matrix(layout)
    found = imported(layout, noisy, nodes)
    assert not all(j.passed for j in judge_matrix(layout, found.S_BW, P, nodes, found.error))
    found = imported(layout, noisy, nodes, accuracy=1e-5)
    assert found.digits == "declared accuracy 1e-05"
    assert all(j.passed for j in judge_matrix(layout, found.S_BW, P, nodes, found.error))


def test_too_few_digits_for_the_read_out(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix) -> None:
    """Test masses per millimetre that are said to be per metre: the condition number rises beyond what digits carry."""
    short = S_BW.copy()
    short.reshape(len(S_BW), -1, 6)[:, :2, :3] *= 1e-3
    printed = np.array([[float(f"{v:.2e}") for v in row] for row in short])
    found = imported(layout, printed, nodes)
    with pytest.raises(PhysicsError, match=r"smallest singular value of the read-out matrix is 0\.001"):
        judge_matrix(layout, found.S_BW, law_matrix(layout), nodes, found.error)


def test_photodiodes_give_the_scale_of_every_row(layout: OpticalLayout, S_BW: Matrix) -> None:
    np.testing.assert_allclose(row_factors(layout, S_BW), 1.0, atol=1e-13)
    factors = np.random.default_rng(5).uniform(0.1, 10, size=(len(layout.paths), 5))
    np.testing.assert_allclose(row_factors(layout, S_BW * factors.reshape(-1, 1)), factors, rtol=1e-12)


def test_scale_of_the_rows_of_tilted_photodiodes(layout: OpticalLayout) -> None:
    """Ten degrees off the beams, where path length and slopes are no longer of size one."""
    from tedm_cli.optics.sensitivity import optical_sensitivity

    turn = Rotation.from_rotvec(np.radians(10) * np.array([0.6, 0.0, 0.8]))
    elements = tuple(
        replace(e, normal=tuple(turn.apply(e.normal)), local_y=tuple(turn.apply(e.local_y)))
        if e.kind == "photodiode" and e.local_y
        else e
        for e in layout.elements
    )
    tilted = replace(layout, elements=elements)
    S = optical_sensitivity(tilted)
    assert np.abs(S[2, tilted.columns("PD1A")][:3]).max() > 0.9
    np.testing.assert_allclose(row_factors(tilted, S), 1.0, atol=1e-13)


def test_chain_of_imported_matrices_is_that_of_the_traced(
    layout: OpticalLayout, S_BW: Matrix, about_grids: Matrix, nodes: Matrix
) -> None:
    D_opt = 1e-9 * np.random.default_rng(4).normal(size=(30, len(layout.bench), 6))
    P = import_law(layout, LabelledMatrix(law_matrix(layout), laser_labels(layout), output_labels(layout)), ANGLES)
    traced = optics_chain(layout, about_grids, D_opt)
    found = optics_chain(layout, imported(layout, about_grids, nodes, "grid").S_BW, D_opt, P=P)
    for a, b in zip(traced.sets, found.sets, strict=True):
        np.testing.assert_array_equal(a.N, b.N)


def test_another_law_is_used_everywhere(layout: OpticalLayout, about_grids: Matrix, nodes: Matrix) -> None:
    """A law in other units of its outputs: laser outputs scale, the calibrated read-out does not."""
    D_opt = 1e-9 * np.random.default_rng(4).normal(size=(30, len(layout.bench), 6))
    plain, weights = law_matrix(layout), np.random.default_rng(6).uniform(0.5, 2, size=3 * len(layout.photodiodes))
    law = LabelledMatrix(weights[:, None] * plain, laser_labels(layout), output_labels(layout))
    one, other = (optics_chain(layout, about_grids, D_opt, P=P) for P in (None, import_law(layout, law, ANGLES)))
    np.testing.assert_allclose(other.D, weights[:, None] * one.D, rtol=1e-13)
    for a, b in zip(one.sets, other.sets, strict=True):
        assert not np.allclose(a.law.O, b.law.O)
        np.testing.assert_allclose(a.N, b.N, atol=1e-13 * np.abs(a.N).max())
    judged = judge_matrix(layout, about_grids, plain, nodes)
    assert [j.name for j in judged if not j.passed] == []


def test_differences_from_the_trace_are_found_in_their_block(layout: OpticalLayout, S_BW: Matrix) -> None:
    other = S_BW.copy()
    path = layout.paths[5]
    other[layout.rows(path), layout.columns("M6")] *= 1.01
    first, second, *_ = block_differences(layout, other, S_BW)
    assert (first.path, first.element) == ("PD12A ref", "M6")
    assert 1e-4 < first.value < 1e-2
    assert second.value == 0.0


def test_a_number_that_is_none_is_named(layout: OpticalLayout, S_BW: Matrix, nodes: Matrix) -> None:
    broken = S_BW.copy()
    broken[7, 20] = np.nan
    message = f"row {output_labels(layout).names[7]}, column {input_labels(layout).names[20]} is not a finite number"
    with pytest.raises(InputError, match=re.escape(message)):
        imported(layout, broken, nodes)


def test_digits_are_found_beside_numbers_that_are_nearly_nothing() -> None:
    """What cancels to 1e-300 has no digits, and hides none of the others'."""
    values = np.array([[1.25, -3.5e-4, 1e-300], [5e-324, 2.75e5, 0.0]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        error, words = printed_accuracy(values)
    assert words == "3 significant digits"
    assert error[0, 0] == pytest.approx(0.5e-2)
    assert np.isfinite(error).all()


def test_a_photodiode_column_of_nearly_nothing_is_judged_in_silence(layout: OpticalLayout, about_grids: Matrix) -> None:
    """The slope of z2 by its own turn, against which others are taken."""
    path = layout.paths[0]
    S = about_grids.copy()
    own = S[layout.rows(path), layout.columns(path.photodiode)]
    at = np.unravel_index(np.argmax(np.abs(own[4:, 3:])), (1, 3))
    S[layout.rows(path).start + 4, layout.columns(path.photodiode).start + 3 + at[1]] = 5e-324
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not np.allclose(row_factors(layout, S)[0], 1.0)
