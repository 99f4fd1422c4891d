"""Units of finite-element models: systems by name, and the factors that bring a deck's numbers to SI.

A deck has no units: its numbers are in any system in which force is mass times length over time squared. What is read
of it is converted by the dimension of each quantity, not card by card: every sum and product of numbers of a deck is in
the deck's system.
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal

_INCH_M = 0.0254
_POUND_FORCE_N = 4.4482216152605
_FREEZING_K = Decimal("273.15")
STANDARD_GRAVITY = 9.80665
"""m/s², by which weights are masses."""


@dataclass(frozen=True)
class Dimension:
    """Exponents of length, mass, time and temperature in a quantity."""

    length: int = 0
    mass: int = 0
    time: int = 0
    temperature: int = 0


NUMBER = Dimension()
LENGTH, AREA, AREA_MOMENT = Dimension(length=1), Dimension(length=2), Dimension(length=4)
MASS, INERTIA, DENSITY = Dimension(mass=1), Dimension(mass=1, length=2), Dimension(mass=1, length=-3)
ACCELERATION, FORCE = Dimension(length=1, time=-2), Dimension(length=1, mass=1, time=-2)
STRESS = Dimension(mass=1, length=-1, time=-2)
FORCE_PER_LENGTH, MOMENT = Dimension(mass=1, time=-2), Dimension(mass=1, length=2, time=-2)
TEMPERATURE, EXPANSION = Dimension(temperature=1), Dimension(temperature=-1)
CONDUCTIVITY = Dimension(length=1, mass=1, time=-3, temperature=-1)
TEMPERATURE_GRADIENT = Dimension(temperature=1, length=-1)

# Degrees per kelvin, and what the scale shows at 273.15 K. Decks in degrees Celsius that say nothing count as K: their
# steps are the same.
_SCALES = {"K": (Decimal(1), _FREEZING_K), "degC": (Decimal(1), Decimal(0)), "degF": (Decimal("1.8"), Decimal(32))}
TEMPERATURES = tuple(_SCALES)


@dataclass(frozen=True)
class DeckUnits:
    """One unit of length, mass and time of a deck in SI, and its scale of temperature."""

    length_m: float = 1.0
    mass_kg: float = 1.0
    time_s: float = 1.0
    temperature: str = "K"

    @property
    def name(self) -> str:
        """As the configuration says it."""
        named = next((n for n, s in SYSTEMS.items() if s == (self.length_m, self.mass_kg, self.time_s)), None)
        if named is not None:
            return f'units = "{named}"'
        return f"length_m = {self.length_m:g}, mass_kg = {self.mass_kg:g}, time_s = {self.time_s:g}"

    @property
    def degrees_per_kelvin(self) -> Decimal:
        """What a step of 1 K is in the deck, exactly."""
        return _SCALES[self.temperature][0]

    @property
    def gravity(self) -> float:
        """Standard gravity in the deck's units: densities that are weights are masses after a division by it."""
        return STANDARD_GRAVITY / self.length_m * self.time_s**2

    def factor(self, dimension: Dimension) -> float:
        """What a number of the deck is multiplied by; temperatures count from the zero of their own scale."""
        return float(
            self.length_m**dimension.length
            * self.mass_kg**dimension.mass
            * self.time_s**dimension.time
            / float(self.degrees_per_kelvin) ** dimension.temperature
        )

    def shown_at(self, kelvin: Decimal) -> Decimal:
        """A temperature as the deck writes it."""
        degrees, freezing = _SCALES[self.temperature]
        return (kelvin - _FREEZING_K) * degrees + freezing


SYSTEMS = {
    "m-kg-s": (1.0, 1.0, 1.0),
    "mm-t-s": (1e-3, 1e3, 1.0),
    "mm-kg-s": (1e-3, 1.0, 1.0),
    "in-lbf-s": (_INCH_M, _POUND_FORCE_N / _INCH_M, 1.0),
}
"""Units of length (m), mass (kg) and time (s) by name; the mass of in-lbf-s is lbf s²/in, some 175 kg."""
SI = DeckUnits()
