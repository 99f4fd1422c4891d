"use strict";
// Sliders and number fields for every group and area. They show temperatures and report what a hand does to them.
class Temperatures {
  /** `changed(areas, kelvin, done)` is called for a hand at work (`done`: it has let go). */
  constructor(areas, changed) {
    this.areas = areas;
    this.changed = changed;
    this.reach = document.getElementById("reach");
    for (const kelvin of Temperatures.REACH) this.reach.append(new Option(`± ${Format.si(kelvin, "K")}`, kelvin));
    this.reach.addEventListener("change", () => this.show(this.temperature));
    this.temperature = new Float64Array(areas.name.length);
    this.per = "";
    this.rows = [];
    this.groups = [];
    const place = document.getElementById("sliders");
    for (const group of new Set(areas.group)) {
      const members = areas.group.flatMap((g, i) => (g === group ? [i] : []));
      const box = document.createElement("div");
      box.className = "group";
      const unit = areas.unit[members[0]];
      const own = this._row(`${group || "no group"}: ${Format.count(members.length, members[0] < areas.count ? "area" : "node")} together`, members, unit);
      const details = document.createElement("details");
      const summary = document.createElement("summary");
      summary.textContent = `${members[0] < areas.count ? "Areas" : "Thermal nodes"} of ${group || "no group"}`;
      const inner = document.createElement("div");
      for (const i of members) {
        this.rows[i] = this._row(areas.name[i], [i], unit);
        inner.append(this.rows[i].element);
      }
      details.append(summary, inner);
      box.append(own.element, details);
      place.append(box);
      this.groups.push({ ...own, members });
    }
  }

  /** `of`: unit of these areas' temperatures, K or K/m. */
  _row(text, members, of) {
    const element = document.createElement("div");
    element.className = "slider";
    const id = `t${Temperatures.made++}`;
    const label = Object.assign(document.createElement("label"), { textContent: text, htmlFor: id });
    const range = Object.assign(document.createElement("input"), { type: "range", id, min: -100, max: 100, step: 1 });
    const number = Object.assign(document.createElement("input"), { type: "number", step: "any" });
    number.setAttribute("aria-label", `${text}, millikelvin${of === "K" ? "" : " per metre"}`);
    const unit = Object.assign(document.createElement("span"), { textContent: `m${of}` });
    range.addEventListener("input", () => this._take(members, (range.value / 100) * this.reach.value, false));
    range.addEventListener("change", () => this._take(members, (range.value / 100) * this.reach.value, true));
    number.addEventListener("change", () => {
      if (number.value !== "" && Number.isFinite(number.valueAsNumber)) this._take(members, number.valueAsNumber / 1000, true);
      else this.show(this.temperature);
    });
    element.append(label, range, number, unit);
    return { element, range, number, label, text, of };
  }

  _take(members, kelvin, done) {
    this.changed(members, kelvin, done);
  }

  /** The smallest reach that holds these temperatures; sliders that a hand moved keep theirs. */
  fit(temperature) {
    const most = temperature.reduce((a, t) => Math.max(a, Math.abs(t)), 0);
    this.reach.value = Temperatures.REACH.find((r) => r >= most * (1 - 1e-9)) ?? Temperatures.REACH.at(-1);
    if (most === 0) this.reach.value = 1e-3;
  }

  /** `per`: what the temperatures are amplitudes per, or nothing. */
  show(temperature, per = this.per) {
    Object.assign(this, { temperature, per });
    const kelvinText = (row, t) => Format.si(t, `${row.of}${per}`);
    const set = (row, kelvin, mixed) => {
      row.range.value = Math.round((100 * kelvin) / this.reach.value);
      row.range.setAttribute("aria-valuetext", mixed ? "different temperatures" : kelvinText(row, kelvin));
      if (document.activeElement !== row.number) row.number.value = mixed ? "" : Number((kelvin * 1000).toPrecision(6));
      row.number.placeholder = mixed ? "different" : `m${row.of}`;
    };
    this.rows.forEach((row, i) => {
      set(row, temperature[i], false);
      row.label.textContent = `${row.text}: ${kelvinText(row, temperature[i])}`;
    });
    for (const group of this.groups) {
      const values = group.members.map((i) => temperature[i]);
      const mixed = values.some((v) => v !== values[0]);
      set(group, values.reduce((a, v) => a + v, 0) / values.length, mixed);
      const said = mixed
        ? `${kelvinText(group, Math.min(...values))} to ${kelvinText(group, Math.max(...values))}`
        : kelvinText(group, values[0]);
      group.label.textContent = `${group.text}: ${said}`;
    }
  }

  /** Mark the sliders of one area, and open its group when it was chosen in the drawing. */
  choose(area, open) {
    this.rows.forEach((row, i) => row.element.classList.toggle("chosen", i === area));
    if (open && area >= 0) this.rows[area].element.closest("details").open = true;
  }
}
Temperatures.REACH = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1, 10, 100];
Temperatures.made = 0;
