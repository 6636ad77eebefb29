// What the viewers of all pages share: unpacking, vectors, camera, pointer, frames, WebGL2 helpers.
//
// In: a canvas, and what to do. Out: `quadloomCommon`. Holds: nothing here knows what is drawn; a frame is drawn only
// when it was asked for; places are pixels of the canvas, from its top left corner.
const quadloomCommon = (() => {
'use strict';

const $ = id => document.getElementById(id);

function bytes(base64) {
  const text = atob(base64), out = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) out[i] = text.charCodeAt(i);
  return out.buffer;
}
const floats = text => new Float32Array(bytes(text));
const integers = text => new Uint32Array(bytes(text));

const rgb = hex => [1, 3, 5].map(k => parseInt(hex.slice(k, k + 2), 16) / 255);

function element(name, { text, ...attributes } = {}, ...children) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}
function drawing(name, attributes = {}, ...children) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

// ------------------------------------------------------------------------------------------------ vectors

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = a => Math.hypot(a[0], a[1], a[2]);
const mix = (a, b, t) => a + (b - a) * t;

// Quaternions as [x, y, z, w].
const turn = (axis, angle) => [...scale(axis, Math.sin(angle / 2)), Math.cos(angle / 2)];
function times(a, b) {
  const v = add(add(scale(b, a[3]), scale(a, b[3])), cross(a, b));
  const q = [...v, a[3] * b[3] - dot(a, b)], n = Math.hypot(...q) || 1;
  return q.map(x => x / n);
}
const inverse = q => [-q[0], -q[1], -q[2], q[3]];
function rotated(q, v) {
  const t = scale(cross(q, v), 2);
  return add(add(v, scale(t, q[3])), cross(q, t));
}
function slerp(a, b, t) {
  let c = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const s = c < 0 ? -1 : 1;
  c = Math.min(1, c * s);
  const angle = Math.acos(c), k = Math.sin(angle);
  const [x, y] = k < 1e-5 ? [1 - t, t] : [Math.sin((1 - t) * angle) / k, Math.sin(t * angle) / k];
  return times(a.map((v, i) => x * v + y * s * b[i]), [0, 0, 0, 1]);
}

// ------------------------------------------------------------------------------------------------ camera

const FIELD_OF_VIEW = 30 * Math.PI / 180;
const HOME_YAW = -32, HOME_PITCH = 22;
const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
const FIT = 0.86;   // share of the free room that the surface fills

const facing = (yaw, pitch) => times(turn(AXES.x, pitch * Math.PI / 180), turn(AXES.y, yaw * Math.PI / 180));

// The rotation after which the normal points at the eye, or null where it all but does.
function turnedToEye(rotation, normal) {
  const size = length(normal), seen = size > 0 ? rotated(rotation, scale(normal, 1 / size)) : AXES.z;
  if (seen[2] > 0.3) return null;
  const axis = cross(seen, AXES.z), sine = length(axis);
  return times(turn(sine > 1e-6 ? scale(axis, 1 / sine) : AXES.y, Math.acos(Math.max(-1, Math.min(1, seen[2])))), rotation);
}

