"use strict";
// What is chosen, and who has to know of it.

/** A sentence on what does not work here. */
function tellFault(text) {
  const place = document.getElementById("fault");
  place.hidden = false;
  place.textContent = text;
}

/** Why something that is packed is not seen. */
function whyNot(error) {
  const old = typeof DecompressionStream === "undefined";
  return old ? "this browser cannot unpack it; Chrome 80, Firefox 113 and Safari 16.4 or newer can" : error.message;
}

class App {
  constructor(data) {
    this.data = data;
    this.temperature = new Float64Array(data.areas.name.length);
    this.per = "";
    this.field = (id) => document.getElementById(id);
    this.readings = new Readings(data);
    this.temperatures = new Temperatures(data.areas, (members, kelvin, done) => this.byHand(members, kelvin, done));
    this.player = new Player((sample) => this.warm(Arithmetic.frame(this.player.film, sample)));
    this._about();
    this._choices();
  }

  _about() {
    const { areas, outputs, cases, version, sources, half } = this.data;
    const nodes = areas.name.length - areas.count;
    const counts = [Format.count(areas.count, "thermal area"), ...(nodes ? [Format.count(nodes, "thermal node")] : []), Format.count(outputs.label.length, "output"), Format.count(cases.length, "case")];
    this.field("about").textContent = [`What happens when it warms: ${counts.join(", ")}`, half].filter(Boolean).join(". ");
    const text = (kind, words, name = "") => Object.assign(document.createElement(kind), { textContent: words, className: name });
    this.field("sources").append(
      text("p", `Made by tedm ${version} from these files (SHA-256). Displacements are drawn from 16-bit steps of each area's largest; outputs come from the sensitivities in full.`),
      ...sources.map((s) => text("div", `${s.name} ${s.sha256}`, "long")),
    );
  }

  _choices() {
    const { areas, outputs, cases, series } = this.data;
    const fill = (id, entries) => this.field(id).append(...entries.map(([value, text]) => new Option(text, value)));
    const judged = this.readings.judged;
    const caseText = (c) => `${c.id}: ${c.title}${c.role ? ` (${c.role})` : ""}`;
    const one = areas.name.length > areas.count ? "One area or thermal node" : "One area";
    const kinds = [["area", `${one}, 1 mK warmer`], ["uniform", "All areas, 1 mK warmer"]];
    if (judged.length) kinds.push(["typical", "A case, as an output feels it"], ["worst", "A case at its worst"]);
    if (cases.some((c) => c.film)) kinds.push(["play", "A case, played in time"]);
    if (series.length) kinds.push(["series", "A series, played in time"]);
    kinds.push(["hand", "Set by hand"]);
    fill("kind", kinds);
    fill("case", cases.map((c, i) => [i, caseText(c)]));
    fill("noise-case", cases.map((c, i) => [i, caseText(c)]));
    const verdicts = judged.map(({ output, limit }, i) => [i, `${outputs.title[output]} (${this.data.limits.title[limit]})`]);
    fill("output", verdicts);
    fill("noise-output", verdicts);
    fill("of", outputs.title.map((title, o) => [o, title]));
    fill("series", series.map((s, i) => [i, s.name]));
    for (const group of new Set(areas.group)) {
      const options = Object.assign(document.createElement("optgroup"), { label: group || "no group" });
      options.append(...areas.name.flatMap((name, i) => (areas.group[i] === group ? [new Option(name, i)] : [])));
      this.field("area").append(options);
    }
    this._begin();
    for (const id of ["kind", "case", "output", "area", "series"]) this.field(id).addEventListener("change", () => this.choose());
    this.field("frequency").max = this.data.limits.frequency.length - 1;
    for (const id of ["frequency", "noise-case", "noise-output"]) this.field(id).addEventListener("input", () => this.noise());
    this.field("none").addEventListener("click", () => this.byHand(areas.name.map((_, i) => i), 0, true));
    document.getElementById("noise").parentElement.hidden = !judged.length;
  }

