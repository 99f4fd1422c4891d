"""The conduction matrix: constants, linear fields, symmetry, exact conductances, refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fem_models import KINDS, rotation_matrix
from mapping_models import bar, box, mesh, plate

from tedm_cli.errors import PhysicsError
from tedm_cli.fem.conduction import conducting_links, conduction_matrix

SOLIDS = sorted({(card, nodes) for card, nodes, _ in KINDS})
PYRAMID = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.4, 0.5, 0.8]])
G = np.array([3.0, -2.0, 1.5])  # K/m


def quadratic_plates():
    """CQUAD8 and CTRIA6."""
    corners = np.array([[0, 0, 0], [2, 0.1, 0], [1.8, 1.1, 0], [0.1, 1, 0.0]])
    middle = [(corners[i] + corners[(i + 1) % 4]) / 2 for i in range(4)]
    yield mesh(np.vstack([corners, middle]), ("CQUAD8", [range(8)]), section=0.01)
    middle = [(corners[i] + corners[(i + 1) % 3]) / 2 for i in range(3)]
    yield mesh(np.vstack([corners[:3], middle]), ("CTRIA6", [range(6)]), section=0.01)


def every():
    """One of each kind, with its volume."""
    yield from (pytest.param(box(*kind), 0.3 * 0.2 * 0.1, id=f"{kind[0]}{kind[1]}") for kind in SOLIDS)
    yield pytest.param(mesh(PYRAMID, ("CPYRAM", [range(5)])), 0.8 / 3, id="CPYRAM")
    yield pytest.param(plate((4, 3), distortion=0.2), 0.4 * 0.2 * 2e-3, id="CQUAD4")
    yield pytest.param(plate((4, 3), corners=3, distortion=0.2), 0.4 * 0.2 * 2e-3, id="CTRIA3")
    yield pytest.param(bar(5), 1e-4, id="CROD")


EVERY = list(every())


@pytest.mark.parametrize(("of", "volume"), EVERY)
def test_energy_of_a_linear_field_is_exact(of, volume) -> None:
    """½ Tᵀ K T = ½ ∫ k |∇T|² dV whatever the distortion: the patch test of conduction; in any position in space."""
    turn = rotation_matrix((1.0, 2.0, -1.0), 0.7)
    k = conduction_matrix(of)
    extent = [np.ptp(of.position[:, i]) > 1e-12 for i in range(3)]  # a flat element feels nothing across it
    moved = replace(of, position=of.position @ turn.T + [5.0, -3.0, 2.0])
    for one, gradient in ((k, G), (conduction_matrix(moved), turn @ G)):
        field = (of if one is k else moved).position @ gradient
        wanted = of.conductivity[0] * (G[extent] ** 2).sum() * volume
        assert field @ (one @ field) == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize(("of", "volume"), EVERY)
def test_symmetric_semidefinite_and_constants_alone_flow_nowhere(of, volume) -> None:
    k = conduction_matrix(of).toarray()
    scale = np.abs(k).max()
    assert np.abs(k - k.T).max() < 1e-14 * scale
    assert np.abs(k.sum(axis=0)).max() < 1e-13 * scale
    eigenvalue = np.linalg.eigvalsh(k) / scale
    assert eigenvalue[0] > -1e-12
    assert (np.abs(eigenvalue) < 1e-10).sum() == 1, "constants, and no spurious mode"


@pytest.mark.parametrize("of", list(quadratic_plates()), ids=["CQUAD8", "CTRIA6"])
def test_quadratic_plates_have_their_rank(of) -> None:
    k = conduction_matrix(of).toarray()
    assert (np.linalg.eigvalsh(k) < 1e-10 * np.abs(k).max()).sum() == 1


def test_conductances_known_by_hand() -> None:
    """A rod k A / L; a square plate of one element 2/3 k t on its diagonal; a cube k a / 3."""
    assert conduction_matrix(bar(1, length=0.5, k=200.0, area=3e-4))[0, 0] == pytest.approx(
        200.0 * 3e-4 / 0.5, rel=1e-14
    )
    assert conduction_matrix(plate((1, 1), (0.2, 0.2), k=10.0, thickness=0.01))[0, 0] == pytest.approx(
        2 / 3 * 10.0 * 0.01, rel=1e-13
    )
    one = mesh(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]) * 0.3,
               ("CHEXA", [range(8)]), k=7.0)  # fmt: skip
    assert conduction_matrix(one)[0, 0] == pytest.approx(7.0 * 0.3 / 3, rel=1e-13)


def test_elements_without_conductivity_are_not_there() -> None:
    whole, half = bar(4), bar(4, k=np.array([100.0, 0.0, 100.0, 100.0]))
    k = conduction_matrix(half).toarray()
    assert k[1, 2] == 0.0
    assert conduction_matrix(whole)[1, 2] < 0.0
    assert k[2, 3] == pytest.approx(conduction_matrix(whole)[2, 3])


def test_links_conduct_as_rods() -> None:
    rod = conduction_matrix(bar(3, length=3.0, k=2.0, area=1.0)).toarray()
    links = conducting_links(4, np.arange(3), np.arange(1, 4), np.full(3, 2.0))
    np.testing.assert_allclose(links.toarray(), rod, rtol=0, atol=1e-15)


def test_inside_out_is_no_harm_and_tangled_is_named() -> None:
    one = box("CHEXA", 8, (1, 1, 1), 0.0)
    flipped = mesh(one.position, ("CHEXA", [one.node_index[[4, 5, 6, 7, 0, 1, 2, 3]]]))
    np.testing.assert_allclose(conduction_matrix(flipped).toarray(), conduction_matrix(one).toarray(), atol=1e-12)
    tangled = mesh(one.position, ("CHEXA", [one.node_index[[1, 0, 2, 3, 4, 5, 6, 7]]]))
    with pytest.raises(PhysicsError, match=r"1 conducting element\(s\) that are tangled or have no extent: 1"):
        conduction_matrix(tangled)
    with pytest.raises(PhysicsError, match="no extent: 2"):
        conduction_matrix(mesh([[0, 0, 0], [1, 0, 0], [1, 0, 0]], ("CROD", [(0, 1), (1, 2)])))
