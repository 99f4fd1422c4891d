"""Units of decks: what they are said to be in, and what they cannot be in."""

from __future__ import annotations

from pathlib import Path

import pytest
from border_tools import Project, replace, untouched


def scale_lengths(deck: Path, factor: float) -> None:
    """Multiply the coordinates of a deck whose grids are in free fields."""
    lines = deck.read_text().splitlines()
    for i, line in enumerate(lines):
        if line.startswith("GRID,"):
            head, x, y, z = line.rsplit(",", 3)
            lines[i] = ",".join(
                [head, *(f"{float(v) * factor:g}" + "." * (float(v) * factor % 1 == 0) for v in (x, y, z))]
            )
    deck.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize(
    ("factor", "density", "concentrated", "piece", "advice"),
    [
        (1e3, "2700.", "", "200 m long", "mm and kg/m3, have to be made one"),
        (1e3, "2.7-9", "", "200 m long", 'units = "mm-t-s": the model would be 0.2 m long and of'),
        (1e3, "2.7-6", "", "200 m long", 'units = "mm-kg-s": the model would be 0.2 m long and of'),
        (39.37, "2.527-4", "", "0.0002527 kg/m3", 'units = "in-lbf-s": the model would be 0.2 m long and of'),
        (39.37, ".0975", "", "0.0975 kg/m3", 'PARAM,WTMASS = 0.00259008, and with [model] units = "in-lbf-s"'),
        (1.0, "2.7", "PARAM,WTMASS,.001\n", "0.0027 kg/m3", "which is read as units"),
        (1.0, "2700.", "PARAM,WTMASS,.001\n", "2.7 kg/m3", "PARAM,WTMASS = 0.001 multiplies densities that"),
        (1e2, "2700.", "", "5.4e+06 kg", "which is read as units"),
        (1.0, "2.7-9", "", "2.7e-09 kg/m3", "which is read as units"),
        (1.0, "2.7", "", "2.7 kg/m3", "which is read as units"),
        (3.28084, "5.239", "", "5.239 kg/m3", "which is read as units"),
        (1.0, "2.7+6", "", "2.7e+06 kg/m3", "which is read as units"),
        (
            4e2,
            "0.",
            "CONM2,77,3,,2.\n",
            "2 kg on a length of 80 m",
            'it could be "mm-kg-s": 0.08 m long and of 2 kg; "in-lb',
        ),
        (1e-3, "2700.", "", "0.0002 m long", "which is read as units"),
    ],
)
def test_other_units_than_were_said(
    tiny: Project, factor: float, density: str, concentrated: str, piece: str, advice: str
) -> None:
    scale_lengths(tiny.deck, factor)
    replace(tiny.deck, "2700.", density)
    replace(tiny.deck, "ENDDATA", concentrated + "ENDDATA")
    with untouched(tiny.folder):  # said before anything is solved
        tiny.run("ingest").refused(4, "unit_loads.bdf", piece, hint=advice)
        tiny.run("solve", "--run", "no-such-nastran {deck}").refused(4, "unit_loads.bdf", piece, hint=advice)


def test_other_units_than_were_said_are_told_before_a_deck_is_written_or_solved(tiny: Project) -> None:
    for file in (tiny.folder / "model.bdf", tiny.deck):
        scale_lengths(file, 1e3)
        replace(file, "2700.", "2.7-9")
    with untouched(tiny.folder):
        for command in ("areas", "write-deck", "solve", "ingest"):
            tiny.run(command).refused(4, "bdf: the model is 200 m long", hint='set [model] units = "mm-t-s"')


def test_wtmass_against_the_units(tiny: Project) -> None:
    """Tonnes per cubic millimetre are masses already: a thousandth of them is what no solid has."""
    scale_lengths(tiny.deck, 1e3)
    replace(tiny.deck, "2700.", "2.7-9")
    replace(tiny.deck, "ENDDATA", "PARAM,WTMASS,.001\nENDDATA")
    replace(tiny.model, "[model]", '[model]\nunits = "mm-t-s"')
    advice = "PARAM,WTMASS = 0.001 multiplies densities that seem to be masses already: without it, and with [model]"
    for command in ("solve", "ingest"):
        with untouched(tiny.folder):
            tiny.run(command).refused(4, "the densest element (1) has 2.7 kg/m3", hint=f'{advice} units = "mm-t-s"')


@pytest.mark.parametrize(
    ("keys", "facts"),
    [
        ('units = "mm-ton-s"', ["model.units: no system of units is called 'mm-ton-s'; did you mean mm-t-s?"]),
        ('units = "SI"', ["model.units: no system of units is called 'SI' (known: m-kg-s, mm-t-s, mm-kg-s, in-lbf-s;"]),
        ('units = "mm-t-s"\nlength_m = 0.001', ["model: units and length_m both say what the units are"]),
        ("length_m = 0.001\nmass_kg = 1.0", ["model: length_m, mass_kg without time_s: a system has all three"]),
        ("length_m = 1e-12\nmass_kg = 1.0\ntime_s = 1.0", ["model.length_m: length 1e-12 is outside 1e-09 to"]),
        ('temperature = "F"', ["model.temperature: must be 'K', 'degC' or 'degF' (found 'F')"]),
    ],
)
def test_units_that_are_none(tiny: Project, keys: str, facts: list[str]) -> None:
    replace(tiny.folder / "model.toml", "[model]", "[model]\n" + keys)
    for command in ("areas", "write-deck", "solve", "ingest"):
        tiny.run(command).refused(3, *facts)
