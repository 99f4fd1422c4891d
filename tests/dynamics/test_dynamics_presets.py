"""Noise sources: levels of the preset as published, what the actuation holds, and spectra that are refused."""

from __future__ import annotations

import numpy as np
import pytest
from dynamics_models import example_plant

from tedm_cli.dynamics.presets import held_at_rest, lpf_sources
from tedm_cli.dynamics.signals import STRAY
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw, SpectrumTable, columns
from tedm_cli.errors import InputError

#: Group: disturbances (all of one group have the same level), level, corner in Hz, slope of the power.
PUBLISHED = {
    "optical_x1": ({"n_TM1_x", "n_TM2_x"}, 35e-15, 0.0, 0.0),
    "optical_x12": ({"n_TM2_x"}, 35e-15, 0.0, 0.0),
    "optical_TM1_eta": ({"n_TM1_eta"}, 1e-10, 0.0, 0.0),
    "optical_TM2_phi": ({"n_TM2_phi"}, 1e-10, 0.0, 0.0),
    "capacitive_TM1_y": ({"n_TM1_y"}, 1.8e-9, 1e-3, 1.0),
    "capacitive_TM2_z": ({"n_TM2_z"}, 1.8e-9, 1e-3, 1.0),
    "capacitive_TM2_theta": ({"n_TM2_theta"}, 130e-9, 1e-3, 1.0),
    "star_tracker_SC_phi": ({"n_SC_phi"}, 1e-5, 0.0, 0.0),
    "thruster_Fy": ({"w_SC_Fy"}, 0.24e-6, 0.0, 0.0),
    "thruster_Lz": ({"w_SC_Lz"}, 0.24e-6, 0.0, 0.0),
    "sun_Fz": ({"w_SC_Fz"}, 10e-9, 1e-3, 1.0),
    "stray_TM1_a_x": ({"s_TM1_a_x"}, 1.23e-15, 0.63e-3, 2.0),
    "stray_TM2_omegadot_z": ({"s_TM2_omegadot_z"}, 1e-13, 0.63e-3, 2.0),
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_levels_of_the_preset(name: str) -> None:
    found = {s.name: s for s in lpf_sources(example_plant().test_masses, np.zeros(12))}
    inputs, level, corner, slope = PUBLISHED[name]
    assert set(found[name].gains) == inputs
    assert set(found[name].gains.values()) == {1.0}
    assert found[name].spectrum == PowerLaw(level, corner, slope)
    f = np.array([1e-3])
    red = (corner / 1e-3) ** slope if corner else 0.0
    np.testing.assert_allclose(found[name].spectrum.psd(f), level**2 * (1.0 + red), rtol=1e-14)


def test_one_source_for_every_degree_of_freedom() -> None:
    """x of either test mass by two, five other read-outs each, three of the star tracker, six thrusters, the Sun."""
    sources = lpf_sources(example_plant().test_masses, np.zeros(12))
    assert len(sources) == 2 + 2 * 5 + 3 + 6 + 1 + len(STRAY)
    assert (columns(sources) != 0.0).sum() == len(sources) + 1  # o1 is in both read-outs of x


def test_what_the_actuation_holds() -> None:
    """x: what test mass 2 differs by; y, z: half of it on each, apart; rotations: their own. Noise: 2 δ times it."""
    at_rest = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 10.0, 20.0, 31.0, 40.0, 50.0, 60.0]) * 1e-10
    held = np.array([0.0, -9.0, -14.0, 4.0, 5.0, 6.0, 9.0, 9.0, 14.0, 40.0, 50.0, 60.0]) * 1e-10
    np.testing.assert_allclose(held_at_rest(at_rest), held, rtol=1e-14)
    masses = example_plant().test_masses
    noise = {s.name: s for s in lpf_sources(masses, at_rest, 3e-6) if s.group == "actuation"}
    assert "actuation_TM1_Fx" not in noise, "nothing is held there"
    assert len(noise) == 11
    spectra = {name: source.spectrum for name, source in noise.items() if isinstance(source.spectrum, PowerLaw)}
    assert spectra.keys() == noise.keys()
    for name, wanted in (
        ("actuation_TM2_Fx", 9e-10 * masses[1].mass_kg),
        ("actuation_TM1_Fy", 9e-10 * masses[0].mass_kg),
        ("actuation_TM2_Lz", 60e-10 * masses[1].inertia_kg_m2[2, 2]),
    ):
        np.testing.assert_allclose(spectra[name].level, 2.0 * 3e-6 * wanted, rtol=1e-12)
    assert {(s.corner_hz, s.slope) for s in spectra.values()} == {(1e-3, 1.0)}
    assert set(noise["actuation_TM2_Lz"].gains) == {"w_TM2_Lz"}


def test_spectra_and_sources_that_are_refused() -> None:
    table = SpectrumTable((1e-3, 1e-2), (1.0, 2.0), "t")
    np.testing.assert_allclose(table.psd(np.array([1e-3, np.sqrt(1e-5), 1e-2])), [1.0, 2.0, 4.0], rtol=1e-12)
    for f in (0.9e-3, 1.1e-2):
        with pytest.raises(InputError, match="is asked for"):
            table.psd(np.array([5e-3, f]))
    with pytest.raises(InputError, match="increasing"):
        SpectrumTable((1e-3, 1e-3), (1.0, 2.0), "t")
    with pytest.raises(InputError, match="not positive"):
        SpectrumTable((1e-3, 1e-2), (1.0, 0.0), "t")
    one = NoiseSource("a", "a", {"w_SC_Fx": 1.0}, PowerLaw(1.0))
    with pytest.raises(InputError, match="two noise sources are called 'a'"):
        columns([one, one])
    with pytest.raises(InputError, match="acts on nothing"):
        columns([NoiseSource("b", "b", {}, PowerLaw(1.0))])