// space: the room at the right and at the bottom that something covers; positions: the surface, within radius 1.
function makeCamera({ canvas, space, positions, redraw }) {
  const camera = { target: [0, 0, 0], distance: 4, rotation: facing(HOME_YAW, HOME_PITCH) };
  let flight = null;
  let placed = false;   // whether the user has chosen a view; until then the surface keeps to the free room
  const stop = () => { flight = null; };
  const follow = on => { placed = !on; };

  // The view for this frame: matrices column by column, the panel's room left free.
  function currentView() {
    const [width, height] = [canvas.clientWidth || 1, canvas.clientHeight || 1], room = space();
    const free = [Math.max(width - room.right, 60), Math.max(height - room.bottom, 60)];
    const focal = Math.min(free[0], free[1]) / 2 / Math.tan(FIELD_OF_VIEW / 2);   // pixels
    const reach = length(camera.target) + 1.1;
    const near = Math.max(camera.distance - reach, camera.distance * 0.004), far = camera.distance + reach;
    const [sx, sy] = [2 * focal / width, 2 * focal / height];
    const [ox, oy] = [room.right / width, -room.bottom / height];
    const q = camera.rotation, column = axis => rotated(q, axis);
    const t = sub([0, 0, -camera.distance], rotated(q, camera.target));
    const view = [...column([1, 0, 0]), 0, ...column([0, 1, 0]), 0, ...column([0, 0, 1]), 0, ...t, 1];
    const projection = [sx, 0, 0, 0, 0, sy, 0, 0, ox, oy, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0];
    return { view, projection, width, height, focal, near, free, centre: [width * (1 - ox) / 2, height * (1 + oy) / 2] };
  }

  // The ray through a pixel of the canvas: origin and direction in scene units.
  function rayAt(x, y) {
    const v = currentView(), back = inverse(camera.rotation);
    const direction = rotated(back, [(x - v.centre[0]) / v.focal, (v.centre[1] - y) / v.focal, -1]);
    return { origin: add(camera.target, rotated(back, [0, 0, camera.distance])), direction: scale(direction, 1 / length(direction)) };
  }

  function flyTo(goal, time = 320) {
    placed = true;
    flight = { from: { ...camera }, goal: { ...camera, ...goal }, start: performance.now(), time };
    redraw();
  }

  function fly(now) {
    if (!flight) return;
    const t = Math.min(1, (now - flight.start) / flight.time), s = t * t * (3 - 2 * t), { from, goal } = flight;
    camera.target = from.target.map((x, k) => mix(x, goal.target[k], s));
    camera.distance = Math.exp(mix(Math.log(from.distance), Math.log(goal.distance), s));
    camera.rotation = slerp(from.rotation, goal.rotation, s);
    if (t < 1) return redraw();
    Object.assign(camera, goal);   // without rounding
    flight = null;
  }

  // Where the whole surface, seen under this rotation, fills the free room but for a margin.
  function fitted(rotation) {
    const p = positions() ?? Float32Array.of(1, 1, 1), step = 3 * Math.max(1, Math.floor(p.length / 60000));
    const { focal, free } = currentView(), low = [Infinity, Infinity], high = [-Infinity, -Infinity], seen = [];
    for (let i = 0; i + 2 < p.length; i += step) {
      const q = rotated(rotation, [p[i], p[i + 1], p[i + 2]]);
      if (!Number.isFinite(q[0] + q[1] + q[2])) continue;
      seen.push(q);
      for (const k of [0, 1]) { low[k] = Math.min(low[k], q[k]); high[k] = Math.max(high[k], q[k]); }
    }
    if (!seen.length) return { target: [0, 0, 0], distance: 4, rotation };
    const middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, 0], slope = free.map(side => FIT * side / 2 / focal);
    const distance = seen.reduce((far, q) => Math.max(far, q[2] + Math.abs(q[0] - middle[0]) / slope[0], q[2] + Math.abs(q[1] - middle[1]) / slope[1]), 0.05);
    return { target: rotated(inverse(rotation), middle), distance, rotation };
  }

  function goHome() {
    flyTo(fitted(facing(HOME_YAW, HOME_PITCH)));
    placed = false;
  }
  function keepFitted() {
    if (!placed) { flight = null; Object.assign(camera, fitted(camera.rotation)); }
    redraw();
  }
  const orbit = (dx, dy) => { placed = true; camera.rotation = times(times(turn(AXES.x, dy), turn(AXES.y, dx)), camera.rotation); };
  function pan(dx, dy) {
    placed = true;
    const perPixel = camera.distance / currentView().focal;
    camera.target = add(camera.target, rotated(inverse(camera.rotation), [-dx * perPixel, dy * perPixel, 0]));
  }
  function zoom(factor, x, y) {
    placed = true;
    const v = currentView(), next = Math.min(Math.max(camera.distance * factor, 0.01), 60);
    const shift = (camera.distance - next) / v.focal;   // keeps the point under the pointer in place
    camera.target = add(camera.target, rotated(inverse(camera.rotation), [(x - v.centre[0]) * shift, (v.centre[1] - y) * shift, 0]));
    camera.distance = next;
  }

  return { camera, currentView, rayAt, flyTo, fly, stop, follow, fitted, goHome, keepFitted, orbit, pan, zoom };
}

// ------------------------------------------------------------------------------------------------ pointer

