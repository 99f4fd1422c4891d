"use strict";
// Colours of what is drawn: scales of numbers, and what has a colour of its own. RGB from 0 to 255.
const Colours = (() => {
  // Diverging: blue through a light grey to red. Sequential: from light to dark (both after ColorBrewer's steps of lightness).
  const DIVERGING = [[5, 48, 97], [33, 102, 172], [67, 147, 195], [146, 197, 222], [225, 227, 228], [244, 165, 130],
    [214, 96, 77], [178, 24, 43], [103, 0, 31]];
  const SEQUENTIAL = [[237, 241, 245], [208, 209, 230], [166, 189, 219], [116, 169, 207], [54, 144, 192], [5, 112, 176],
    [4, 90, 141], [2, 56, 88]];
  const NONE = [150, 150, 150];
  const FIXED = {
    none: NONE,
    "test mass": [232, 178, 48],
    "compensation mass": [150, 96, 40],
    injector: [90, 90, 100],
    mirror: [196, 202, 210],
    beamsplitter: [150, 205, 235],
    window: [176, 224, 240],
    photodiode: [0, 120, 120],
    meas: [230, 50, 20],
    ref: [150, 50, 190], // and wider
  };

  function along(scale, t) {
    const x = Math.min(Math.max(t, 0), 1) * (scale.length - 1);
    const i = Math.min(Math.floor(x), scale.length - 2);
    return scale[i].map((v, c) => Math.round(v + (x - i) * (scale[i + 1][c] - v)));
  }

  /** From -1 to 1. */
  const diverging = (t) => along(DIVERGING, (t + 1) / 2);
  /** From 0 to 1. */
  const sequential = (t) => along(SEQUENTIAL, t);
  const css = (rgb) => `rgb(${rgb.join(",")})`;
  const gradient = (scale) => `linear-gradient(90deg, ${Array.from({ length: 17 }, (_, i) => css(scale(i / 16))).join(", ")})`;

  return { diverging, sequential, css, gradient, FIXED, NONE };
})();
