"use strict";
// The drawing as the page asks for it: colours, legend, exaggeration, cut, and what of the model is shown.
class Picture {
  /** `layers`: {steps, scale, moved} of mesh, bench and boxes; `chosen(area)` is called for a click on an area. */
  constructor(data, drawing, layers, chosen) {
    Object.assign(this, { data, drawing, layers, wished: 1, factor: 1, area: -1, temperature: null, per: "" });
    this.field = (id) => document.getElementById(id);
    this.hidden = new Set();
    this.canvas = this.field("canvas");
    const [low, high] = [0, 1].map((end) => [0, 1, 2].map((c) => drawing.box[end][c]));
    this.box = { low, high, size: Math.hypot(...high.map((v, c) => v - low[c])) };
    this.camera = new Camera(low.map((v, c) => (v + high[c]) / 2), this.box.size / 2, () => this.redraw());
    this.scene = new Scene(this.canvas, drawing, data.areas.name.length);
    this.camera.follow(this.canvas, (x, y) => {
      const entry = this.scene.pick(this._look(), x, y);
      chosen(entry < data.areas.name.length ? entry : -1);
    });
    this.canvas.addEventListener("webglcontextlost", (e) => {
      e.preventDefault();
      this.lost = true;
      tellFault("The browser has taken the graphics memory away. Load the page again to see the drawing; the numbers still work.");
    });
    for (const button of document.querySelectorAll("[data-look]")) {
      button.addEventListener("click", () => this.camera.look(button.dataset.look));
    }
    for (const button of document.querySelectorAll("[data-zoom]")) {
      button.addEventListener("click", () => this.camera.zoom(Number(button.dataset.zoom)));
    }
    for (const id of ["colour", "of", "axis", "cut"]) this.field(id).addEventListener("input", () => this.repaint());
    this.field("exaggeration").addEventListener("input", () => this._exaggerate());
    this.field("fit").addEventListener("click", () => this.fit());
    this._shows();
    const dark = matchMedia("(prefers-color-scheme: dark)");
    dark.addEventListener("change", () => this.redraw());
    this.dark = dark;
    new ResizeObserver(() => this.redraw()).observe(this.canvas);
  }