// One pointer turns (or moves, with Shift or another button); two move and zoom.
function listenToPointers(canvas, { orbit, pan, zoom, stop, redraw, click, doubleClick }) {
  const local = event => { const box = canvas.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
  const point = event => { const [x, y] = local(event); return { x, y }; };
  const down = new Map();
  const middle = () => { const all = [...down.values()]; return [all.reduce((s, p) => s + p.x, 0) / all.length, all.reduce((s, p) => s + p.y, 0) / all.length]; };
  const spread = () => { const [a, b] = [...down.values()]; return b ? Math.hypot(a.x - b.x, a.y - b.y) : 0; };
  canvas.addEventListener('pointerdown', event => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, { ...point(event), moves: event.button !== 0 || event.shiftKey, start: [event.clientX, event.clientY] });
    canvas.classList.add('dragging');
    stop();
  });
  canvas.addEventListener('pointermove', event => {
    const finger = down.get(event.pointerId);
    if (!finger) return;
    const [x, y] = middle(), wide = spread();
    Object.assign(finger, point(event));
    const [nx, ny] = middle(), [dx, dy] = [nx - x, ny - y];
    if (down.size > 1) { pan(dx, dy); if (wide > 0 && spread() > 0) zoom(wide / spread(), nx, ny); }
    else if (finger.moves) pan(dx, dy);
    else orbit(dx * 0.0085, dy * 0.0085);
    redraw();
  });
  canvas.addEventListener('pointerup', event => {
    const { start, moves } = down.get(event.pointerId) ?? {};
    const still = start && !moves && down.size === 1 && Math.hypot(event.clientX - start[0], event.clientY - start[1]) < 4;
    if (still) click(...local(event));
  });
  for (const end of ['pointerup', 'pointercancel']) {
    canvas.addEventListener(end, event => { down.delete(event.pointerId); if (!down.size) canvas.classList.remove('dragging'); });
  }
  canvas.addEventListener('contextmenu', event => event.preventDefault());
  canvas.addEventListener('dblclick', event => doubleClick(...local(event)));
  canvas.addEventListener('wheel', event => {
    event.preventDefault();
    stop();
    const pixels = event.deltaY * (event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1);
    zoom(Math.exp(Math.min(Math.max(pixels, -240), 240) * 0.0016), ...local(event));
    redraw();
  }, { passive: false });
}

// ------------------------------------------------------------------------------------------------ frames

const REST = 180;   // milliseconds

// Pixels of the canvas per pixel of the page; pictures at rest are drawn finer than the screen.
const MOST_PIXELS = 1.6e7;
function pixelRatio(canvas, fine) {
  const own = Math.min(devicePixelRatio || 1, 2.5), most = Math.sqrt(MOST_PIXELS / (canvas.clientWidth * canvas.clientHeight || 1));
  return fine ? Math.max(own, Math.min(2 * own, 3, most)) : own;
}

// Draws before the next frame, and once more, finely, when nothing has changed for a moment.
function makeFrames({ step, draw }) {
  let asked = false, rest = 0;
  function redraw() {
    if (asked) return;
    asked = true;
    document.documentElement.dataset.drawn = 'no';
    clearTimeout(rest);
    requestAnimationFrame(now => {
      asked = false;
      step(now);
      show(false);
      if (!asked) rest = setTimeout(() => requestAnimationFrame(() => { if (!asked) show(true); }), REST);
    });
  }
  function show(fine) {
    draw(fine);
    document.documentElement.dataset.drawn = fine ? 'finely' : 'coarsely';
  }
  return { redraw };
}

// ------------------------------------------------------------------------------------------------ geometry for the GPU

const CREASE = Math.cos(40 * Math.PI / 180);   // sharper edges are shaded as edges
const LARGE_FAN = 64;                          // corners with more faces are shaded flat: comparing them is quadratic

// Vector area of every face, by its diagonals or sides.
function faceNormals({ positions: p, faces, degree, count }) {
  const out = new Float32Array(3 * count);
  for (let f = 0; f < count; f++) {
    const [a, b, c, d] = [0, 1, 2, degree - 1].map(k => 3 * faces[f * degree + k]);
    const [s, t] = degree === 4 ? [[a, c], [b, d]] : [[a, b], [a, c]];
    for (let k = 0; k < 3; k++) {
      const i = (k + 1) % 3, j = (k + 2) % 3;
      out[3 * f + k] = 0.5 * ((p[s[1] + i] - p[s[0] + i]) * (p[t[1] + j] - p[t[0] + j]) - (p[s[1] + j] - p[s[0] + j]) * (p[t[1] + i] - p[t[0] + i]));
    }
  }
  return out;
}

// The corners around every vertex, as starts and a list.
function cornersByVertex({ positions, faces }) {
  const start = new Uint32Array(positions.length / 3 + 1);
  for (const v of faces) start[v + 1]++;
  for (let v = 1; v < start.length; v++) start[v] += start[v - 1];
  const place = start.slice(), list = new Uint32Array(faces.length);
  faces.forEach((v, corner) => { list[place[v]++] = corner; });
  return { start, list };
}

