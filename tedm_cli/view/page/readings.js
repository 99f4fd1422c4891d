"use strict";
// Tables of what the outputs do under the temperatures, and of the noise of a case at one frequency.
class Readings {
  constructor(data) {
    this.data = data;
    const { outputs, limits, cases } = data;
    const judged = new Map(cases.flatMap((c) => c.verdicts.map((v) => [`${v.output} ${v.limit}`, v])));
    this.judged = [...judged.values()].map(({ output, limit }) => ({ output, limit }));
    const named = new Set(this.judged.map((j) => j.output));
    this.others = outputs.label.map((_, o) => o).filter((o) => !named.has(o));
    this.rows = [];
    const head = ["Output", "now", "ratio"];
    const required = ({ output, limit }) => [output, `Limit: ${limits.title[limit]} (${limits.name[limit]})`];
    this._table("outputs", head, this.judged, required);
    this._table("others", ["Output", "now"], this.others, (o) => [o, "not judged"]);
    document.getElementById("more").textContent = `${Format.count(this.others.length, "output")} without a requirement`;
    document.getElementById("more").parentElement.hidden = !this.others.length;
    document.getElementById("more").parentElement.open = !this.judged.length;
    document.getElementById("outputs").hidden = !this.judged.length;
    this._table("noise-table", ["Output", "noise", "limit", "ratio"], this.judged, required);
    this.spoken = 0;
  }

  _table(id, head, rows, names) {
    const table = document.getElementById(id);
    const cell = (kind, text, scope) => {
      const made = Object.assign(document.createElement(kind), { textContent: text });
      if (scope) made.scope = scope;
      return made;
    };
    const top = document.createElement("tr");
    top.append(...head.map((text) => cell("th", text, "col")));
    const body = document.createElement("tbody");
    this.rows[id] = rows.map((row) => {
      const line = document.createElement("tr");
      const [output, title] = names(row);
      const first = cell("th", this.data.outputs.title[output], "row");
      const label = Object.assign(document.createElement("span"), { className: "label", textContent: this.data.outputs.label[output] });
      first.append(" ", label);
      first.title = title;
      const cells = head.slice(1).map(() => cell("td", ""));
      line.append(first, ...cells);
      body.append(line);
      return cells;
    });
    const thead = document.createElement("thead");
    thead.append(top);
    table.replaceChildren(thead, body);
  }

  unit(output) {
    return Format.unit(this.data.outputs.unit[output]);
  }

  /** Outputs [n] now (`per`: amplitudes per √Hz), and their ratios as such amplitudes at place `f` of the frequencies, but
   *  of a moment of a film. */
  show(values, f, safety, per, moment) {
    const { limits, outputs } = this.data;
    const count = limits.frequency.length;
    let worst = null;
    this.judged.forEach(({ output, limit }, i) => {
      const ratio = moment ? NaN : Arithmetic.ratio(safety, values[output], limits.amplitude[limit * count + f]);
      const [now, cell] = this.rows.outputs[i];
      now.textContent = Format.si(values[output], this.unit(output) + per);
      Readings.judge(cell, ratio);
      if (!(ratio <= (worst?.ratio ?? -1)) && !Number.isNaN(ratio)) worst = { ratio, output };
    });
    this.others.forEach((output, i) => {
      this.rows.others[i][0].textContent = Format.si(values[output], this.unit(output) + per);
    });
    document.getElementById("read-note").textContent = this.judged.length
      ? moment
        ? "At this moment. Limits are on noise, in amplitudes per √Hz: “Noise of a case” below holds them."
        : `${per ? "Noise of each output in amplitudes per √Hz" : "What each output does under these temperatures"}. Ratio to ` +
          `the limit at ${Format.hz(limits.frequency[f])}${per ? "" : ", reading the temperatures as K/√Hz"}, ` +
          `safety factor ${safety} included; above 1 violated, – where no limit holds. Change the frequency below.`
      : "No output has a requirement.";
    const most = worst ?? { output: 0 };
    const text = `${outputs.label[most.output]} ${Format.si(values[most.output], this.unit(most.output) + per)}`;
    this._speak(worst ? `Largest ratio ${Format.ratio(worst.ratio)}: ${text}` : text);
  }

  static judge(cell, ratio) {
    cell.textContent = Format.ratio(ratio);
    cell.className = Number.isNaN(ratio) ? "" : ratio <= 1 ? "met" : "violated";
  }

  /** Say it to a screen reader, at most once in two seconds, the last of what there was to say. */
  _speak(text) {
    this.words = text;
    if (this.waiting) return;
    const wait = Math.max(0, this.spoken + 2000 - Date.now());
    this.waiting = setTimeout(() => {
      this.waiting = null;
      this.spoken = Date.now();
      const live = document.getElementById("live");
      if (live.textContent !== this.words) live.textContent = this.words;
    }, wait);
  }

  /** Noise of case number `c` at place `f` of the frequencies, and the spectrum of verdict number `drawn`. */
  noise(c, f, drawn) {
    const { cases, limits } = this.data;
    const frequency = limits.frequency;
    const found = cases[c];
    this.judged.forEach(({ output, limit }, i) => {
      const verdict = found.verdicts.find((v) => v.output === output && v.limit === limit);
      const [noise, most, ratio] = this.rows["noise-table"][i];
      const asd = verdict ? verdict.asd[f] : NaN;
      const amplitude = limits.amplitude[limit * frequency.length + f];
      const unit = `${this.unit(output)}/√Hz`;
      noise.textContent = Format.si(asd, unit);
      most.textContent = Format.si(amplitude, unit);
      Readings.judge(ratio, Arithmetic.ratio(found.safety, asd, amplitude));
    });
    const { output, limit } = this.judged[drawn];
    const verdict = found.verdicts.find((v) => v.output === output && v.limit === limit);
    const curve = limits.amplitude.subarray(limit * frequency.length, (limit + 1) * frequency.length);
    const svg = document.getElementById("spectrum");
    Chart.spectrum(svg, frequency, [["noise", verdict.asd.map((v) => v * found.safety)], ["limit", curve]], f);
    const name = this.data.outputs.label[output];
    svg.setAttribute("aria-label", `Spectrum of ${name} in case ${found.id} and its requirement; numbers are in the table below`);
    const key = document.getElementById("spectrum-key");
    const entry = (kind, text) => Object.assign(document.createElement("span"), { className: kind, textContent: text });
    key.replaceChildren(
      entry("noise", `${found.safety} × ${name}, ${this.unit(output)}/√Hz`),
      entry("limit", limits.title[limit]),
    );
    document.getElementById("noise-note").textContent =
      `The largest ratio of ${name} to its limit is ${Format.ratio(verdict.ratio)}, at ${Format.hz(verdict.hz)}. ` +
      `Temperatures: ${found.temperature}. The slider stops at the frequencies of the case file; nothing is interpolated.`;
  }
}
