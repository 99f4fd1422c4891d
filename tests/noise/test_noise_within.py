"""Gradients within areas as areas of a case: their kinds, mirror images and spectra."""

from __future__ import annotations

import numpy as np
import pytest

from tedm_cli.errors import ConfigError, InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation import CorrelationCase, blocks, correlation
from tedm_cli.noise.selection import BlockSelector
from tedm_cli.noise.temperature import ShapedSpectrum, TemperatureModel, WhiteSpectrum

MODEL = AreaTable(
    np.array(["A_PLUS", "A_MINUS"]),
    np.array(["bench", "bench"]),
    np.array(["inside", "inside"]),
    np.array(["+y", "-y"]),
    np.array([[0.0, 0.1, 0.0], [0.0, -0.1, 0.0]]),
)


def gradients(axes: str, sides: tuple[str, ...] = ("+y", "-y")) -> AreaTable:
    """Of both areas along the axes, those of +y first."""
    names = [f"{'A_PLUS' if side == '+y' else 'A_MINUS'} grad {axis}" for side in sides for axis in axes]
    n = len(names)
    return AreaTable(
        np.array(names),
        np.full(n, "bench"),
        np.full(n, "inside"),
        np.repeat(sides, len(axes)),
        np.array([[0.0, 0.1 if side == "+y" else -0.1, 0.0] for side in sides for _ in axes]),
        kind=np.array([f"gradient_{axis}" for _ in sides for axis in axes]),
    )


def test_they_are_behind_the_areas_of_the_model() -> None:
    found = MODEL.and_last(gradients("xz"))
    assert found.name.tolist() == [*MODEL.name, *gradients("xz").name]
    assert found.gradient.tolist() == found.within.tolist() == [False] * 2 + [True] * 4
    assert found.unit == ["K"] * 2 + ["K/m"] * 4
    assert found.centroid_m is not None
    assert found.centroid_m[:, 1].tolist() == [0.1, -0.1, 0.1, 0.1, -0.1, -0.1]
    assert set(found.group_by_unit) == {"bench", "bench (gradients)"}
    with pytest.raises(InputError, match="'A_MINUS grad x' is used 2 times"):
        found.and_last(gradients("x"))


def test_each_has_its_image_along_the_same_axis() -> None:
    """All three of an area have one centroid."""
    areas = MODEL.and_last(gradients("xyz"))
    mirror = CorrelationCase("1", "", (BlockSelector(areas=("*",), partition="mirror"),))
    heard = np.ones(len(areas), dtype=bool)
    pairs = [areas.name[b].tolist() for b in correlation(mirror, areas, heard).blocks]
    wanted = [[f"A_PLUS{g}", f"A_MINUS{g}"] for g in ("", " grad x", " grad y", " grad z")]
    assert pairs == wanted
    one_sided = MODEL.and_last(gradients("x", ("+y",))).and_last(gradients("y", ("-y",)))
    with pytest.raises(ConfigError, match=r"without a mirror image .*: A_PLUS grad x, A_MINUS grad y"):
        correlation(mirror, one_sided, np.ones(4, dtype=bool))
    assert [b.tolist() for b in blocks(mirror, areas)] == [[0, 1]], "silent gradients are in no block"


def test_their_spectra_keep_their_shapes_and_units() -> None:
    """A shape that the model's areas have too is another one in K/m: filters and words are apart."""
    model = TemperatureModel.from_spectra([WhiteSpectrum(2.0), ShapedSpectrum(3.0)])
    found = model.and_gradients([WhiteSpectrum(5.0), ShapedSpectrum(7.0, order=1.0)])
    f = np.array([1e-3, 1e-2])
    np.testing.assert_array_equal(found.amplitudes(f)[:2], model.amplitudes(f))
    np.testing.assert_array_equal(found.amplitudes(f)[2], [5.0, 5.0])
    np.testing.assert_allclose(found.amplitudes(f)[3], ShapedSpectrum(7.0, order=1.0).amplitude(f), rtol=1e-15)
    assert found.gradient.tolist() == [False, False, True, True]
    assert found.heard.all()
    assert found.words().startswith(f"{model.words()}; 5 K/m/sqrt(Hz), white; 7 K/m/sqrt(Hz), low-pass of order 1")
