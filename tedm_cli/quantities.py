"""Quantities that users give, with the bounds outside which a value is a slip of unit, exponent or key.

The bounds are far beyond any mission or laboratory, and near enough for every product of a chain to stay finite.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import AnyArray


@dataclass(frozen=True)
class Quantity:
    """A quantity, its unit ("" for plain numbers), and its bounds, both included.

    `least`: smallest magnitude of a value other than zero.
    """

    name: str
    unit: str
    low: float
    high: float
    least: float = 0.0

    @property
    def range(self) -> str:
        """Both bounds with the unit, in words."""
        return f"{_shown(self.low)} to {_shown(self.high)}" + (f" {self.unit}" if self.unit else "")

    def fact(self, value: float) -> str:
        """What is wrong with a value, in words; empty where nothing is."""
        unit = f" {self.unit}" if self.unit else ""
        if not self.low <= value <= self.high:  # not a number compares as false
            return f"{self.name} {_shown(value)} is outside {self.range}"
        if value != 0 and abs(value) < self.least:
            return f"{self.name} {_shown(value)} is neither 0 nor at least {_shown(self.least)}{unit}"
        return ""

    def first_outside(self, values: AnyArray) -> tuple[int, ...] | None:
        """Index of the first of real `values` that `fact` finds fault with; None where there is none."""
        size = np.abs(values)
        sound = (values >= self.low) & (values <= self.high) & ((values == 0.0) | (size >= self.least))
        return None if sound.all() else tuple(int(i) for i in np.argwhere(~sound)[0])


def _shown(value: float) -> str:
    """A number in few characters; whole numbers in full where they are not absurd."""
    if not isinstance(value, int):
        return f"{value:g}"
    if abs(value) < 10**20:
        return f"{value:,}"
    return f"{'-' if value < 0 else ''}1e{int(abs(value).bit_length() * math.log10(2.0))}"


# Lengths: from films to the largest structures; coordinates and optical paths reach to other satellites and stars.
LENGTH = Quantity("length", "m", 1e-9, 1e4)
LENGTH_OR_ZERO = Quantity("length", "m", 0.0, 1e4, 1e-12)
OFFSET = Quantity("offset", "m", -1e4, 1e4)
COORDINATE = Quantity("coordinate", "m", -1e6, 1e6)
FAR_COORDINATE = Quantity("coordinate", "m", -1e13, 1e13)
OPTICAL_PATH = Quantity("optical path", "m", -1e13, 1e13)
RADIUS_OF_CURVATURE = Quantity("radius of curvature", "m", -1e15, 1e15, 1e-6)
CORRELATION_LENGTH = Quantity("correlation length", "mm", 1e-3, 1e9)
LENGTH_TOLERANCE = Quantity("tolerance", "m", 1e-15, 1e13)
WAVELENGTH = Quantity("wavelength", "m", 1e-12, 1e3)
REFRACTIVE_INDEX = Quantity("refractive index", "", 1.0, 10.0)

# Angles and directions: what is no unit vector is said better by its length.
ANGLE = Quantity("angle", "rad", -1e3, 1e3)
ANGLE_DEG = Quantity("angle", "deg", -1e4, 1e4)
ANGLE_TOLERANCE = Quantity("tolerance", "rad", 1e-15, 3.2)
DIRECTION = Quantity("component of a direction", "", -1e3, 1e3)

# Masses: from levitated spheres to test stands; a point mass may stand for a mountain or the Sun.
MASS = Quantity("mass", "kg", 1e-18, 1e6)
POINT_MASS = Quantity("mass", "kg", 1e-20, 1e31)
DENSITY = Quantity("density", "kg/m^3", 1e-3, 1e6)
GRAVITATIONAL_CONSTANT = Quantity("gravitational constant", "m^3/(kg s^2)", 6e-11, 7.5e-11)

# Temperatures: those of a series may be differences from any other; spectra of an area that is silent are 0.
TEMPERATURE = Quantity("temperature", "K", -1e4, 1e4)
ABSOLUTE_TEMPERATURE = Quantity("temperature", "K", 0.0, 1e4)
TEMPERATURE_GRADIENT = Quantity("temperature gradient", "K/m", -1e6, 1e6)
TEMPERATURE_ASD = Quantity("temperature level", "K/sqrt(Hz)", 0.0, 1e6, 1e-20)
GRADIENT = Quantity("temperature gradient", "K/m", -1e6, 1e6)
GRADIENT_ASD = Quantity("level of a temperature gradient", "K/m/sqrt(Hz)", 0.0, 1e8, 1e-20)
CELSIUS = Quantity("temperature", "degC", -273.15, 1e4)
EXPANSION = Quantity("coefficient of expansion", "1/K", -1.0, 1.0)
PLATE_EXPANSION = Quantity("coefficient of expansion", "1/K", -1e-2, 1e-2)
MOISTURE = Quantity("change of moisture", "%", -100.0, 100.0, 1e-9)
SWELLING = Quantity("coefficient of moisture expansion", "per %", -1.0, 1.0)
FIELD_OF_GRAVITY = Quantity("field of gravity", "m/s^2", -1e4, 1e4, 1e-12)
EFFECT = Quantity("value of an effect", "in its unit", -1e3, 1e3, 1e-30)
INDEX_CHANGE = Quantity("change of the refractive index", "1/K", -1e-2, 1e-2)

# Thermal networks: from a bead to a satellite; conductors between boundaries and perfect joints included.
HEAT_CAPACITY = Quantity("heat capacity", "J/K", 0.0, 1e12, 1e-12)
CONDUCTANCE = Quantity("conductance", "W/K", 0.0, 1e12, 1e-20)
RADIATIVE_AREA = Quantity("radiative conductance", "m^2", 0.0, 1e8, 1e-20)
CONDUCTIVITY = Quantity("conductivity", "W/(m K)", 1e-6, 1e5)
LINK_CONDUCTANCE = Quantity("conductance", "W/K", 1e-12, 1e9)
HEAT = Quantity("power", "W", -1e9, 1e9)
POWER_ASD = Quantity("power level", "W/sqrt(Hz)", 0.0, 1e9, 1e-20)
POWER_SHARE = Quantity("weight", "", -1e6, 1e6)

# Bodies and noise of a satellite in orbit.
SPACECRAFT_MASS = Quantity("mass", "kg", 1.0, 1e7)
INERTIA = Quantity("inertia", "kg m^2", -1e9, 1e9)
STIFFNESS = Quantity("stiffness", "in SI units", -1e3, 1e3)
NOISE_LEVEL = Quantity("noise level", "in its SI unit per sqrt(Hz)", 1e-30, 1e6)
NOISE_GAIN = Quantity("gain", "", -1e12, 1e12)
SPECTRAL_SLOPE = Quantity("slope", "", 0.0, 12.0)
CORNER = Quantity("corner frequency", "Hz", 0.0, 1e6, 1e-12)
CROSSOVER = Quantity("crossover", "Hz", 1e-8, 1e3)
CONTROL_DELAY = Quantity("delay", "s", 0.0, 1e4, 1e-9)
CORNER_RATIO = Quantity("ratio of frequencies", "", 1e-3, 1e6)
TRANSFER_COEFFICIENT = Quantity("coefficient", "", -1e15, 1e15)
RELATIVE_NOISE = Quantity("relative noise", "per sqrt(Hz)", 0.0, 1.0, 1e-20)

# Time and frequency: from decades to microseconds; stamps may count from any epoch.
FREQUENCY = Quantity("frequency", "Hz", 1e-9, 1e6)
TIME_STAMP = Quantity("time", "s", -1e12, 1e12)
DURATION = Quantity("duration", "s", 1e-6, 1e9)
DELAY = Quantity("delay", "s", -1e9, 1e9)
FILTER_ORDER = Quantity("order", "", 1e-2, 12.0)

# Limits and what is judged by them.
REQUIREMENT = Quantity("amplitude", "in the unit of its quantity per sqrt(Hz)", 1e-30, 1e10)
LIMIT_AT_REST = Quantity("limit at rest", "in the SI unit of its quantity", -1e3, 1e3, 1e-30)
BUILT_MASS = Quantity("mass", "kg", 0.0, 1e6, 1e-18)
BUILT_OFFSET = Quantity("offset", "m", -0.1, 0.1, 1e-12)
SIGMAS = Quantity("number of standard deviations", "", 0.0, 100.0)
LIMIT_MARGIN = Quantity("margin", "", 0.0, 0.99)
SAFETY_FACTOR = Quantity("safety factor", "", 1e-6, 1e6)
CRITERION_LIMIT = Quantity("limit", "in the unit of its criterion", -1e12, 1e12, 1e-30)
CRITERION_WEIGHT = Quantity("weight", "", 0.0, 1e6, 1e-6)
AREA_ERROR = Quantity("relative error", "", 1e-6, 0.9)
AREA_WEIGHT = Quantity("weight", "", 0.0, 1.0)
CORRELATION = Quantity("correlation coefficient", "", -1.0, 1.0)
RELATIVE_DEVIATION = Quantity("relative deviation", "", 0.0, 10.0, 1e-12)
EXPANSION_DEVIATION = Quantity("deviation of an expansion", "1/K", 0.0, 1e-2, 1e-16)
POSITION_DEVIATION = Quantity("deviation of a position", "m", 0.0, 0.1, 1e-12)
MESH_DEVIATION = Quantity("deviation by the estimated error", "", 0.0, 100.0, 1e-6)
MESH_REFINEMENT = Quantity("ratio of element sizes", "", 1e-2, 1e2)
MESH_ORDER = Quantity("order of the error", "", 0.1, 12.0)
PROBABILITY = Quantity("probability", "", 1e-3, 0.999999)
SPECTRAL_TOLERANCE = Quantity("tolerance", "", 1e-4, 0.99)
QUADRATURE_TOLERANCE = Quantity("tolerance", "", 1e-10, 0.1)
COMPENSATION_TOLERANCE = Quantity("tolerance", "", 1e-11, 1e-2)
MATRIX_ACCURACY = Quantity("accuracy", "", 1e-17, 1e-2)
MATRIX_DIFFERENCE = Quantity("difference", "", 1e-17, 1e3)
MATRIX_ENTRY = Quantity("matrix entry", "in its unit", -1e20, 1e20)

# Whole numbers. Ids of Nastran have at most nine digits.
ID = Quantity("Nastran id", "", 1, 999_999_999)
ISSUE = Quantity("issue", "", 0, 9_999)
FRAME_ID = Quantity("id of a coordinate system", "", 0, 999_999_999)
GAUSS_POINTS = Quantity("number of Gauss points", "", 3, 16)
GRID_POINTS = Quantity("number of frequencies", "", 2, 100_000)
MODES = Quantity("number of modes", "", 0, 10_000)
SEED = Quantity("seed", "", 0, 2**63 - 1)
REALISED_SAMPLES = Quantity("number of samples", "", 1024, 100_000_000)
DRAWS = Quantity("number of draws", "", 100, 1_000_000)
BOX_PARTS = Quantity("number of parts", "", 1, 100)
SEARCH_STEPS = Quantity("number of steps", "", 1, 10_000)
TIED_GRIDS = Quantity("number of grids", "", 3, 1_000)
SAMPLES = Quantity("number of samples", "", 1, 1_000_000_000)
