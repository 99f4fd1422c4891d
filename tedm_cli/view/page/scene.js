"use strict";
// The drawing, with WebGL 2. Places and displacements of all corners are textures; faces and lines name their corners, so
// that a new temperature uploads the displacements and nothing else.
class Scene {
  /** `drawing` as `unpackDrawing` makes it. Throws where there is no WebGL 2. */
  constructor(canvas, drawing, areas) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: false, powerPreference: "high-performance" });
    if (!gl) throw new Error("this browser offers no WebGL 2");
    Object.assign(this, { gl, canvas, drawing, areas });
    this.corners = drawing.corners;
    this.fixed = Object.fromEntries(Object.keys(Colours.FIXED).map((name, i) => [name, areas + i]));
    this.entries = areas + Object.keys(Colours.FIXED).length;
    this.programs = { face: this._program(FACE_VERTEX, FACE_FRAGMENT), line: this._program(LINE_VERTEX, FACE_FRAGMENT) };
    this.place = this._texture(this.corners, gl.RGBA32F, gl.FLOAT);
    this.move = this._texture(this.corners, gl.RGBA32F, gl.FLOAT);
    this.palette = this._texture(this.entries, gl.RGBA8, gl.UNSIGNED_BYTE);
    this.scale = this._texture(256, gl.RGBA8, gl.UNSIGNED_BYTE);
    this._fill(this.place, Float32Array, this.corners, (i, o, a) => {
      for (let c = 0; c < 3; c++) a[o + c] = drawing.position[3 * i + c];
    });
    this._fill(this.scale, Uint8Array, 256, (i, o, a) => a.set([...Colours.sequential(i / 255), 255], o));
    this.byNode = false;
    this.faceArray = gl.createVertexArray();
    this.lineArray = gl.createVertexArray();
    this._faces();
    this._lines();
    this.pickTarget = this._pickTarget();
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  }

  _program(vertex, fragment) {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "no program");
    const at = {};
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
      const { name } = gl.getActiveUniform(program, i);
      at[name] = gl.getUniformLocation(program, name);
    }
    return { program, at };
  }

  _texture(entries, format, type) {
    const gl = this.gl;
    const texture = gl.createTexture();
    const height = Math.max(1, Math.ceil(entries / Scene.WIDTH));
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, Scene.WIDTH, height);
    for (const end of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, end, gl.NEAREST);
    return { texture, height, type };
  }

  /** Upload what `set(entry, place, array)` puts there. */
  _fill(to, Kind, entries, set) {
    const gl = this.gl;
    to.array ??= new Kind(4 * Scene.WIDTH * to.height);
    for (let i = 0; i < entries; i++) set(i, 4 * i, to.array);
    gl.bindTexture(gl.TEXTURE_2D, to.texture);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, Scene.WIDTH, to.height, gl.RGBA, to.type, to.array);
  }

  /** Faces and lines by the thermal node that they are in, or by their area; what is in no node has its area's. */
  show(byNode) {
    if (byNode === this.byNode) return;
    this.byNode = byNode;
    this._faces();
    this._lines();
  }

  _buffer(array, attributes) {
    const gl = this.gl;
    attributes.held ??= gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, attributes.held);
    gl.bufferData(gl.ARRAY_BUFFER, array, gl.STATIC_DRAW);
    for (const [place, count, offset, divisor] of attributes) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribIPointer(place, count, gl.UNSIGNED_INT, attributes.stride, offset);
      gl.vertexAttribDivisor(place, divisor);
    }
  }

  /** Triangles of the mesh, then those of bench and boxes; each corner with the entry of the palette of its face, and
   *  above these 16 bits which of the sides opposite its three corners are edges of the mesh. */
  _faces() {
    const gl = this.gl;
    const { quad, triangle, triangleColour } = this.drawing;
    const quadColour = this.byNode ? this.drawing.quadNode : this.drawing.quadColour;
    const data = new Uint32Array(12 * quadColour.length + 2 * triangle.length);
    let o = 0;
    const entry = (colour) => (typeof colour === "string" ? this.fixed[colour] : colour < 0 ? this.fixed.none : colour);
    const add = (corners, colour, edges) => {
      for (const corner of corners) {
        data[o++] = corner;
        data[o++] = entry(colour) | (edges << 16);
      }
    };
    for (let f = 0; f < quadColour.length; f++) {
      const [a, b, c, d] = quad.subarray(4 * f, 4 * f + 4);
      if (d === c) add([a, b, c], quadColour[f], 7);
      else {
        add([a, b, c], quadColour[f], 5);
        add([a, c, d], quadColour[f], 3);
      }
    }
    this.meshCount = o / 2;
    for (let i = 0; i < triangle.length; i += 3) add(triangle.slice(i, i + 3), triangleColour[i / 3], 0);
    this.allCount = o / 2;
    this.boxFirst = this.allCount - this.drawing.boxCorners;
    gl.bindVertexArray(this.faceArray);
    this.faceLayout ??= Object.assign([[0, 1, 0, 0], [1, 1, 4, 0]], { stride: 8 });
    this._buffer(data.subarray(0, o), this.faceLayout);
    gl.bindVertexArray(null);
  }

  /** Bars and rods, then beams, as rectangles on the screen. */
  _lines() {
    const gl = this.gl;
    const { line, segment, segmentColour } = this.drawing;
    const lineColour = this.byNode ? this.drawing.lineNode : this.drawing.lineColour;
    const data = [];
    lineColour.forEach((c, i) => data.push(line[2 * i], line[2 * i + 1], c < 0 ? this.fixed.none : c, Scene.BAR_PX));
    this.barCount = lineColour.length;
    segmentColour.forEach((c, i) => {
      data.push(segment[2 * i], segment[2 * i + 1], this.fixed[c], c === "ref" ? Scene.REF_PX : Scene.MEAS_PX);
    });
    this.beamCount = segmentColour.length;
    gl.bindVertexArray(this.lineArray);
    this.lineData = new Uint32Array(data);
    this.lineLayout ??= Object.assign([[0, 2, 0, 1], [1, 1, 8, 1], [2, 1, 12, 1]], { stride: 16 });
    this._buffer(this.lineData, this.lineLayout);
    this.lineBuffer = gl.getParameter(gl.ARRAY_BUFFER_BINDING);
    gl.bindVertexArray(null);
  }

  _pickTarget() {
    const gl = this.gl;
    const target = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    for (const [format, where] of [[gl.RGBA8, gl.COLOR_ATTACHMENT0], [gl.DEPTH_COMPONENT16, gl.DEPTH_ATTACHMENT]]) {
      const store = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, store);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, 1, 1);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, where, gl.RENDERBUFFER, store);
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return target;
  }

  /** Displacements (m) of all corners, layer after layer, each [3 n] with x of all corners first. */
  displace(layers) {
    let first = 0;
    const array = (this.move.array ??= new Float32Array(4 * Scene.WIDTH * this.move.height));
    for (const moved of layers) {
      const n = moved.length / 3;
      for (let i = 0; i < n; i++) {
        const o = 4 * (first + i);
        array[o] = moved[i];
        array[o + 1] = moved[n + i];
        array[o + 2] = moved[2 * n + i];
      }
      first += n;
    }
    this._fill(this.move, Float32Array, 0, () => {});
  }

  /** Colours [entries] of areas (RGB) and whether each is shown; what is no area keeps its own colour. */
  paint(colour, shown, hidden) {
    const fixed = Object.entries(Colours.FIXED);
    this._fill(this.palette, Uint8Array, this.entries, (i, o, a) => {
      const area = i < this.areas;
      const [name, own] = area ? [] : fixed[i - this.areas];
      const seen = area ? shown[i] : !hidden.has(name);
      a.set([...(area ? colour[i] : own), seen ? 255 : 0], o);
    });
  }

  /** `look`: matrix, factor, byDisplacement, largest (m), cut [x, y, z, w] or null, edges, chosen, background [r, g, b],
   *  detail: pixels drawn per pixel of the screen. */
  draw(look) {
    const gl = this.gl;
    const ratio = look.detail * Math.min(window.devicePixelRatio || 1, Scene.MOST_RATIO);
    const [w, h] = [this.canvas.clientWidth, this.canvas.clientHeight].map((v) => Math.max(1, Math.round(v * ratio)));
    if (this.canvas.width !== w || this.canvas.height !== h) Object.assign(this.canvas, { width: w, height: h });
    gl.viewport(0, 0, w, h);
    gl.clearColor(...look.background.map((v) => v / 255), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const set = (program) => this._uniforms(program, look, [w, h], ratio);
    let at = set(this.programs.face);
    gl.bindVertexArray(this.faceArray);
    gl.drawArrays(gl.TRIANGLES, 0, this.meshCount);
    gl.uniform4f(at.u_cut, 0, 0, 0, 1);
    gl.drawArrays(gl.TRIANGLES, this.meshCount, this.allCount - this.meshCount);
    gl.enable(gl.BLEND);
    this._through(at, 0.25, () => gl.drawArrays(gl.TRIANGLES, this.boxFirst, this.allCount - this.boxFirst));
    at = set(this.programs.line);
    gl.bindVertexArray(this.lineArray);
    this._segments(0, this.barCount);
    gl.uniform4f(at.u_cut, 0, 0, 0, 1);
    this._segments(this.barCount, this.beamCount);
    this._through(at, 0.45, () => this._segments(this.barCount, this.beamCount));
    gl.disable(gl.BLEND);
    gl.bindVertexArray(null);
  }

  /** Beams and test masses are inside the structure: where something hides them, they shine through it. */
  _through(at, alpha, draw) {
    const gl = this.gl;
    gl.depthFunc(gl.GREATER);
    gl.depthMask(false);
    gl.uniform1f(at.u_alpha, alpha);
    draw();
    gl.uniform1f(at.u_alpha, 1);
    gl.depthMask(true);
    gl.depthFunc(gl.LESS);
  }

  _segments(first, count) {
    const gl = this.gl;
    if (!count) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lineBuffer);
    for (const [place, n, offset] of [[0, 2, 0], [1, 1, 8], [2, 1, 12]]) {
      gl.vertexAttribIPointer(place, n, gl.UNSIGNED_INT, 16, 16 * first + offset);
    }
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
  }

  _uniforms({ program, at }, look, size, ratio) {
    const gl = this.gl;
    gl.useProgram(program);
    [this.place, this.move, this.palette, this.scale].forEach((texture, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture.texture);
      gl.uniform1i(at[["u_place", "u_move", "u_palette", "u_scale"][unit]], unit);
    });
    gl.activeTexture(gl.TEXTURE0);
    gl.uniformMatrix4fv(at.u_matrix, false, look.matrix);
    gl.uniform3f(at.u_eye, ...look.eye);
    gl.uniform1f(at.u_factor, look.factor);
    gl.uniform1f(at.u_largest, look.byDisplacement ? look.largest : -1);
    gl.uniform4f(at.u_cut, ...(look.cut ?? [0, 0, 0, 1]));
    gl.uniform1i(at.u_areas, this.areas);
    gl.uniform1i(at.u_chosen, look.chosen);
    gl.uniform1i(at.u_edges, look.edges ? 1 : 0);
    gl.uniform1i(at.u_flat, program === this.programs.line.program ? 1 : 0);
    gl.uniform1i(at.u_pick, look.pick ? 1 : 0);
    gl.uniform1f(at.u_alpha, 1);
    gl.uniform2f(at.u_size, ...size);
    gl.uniform1f(at.u_ratio, ratio);
    return at;
  }

  /** The entry of the palette that is drawn at a point of the canvas (px from its upper left corner), or -1. */
  pick(look, x, y) {
    const gl = this.gl;
    const ratio = this.canvas.width / this.canvas.clientWidth;
    const [w, h] = [this.canvas.width, this.canvas.height];
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.pickTarget);
    gl.viewport(-Math.round(x * ratio), Math.round(y * ratio) - h + 1, w, h);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const picked = { ...look, pick: true };
    const at = this._uniforms(this.programs.face, picked, [w, h], ratio);
    gl.bindVertexArray(this.faceArray);
    gl.drawArrays(gl.TRIANGLES, 0, this.meshCount);
    gl.uniform4f(at.u_cut, 0, 0, 0, 1);
    gl.drawArrays(gl.TRIANGLES, this.meshCount, this.allCount - this.meshCount);
    this._uniforms(this.programs.line, picked, [w, h], ratio);
    gl.bindVertexArray(this.lineArray);
    this._segments(0, this.barCount);
    const pixel = new Uint8Array(4);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.bindVertexArray(null);
    const entry = pixel[0] + 256 * pixel[1];
    return entry === 65535 ? -1 : entry;
  }
}
Scene.WIDTH = 1024; // of textures
Scene.MOST_RATIO = 2; // pixels of the screen per pixel of the page
[Scene.BAR_PX, Scene.REF_PX, Scene.MEAS_PX] = [9, 5, 3]; // half widths are quarters of these
