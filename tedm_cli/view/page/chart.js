"use strict";
// Two small charts as SVG: spectra over frequency, and an output over time. What they say is in the tables beside them.
const Chart = (() => {
  const NS = "http://www.w3.org/2000/svg";
  const [W, H, LEFT, RIGHT, TOP, BOTTOM] = [360, 190, 50, 22, 10, 28];

  function node(name, attributes, text) {
    const made = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  }

  /** Points where a curve breaks off at NaN. */
  function path(xs, ys) {
    let open = false;
    let text = "";
    xs.forEach((x, i) => {
      if (!Number.isFinite(ys[i])) {
        open = false;
        return;
      }
      text += `${open ? "L" : "M"}${x.toFixed(1)} ${ys[i].toFixed(1)}`;
      open = true;
    });
    return text;
  }

  function frame(svg, xTicks, yTicks, xLabel) {
    svg.replaceChildren();
    svg.setAttribute("viewBox", `0 0 ${W} ${H}`);
    for (const [x, text] of xTicks) {
      svg.append(node("line", { x1: x, x2: x, y1: TOP, y2: H - BOTTOM, class: "grid" }));
      svg.append(node("text", { x, y: H - BOTTOM + 12, "text-anchor": "middle" }, text));
    }
    for (const [y, text] of yTicks) {
      svg.append(node("line", { x1: LEFT, x2: W - RIGHT, y1: y, y2: y, class: "grid" }));
      svg.append(node("text", { x: LEFT - 5, y: y + 3.5, "text-anchor": "end" }, text));
    }
    svg.append(node("text", { x: (LEFT + W - RIGHT) / 2, y: H - 3, "text-anchor": "middle" }, xLabel));
  }

  function decades(low, high, place, text, most) {
    const first = Math.ceil(Math.log10(low) - 1e-9);
    const last = Math.floor(Math.log10(high) + 1e-9);
    const every = Math.max(1, Math.ceil((last - first + 1) / most));
    const ticks = [];
    for (let d = first; d <= last; d += every) ticks.push([place(10 ** d), text(10 ** d)]);
    return ticks;
  }

  /** `curves` of [class, amplitudes [F]] in one unit over `frequency` [F], with a mark at place `at`. */
  function spectrum(svg, frequency, curves, at) {
    const all = curves.flatMap(([, y]) => Array.from(y)).filter((v) => v > 0 && Number.isFinite(v));
    if (!all.length) {
      svg.replaceChildren();
      return;
    }
    const high = Math.max(...all) * 2;
    const low = Math.max(Math.min(...all) / 2, high * 1e-9);
    const [f0, f1] = [frequency[0], frequency[frequency.length - 1]];
    const x = (f) => LEFT + ((W - LEFT - RIGHT) * Math.log(f / f0)) / Math.log(f1 / f0);
    const y = (v) => H - BOTTOM - ((H - TOP - BOTTOM) * Math.log(Math.max(v, low) / low)) / Math.log(high / low);
    frame(svg, decades(f0, f1, x, (f) => Format.si(f, "Hz", 1), 5), decades(low, high, y, Format.decade, 6), "frequency");
    const xs = Array.from(frequency, x);
    svg.append(node("line", { x1: x(frequency[at]), x2: x(frequency[at]), y1: TOP, y2: H - BOTTOM, class: "mark" }));
    for (const [kind, values] of curves) {
      svg.append(node("path", { d: path(xs, Array.from(values, (v) => (v > 0 ? y(v) : NaN))), class: kind }));
    }
    for (const [kind, values] of curves) {
      if (values[at] > 0) svg.append(node("circle", { cx: x(frequency[at]), cy: y(values[at]), r: 3.2, class: kind }));
    }
  }

  /** A series `values` [B] of `name` in `unit` over `time` [B] s, with a mark at sample `at`. */
  function series(svg, name, time, values, unit, at) {
    const most = Math.max(...Array.from(values, Math.abs)) || 1;
    const top = Arithmetic.roundUp(most);
    const [t0, t1] = [time[0], time[time.length - 1]];
    const x = (t) => LEFT + ((W - LEFT - RIGHT) * (t - t0)) / (t1 - t0 || 1);
    const y = (v) => (TOP + H - BOTTOM) / 2 - ((H - TOP - BOTTOM) / 2) * (v / top);
    const ticks = [0, 0.25, 0.5, 0.75, 1].map((p) => t0 + p * (t1 - t0)).map((t) => [x(t), Format.time(t, t1)]);
    frame(svg, ticks, [-1, 0, 1].map((p) => [y(p * top), Format.si(p * top, unit, 1)]), "time");
    svg.append(node("text", { x: LEFT + 5, y: TOP + 11 }, name));
    svg.append(node("path", { d: path(Array.from(time, x), Array.from(values, y)), class: "noise" }));
    svg.append(node("line", { x1: x(time[at]), x2: x(time[at]), y1: TOP, y2: H - BOTTOM, class: "mark" }));
    svg.append(node("circle", { cx: x(time[at]), cy: y(values[at]), r: 3.2, class: "noise" }));
  }

  return { spectrum, series };
})();