  /** Boxes to tick for groups and for what is no area. */
  _shows() {
    const { areas } = this.data;
    const kinds = {
      "mesh lines": ["edges"],
      "beams (measurement red, reference violet)": ["meas", "ref"],
      "optical elements": ["injector", "mirror", "beamsplitter", "window", "photodiode"],
      "test masses": ["test mass"],
      "compensation masses": ["compensation mass"],
    };
    const there = (names) => names.includes("edges") || names.some((n) => this.drawing.kinds.has(n));
    const entries = [...new Set(areas.base)].map((g) => [g || "no group", [`group ${g}`]]);
    entries.push(...Object.entries(kinds).filter(([, names]) => there(names)));
    if (this.drawing.kinds.has("none")) entries.push(["what is in no area", ["none"]]);
    for (const [text, names] of entries) {
      const label = document.createElement("label");
      const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: true });
      if (names[0] === "edges" && this.drawing.quadColour.length > Picture.MANY_FACES) box.checked = false;
      const take = () => names.forEach((n) => (box.checked ? this.hidden.delete(n) : this.hidden.add(n)));
      box.addEventListener("input", () => {
        take();
        this.repaint();
      });
      take();
      label.append(box, ` ${text}`);
      this.field("show").append(label);
    }
  }

  /** Take new temperatures [k] (K; `per`: amplitudes per √Hz, or nothing). */
  warm(temperature, per = this.per) {
    Object.assign(this, { temperature, per });
    this.scene.show(temperature.subarray(this.data.areas.count).some((t) => t !== 0));
    for (const layer of this.layers) Arithmetic.displace(layer, temperature, layer.moved);
    this.largest = this.layers.map((layer) => Arithmetic.largest(layer.moved));
    this.scene.displace(this.layers.map((layer) => layer.moved));
    this.repaint();
  }

  /** The largest displacement (m) in each layer under any of these temperatures. */
  _most(frames) {
    return this.layers.map((l) => Math.max(...frames.map((t) => Arithmetic.largest(Arithmetic.displace(l, t, l.moved)).value)));
  }

  /** No film any more: colours follow what is there. */
  free() {
    this.frames = this.scaled = null;
  }

  /** Exaggerate so that the largest of these temperatures' displacements, by default of those there are, is well seen.
   *  `hottest` (K): they are a film, whose colours keep their meaning while it is played. */
  fit(frames = this.frames ?? [this.temperature], hottest = this.scaled?.temperature) {
    this.frames = hottest === undefined ? null : frames;
    const most = this._most(frames);
    this.scaled = hottest === undefined ? null : { temperature: hottest, displacement: most[0] };
    this.wished = Arithmetic.exaggeration(Math.max(...most), this.box.size, Picture.SHARE);
    this.field("exaggeration").value = 50;
    this._exaggerate();
    if (this.temperature) this.warm(this.temperature);
  }

  /** Fit again where a hand has made displacements that cannot be seen, or that fly apart. */
  fitIfLost() {
    const share = (this.factor * Math.max(...this.largest.map((l) => l.value))) / this.box.size;
    if (share > 0 && (share > 4 * Picture.SHARE || share < Picture.SHARE / 20)) this.fit();
  }

  _exaggerate() {
    const at = Number(this.field("exaggeration").value);
    this.factor = at === 0 ? 0 : Number((this.wished * 10 ** ((at - 50) / 25)).toPrecision(2));
    this.field("exaggeration").setAttribute("aria-valuetext", `${Format.factor(this.factor)} times`);
    if (this.temperature) this.repaint();
  }

  choose(area) {
    this.area = area;
    this.repaint();
  }

  repaint() {
    if (!this.temperature || this.lost) return;
    const { areas, outputs } = this.data;
    const by = this.field("colour").value;
    this.field("of-field").hidden = by !== "sensitivity";
    const k = areas.name.length;
    const row = Number(this.field("of").value);
    const value = by === "temperature" ? this.temperature : outputs.rows.subarray(row * k, (row + 1) * k);
    // Gradients are in another unit, and no surface is theirs.
    const now = value.reduce((a, v, i) => (areas.unit[i] === "K" ? Math.max(a, Math.abs(v)) : a), 0);
    const most = (by === "temperature" && this.scaled?.temperature) || now;
    const colour = areas.name.map((_, i) =>
      by === "area" ? this.drawing.colour[i] : by === "displacement" ? Colours.NONE : Colours.diverging(most ? value[i] / most : 0),
    );
    this.scene.paint(colour, areas.base.map((g) => !this.hidden.has(`group ${g}`)), this.hidden);
    this._legend(by, most, row, value);
    this._say();
    this.redraw();
  }

  _legend(by, most, row, value) {
    const { areas, outputs } = this.data;
    const legend = this.field("legend");
    const line = (text, kind = "div") => Object.assign(document.createElement(kind), { textContent: text });
    legend.replaceChildren();
    if (by === "area") {
      const list = Object.assign(document.createElement("ul"), { className: "groups" });
      const [from, to] = this.scene.byNode ? [areas.count, areas.name.length] : [0, areas.count];
      for (const group of new Set(areas.group.slice(from, to))) {
        const entry = line(group || "no group", "li");
        const swatch = Object.assign(document.createElement("span"), { className: "swatch" });
        swatch.style.background = Colours.css(this.drawing.colour[areas.group.indexOf(group)]);
        entry.prepend(swatch);
        list.append(entry);
      }
      const what = this.scene.byNode ? ["nodes", "node"] : ["areas", "area"];
      legend.append(line(`Thermal ${what[0]}: hue by group, lightness by ${what[1]}`), list);
    } else {
      const unit = by === "temperature" ? `K${this.per}` : by === "displacement" ? `m${this.per}` : `${Format.unit(outputs.unit[row])}/K`;
      const top = by === "displacement" ? this._top() : most;
      const title = { temperature: "Temperature", displacement: "Displacement", sensitivity: outputs.label[row] + ` per kelvin of each ${this.scene.byNode ? "thermal node" : "area"}` };
      const bar = Object.assign(document.createElement("div"), { className: "bar" });
      bar.style.background = Colours.gradient(by === "displacement" ? Colours.sequential : (t) => Colours.diverging(2 * t - 1));
      const ends = Object.assign(document.createElement("div"), { className: "ends" });
      const signed = [Format.si(-top, unit), `0 ${unit}`, `+${Format.si(top, unit)}`];
      ends.append(...(by === "displacement" ? [`0 ${unit}`, Format.si(top, unit)] : signed).map((t) => line(t, "span")));
      legend.append(line(title[by]), bar, ends);
    }
    if (this.area >= 0) {
      const own = areas.unit[this.area];
      const per = `${Format.unit(outputs.unit[row])}/${own === "K" ? own : `(${own})`}`;
      const extra = by === "sensitivity" ? `, ${Format.si(value[this.area], per)}` : "";
      legend.append(line(`Striped: ${areas.name[this.area]}, ${Format.si(this.temperature[this.area], `${own}${this.per}`)}${extra}`));
    }
  }

  /** The displacement (m) at the end of the scale of colours. */
  _top() {
    return this.scaled?.displacement ?? this.largest[0].value;
  }

  /** What is seen, in words. */
  _say() {
    const { drawing } = this;
    const [mesh, bench] = this.largest;
    const parts = [];
    if (mesh.value === 0) parts.push("Nothing is warm, so nothing moves.");
    else if (this.factor === 0) parts.push(`Displacements are not drawn; the largest is ${Format.si(mesh.value, `m${this.per}`)}.`);
    else {
      const owner = (this.scene.byNode ? drawing.nodeOfCorner : drawing.areaOfCorner)[mesh.at];
      const where = owner >= 0 ? ` in ${this.data.areas.name[owner]}` : "";
      parts.push(
        `Displacements are drawn ${Format.factor(this.factor)} times ${this.factor < 1 ? "as large" : "larger"}: the largest, ` +
          `${Format.si(mesh.value, `m${this.per}`)}${where}, is seen as ${Format.si(this.factor * mesh.value, "m")}.`,
      );
      if (bench.value > 0) {
        parts.push(
          `Beams and optical elements by the same factor (the largest ${Format.si(bench.value, `m${this.per}`)}); test masses stay where they are.`,
        );
      }
    }
    const coarse = drawing.cell > 0 ? ` on a coarser surface, cells of ${Format.si(drawing.cell, "m", 2)}` : ", the outer surface";
    parts.push(`Drawn: ${Format.count(drawing.meshCorners, "grid")} of ${Format.count(drawing.grids, "grid").replace(/ grids?$/, "")}${coarse}.`);
    this.field("drawn").textContent = parts.join(" ");
    this.canvas.setAttribute("aria-label", `The model, deformed. ${parts.join(" ")}`);
  }

  _look() {
    const axis = "xyz".indexOf(this.field("axis").value || "-");
    let cut = null;
    if (axis >= 0) {
      const part = this.field("cut").value / 100;
      const at = this.box.low[axis] + part * (this.box.high[axis] - this.box.low[axis]);
      const sign = axis === 1 ? -1 : 1; // what is in front, as one looks from the corner, is taken away
      cut = [0, 0, 0, sign * at];
      cut[axis] = sign;
    }
    const b = this.camera.axes()[2];
    return {
      matrix: this.camera.matrix(this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight)),
      eye: this.camera.target.map((t, c) => t + this.camera.distance * b[c]),
      factor: this.factor,
      byDisplacement: this.field("colour").value === "displacement",
      largest: this._top(),
      cut,
      edges: !this.hidden.has("edges"),
      chosen: this.area,
      background: this.dark.matches ? [31, 31, 36] : [247, 247, 248],
    };
  }

  redraw() {
    if (this.request || this.lost || !this.temperature) return;
    const asked = performance.now();
    this.request = requestAnimationFrame(() => {
      this.request = null;
      // What moves is drawn with fewer pixels where the machine is slow, and in full once it stands still.
      const now = performance.now();
      const moving = now - (this.before ?? -Infinity) < Picture.STILL_MS;
      if (now - asked > Picture.SLOW_MS) this.slow = moving;
      else if (now - asked < Picture.SLOW_MS / 3) this.slow = false;
      this.before = now;
      clearTimeout(this.rest);
      const detail = this.slow && moving ? 0.5 : 1;
      this.scene.draw({ ...this._look(), detail });
      if (detail < 1) this.rest = setTimeout(() => this.redraw(), Picture.STILL_MS);
      document.documentElement.dataset.drawn ??= Math.round(performance.now());
    });
  }
}
[Picture.SLOW_MS, Picture.STILL_MS] = [60, 350]; // that a frame waits for the one before, and until nothing moves
Picture.SHARE = 0.05; // of the size of the model that the largest displacement is drawn as
Picture.MANY_FACES = 12000; // from which on their edges would hide them