  /** The case and output that come nearest to a requirement, of those that are likely where there are any, and the area
   *  that this output feels most. */
  _begin() {
    const { cases, outputs, areas } = this.data;
    const likely = cases.some((c) => c.role === "likely" && c.verdicts.length);
    let [best, at, row] = [-1, 0, 0];
    cases.forEach((c, i) => {
      c.verdicts.forEach((v) => {
        if ((!likely || c.role === "likely") && v.ratio > best) {
          [best, at, row] = [v.ratio, i, v.output];
          const judged = this.readings.judged.findIndex((j) => j.output === v.output && j.limit === v.limit);
          this.field("output").value = this.field("noise-output").value = judged;
          this.field("frequency").max = this.data.limits.frequency.length - 1;
          this.field("frequency").value = Arithmetic.nearest(this.data.limits.frequency, v.hz);
        }
      });
    });
    this.field("case").value = this.field("noise-case").value = at;
    this.field("of").value = row;
    const k = areas.name.length;
    const feels = Array.from(outputs.rows.subarray(row * k, row * k + areas.count), Math.abs);
    this.field("area").value = feels.indexOf(Math.max(...feels));
  }

  get verdict() {
    const { output, limit } = this.readings.judged[Number(this.field("output").value)];
    return this.data.cases[Number(this.field("case").value)].verdicts.find((v) => v.output === output && v.limit === limit);
  }

  /** Take what is chosen as the temperatures. */
  async choose() {
    const { areas, cases, series, outputs } = this.data;
    const kind = this.field("kind").value;
    const turn = (this.turn = (this.turn ?? 0) + 1);
    const shown = { case: ["typical", "worst", "play"], output: ["typical", "worst"], area: ["area"], series: ["series"] };
    for (const [id, kinds] of Object.entries(shown)) this.field(`${id}-field`).hidden = !kinds.includes(kind);
    if (shown.case.includes(kind)) this.field("noise-case").value = this.field("case").value;
    const k = areas.name.length;
    const found = cases[Number(this.field("case").value)];
    this.per = ["typical", "worst"].includes(kind) ? "/√Hz" : "";
    if (kind !== "area") this.mark(-1, false);
    const silent = found.silent.length ? ` ${Format.count(found.silent.length, "area")} silent.` : "";
    const reason = found.reason ? ` ${found.reason.replace(/([^.!?])$/, "$1.")}` : "";
    const named = `Case ${found.id}${found.role ? ` (${found.role})` : ""}: ${found.title}.${reason}${silent}`;
    let film = null;
    let temperature = this.temperature;
    let words = "Temperatures as they were set by hand, with the sliders below.";
    if (kind === "area") {
      const area = Number(this.field("area").value);
      temperature = Float64Array.from({ length: k }, (_, i) => (i === area ? WARMER_K : 0));
      words = `${areas.name[area]} (${area < areas.count ? "" : "thermal node, "}${areas.base[area] || "no group"}, ${areas.shield[area]} of the thermal shield) ${areas.unit[area] === "K" ? "is 1 mK warmer" : `has a gradient of ${Format.si(WARMER_K, areas.unit[area])}`}; everything else keeps its temperature. A click on the model chooses another ${area < areas.count ? "area" : "node"}.`;
      this.mark(area, false);
    } else if (kind === "uniform") {
      temperature = Float64Array.from(areas.unit, (unit, i) => (unit === "K" && i < areas.count ? WARMER_K : 0));
      const means = areas.unit.filter((unit, i) => unit === "K" && i < areas.count).length;
      words = `All ${Format.count(means, "thermal area")} are 1 mK warmer.${means < areas.count ? " Gradients stay zero." : ""}`;
    } else if (kind === "typical" || kind === "worst") {
      const verdict = this.verdict;
      const label = outputs.label[verdict.output];
      temperature = verdict[kind].slice();
      const at = Format.hz(verdict.patternHz);
      words =
        kind === "typical"
          ? `${named} Amplitudes per √Hz at ${at}: the temperatures that go, on average, with one standard amplitude of ${label}. ${label} is then what the case makes of it; single moments of the case differ in what ${label} does not feel.`
          : `${named} Amplitudes per √Hz at ${at}: every ${found.nodes ? "thermal node" : "area"} at the amplitude that the case gives it, each with the sign by which all add up in ${label}. No correlation of the same temperatures makes more of it.`;
      this.field("noise-output").value = this.field("output").value;
      this.field("frequency").value = Arithmetic.nearest(this.data.limits.frequency, verdict.patternHz);
    } else if (kind === "play" || kind === "series") {
      film = kind === "play" ? found.film : series[Number(this.field("series").value)];
      const what = kind === "play" ? named : `Series ${film.name}.`;
      words = film ? `${what} Played: ${film.words}. Rounded to 16 bits of each area's or node's largest.` : `${named} Its delays are too long for a realisation.`;
      if (!film) temperature = new Float64Array(k);
    }
    this.field("words").textContent = words;
    try {
      if (film) film = await unpackFilm(film);
    } catch (error) {
      tellFault(`This cannot be played: ${whyNot(error)}.`);
      return;
    }
    if (turn !== this.turn) return; // something else was chosen meanwhile
    this.film = film;
    if (film) this._fitFilm(film);
    else {
      this.picture?.free();
      this.temperatures.fit(temperature);
      this.warm(temperature);
      this.picture?.fit();
    }
    this.player.load(film);
    this.noise();
  }

