"use strict";
// What the graphics card does with faces and lines.
const SHADER_HEAD = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D u_place, u_move, u_palette, u_scale;
uniform float u_factor, u_largest, u_alpha, u_ratio;
uniform vec4 u_cut;
uniform vec3 u_eye;
uniform vec2 u_size;
uniform int u_areas, u_chosen, u_edges, u_pick, u_flat;
uniform mat4 u_matrix;
ivec2 cell(uint i) { return ivec2(int(i) & 1023, int(i) >> 10); }
`;
const CORNER = `
flat out int v_entry, v_edges;
flat out vec3 v_base;
out vec3 v_at, v_rest, v_weight;
out float v_moved;
vec3 rest(uint i) { return texelFetch(u_place, cell(i), 0).xyz; }
vec3 moved(uint i) { return texelFetch(u_move, cell(i), 0).xyz; }
bool hidden(uint entry) {
  vec4 colour = texelFetch(u_palette, cell(entry), 0);
  v_base = colour.rgb;
  return colour.a < 0.5;
}
void corner(uint i) {
  v_rest = rest(i);
  vec3 d = moved(i);
  v_moved = length(d);
  v_at = v_rest + u_factor * d;
}
`;
const FACE_VERTEX = `${SHADER_HEAD}
layout(location = 0) in uint a_corner;
layout(location = 1) in uint a_entry;
${CORNER}
void main() {
  uint entry = a_entry & 65535u;
  v_entry = int(entry);
  v_edges = int(a_entry >> 16);
  int place = gl_VertexID % 3;
  v_weight = vec3(place == 0, place == 1, place == 2);
  corner(a_corner);
  gl_Position = hidden(entry) ? vec4(2.0, 2.0, 2.0, 1.0) : u_matrix * vec4(v_at, 1.0);
}`;
const LINE_VERTEX = `${SHADER_HEAD}
layout(location = 0) in uvec2 a_ends;
layout(location = 1) in uint a_entry;
layout(location = 2) in uint a_width;
${CORNER}
void main() {
  v_entry = int(a_entry);
  v_edges = 0;
  v_weight = vec3(1.0);
  bool second = gl_VertexID > 1;
  corner(second ? a_ends.x : a_ends.y);
  vec4 other = u_matrix * vec4(v_at, 1.0);
  corner(second ? a_ends.y : a_ends.x);
  vec4 own = u_matrix * vec4(v_at, 1.0);
  vec2 along = (other.xy / other.w - own.xy / own.w) * u_size * (second ? -1.0 : 1.0);
  float far = max(length(along), 1e-6);
  vec2 across = vec2(-along.y, along.x) / far * (gl_VertexID % 2 == 0 ? 1.0 : -1.0);
  own.xy += across * (float(a_width) / 4.0) * u_ratio * 2.0 / u_size * own.w;
  own.z -= 1e-4 * own.w;
  gl_Position = hidden(a_entry) ? vec4(2.0, 2.0, 2.0, 1.0) : own;
}`;
const FACE_FRAGMENT = `${SHADER_HEAD}
flat in int v_entry, v_edges;
flat in vec3 v_base;
in vec3 v_at, v_rest, v_weight;
in float v_moved;
out vec4 colour;
void main() {
  if (dot(v_rest, u_cut.xyz) > u_cut.w) discard;
  if (u_pick == 1) {
    colour = vec4(float(v_entry & 255), float(v_entry >> 8), 0.0, 255.0) / 255.0;
    return;
  }
  vec3 base = v_base;
  if (u_largest >= 0.0 && v_entry < u_areas) {
    float part = u_largest > 0.0 ? clamp(v_moved / u_largest, 0.0, 1.0) : 0.0;
    base = texelFetch(u_scale, ivec2(int(part * 255.0 + 0.5), 0), 0).rgb;
  }
  vec3 normal = cross(dFdx(v_at), dFdy(v_at));
  float size = length(normal);
  vec3 towards = normalize(u_eye - v_at);
  float lit = size > 0.0 && u_flat == 0 ? abs(dot(normal / size, normalize(towards + vec3(0.0, 0.0, 0.35)))) : 1.0;
  base *= 0.5 + 0.5 * lit;
  if (u_edges == 1 && v_edges != 0) {
    vec3 away = v_weight / max(fwidth(v_weight), vec3(1e-6)); // px from each side of the triangle
    vec3 seen = mix(vec3(9.0), away, vec3(v_edges & 1, (v_edges >> 1) & 1, (v_edges >> 2) & 1));
    base *= 1.0 - 0.28 * (1.0 - smoothstep(0.0, 0.9 * u_ratio, min(seen.x, min(seen.y, seen.z))));
  }
  if (v_entry == u_chosen) {
    float stripe = step(0.5, fract((gl_FragCoord.x + gl_FragCoord.y) / (10.0 * u_ratio)));
    base = mix(base, vec3(1.0), 0.45 * stripe);
  }
  colour = vec4(base, u_alpha);
}`;
