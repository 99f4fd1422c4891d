"use strict";
// Temperatures in time: a series or a realisation, played, paused and scrubbed.
class Player {
  /** `show(sample)` is called when another sample is to be seen. */
  constructor(show) {
    this.show = show;
    this.film = null;
    this.button = document.getElementById("play");
    this.scrub = document.getElementById("scrub");
    this.speed = document.getElementById("speed");
    this.button.addEventListener("click", () => this.run(!this.running));
    this.scrub.addEventListener("input", () => this.go(Number(this.scrub.value)));
    document.addEventListener("visibilitychange", () => document.hidden && this.run(false));
  }

  /** Take a film, or none; it begins at its first sample and waits. */
  load(film) {
    this.run(false);
    this.film = film;
    document.getElementById("player").hidden = !film;
    if (!film) return;
    this.scrub.max = film.time.length - 1;
    this.go(0);
  }

  go(sample) {
    this.sample = sample;
    this.scrub.value = sample;
    const text = Format.time(this.film.time[sample], this.film.time[this.film.time.length - 1]);
    document.getElementById("clock").textContent = text;
    this.scrub.setAttribute("aria-valuetext", text);
    this.show(sample);
  }

  run(on) {
    this.running = on && !!this.film;
    this.button.textContent = this.running ? "Pause" : "Play";
    this.button.setAttribute("aria-pressed", String(this.running));
    cancelAnimationFrame(this.request);
    if (!this.running) return;
    let before = performance.now();
    const step = (now) => {
      const ahead = Math.floor(((now - before) / 1000) * this.speed.value);
      if (ahead > 0) {
        before += (1000 * ahead) / this.speed.value;
        this.go((this.sample + ahead) % this.film.time.length);
      }
      if (this.running) this.request = requestAnimationFrame(step);
    };
    this.request = requestAnimationFrame(step);
  }
}