  /** Exaggeration, sliders and chart for all of a film. */
  _fitFilm(film) {
    const count = film.time.length;
    const some = Array.from({ length: 24 }, (_, i) => Arithmetic.frame(film, Math.floor((i * (count - 1)) / 23)));
    this.picture?.fit(some, film.scale.reduce((a, s) => Math.max(a, 32767 * s), 0));
    this.temperatures.fit(film.scale.map((s) => 32767 * s));
    film.rows ??= new Map();
  }

  byHand(members, kelvin, done) {
    const temperature = this.temperature.slice();
    for (const i of members) temperature[i] = kelvin;
    if (this.field("kind").value !== "hand") {
      this.turn += 1;
      this.field("kind").value = "hand";
      for (const id of ["case", "output", "area", "series"]) this.field(`${id}-field`).hidden = true;
      this.field("words").textContent = "Temperatures as they are set by hand.";
      this.film = null;
      this.picture?.free();
      this.per = "";
      this.player.load(null);
    }
    this.warm(temperature);
    if (done) this.picture?.fitIfLost();
  }

  /** Show these temperatures [k] (K) everywhere. */
  warm(temperature) {
    this.temperature = temperature;
    this.temperatures.show(temperature, this.per);
    this.picture?.warm(temperature, this.per);
    this.read();
    if (this.film) this._chart();
  }

  read() {
    this.outputs = Arithmetic.outputs(this.data.outputs.rows, this.temperature);
    const safety = this.data.cases[Number(this.field("noise-case").value)].safety;
    this.readings.show(this.outputs, Number(this.field("frequency").value), safety, this.per, !!this.film);
  }

  /** The drawn output over the time of the film. */
  _chart() {
    const { outputs } = this.data;
    const output = this.readings.judged.length ? this.readings.judged[Number(this.field("noise-output").value)].output : 0;
    const film = this.film;
    if (!film.rows.has(output)) {
      const k = this.temperature.length;
      const row = outputs.rows.subarray(output * k, (output + 1) * k);
      film.rows.set(output, Array.from(film.time, (_, s) => Arithmetic.outputs(row, Arithmetic.frame(film, s))[0]));
    }
    const svg = this.field("film");
    Chart.series(svg, outputs.label[output], film.time, film.rows.get(output), Format.unit(outputs.unit[output]), this.player.sample);
    svg.setAttribute("aria-label", `${outputs.label[output]} over time`);
  }

  noise() {
    const f = Number(this.field("frequency").value);
    const text = Format.hz(this.data.limits.frequency[f]);
    this.field("hz").textContent = text;
    this.field("frequency").setAttribute("aria-valuetext", text);
    this.read();
    if (this.readings.judged.length) {
      this.readings.noise(Number(this.field("noise-case").value), f, Number(this.field("noise-output").value));
    }
    if (this.film) this._chart();
  }

  /** Mark an area in the drawing and among the sliders. */
  mark(area, open) {
    this.temperatures.choose(area, open);
    this.picture?.choose(area);
  }

  /** A click on the drawing: of an area that is warmed alone, or to be looked at. */
  picked(area) {
    if (area >= 0 && this.field("kind").value === "area") {
      this.field("area").value = area;
      this.choose();
    } else {
      this.mark(area, area >= 0);
    }
  }
}

const WARMER_K = 1e-3; // K, of what is one area or all of them warmer
