"use strict";
// From the text of the page to the page at work.
let app;

async function main() {
  const data = unpackNumbers(JSON.parse(document.getElementById("content").textContent));
  app = new App(data);
  await app.choose();
  document.documentElement.dataset.numbers = Math.round(performance.now());
  try {
    const { drawing, layers } = await unpackDrawing(data.drawing);
    app.picture = new Picture(data, drawing, layers, (area) => app.picked(area));
  } catch (error) {
    tellFault(`The model is not drawn: ${whyNot(error)}. The numbers below are right all the same.`);
    app.field("stage").hidden = true;
    app.field("look").parentElement.hidden = true;
    return;
  }
  app.picture.warm(app.temperature, app.per);
  if (app.film) app._fitFilm(app.film);
  else app.picture.fit();
  app.mark(app.field("kind").value === "area" ? Number(app.field("area").value) : -1, false);
}

main();
