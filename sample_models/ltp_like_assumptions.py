"""What the thermal network of the LTP-like sample is given: every value with its source, in tables of one unit each.

"assumption" is a round number of the usual size that has no source. `docs/explanation/sample.md` shows these tables.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """Values of one kind, each with its source."""

    title: str
    unit: str
    rows: dict[str, tuple[float, str]]

    def __getitem__(self, name: str) -> float:
        if name not in self.rows:
            raise SystemExit(f"no {self.title} is assumed for {name}")
        return self.rows[name][0]


ASSUMED = "assumption"
TEXTBOOK = "Fortescue et al., Spacecraft Systems Engineering, 4th ed., table 11.3"

C_P = Table(
    "specific heat",
    "J/(kg K)",
    {
        "zerodur": (820.0, "handbook, 25 °C"),
        "titanium": (526.0, "handbook, Ti-6Al-4V, 25 °C"),
        "molybdenum": (251.0, "handbook"),
        "tungsten": (132.0, "handbook"),
        "gold_platinum": (130.0, "handbook, 73 % gold and 27 % platinum by mass"),
        "aluminium": (896.0, "handbook, 6061"),
        "window_glass": (550.0, ASSUMED),
        "glass_fibre": (900.0, ASSUMED),
        "electronics": (900.0, ASSUMED),
    },
)
K = Table(
    "conductivity",
    "W/(m K)",
    {
        "zerodur": (1.46, "handbook, 20 °C"),
        "titanium": (6.7, "handbook, Ti-6Al-4V"),
        "molybdenum": (138.0, "handbook"),
        "tungsten": (174.0, "handbook"),
        "aluminium": (167.0, "handbook, 6061"),
        "window_glass": (0.8, ASSUMED),
        "glass_fibre": (0.5, ASSUMED),
    },
)
EMITTANCE = Table(
    "emittance",
    "1",
    {
        "SC": (0.85, f"black paint: {TEXTBOOK}"),
        "UNIT": (0.85, f"black paint: {TEXTBOOK}"),
        "SHIELD": (0.08, f"polished aluminium: {TEXTBOOK}"),
        "STRUT": (0.05, f"wrapped in aluminised Kapton: {TEXTBOOK}"),
        "VE": (0.60, f"titanium: {TEXTBOOK}"),
        "SUPPORT": (0.60, f"titanium: {TEXTBOOK}"),
        "CAGING": (0.60, f"titanium: {TEXTBOOK}"),
        "BRACKET": (0.60, f"titanium: {TEXTBOOK}"),
        "PUMP": (0.60, f"titanium: {TEXTBOOK}"),
        "FLANGE": (0.60, f"titanium: {TEXTBOOK}"),
        "EH": (0.04, f"gold: {TEXTBOOK}"),
        "TM": (0.04, f"gold: {TEXTBOOK}"),
        "CM": (0.10, f"bare tungsten: {ASSUMED}"),
        "OB": (0.85, f"bare glass ceramic: {ASSUMED}"),
        "WINDOW": (0.85, f"bare glass: {ASSUMED}"),
    },
)
CONTACT = Table(
    "conductance of a joint by its area",
    "W/(m2 K)",
    {
        "BRACKET and EH": (500.0, f"bolts: {ASSUMED}"),
        "BRACKET and FLANGE": (500.0, f"bolts: {ASSUMED}"),
        "BRACKET and OB": (200.0, f"bolts into inserts: {ASSUMED}"),
        "BRACKET and VE": (500.0, f"bolts: {ASSUMED}"),
        "CAGING and VE": (500.0, f"bolts: {ASSUMED}"),
        "CM and EH": (500.0, f"bolts: {ASSUMED}"),
        "EH and EH": (1000.0, f"many bolts: {ASSUMED}"),
        "EH and SUPPORT": (100.0, f"insulating spacers: {ASSUMED}"),
        "FLANGE and OB": (200.0, f"bolts into inserts: {ASSUMED}"),
        "PUMP and VE": (500.0, f"bolts: {ASSUMED}"),
        "SUPPORT and VE": (500.0, f"bolts: {ASSUMED}"),
        "VE and WINDOW": (500.0, f"seal: {ASSUMED}"),
    },
)
LINK = Table(
    "conductance of a link",
    "W/K",
    {
        "flange to hub": (0.1, f"a stud: {ASSUMED}"),
        "concentrated mass": (0.5, f"bolted base: {ASSUMED}"),
        "unit to panel": (2.0, f"bolted base: {ASSUMED}"),
        "harness of front-end electronics": (3e-3, f"50 copper wires of 0.08 mm2, 0.5 m: {ASSUMED}"),
        "harness of a photodiode": (6e-4, f"10 copper wires of 0.08 mm2, 0.5 m: {ASSUMED}"),
        "stand-off of a shield's panel": (5e-3, ASSUMED),
    },
)
LENGTH = Table(
    "length of the shield",
    "m",
    {
        "half length along x": (0.290, ASSUMED),
        "half length along y": (0.127, f"between sidewalls and flanges: {ASSUMED}"),
        "half length along z": (0.090, ASSUMED),
        "skin": (0.3e-3, f"aluminium, two on each panel: {ASSUMED}"),
    },
)
CORE = Table(
    "conductance of the shield's core by its area", "W/(m2 K)", {"core": (50.0, f"20 mm honeycomb: {ASSUMED}")}
)
AREA = Table(
    "area that sees the shield",
    "m2",
    {"unit": (0.02, ASSUMED), "front-end electronics": (0.01, ASSUMED)},
)
DENSITY = Table("density", "kg/m3", {"aluminium": (2700.0, "handbook, 6061")})
MASS = Table(
    "mass",
    "kg",
    {
        "test mass": (1.96, "configs/model.toml"),
        "FEE_1": (4.0, ASSUMED),
        "FEE_2": (4.0, ASSUMED),
        "PHASEMETER": (8.0, ASSUMED),
        "LASER": (10.0, ASSUMED),
    },
)
POWER = Table(
    "power",
    "W",
    {
        "FEE_1": (10.0, ASSUMED),
        "FEE_2": (10.0, ASSUMED),
        "PHASEMETER": (20.0, ASSUMED),
        "LASER": (25.0, ASSUMED),
        "front-end electronics on a sensor": (0.2, ASSUMED),
        "photodiode with its amplifier": (0.01, ASSUMED),
    },
)
TEMPERATURE = Table(
    "temperature of a spacecraft's panel",
    "K",
    {
        "MINUS_X": (293.15, ASSUMED),
        "PLUS_X": (293.15, ASSUMED),
        "MINUS_Y": (293.15, ASSUMED),
        "PLUS_Y": (293.15, ASSUMED),
        "MINUS_Z": (288.15, f"shadow: {ASSUMED}"),
        "PLUS_Z": (298.15, f"below the solar array: {ASSUMED}"),
    },
)
TABLES = (C_P, K, EMITTANCE, CONTACT, LINK, LENGTH, CORE, AREA, DENSITY, MASS, POWER, TEMPERATURE)

#: units of the spacecraft, and the panel that each is on
UNITS = {"FEE_1": "MINUS_X", "FEE_2": "PLUS_X", "PHASEMETER": "PLUS_Y", "LASER": "MINUS_Y"}
