"use strict";
// All numbers of the page: unpacking, outputs, displacements, ratios. No document, so that it runs without a browser.
const Arithmetic = (() => {
  const DIGIT = new Uint8Array(128);
  "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/".split("").forEach((c, i) => {
    DIGIT[c.charCodeAt(0)] = i;
  });

  /** Bytes of base64 with its padding. */
  function bytes(text) {
    const padding = text.endsWith("==") ? 2 : text.endsWith("=") ? 1 : 0;
    const out = new Uint8Array((text.length / 4) * 3 - padding);
    for (let i = 0, o = 0; i < text.length; i += 4) {
      const word =
        (DIGIT[text.charCodeAt(i)] << 18) |
        (DIGIT[text.charCodeAt(i + 1)] << 12) |
        (DIGIT[text.charCodeAt(i + 2)] << 6) |
        DIGIT[text.charCodeAt(i + 3)];
      out[o++] = word >> 16;
      if (o < out.length) out[o++] = word >> 8;
      if (o < out.length) out[o++] = word;
    }
    return out;
  }

  const size = (shape) => shape.reduce((a, b) => a * b, 1);

  /** 64-bit numbers as they were written. */
  function numbers(packed) {
    const raw = bytes(packed.float64);
    const view = new DataView(raw.buffer);
    const out = new Float64Array(size(packed.shape));
    for (let i = 0; i < out.length; i++) out[i] = view.getFloat64(8 * i, true);
    return out;
  }

  /** 16-bit rows [k, m] from their inflated bytes: differences along a row, all low bytes before all high ones. */
  function steps(shape, raw) {
    const [k, m] = shape;
    const out = new Int16Array(k * m);
    for (let row = 0; row < k; row++) {
      let value = 0;
      for (let i = row * m; i < (row + 1) * m; i++) {
        value += raw[i] | (raw[k * m + i] << 8);
        out[i] = value; // an Int16Array keeps the low 16 bits
      }
    }
    return out;
  }

  /** 32-bit words from their inflated bytes, which stand plane by plane; `Kind` is Int32Array or Float32Array. */
  function words(shape, raw, Kind) {
    const n = size(shape);
    const out = new Uint8Array(4 * n);
    const little = new Uint8Array(new Uint32Array([1]).buffer)[0] === 1;
    for (let plane = 0; plane < 4; plane++) {
      const at = little ? plane : 3 - plane;
      for (let i = 0; i < n; i++) out[4 * i + at] = raw[plane * n + i];
    }
    return new Kind(out.buffer);
  }

  const SPLIT = 134217729; // 2^27 + 1 (Dekker 1971)

  /** Sum of row[i] * x[i] as if in twice the digits (Ogita, Rump and Oishi 2005): terms that cancel leave all of theirs. */
  function dot(rows, first, x) {
    let sum = 0;
    let rest = 0;
    for (let i = 0; i < x.length; i++) {
      const a = rows[first + i];
      const b = x[i];
      const product = a * b;
      let c = SPLIT * a;
      const aHigh = c - (c - a);
      const aLow = a - aHigh;
      c = SPLIT * b;
      const bHigh = c - (c - b);
      const bLow = b - bHigh;
      const productRest = aLow * bLow - (product - aHigh * bHigh - aLow * bHigh - aHigh * bLow);
      const next = sum + product;
      const back = next - sum;
      rest += sum - (next - back) + (product - back) + productRest;
      sum = next;
    }
    return sum + rest;
  }

  /** Every output [n] of temperatures [k] (K), from sensitivities `rows` [n, k]. */
  function outputs(rows, temperature) {
    const k = temperature.length;
    return Float64Array.from({ length: rows.length / k }, (_, o) => dot(rows, o * k, temperature));
  }

  /** Adds what `temperature` [k] (K) does to the corners of a layer to `out` [3 n] (m): x of all corners, then y, z. */
  function displace(layer, temperature, out) {
    const m = out.length;
    out.fill(0);
    for (let area = 0; area < temperature.length; area++) {
      const factor = temperature[area] * layer.scale[area];
      if (factor === 0) continue;
      const step = layer.steps.subarray(area * m, (area + 1) * m);
      for (let i = 0; i < m; i++) out[i] += factor * step[i];
    }
    return out;
  }

  /** The largest displacement (m) in [3 n], and whose it is; -1 where nothing moves. */
  function largest(moved) {
    const n = moved.length / 3;
    let square = 0;
    let at = -1;
    for (let i = 0; i < n; i++) {
      const s = moved[i] ** 2 + moved[n + i] ** 2 + moved[2 * n + i] ** 2;
      if (s > square) {
        square = s;
        at = i;
      }
    }
    return { value: Math.sqrt(square), at };
  }

  /** Temperatures [k] (K) of one sample of a film. */
  function frame(film, sample) {
    const count = film.time.length;
    return Float64Array.from(film.scale, (scale, area) => scale * film.steps[area * count + sample]);
  }

  /** Safety factor times amplitude over limit; NaN outside the band of the limit. */
  function ratio(safety, amplitude, limit) {
    return (safety * Math.abs(amplitude)) / limit;
  }

  /** A factor of exaggeration of two digits by which `moved` (m) is drawn as about `share` of `length` (m). */
  function exaggeration(moved, length, share) {
    if (!(moved > 0)) return 1;
    const wanted = (share * length) / moved;
    const decade = 10 ** (Math.floor(Math.log10(wanted)) - 1);
    return Number((Math.floor(wanted / decade) * decade).toPrecision(2));
  }

  /** The smallest of 1, 2, 5, 10, ... that is not below `value`. */
  function roundUp(value) {
    const decade = 10 ** Math.floor(Math.log10(value));
    const digit = [1, 2, 5, 10].find((d) => d * decade >= value * (1 - 1e-9));
    return Number((digit * decade).toPrecision(1));
  }

  /** The place of the frequency [F], ascending, that is nearest to `hz` on a logarithmic axis. */
  function nearest(frequency, hz) {
    let best = 0;
    for (let i = 1; i < frequency.length; i++) {
      if (Math.abs(Math.log(frequency[i] / hz)) < Math.abs(Math.log(frequency[best] / hz))) best = i;
    }
    return best;
  }

  return { bytes, numbers, steps, words, outputs, displace, largest, frame, ratio, exaggeration, roundUp, nearest };
})();
