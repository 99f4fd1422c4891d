"use strict";
// What the page holds, as arrays.

async function inflate(text) {
  const stream = new Blob([Arithmetic.bytes(text)]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The payload with its numbers as arrays; what is deflated is left for later. */
function unpackNumbers(content) {
  const { outputs, limits, cases, series } = content;
  outputs.rows = Arithmetic.numbers(outputs.rows);
  limits.frequency = Arithmetic.numbers(limits.frequency);
  limits.amplitude = Arithmetic.numbers(limits.amplitude);
  for (const verdict of cases.flatMap((c) => c.verdicts)) {
    for (const key of ["asd", "typical", "worst"]) verdict[key] = Arithmetic.numbers(verdict[key]);
  }
  for (const film of [...series, ...cases.map((c) => c.film)].filter(Boolean)) {
    film.time = Arithmetic.numbers(film.time);
    film.scale = Arithmetic.numbers(film.scale);
  }
  return content;
}

async function unpackFilm(film) {
  if (!(film.steps instanceof Int16Array)) film.steps = Arithmetic.steps(film.steps.shape, await inflate(film.steps.int16));
  return film;
}

/** Mesh, bench and boxes as one list of corners with what they make, and the layers of displacements. */
async function unpackDrawing(packed) {
  const { mesh, bench, boxes } = packed;
  const whole = async (p) => Arithmetic.words(p.shape, await inflate(p.int32), Int32Array);
  const real = async (p) => Arithmetic.words(p.shape, await inflate(p.float32), Float32Array);
  const layer = async (l) => ({
    scale: Arithmetic.numbers(l.scale),
    steps: Arithmetic.steps(l.steps.shape, await inflate(l.steps.int16)),
    moved: new Float64Array(l.steps.shape[1]),
  });
  const [meshAt, benchAt] = [await real(mesh.position), await real(bench.position)];
  const [n, b] = [meshAt.length / 3, benchAt.length / 3];
  const shifted = (array, by) => array.map((v) => v + by);
  const [benchFace, benchSegment] = [shifted(await whole(bench.face), n), shifted(await whole(bench.segment), n)];
  const boxCorners = boxes.reduce((sum, box) => sum + box.corner.length, 0);
  const position = new Float32Array(3 * (n + b + boxCorners));
  position.set(meshAt);
  position.set(benchAt, 3 * n);
  const triangle = [...benchFace];
  const triangleColour = Array.from(await whole(bench.faceKind), (kind) => bench.kinds[kind]);
  let next = n + b;
  for (const box of boxes) {
    box.corner.forEach((p, c) => {
      position.set(p, 3 * next);
      triangle.push(next++);
      if (c % 3 === 0) triangleColour.push(box.kind);
    });
  }
  const quad = await whole(mesh.face);
  const quadColour = await whole(mesh.faceArea);
  const line = await whole(mesh.line);
  const lineColour = await whole(mesh.lineArea);
  const [quadNode, lineNode] = [await whole(mesh.faceNode), await whole(mesh.lineNode)];
  const ofCorners = (byQuad, byLine) => {
    const owner = new Int32Array(n).fill(-1);
    byQuad.forEach((column, f) => quad.subarray(4 * f, 4 * f + 4).forEach((corner) => (owner[corner] = column)));
    byLine.forEach((column, l) => line.subarray(2 * l, 2 * l + 2).forEach((corner) => (owner[corner] = column)));
    return owner;
  };
  const [areaOfCorner, nodeOfCorner] = [ofCorners(quadColour, lineColour), ofCorners(quadNode, lineNode)];
  const box = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  position.forEach((v, i) => {
    box[0][i % 3] = Math.min(box[0][i % 3], v);
    box[1][i % 3] = Math.max(box[1][i % 3], v);
  });
  const segmentColour = Array.from(await whole(bench.segmentBeam), (beam) => bench.beams[beam]);
  const kinds = new Set([...triangleColour, ...segmentColour]);
  if ([quadColour, lineColour, quadNode, lineNode].some((owner) => owner.includes(-1))) kinds.add("none");
  return {
    layers: [await layer(mesh), await layer(bench), await layer(packed.carried)],
    drawing: {
      corners: position.length / 3, meshCorners: n, grids: packed.grids, cell: packed.cell, position, quad, quadColour, quadNode,
      triangle, triangleColour, line, lineColour, lineNode, segment: benchSegment, segmentColour,
      boxCorners, areaOfCorner, nodeOfCorner, box, kinds, colour: packed.colour.map((rgb) => rgb.map((v) => Math.round(255 * v))),
    },
  };
}
