"""Numbers, units and quantities as words of figures and reports."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence

SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
QUANTITY = {
    "acceleration": "self-gravity acceleration",
    "angular_acceleration": "self-gravity angular acceleration",
    "displacement": "read-out displacement",
    "angle": "read-out angle",
}
#: What is not there of a project with one half of the chain, for readers of its results.
GRAVITY_ALONE = "The project has no optics: only self-gravity is computed, and there are no read-outs."
READ_OUT_ALONE = (
    "The model has no test masses: only read-outs are computed; there is no self-gravity noise and no field at rest."
)
#: What is odd but no error, where a report tells what its results take for granted.
TO_LOOK_AT = "To look at"
_NUMBER_WORDS = (
    *("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"),
)
#: Unit that a read-out in m or rad is shown in, and the factor to it.
READ_OUT_UNIT = {"m": ("pm", 1e12), "rad": ("nrad", 1e9)}


def quantity(kind: str, outputs: Sequence[str]) -> str:
    """Title of a family of outputs; names the axis where they share one, as TM1_a_x and TM2_a_x do."""
    axes = {o.rsplit("_", 1)[-1] for o in outputs}
    axis = axes.pop() if len(axes) == 1 else ""
    along = "about" if "ang" in kind else "along"
    text = QUANTITY.get(kind, kind)
    return f"{text} {along} {axis}" if axis in ("x", "y", "z") else text


def ratio_text(ratio: float) -> str:
    """A ratio with three digits, and with more where three would hide on which side of 1 it lies."""
    if ratio == 0.0:
        return "0"
    if ratio >= 1e3:
        return f"{ratio:.0f}" if ratio < 1e6 else power_text(ratio, 3)
    for digits in (3, 5, 8, 12):
        text = f"{ratio:#.{digits}g}".removesuffix(".")
        if float(text) != 1.0 or ratio == 1.0:
            return text
    return f"{ratio!r}"


def rounded_down(factor: float) -> str:
    """A factor below 1 with two digits, never more than it is: at what is printed the requirement is met."""
    if not 0.0 < factor < math.inf:
        return f"{factor:g}"
    unit = 10.0 ** (math.floor(math.log10(factor)) - 1)
    return f"{math.floor(factor / unit * (1.0 + 1e-12)) * unit:.2g}"


def number_text(value: float) -> str:
    """About three digits, for a narrow cell."""
    size = abs(value)
    digits = 0 if size >= 100 else 1 if size >= 10 else 2 if size >= 1 else 3
    text = f"{value:.{digits}f}"
    return "0" if float(text) == 0.0 else text.replace("-", "−")


def power_text(value: float, digits: int = 2) -> str:
    """A positive number as 2.4 × 10⁻¹³, plain where it is of everyday size."""
    if 0.01 <= value < 1e4:
        return f"{value:.{digits}g}" if value < 10**digits else f"{value:.0f}"
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa} × 10{str(int(exponent)).translate(SUPERSCRIPT)}"


def sci(value: float, digits: int = 4) -> str:
    """A number with powers of ten raised, plain where it is of everyday size."""
    if value == 0.0 or not math.isfinite(value):
        return f"{value:g}".replace("-0", "0").replace("-", "−")
    if 1e-3 <= abs(value) < 1e5:
        return f"{value:.{digits}g}".replace("-", "−") if abs(value) < 10**digits else f"{value:.0f}".replace("-", "−")
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa} × 10{str(int(exponent)).translate(SUPERSCRIPT)}".replace("-", "−")


def span(low: float, high: float) -> str:
    """A range of ratios; one number where its ends read the same."""
    ends = ratio_text(low), ratio_text(high)
    return ends[0] if ends[0] == ends[1] else " to ".join(ends)


def percent(share: float, digits: int = 0) -> str:
    """A share of the power; signed where it cancels."""
    text = f"{100 * share:.{digits}f} %"
    return text.removeprefix("-") if float(text[:-2]) == 0.0 else text.replace("-", "−")


def chance_text(probability: float, low: float, high: float) -> str:
    """A probability by draws, `0.974`; where it happened never or always, what it is below or above: `< 0.0004`."""
    if probability == 0.0:
        return f"< {high:.1g}"
    if probability == 1.0:
        digits = max(2, math.ceil(-math.log10(1.0 - low)))
        return f"> {math.floor(low * 10**digits) / 10**digits:.{digits}f}"
    digits = min(6, max(2, math.ceil(-math.log10(min(probability, 1.0 - probability))) + 1))
    return f"{probability:.{digits}f}"


def count(n: int, noun: str, plural: str = "") -> str:
    """`1 case`, `2 cases`."""
    return f"{n} {noun if n == 1 else plural or noun + 's'}"


def vector(values: Sequence[float]) -> str:
    return f"({', '.join(sci(float(v), 5) for v in values)})"


def parts_noun(names: Iterable[str]) -> str:
    """What the parts of outputs are called, of which elements have no blank in their names (`W1 glass`)."""
    return "parts" if any(" " in name for name in names) else "optical elements"


def and_text(names: Sequence[str]) -> str:
    """`a`, `a and b`, `a, b and c`."""
    return " and ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else "".join(names)


def temperature_text(kelvin: float) -> str:
    """A temperature in both scales, `293.15 K (20.00 °C)`."""
    return f"{kelvin:.2f} K ({kelvin - 273.15:.2f} °C)".replace("-", "−")


def mhz_text(frequency_hz: float) -> str:
    return f"{frequency_hz * 1e3:.3g} mHz"


def unit_text(unit: str) -> str:
    """A unit with its powers raised: `1/(m s^2)` to 1/(m s²)."""
    return re.sub(r"\^(-?\d+)", lambda m: m[1].translate(SUPERSCRIPT), unit)


def capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def number_word(n: int) -> str:
    """`twelve`; larger numbers in digits."""
    return _NUMBER_WORDS[n] if 0 <= n < len(_NUMBER_WORDS) else f"{n}"


def the_bench(benches: int) -> str:
    """What moves as one: the bench, or each of several."""
    return "each bench" if benches > 1 else "the bench"


def decimals(values: Sequence[float], unit_factor: float, digits: int) -> str:
    """A vector in a unit that makes its size everyday, `(−0.158, 0, −8.483)`."""
    shown = (f"{v * unit_factor:.{digits}f}" for v in values)
    return f"({', '.join('0' if float(t) == 0.0 else t.replace('-', '−') for t in shown)})"


def clause(title: str) -> str:
    """A title in front of its verb: set off by a comma where it has commas of its own."""
    return f"{title}," if "," in title else title
