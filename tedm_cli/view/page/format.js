"use strict";
// Numbers as words.
const Format = (() => {
  const PREFIX = ["q", "r", "y", "z", "a", "f", "p", "n", "µ", "m", "", "k", "M", "G"];
  const MINUS = "\u2212";
  const UNIT = { "m s^-2": "m/s²", "rad s^-2": "rad/s²" };

  /** A number with so many digits, and the prefix that keeps it between 1 and 1000: `23.4 nm`. */
  function si(value, unit, digits = 3) {
    if (Number.isNaN(value)) return "–";
    if (value === 0) return `0 ${unit}`;
    if (!Number.isFinite(value)) return `${value < 0 ? MINUS : ""}∞ ${unit}`;
    let thousand = Math.floor(Math.log10(Math.abs(value)) / 3);
    let text = plain(value / 1000 ** thousand, digits);
    if (text.replace(MINUS, "") === "1000") text = plain(value / 1000 ** ++thousand, digits);
    const prefix = PREFIX[thousand + 10];
    return prefix === undefined ? `${power(value, digits)} ${unit}` : `${text} ${prefix}${unit}`;
  }

  /** A number with so many digits, without an exponent where it is of everyday size. */
  function plain(value, digits = 3) {
    const rounded = Number(value.toPrecision(digits));
    const whole = Math.floor(Math.log10(Math.abs(rounded))) + 1;
    return rounded.toFixed(Math.max(0, digits - whole)).replace("-", MINUS);
  }

  function power(value, digits = 3) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
    return `${mantissa.replace("-", MINUS)} × 10${raised(Number(exponent))}`;
  }

  const raised = (exponent) => String(exponent).replace(/./g, (c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[c] ?? "⁻");
  /** A power of ten. */
  const decade = (value) => `10${raised(Math.round(Math.log10(value)))}`;

  /** A ratio, with more digits where three would hide on which side of 1 it lies. */
  function ratio(value) {
    if (Number.isNaN(value)) return "–";
    if (value === 0) return "0";
    if (value >= 1e4 || value < 1e-4) return power(value);
    for (const digits of [3, 5, 8, 12]) {
      if (Number(value.toPrecision(digits)) !== 1 || value === 1) return plain(value, digits);
    }
    return String(value);
  }

  /** A factor of two digits as it is said: `210 000`. */
  function factor(value) {
    if (value >= 1e9 || value < 1) return power(value, 2);
    return String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, "\u202f");
  }

  const unit = (text) => UNIT[text] ?? text;
  const hz = (value) => si(value, "Hz");

  /** Seconds, or hours and days where there are many, of this or of the time `last` that it is one of. */
  function time(seconds, last = seconds) {
    if (Math.abs(last) < 7200) return `${Math.round(seconds)} s`;
    if (Math.abs(last) < 2 * 86400) return `${(seconds / 3600).toFixed(2)} h`;
    return `${(seconds / 86400).toFixed(2)} d`;
  }

  const count = (n, noun) => `${String(n).replace(/\B(?=(\d{3})+$)/g, "\u202f")} ${noun}${n === 1 ? "" : "s"}`;

  return { si, plain, power, decade, ratio, factor, unit, hz, time, count };
})();
