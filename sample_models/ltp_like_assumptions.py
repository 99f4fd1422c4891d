"""What the thermal network of the LTP-like sample is given: every value with its source, in tables of one unit each.

"assumption" is a round number of the usual size that has no source. Run as a script, it prints the table that
the documentation shows ("The shipped sample").
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
MAKER = "Schott, ZERODUR"  # data of the maker, as encyclopedias quote them
# CRC Handbook of Chemistry and Physics, 97th ed. (2016): Thermal and Physical Properties of Pure Metals; c_p at 25 °C
CRC = "CRC Handbook"
# data sheets of ASM Aerospace Specification Metals: Titanium Ti-6Al-4V (Grade 5), Annealed; Aluminum 6061-T6
ASM = "ASM data"
BOOK = "Fortescue"  # Fortescue, Swinerd, Stark: Spacecraft Systems Engineering, 4th ed. (2011), table 11.3

C_P = Table(
    "specific heat",
    "J/(kg K)",
    {
        "zerodur": (820.0, f"{MAKER}, 25 °C"),
        "titanium": (526.0, f"{ASM}, Ti-6Al-4V"),
        "molybdenum": (251.0, CRC),
        "tungsten": (132.0, CRC),
        "gold_platinum": (130.0, f"{CRC}, 73 % gold and 27 % platinum by mass"),
        "aluminium": (896.0, f"{ASM}, 6061-T6"),
        "window_glass": (550.0, ASSUMED),
        "glass_fibre": (900.0, ASSUMED),
        "electronics": (900.0, ASSUMED),
    },
)
K = Table(
    "conductivity",
    "W/(m K)",
    {
        "zerodur": (1.46, f"{MAKER}, 20 °C"),
        "titanium": (6.7, f"{ASM}, Ti-6Al-4V"),
        "molybdenum": (138.0, CRC),
        "tungsten": (174.0, CRC),
        "aluminium": (167.0, f"{ASM}, 6061-T6"),
        "window_glass": (0.8, ASSUMED),
        "glass_fibre": (0.5, ASSUMED),
    },
)
EMITTANCE = Table(
    "emittance",
    "1",
    {
        "SC": (0.85, f"{BOOK}: black paint (epoxy)"),
        "UNIT": (0.85, f"{BOOK}: black paint (epoxy)"),
        "SHIELD": (0.08, f"{BOOK}: polished aluminium"),
        "STRUT": (0.05, f"{BOOK}: wrapped in aluminised Kapton, aluminium outside"),
        "VE": (0.60, f"{BOOK}: polished titanium"),
        "SUPPORT": (0.60, f"{BOOK}: polished titanium"),
        "CAGING": (0.60, f"{BOOK}: polished titanium"),
        "BRACKET": (0.60, f"{BOOK}: polished titanium"),
        "PUMP": (0.60, f"{BOOK}: polished titanium"),
        "FLANGE": (0.60, f"{BOOK}: polished titanium"),
        "EH": (0.04, f"{BOOK}: gold"),
        "TM": (0.04, f"{BOOK}: gold"),
        "CM": (0.10, f"{ASSUMED}: bare tungsten"),
        "OB": (0.85, f"{ASSUMED}: bare glass ceramic"),
        "WINDOW": (0.85, f"{ASSUMED}: bare glass"),
    },
)
CONTACT = Table(
    "conductance of a joint by its area",
    "W/(m2 K)",
    {
        "BRACKET and EH": (500.0, f"{ASSUMED}: bolts"),
        "BRACKET and FLANGE": (500.0, f"{ASSUMED}: bolts"),
        "BRACKET and OB": (200.0, f"{ASSUMED}: bolts into inserts"),
        "BRACKET and VE": (500.0, f"{ASSUMED}: bolts"),
        "CAGING and VE": (500.0, f"{ASSUMED}: bolts"),
        "CM and EH": (500.0, f"{ASSUMED}: bolts"),
        "EH and EH": (1000.0, f"{ASSUMED}: many bolts"),
        "EH and SUPPORT": (100.0, f"{ASSUMED}: insulating spacers"),
        "FLANGE and OB": (200.0, f"{ASSUMED}: bolts into inserts"),
        "PUMP and VE": (500.0, f"{ASSUMED}: bolts"),
        "SUPPORT and VE": (500.0, f"{ASSUMED}: bolts"),
        "VE and WINDOW": (500.0, f"{ASSUMED}: seal"),
    },
)
LINK = Table(
    "conductance of a link",
    "W/K",
    {
        "flange to hub": (0.1, f"{ASSUMED}: a stud"),
        "concentrated mass": (0.5, f"{ASSUMED}: bolted base"),
        "unit to panel": (2.0, f"{ASSUMED}: bolted base"),
        "harness of front-end electronics": (3e-3, f"{ASSUMED}: 50 copper wires of 0.08 mm2, 0.5 m"),
        "harness of a photodiode": (6e-4, f"{ASSUMED}: 10 copper wires of 0.08 mm2, 0.5 m"),
        "stand-off of a shield's panel": (5e-3, ASSUMED),
    },
)
LENGTH = Table(
    "length of the shield",
    "m",
    {
        "half length along x": (0.290, ASSUMED),
        "half length along y": (0.127, f"{ASSUMED}: between sidewalls and flanges"),
        "half length along z": (0.090, ASSUMED),
        "skin": (0.3e-3, f"{ASSUMED}: aluminium, two on each panel"),
    },
)
CORE = Table(
    "conductance of the shield's core by its area", "W/(m2 K)", {"core": (50.0, f"{ASSUMED}: 20 mm honeycomb")}
)
AREA = Table(
    "area that sees the shield",
    "m2",
    {"unit": (0.02, ASSUMED), "front-end electronics": (0.01, ASSUMED)},
)
DENSITY = Table("density", "kg/m3", {"aluminium": (2700.0, f"{ASM}, 6061-T6")})
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
        "MINUS_Z": (288.15, f"{ASSUMED}: shadow"),
        "PLUS_Z": (298.15, f"{ASSUMED}: below the solar array"),
    },
)
TABLES = (C_P, K, EMITTANCE, CONTACT, LINK, LENGTH, CORE, AREA, DENSITY, MASS, POWER, TEMPERATURE)

#: units of the spacecraft, and the panel that each is on
UNITS = {"FEE_1": "MINUS_X", "FEE_2": "PLUS_X", "PHASEMETER": "PLUS_Y", "LASER": "MINUS_Y"}


def page() -> str:
    """All values as one table in Markdown; names of one kind with the same value and source share a line."""
    lines = ["| quantity | of | value | source |", "|---|---|---|---|"]
    for table in TABLES:
        alike: dict[tuple[float, str], list[str]] = {}
        for name, row in table.rows.items():
            alike.setdefault(row, []).append(name)
        unit = "" if table.unit == "1" else f" {table.unit}"
        for (value, source), names in alike.items():
            lines.append(f"| {table.title} | {', '.join(names)} | {value:g}{unit} | {source} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    print(page(), end="")