// A normal per corner: the mean of the faces around its vertex that turn away by less than the crease angle.
function cornerNormals(mesh) {
  const { faces, degree } = mesh, area = faceNormals(mesh), { start, list } = cornersByVertex(mesh);
  const size = Float32Array.from({ length: mesh.count }, (_, f) => Math.hypot(area[3 * f], area[3 * f + 1], area[3 * f + 2]) || 1);
  const out = new Float32Array(3 * faces.length);
  for (let corner = 0; corner < faces.length; corner++) {
    const v = faces[corner], f = Math.floor(corner / degree);
    let x = area[3 * f], y = area[3 * f + 1], z = area[3 * f + 2];
    const [nx, ny, nz] = [x / size[f], y / size[f], z / size[f]];
    const fan = start[v + 1] - start[v] <= LARGE_FAN ? start[v + 1] : start[v];
    for (let i = start[v]; i < fan; i++) {
      const g = Math.floor(list[i] / degree), [ax, ay, az] = [area[3 * g], area[3 * g + 1], area[3 * g + 2]];
      if (g !== f && ax * nx + ay * ny + az * nz > CREASE * size[g]) { x += ax; y += ay; z += az; }
    }
    const n = Math.hypot(x, y, z) || 1;
    out.set([x / n, y / n, z / n], 3 * corner);
  }
  return out;
}

// ------------------------------------------------------------------------------------------------ shaders

const WIPE = `
uniform vec2 wipe;   // x in pixels; +1 keeps the left, -1 the right, 0 all
void keepSide() { if ((gl_FragCoord.x - wipe.x) * wipe.y > 0.0) discard; }`;

const LINE_VERTEX = `#version 300 es
layout(location = 0) in vec2 corner;      // along 0..1, across -1..1
layout(location = 1) in vec3 from;
layout(location = 2) in vec3 to;
layout(location = 3) in vec3 tint;
flat out vec3 vTint;
uniform mat4 view, projection;
uniform vec2 viewport;
uniform float width, raise, near;
out float vAcross;
vec3 raised(vec3 eye) { return eye * (1.0 - min(raise, 0.3 * length(eye)) / max(length(eye), 1e-6)); }
void main() {
  vTint = tint;
  vec3 a = raised((view * vec4(from, 1.0)).xyz), b = raised((view * vec4(to, 1.0)).xyz);
  float limit = -near * 0.9;
  if (a.z > limit && b.z > limit) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); vAcross = 0.0; return; }
  if (a.z > limit) a = mix(a, b, (a.z - limit) / (a.z - b.z));
  if (b.z > limit) b = mix(b, a, (b.z - limit) / (b.z - a.z));
  vec4 p = projection * vec4(a, 1.0), q = projection * vec4(b, 1.0);
  vec2 along = (q.xy / q.w - p.xy / p.w) * viewport;
  float size = length(along);
  along = size > 1e-5 ? along / size : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  float radius = 0.5 * width + 0.75;
  vec4 end = corner.x < 0.5 ? p : q;
  vec2 offset = across * corner.y * radius + along * (corner.x * 2.0 - 1.0) * 0.3 * width;
  vAcross = corner.y * radius;
  gl_Position = end + vec4(offset * 2.0 / viewport * end.w, 0.0, 0.0);
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
in float vAcross;
flat in vec3 vTint;
uniform float width, alpha;
out vec4 colour;
${WIPE}
void main() {
  keepSide();
  colour = vec4(vTint, alpha * (1.0 - smoothstep(0.5 * width - 0.5, 0.5 * width + 0.5, abs(vAcross))));
  if (colour.a < 0.02) discard;
}`;

function gpuTools(gl) {
  function program(vertex, fragment) {
    const linked = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(linked, shader);
    }
    gl.linkProgram(linked);
    if (!gl.getProgramParameter(linked, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(gl.getProgramInfoLog(linked));
    const at = {};
    for (let i = 0; i < gl.getProgramParameter(linked, gl.ACTIVE_UNIFORMS); i++) {
      const name = gl.getActiveUniform(linked, i).name.replace('[0]', '');
      at[name] = gl.getUniformLocation(linked, name);
    }
    return { linked, at };
  }

  function vertexArray(attributes) {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    for (const { buffer, at, size, stride, offset, perInstance, type = gl.FLOAT } of attributes) {   // integers are shares of the largest
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, type, type !== gl.FLOAT, stride, offset);
      gl.vertexAttribDivisor(at, perInstance ? 1 : 0);
    }
    return array;
  }

  function bufferOf(data) {
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return buffer;
  }
  return { program, vertexArray, bufferOf };
}

return { $, bytes, floats, integers, rgb, element, drawing, add, sub, scale, dot, cross, length, turn, times, inverse, rotated, AXES,
  HOME_YAW, HOME_PITCH, facing, turnedToEye, makeCamera, listenToPointers, pixelRatio, makeFrames, faceNormals, cornerNormals,
  WIPE, LINE_VERTEX, LINE_FRAGMENT, gpuTools };
})();
