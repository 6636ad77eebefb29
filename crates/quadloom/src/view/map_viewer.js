// The viewer of a map's page: the surface in WebGL2, the flat picture beside it, and one lit face in both.
//
// In: the JSON of #scene, packed by map_page.rs; common.js. Out: the picture; `window.quadloomMap` for scripts; options in
// the address after '#', as in #theme=dark&yaw=-30&pitch=20&zoom=1.4&face=12&turntable=on.
// Holds: a frame is drawn only when something changed; of the flat picture only the elements of KEPT are taken over;
// nothing is asked for outside the page.
(() => {
'use strict';

const { $, bytes, floats, rgb, element, drawing, add, scale, dot, length, turn, times, rotated, AXES, HOME_YAW, HOME_PITCH, facing, turnedToEye,
  makeCamera, listenToPointers, pixelRatio, makeFrames, faceNormals, cornerNormals, LINE_VERTEX, LINE_FRAGMENT, gpuTools } = quadloomCommon;

// ------------------------------------------------------------------------------------------------ the scene

const packed = JSON.parse($('scene').textContent);
const NUMBERS = { 1: Uint8Array, 2: Uint16Array, 4: Uint32Array };
const numbers = ({ width, data }) => new NUMBERS[width](bytes(data));

const NO_CLASS = [150, 156, 163];
const surface = sortedByFace();
const { positions, faces: corners, count, tint, parts } = surface;   // parts: face to its range of triangles
const named = [...parts.keys()];

// The triangles, those of each face side by side in the order of faces, those of none at the end.
function sortedByFace() {
  const given = numbers(packed.triangles), face = numbers(packed.face), tints = numbers(packed.tint), none = 256 ** packed.face.width - 1;
  const size = new Map();
  for (const f of face) size.set(f, (size.get(f) ?? 0) + 1);
  const parts = new Map(), place = new Map();
  let start = 0;
  for (const f of [...size.keys()].sort((a, b) => a - b)) {
    place.set(f, start);
    if (f !== none) parts.set(f, { start, end: start + size.get(f) });
    start += size.get(f);
  }
  const faces = new Uint32Array(given.length), tint = new Uint32Array(face.length), owner = new Float64Array(face.length).fill(-1);   // of 32-bit numbers and -1
  face.forEach((f, t) => {
    const to = place.get(f);
    place.set(f, to + 1);
    for (let k = 0; k < 3; k++) faces[3 * to + k] = given[3 * t + k];
    tint[to] = tints[t];
    if (f !== none) owner[to] = f;
  });
  return { positions: floats(packed.positions), faces, degree: 3, count: face.length, tint, owner, parts };
}
const faceOf = triangle => (triangle >= 0 && triangle < count && surface.owner[triangle] >= 0 ? surface.owner[triangle] : null);
const colourOf = tint => (tint === 0 ? packed.edge_color : tint === 1 ? NO_CLASS : packed.palette[tint - 2]);
const css = colour => `rgb(${colour.join(', ')})`;

// Colour of a face: of its first triangle outside bands.
function faceColour(face) {
  const { start, end } = parts.get(face) ?? { start: 0, end: 0 };
  for (let t = start; t < end; t++) if (tint[t] > 1) return colourOf(tint[t]);
  return null;
}

let flat = null;   // the flat picture
const state = { theme: 'light', chosenTheme: false, hover: null, kept: null, turning: false, oversampling: true, ready: false };
const lit = () => state.kept ?? state.hover;

const THEMES = {
  light: { back: '#7a7266', veil: [0.74, 0.74, 0.73], ghost: 0.5, sky: [1.0, 1.0, 1.02], ground: [0.62, 0.60, 0.58], rim: 0.16 },
  dark: { back: '#4d473d', veil: [0.03, 0.035, 0.045], ghost: 0.5, sky: [0.80, 0.86, 0.96], ground: [0.30, 0.29, 0.30], rim: 0.42 },
};

// ------------------------------------------------------------------------------------------------ camera

const canvas = $('canvas');
const space = () => ({ right: 0, bottom: 60 });   // above the tools
const { camera, currentView, flyTo, fly, stop, follow, fitted, goHome, keepFitted, orbit, pan, zoom } =
  makeCamera({ canvas, space, positions: () => positions, redraw: () => redraw() });

const TURNTABLE_SPEED = 14 * Math.PI / 180;   // a second
const LONGEST_STEP = 0.1;                      // seconds: a sleeping page does not jump
let lastSpin = null;

// Turns about the axis of the surface that is nearest to upright, so that a tilted view stays tilted.
function spin(now) {
  if (!state.turning) { lastSpin = null; return; }
  const passed = lastSpin === null ? 0 : Math.min((now - lastSpin) / 1000, LONGEST_STEP);
  lastSpin = now;
  if (!canvas.classList.contains('dragging')) {
    const upright = axis => rotated(camera.rotation, axis)[1];
    const axis = Object.values(AXES).reduce((best, next) => (Math.abs(upright(next)) > Math.abs(upright(best)) + 1e-9 ? next : best), AXES.y);
    camera.rotation = times(camera.rotation, turn(axis, passed * TURNTABLE_SPEED * Math.sign(upright(axis) || 1)));
  }
  redraw();
}

// ------------------------------------------------------------------------------------------------ shaders

const SURFACE_VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 normal;      // and openness, the share of the sky that is seen
layout(location = 2) in vec4 tint;
uniform mat4 view, projection;
uniform ivec2 marked;                     // triangles of the lit face, if any
out vec3 vNormal, vEye;
out float vOpen;
flat out vec3 vTint;
flat out float vLit;
void main() {
  vec4 eye = view * vec4(position, 1.0);
  int triangle = gl_VertexID / 3;
  vEye = eye.xyz; vNormal = mat3(view) * normal.xyz; vOpen = normal.w; vTint = tint.rgb;
  vLit = marked.x == marked.y ? 0.0 : triangle >= marked.x && triangle < marked.y ? 1.0 : -1.0;
  gl_Position = projection * eye;
}`;

const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 vNormal, vEye;
in float vOpen;
flat in vec3 vTint;
flat in float vLit;
uniform vec3 back, sky, ground, veil;
uniform float rim, alpha;
out vec4 colour;
vec3 linear(vec3 c) { return pow(c, vec3(2.2)); }
void main() {
  vec3 n = normalize(vNormal), toEye = normalize(-vEye);
  vec3 albedo = linear(vTint);
  if (!gl_FrontFacing) { n = -n; albedo = mix(albedo, linear(back), 0.6); }
  if (vLit > 0.5) albedo = albedo * 1.30 + 0.025;
  if (vLit < -0.5) albedo = mix(mix(albedo, vec3(dot(albedo, vec3(0.3, 0.55, 0.15))), 0.3), veil, 0.45);
  float open = mix(1.0, vOpen, 0.9);
  // 1. A warm key light from the upper left, a cool one from the right, the sky above and what the ground gives back.
  vec3 key = normalize(vec3(-0.48, 0.68, 0.62)), fill = normalize(vec3(0.85, -0.12, 0.42));
  float lit = max(0.0, (dot(n, key) + 0.22) / 1.22), side = max(0.0, dot(n, fill));
  vec3 light = vec3(1.0, 0.965, 0.91) * 0.74 * lit * mix(0.55, 1.0, open)
    + vec3(0.70, 0.82, 1.0) * 0.13 * side * open
    + mix(ground, sky, smoothstep(-1.0, 1.0, n.y)) * 0.46 * open * open;
  vec3 c = albedo * light;
  // 2. A sheen, and a rim where the surface turns away.
  float facing = clamp(dot(n, toEye), 0.0, 1.0);
  float broad = pow(max(0.0, dot(n, normalize(key + toEye))), 14.0), sharp = pow(max(0.0, dot(n, normalize(key + toEye))), 90.0);
  c += vec3(1.0, 0.98, 0.95) * (0.045 * broad + 0.13 * sharp) * open;
  c += sky * rim * pow(1.0 - facing, 3.5) * (0.35 + 0.65 * smoothstep(-0.4, 0.9, n.y)) * open * (0.35 + albedo);
  // 3. Bright colours bend towards white instead of breaking off.
  c = c / (1.0 + max(vec3(0.0), c - 0.72) * 0.9);
  colour = vec4(pow(min(c, 1.0), vec3(1.0 / 2.2)), 1.0) * alpha;
}`;

// The number of the triangle, plus one, as a colour.
const NUMBER_VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
uniform mat4 view, projection;
flat out int vNumber;
void main() { vNumber = gl_VertexID / 3 + 1; gl_Position = projection * view * vec4(position, 1.0); }`;
const NUMBER_FRAGMENT = `#version 300 es
precision highp float;
flat in int vNumber;
out vec4 colour;
void main() { colour = vec4(ivec4(vNumber, vNumber >> 8, vNumber >> 16, vNumber >> 24) & 255) / 255.0; }`;

const DEPTH_VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
uniform mat3 turned;
void main() { vec3 p = turned * position; gl_Position = vec4(p.xy / 1.05, -p.z / 1.05, 1.0); }`;
const DEPTH_FRAGMENT = `#version 300 es
precision highp float;
void main() { }`;

// One point per vertex: how much of the light from this direction reaches it, and how much would without obstacles.
const OPEN_VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat3 turned;
uniform highp sampler2DShadow depth;
uniform ivec2 size;
uniform float weight;
out vec4 vSeen;
void main() {
  vec3 n = turned * normal, p = (turned * (position + 0.008 * normal)) / 1.05;
  float toward = max(0.0, n.z) * weight;
  float free = texture(depth, vec3(p.xy, -p.z - 0.003) * 0.5 + 0.5);
  vSeen = vec4(toward * free, toward, 0.0, 0.0);
  ivec2 place = ivec2(gl_VertexID % size.x, gl_VertexID / size.x);
  gl_Position = vec4((vec2(place) + 0.5) / vec2(size) * 2.0 - 1.0, 0.0, 1.0);
  gl_PointSize = 1.0;
}`;
const OPEN_FRAGMENT = `#version 300 es
precision highp float;
in vec4 vSeen;
out vec4 seen;
void main() { seen = vSeen; }`;

// ------------------------------------------------------------------------------------------------ openness

const DEPTH_SIDE = 1024;
const LEAST_DIRECTIONS = 24, MOST_DIRECTIONS = 64, WORK = 5e6;   // triangles drawn for the shadows
const OPEN_WIDTH = 1024;

// Directions evenly over the sphere.
function directions(n) {
  return Array.from({ length: n }, (_, k) => {
    const z = 1 - (2 * k + 1) / n, r = Math.sqrt(1 - z * z), angle = k * Math.PI * (3 - Math.sqrt(5));
    return [r * Math.cos(angle), r * Math.sin(angle), z];
  });
}

// The rotation that takes a direction to z, column by column.
function toZ([x, y, z]) {
  const helper = Math.abs(x) < 0.9 ? [1, 0, 0] : [0, 1, 0], away = dot(helper, [x, y, z]);
  const u = add(helper, scale([x, y, z], -away)), s = scale(u, 1 / length(u));
  const t = [y * s[2] - z * s[1], z * s[0] - x * s[2], x * s[1] - y * s[0]];
  return [s[0], t[0], x, s[1], t[1], y, s[2], t[2], z];
}

// Mean normal of every vertex.
function vertexNormals() {
  const area = faceNormals(surface), out = new Float32Array(positions.length);
  for (let corner = 0; corner < corners.length; corner++) {
    const v = 3 * corners[corner], f = 3 * ((corner / 3) | 0);
    out[v] += area[f]; out[v + 1] += area[f + 1]; out[v + 2] += area[f + 2];
  }
  for (let v = 0; v < out.length; v += 3) {
    const n = Math.hypot(out[v], out[v + 1], out[v + 2]) || 1;
    out[v] /= n; out[v + 1] /= n; out[v + 2] /= n;
  }
  return out;
}

// Per vertex the share of directions, weighted as a matt surface does, from which it is seen; null where the GPU cannot.
function measureOpenness() {
  if (!gl.getExtension('EXT_color_buffer_float') || !count) return null;
  const vertices = positions.length / 3, height = Math.ceil(vertices / OPEN_WIDTH);
  if (height > gl.getParameter(gl.MAX_TEXTURE_SIZE)) return null;
  const n = Math.round(Math.min(Math.max(WORK / count, LEAST_DIRECTIONS), MOST_DIRECTIONS));
  const place = bufferOf(positions), normal = bufferOf(vertexNormals());
  const whole = vertexArray([{ buffer: place, at: 0, size: 3, stride: 12, offset: 0 }, { buffer: normal, at: 1, size: 3, stride: 12, offset: 0 }]);
  const index = gl.createBuffer();
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
  const depth = target(gl.DEPTH_COMPONENT24, DEPTH_SIDE, DEPTH_SIDE, gl.DEPTH_ATTACHMENT), sum = target(gl.RGBA16F, OPEN_WIDTH, height, gl.COLOR_ATTACHMENT0);
  const shadow = program(DEPTH_VERTEX, DEPTH_FRAGMENT), open = program(OPEN_VERTEX, OPEN_FRAGMENT);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT);
  for (const direction of directions(n)) {
    const turned = toZ(direction);
    gl.bindFramebuffer(gl.FRAMEBUFFER, depth.frame);
    gl.viewport(0, 0, DEPTH_SIDE, DEPTH_SIDE);
    gl.enable(gl.DEPTH_TEST); gl.disable(gl.BLEND);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(shadow.linked);
    gl.uniformMatrix3fv(shadow.at.turned, false, turned);
    gl.drawElements(gl.TRIANGLES, corners.length, gl.UNSIGNED_INT, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, sum.frame);
    gl.viewport(0, 0, OPEN_WIDTH, height);
    gl.disable(gl.DEPTH_TEST); gl.enable(gl.BLEND); gl.blendFunc(gl.ONE, gl.ONE);
    gl.bindTexture(gl.TEXTURE_2D, depth.texture);
    gl.useProgram(open.linked);
    gl.uniformMatrix3fv(open.at.turned, false, turned);
    gl.uniform2i(open.at.size, OPEN_WIDTH, height);
    gl.uniform1f(open.at.weight, 4 / n);
    gl.drawArrays(gl.POINTS, 0, vertices);
  }
  const seen = new Float32Array(4 * OPEN_WIDTH * height);
  gl.readPixels(0, 0, OPEN_WIDTH, height, gl.RGBA, gl.FLOAT, seen);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.bindTexture(gl.TEXTURE_2D, null);
  gl.bindVertexArray(null);
  for (const { frame, texture } of [depth, sum]) { gl.deleteFramebuffer(frame); gl.deleteTexture(texture); }
  for (const buffer of [place, normal, index]) gl.deleteBuffer(buffer);
  return smoothed(Float32Array.from({ length: vertices }, (_, v) => (seen[4 * v + 1] > 0 ? Math.min(1, seen[4 * v] / seen[4 * v + 1]) : 1)));
}

function target(format, width, height, attachment) {
  const frame = gl.createFramebuffer(), texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
  const shadow = attachment === gl.DEPTH_ATTACHMENT, filter = shadow ? gl.LINEAR : gl.NEAREST;
  for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, filter], [gl.TEXTURE_MAG_FILTER, filter], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, name, value);
  if (shadow) gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
  gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, attachment, gl.TEXTURE_2D, texture, 0);
  if (shadow) gl.drawBuffers([gl.NONE]);
  return { frame, texture };
}

// Shadows have steps; means over neighbours take them away.
const ROUNDS = 3;
function smoothed(values) {
  for (let round = 0; round < ROUNDS; round++) {
    const sum = values.slice(), weight = new Float32Array(values.length).fill(1);
    for (let corner = 0; corner < corners.length; corner += 3) {
      const [a, b, c] = [corners[corner], corners[corner + 1], corners[corner + 2]], all = values[a] + values[b] + values[c];
      for (const v of [a, b, c]) { sum[v] += all - values[v]; weight[v] += 2; }
    }
    values = sum.map((x, v) => x / weight[v]);
  }
  return values;
}

// ------------------------------------------------------------------------------------------------ drawing

const BYTES_PER_CORNER = 24;   // position 3 floats, normal and openness 4 shorts, colour 4 bytes
function surfaceBuffer(open) {
  const normal = cornerNormals(surface), data = new ArrayBuffer(3 * count * BYTES_PER_CORNER);
  const real = new Float32Array(data), short = new Int16Array(data), byte = new Uint8Array(data), share = x => Math.round(32767 * x);
  for (let corner = 0; corner < corners.length; corner++) {
    const v = corners[corner], colour = colourOf(tint[(corner / 3) | 0]);
    for (let k = 0; k < 3; k++) {
      real[6 * corner + k] = positions[3 * v + k];
      short[12 * corner + 6 + k] = share(normal[3 * corner + k]);
      byte[24 * corner + 20 + k] = colour[k];
    }
    short[12 * corner + 9] = share(open ? open[v] : 1);
  }
  return data;
}

let gl = null, gpu = null, program = null, vertexArray = null, bufferOf = null, data = null;

function startGpu() {
  ({ program, vertexArray, bufferOf } = gpuTools(gl));
  data ??= surfaceBuffer(measureOpenness());
  const buffer = bufferOf(data), part = (at, size, type, offset) => ({ buffer, at, size, type, stride: BYTES_PER_CORNER, offset });
  gpu = {
    surface: program(SURFACE_VERTEX, SURFACE_FRAGMENT), number: program(NUMBER_VERTEX, NUMBER_FRAGMENT), line: program(LINE_VERTEX, LINE_FRAGMENT),
    array: vertexArray([part(0, 3, gl.FLOAT, 0), part(1, 4, gl.SHORT, 12), part(2, 4, gl.UNSIGNED_BYTE, 20)]),
    strip: bufferOf(new Float32Array([0, -1, 0, 1, 1, -1, 1, 1])), outlines: new Map(), numbers: null,
  };
}

// The sides of the face's triangles that have no other of its triangles beside them.
function outline(face) {
  const { start, end } = parts.get(face), vertices = positions.length / 3, sides = new Map();
  for (let corner = 3 * start; corner < 3 * end; corner++) {
    const a = corners[corner], b = corners[corner % 3 === 2 ? corner - 2 : corner + 1], name = Math.min(a, b) * vertices + Math.max(a, b);
    if (!sides.delete(name)) sides.set(name, [a, b]);
  }
  return Float32Array.from([...sides.values()].flat().flatMap(v => [...positions.subarray(3 * v, 3 * v + 3)]));
}
function outlineArray(face) {
  if (!gpu.outlines.has(face)) {
    const points = outline(face), buffer = bufferOf(points), part = (at, offset) => ({ buffer, at, size: 3, stride: 24, offset, perInstance: true });
    gpu.outlines.set(face, { array: vertexArray([{ buffer: gpu.strip, at: 0, size: 2, stride: 8, offset: 0 }, part(1, 0), part(2, 12)]), count: points.length / 6 });
  }
  return gpu.outlines.get(face);
}

function useProgram({ linked, at }, view) {
  gl.useProgram(linked);
  gl.uniformMatrix4fv(at.view, false, view.view);
  gl.uniformMatrix4fv(at.projection, false, view.projection);
  return at;
}

function draw(fine) {
  const ratio = pixelRatio(canvas, fine && state.oversampling), view = currentView();
  const [w, h] = [Math.round(view.width * ratio), Math.round(view.height * ratio)];
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  if (gpu.numbers) gpu.numbers.valid = false;
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.viewport(0, 0, w, h);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LESS);
  gl.disable(gl.BLEND);
  const theme = THEMES[state.theme], part = parts.get(lit()) ?? { start: 0, end: 0 }, at = useProgram(gpu.surface, view);
  gl.uniform2i(at.marked, part.start, part.end);
  gl.uniform3fv(at.back, rgb(theme.back));
  gl.uniform3fv(at.sky, theme.sky);
  gl.uniform3fv(at.ground, theme.ground);
  gl.uniform3fv(at.veil, theme.veil);
  gl.uniform1f(at.rim, theme.rim);
  gl.uniform1f(at.alpha, 1);
  gl.bindVertexArray(gpu.array);
  gl.drawArrays(gl.TRIANGLES, 0, 3 * count);
  if (part.end > part.start) drawLit(part, theme, view, ratio, at);
}

// The lit face shines through what hides it, and has an outline.
function drawLit({ start, end }, theme, view, ratio, at) {
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  gl.depthMask(false);
  gl.depthFunc(gl.GREATER);
  gl.uniform1f(at.alpha, theme.ghost);
  gl.drawArrays(gl.TRIANGLES, 3 * start, 3 * (end - start));
  gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  drawOutline(OUTLINE, view, ratio, 0.4);
  gl.depthFunc(gl.LESS);
  drawOutline(CASING, view, ratio, 0.9);
  drawOutline(OUTLINE, view, ratio, 1);
  gl.depthMask(true);
}

// White in dark is seen on every colour.
const OUTLINE = { width: 2, raise: 0.0065, colour: [1, 1, 1] }, CASING = { width: 4.6, raise: 0.006, colour: [0.04, 0.05, 0.07] };
function drawOutline({ width, raise, colour }, view, ratio, alpha) {
  const { array, count } = outlineArray(lit()), at = useProgram(gpu.line, view);
  gl.uniform2f(at.wipe, 0, 0);
  gl.uniform2f(at.viewport, canvas.width, canvas.height);
  gl.vertexAttrib3fv(3, colour);
  gl.uniform1f(at.width, width * ratio);
  gl.uniform1f(at.raise, raise);
  gl.uniform1f(at.near, view.near);
  gl.uniform1f(at.alpha, alpha);
  gl.bindVertexArray(array);
  gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
}

const { redraw } = makeFrames({ step: now => { fly(now); spin(now); }, draw: fine => { if (gpu && !gl.isContextLost()) draw(fine); } });

// ------------------------------------------------------------------------------------------------ picking

// The numbers of the triangles in the pixels of the page, drawn again after the surface was.
function numbersNow() {
  const view = currentView(), [width, height] = [Math.max(1, Math.round(view.width)), Math.max(1, Math.round(view.height))];
  if (gpu.numbers && (gpu.numbers.width !== width || gpu.numbers.height !== height)) {
    gl.deleteFramebuffer(gpu.numbers.frame); gl.deleteTexture(gpu.numbers.texture); gl.deleteRenderbuffer(gpu.numbers.depth);
    gpu.numbers = null;
  }
  gpu.numbers ??= { ...target(gl.RGBA8, width, height, gl.COLOR_ATTACHMENT0), depth: depthBeside(width, height), width, height, valid: false };
  gl.bindFramebuffer(gl.FRAMEBUFFER, gpu.numbers.frame);
  if (gpu.numbers.valid) return gpu.numbers;
  gl.viewport(0, 0, width, height);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST); gl.depthFunc(gl.LESS); gl.disable(gl.BLEND);
  useProgram(gpu.number, view);
  gl.bindVertexArray(gpu.array);
  gl.drawArrays(gl.TRIANGLES, 0, 3 * count);
  gpu.numbers.valid = true;
  return gpu.numbers;
}
function depthBeside(width, height) {
  const depth = gl.createRenderbuffer();
  gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
  gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
  return depth;
}

// The face seen at a pixel of the canvas, or null.
function pick(x, y) {
  if (!gpu || gl.isContextLost()) return null;
  const { height } = numbersNow(), pixel = new Uint8Array(4);
  gl.readPixels(Math.floor(x), height - 1 - Math.floor(y), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  return faceOf((pixel[0] | pixel[1] << 8 | pixel[2] << 16 | pixel[3] << 24) - 1);
}

// ------------------------------------------------------------------------------------------------ the flat picture

const KEPT = new Set(['svg', 'g', 'path', 'polygon', 'polyline', 'line', 'circle', 'ellipse', 'rect', 'text', 'tspan', 'title', 'desc', 'defs', 'use',
  'clipPath', 'mask', 'symbol', 'linearGradient', 'radialGradient', 'stop', 'style']);
const SVG = 'http://www.w3.org/2000/svg';
let flatView = null;                // all of it: x, y, width, height
const groups = new Map();           // face to its groups

function takeFlat() {
  const text = packed.flat.trim();
  if (!text) return null;
  const source = text.replace(/<svg(?=[\s>])(?![^>]*\sxmlns\s*=)/, `<svg xmlns="${SVG}"`);
  const root = new DOMParser().parseFromString(source, 'image/svg+xml').documentElement;
  if (root.localName !== 'svg' || root.querySelector('parsererror')) return remark('The flat picture is not well-formed, so it is not shown.');
  purge(root);
  const view = (root.getAttribute('viewBox') ?? '').trim().split(/[\s,]+/).map(Number);
  const size = ['width', 'height'].map(name => parseFloat(root.getAttribute(name)) || 100);
  for (const name of ['width', 'height', 'x', 'y', 'style']) root.removeAttribute(name);
  for (const [name, value] of Object.entries({ tabindex: '0', role: 'img', 'aria-label': `${packed.title}, flat picture`, preserveAspectRatio: 'xMidYMid meet' })) root.setAttribute(name, value);
  flatView = view.length === 4 && view.every(Number.isFinite) && view[2] > 0 && view[3] > 0 ? view : [0, 0, ...size];
  return document.importNode(root, true);
}

// Takes away everything but drawing: scripts, foreign content, handlers, links out of the page.
function purge(root) {
  for (const node of [...root.querySelectorAll('*')]) if (!KEPT.has(node.localName) || node.namespaceURI !== SVG) node.remove();
  for (const node of [root, ...root.querySelectorAll('*')]) {
    for (const { name, localName, value } of [...node.attributes]) if (/^on/i.test(localName) || (localName === 'href' && !value.startsWith('#'))) node.removeAttribute(name);
  }
}

function showFlat() {
  flat = takeFlat();
  document.documentElement.dataset.flat = flat ? 'shown' : 'none';
  $('flat').hidden = !flat;
  if (!flat) return;
  $('flat').append(flat);
  for (const group of flat.querySelectorAll('[data-face]')) {
    const face = faceOfGroup(group);
    if (face === null) continue;
    if (!groups.has(face)) groups.set(face, []);
    groups.get(face).push(group);
  }
  frameFlat(flatView);
}
const faceOfGroup = group => (/^\d+$/.test(group?.dataset.face ?? '') ? Number(group.dataset.face) : null);

let framed = null;
const perPixel = () => Math.max(framed[2] / ($('flat').clientWidth || 1), framed[3] / ($('flat').clientHeight || 1));
function frameFlat(view) {
  framed = [...view];
  flat.setAttribute('viewBox', view.map(x => +x.toPrecision(9)).join(' '));
  flat.style.setProperty('--pixel', `${perPixel()}px`);   // outlines keep their width
}

// A veil over the whole, and copies of the face's groups above it: only there an outline goes around them.
let veiled = null;
function lightFlat(face) {
  veiled?.remove();
  veiled = null;
  for (const group of [...$('flat').querySelectorAll('.lit')]) group.classList.remove('lit');
  if (!groups.has(face)) return;
  const [x, y, w, h] = flatView, far = 20;
  veiled = drawing('g', { class: 'veiled' }, drawing('rect', { class: 'veil', x: x - far * w, y: y - far * h, width: (2 * far + 1) * w, height: (2 * far + 1) * h }));
  for (const group of groups.get(face)) {
    group.classList.add('lit');
    veiled.append(copyOf(group));
  }
  flat.append(veiled);
}

// A copy within copies of what surrounds the group, so that it has the same place and style.
function copyOf(group) {
  let copy = group.cloneNode(true);
  copy.classList.add('halo');
  for (let around = group.parentNode; around !== flat; around = around.parentNode) {
    const outer = around.cloneNode(false);
    outer.append(copy);
    copy = outer;
  }
  for (const node of [copy, ...copy.querySelectorAll('*')]) { node.removeAttribute('id'); node.removeAttribute('data-face'); node.classList.remove('lit'); }
  return copy;
}

function listenToFlat() {
  const box = $('flat'), groupAt = event => event.target.closest?.('[data-face]');
  let down = null;
  box.addEventListener('pointerover', event => { if (!down) hover(faceOfGroup(groupAt(event))); });
  box.addEventListener('pointerleave', () => hover(null));
  box.addEventListener('pointerdown', event => { if (event.button === 0) down = { x: event.clientX, y: event.clientY, view: framed, moved: false, id: event.pointerId }; });
  box.addEventListener('pointermove', event => {
    if (!down) return;
    const [dx, dy] = [event.clientX - down.x, event.clientY - down.y];
    if (!down.moved && Math.hypot(dx, dy) < 4) return;
    if (!down.moved) { box.setPointerCapture(down.id); box.classList.add('moving'); down.moved = true; }
    const [x, y, w, h] = down.view, s = perPixel();
    frameFlat([x - dx * s, y - dy * s, w, h]);
  });
  for (const end of ['pointerup', 'pointercancel']) box.addEventListener(end, event => {
    if (down && !down.moved && end === 'pointerup') keep(faceOfGroup(groupAt(event)), true);
    down = null;
    box.classList.remove('moving');
  });
  box.addEventListener('dblclick', () => frameFlat(flatView));
  box.addEventListener('wheel', event => {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1), s = perPixel(), area = box.getBoundingClientRect();
    const width = Math.min(Math.max(framed[2] * Math.exp(Math.min(Math.max(pixels, -240), 240) * 0.0016), flatView[2] / 400), 1.25 * flatView[2]);
    const factor = width / framed[2], [x, y, w, h] = framed;
    const [px, py] = [x + w / 2 + (event.clientX - area.left - area.width / 2) * s, y + h / 2 + (event.clientY - area.top - area.height / 2) * s];
    frameFlat(width >= flatView[2] ? flatView : [px + (x - px) * factor, py + (y - py) * factor, w * factor, h * factor]);
  }, { passive: false });
}

// ------------------------------------------------------------------------------------------------ panel

const grouped = n => n.toLocaleString('en').replaceAll(',', '\u202f');
function remark(text) {
  $('remark').textContent = `${$('remark').textContent} ${text}`.trim();
  $('remark').hidden = false;
  return null;
}

const MOST_SWATCHES = 24;
function buildLegend() {
  const faces = packed.palette.map(() => new Set());
  let bands = false;
  tint.forEach((k, t) => { if (k > 1) { if (faceOf(t) !== null) faces[k - 2].add(surface.owner[t]); } else bands ||= k === 0; });
  const swatch = (colour, text, kind = '') => {
    const dot = element('i', { class: kind });
    dot.style.background = css(colour);
    return element('span', {}, dot, text);
  };
  const used = packed.palette.map((colour, k) => [colour, faces[k].size]).filter(([, size]) => size > 0);
  if (used.length <= MOST_SWATCHES) $('legend').append(...used.map(([colour, size]) => swatch(colour, `${grouped(size)} ${size === 1 ? 'face' : 'faces'}`)));
  if (bands) $('legend').append(swatch(packed.edge_color, 'edges', 'band'));
}

function buildPanel() {
  $('facts').append(...packed.facts.map(([name, value]) => element('div', {}, element('dt', { text: name }), element('dd', { text: value }))));
  $('choice').hidden = named.length < 2;
  $('number').max = named.at(-1) ?? 0;
  if (packed.left_out) remark(`${grouped(packed.left_out)} of ${grouped(packed.left_out + count)} triangles cannot be drawn: a vertex is missing or not finite.`);
  buildLegend();
}

function tellFace() {
  const face = lit(), colour = face === null ? null : faceColour(face);
  if (face === null) { $('status').textContent = named.length ? `${grouped(named.length)} faces` : ''; $('number').value = ''; return; }
  const dot = element('i');
  dot.style.background = colour ? css(colour) : 'transparent';
  $('status').replaceChildren(dot, element('b', { text: `face ${face}` }), state.kept === null ? '' : ' · kept, Esc lets it go');
  $('number').value = face;
}

// Makes page and pictures agree with the state.
function refresh() {
  document.documentElement.dataset.theme = state.theme;
  lightFlat(lit());
  tellFace();
  for (const [id, on] of [['turntable', state.turning], ['theme', state.theme === 'dark']]) $(`tool-${id}`).setAttribute('aria-pressed', String(on));
  redraw();
}

// ------------------------------------------------------------------------------------------------ actions

const exists = face => face !== null && (parts.has(face) || groups.has(face));
function hover(face) {
  const next = exists(face) ? face : null;
  canvas.classList.toggle('over', next !== null);
  if (next === state.hover) return;
  state.hover = next;
  if (state.kept === null) refresh();
}
// towards: whether the surface turns so that the face is seen.
function keep(face, towards = false) {
  state.kept = exists(face) ? face : null;
  if (state.kept === null) state.hover = null;
  else if (towards && parts.has(face)) turnTo(face);
  refresh();
}
function turnTo(face) {
  const rotation = turnedTo(face);
  if (rotation) flyTo({ rotation }, 520);
}
// The rotation with which the face is seen; null where it faces all ways alike, or is not on the surface.
function turnedTo(face) {
  const { start, end } = parts.get(face) ?? { start: 0, end: 0 }, area = faceNormals({ positions, faces: corners.subarray(3 * start, 3 * end), degree: 3, count: end - start }), normal = [0, 0, 0];
  area.forEach((x, k) => { normal[k % 3] += x; });
  return turnedToEye(camera.rotation, normal);
}
function step(by) {
  if (!named.length) return;
  const at = named.indexOf(lit());
  keep(named[at < 0 ? (by > 0 ? 0 : named.length - 1) : (at + by + named.length) % named.length], true);
}
function setTurntable(on = !state.turning) {
  state.turning = on;
  refresh();
}
function setTheme(theme) {
  Object.assign(state, { theme, chosenTheme: true });
  refresh();
}
function home() {
  goHome();
  if (flat) frameFlat(flatView);
}
const toggleTheme = () => setTheme(state.theme === 'light' ? 'dark' : 'light');

const STEP = 8 * Math.PI / 180;
const KEYS = {
  ' ': () => setTurntable(), t: toggleTheme, r: home, n: () => step(1), p: () => step(-1), escape: () => keep(null), '?': () => $('help').showModal(),
  '+': () => zoom(1 / 1.15, ...currentView().centre), '=': () => zoom(1 / 1.15, ...currentView().centre), '-': () => zoom(1.15, ...currentView().centre),
  arrowleft: () => orbit(-STEP, 0), arrowright: () => orbit(STEP, 0), arrowup: () => orbit(0, -STEP), arrowdown: () => orbit(0, STEP),
};
function listenToKeys() {
  addEventListener('keydown', event => {
    const action = KEYS[event.key.toLowerCase()], inNumber = event.target === $('number') && /^(Arrow.*|[+-])$/.test(event.key);
    if (!action || event.ctrlKey || event.metaKey || event.altKey || $('help').open || inNumber) return;
    if (event.key === ' ' && event.target.closest?.('button')) return;
    event.preventDefault();
    stop();
    action();
    redraw();
  });
}

function listenToTools() {
  const tools = { turntable: () => setTurntable(), theme: toggleTheme, home, help: () => $('help').showModal() };
  for (const [id, action] of Object.entries(tools)) $(`tool-${id}`).addEventListener('click', action);
  $('previous').addEventListener('click', () => step(-1));
  $('next').addEventListener('click', () => step(1));
  $('number').addEventListener('change', () => keep(Number.isInteger($('number').valueAsNumber) ? $('number').valueAsNumber : null, true));
  addEventListener('resize', () => { keepFitted(); if (flat) frameFlat(framed); });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', event => { if (!state.chosenTheme) { state.theme = event.matches ? 'dark' : 'light'; refresh(); } });
}

function listenToCanvas() {
  listenToPointers(canvas, { orbit, pan, zoom, stop, redraw, click: (x, y) => keep(pick(x, y)), doubleClick: (x, y) => { if (pick(x, y) === null) home(); } });
  canvas.addEventListener('pointermove', event => { if (!event.buttons && event.pointerType !== 'touch') hover(pick(event.offsetX, event.offsetY)); });
  canvas.addEventListener('pointerleave', () => hover(null));
}

// ------------------------------------------------------------------------------------------------ start

function readAddress() {
  const asked = new URLSearchParams(location.hash.slice(1)), number = (name, usual) => (asked.has(name) && Number.isFinite(+asked.get(name)) ? +asked.get(name) : usual);
  state.theme = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
  if (asked.get('theme') in THEMES) Object.assign(state, { theme: asked.get('theme'), chosenTheme: true });
  const start = fitted(facing(number('yaw', HOME_YAW), number('pitch', HOME_PITCH)));
  Object.assign(camera, start, { distance: start.distance / Math.min(Math.max(number('zoom', 1), 0.02), 100) });
  follow(!asked.has('zoom'));
  const face = number('face', NaN);
  if (exists(face)) {
    state.kept = face;
    const turned = asked.has('yaw') || asked.has('pitch') ? null : turnedTo(face);
    if (turned) camera.rotation = turned;
  }
  state.turning = asked.get('turntable') === 'on';
}

function fail(message) {
  $('failure').textContent = message;
  $('failure').hidden = false;
}

function start() {
  gl = canvas.getContext('webgl2', { antialias: true, alpha: true, premultipliedAlpha: true, powerPreference: 'high-performance' });
  if (gl) {
    canvas.addEventListener('webglcontextlost', event => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => { startGpu(); redraw(); });
    startGpu();
  } else {
    fail('This browser offers no WebGL2, so the surface cannot be drawn. The facts beside are complete.');
  }
  state.ready = true;
  refresh();
}

showFlat();
buildPanel();
readAddress();
listenToKeys();
listenToTools();
listenToCanvas();
if (flat) listenToFlat();
document.documentElement.dataset.theme = state.theme;
$('status').textContent = 'measuring light and shadow …';
requestAnimationFrame(() => setTimeout(start));   // after the words are seen

window.quadloomMap = {
  faces: named, camera, redraw, setTurntable, setTheme, setOversampling: on => { state.oversampling = on; redraw(); },
  get ready() { return state.ready; },
  pick: (x, y) => { const box = canvas.getBoundingClientRect(); return pick(x - box.left, y - box.top); },
  light: face => keep(face), lit: () => { const face = lit(); return parts.has(face) ? face : null; },
  litFlat: () => faceOfGroup($('flat').querySelector('.lit[data-face]')), kept: () => state.kept, turning: () => state.turning,
};
})();
