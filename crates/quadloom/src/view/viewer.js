// The viewer of a Quadloom page: WebGL2 without a library.
//
// In: the JSON of #scene, packed by page.rs (base64 of little-endian 32-bit numbers, bounding box within radius 1).
// Out: the picture and its panel; `window.quadloom` for scripts; picture options in the address after '#', as in
// #preset=map&theme=dark&palette=safe&panel=off&yaw=-30&pitch=20&zoom=1.4&compare=0.5&layers=quads,features&tile=3.
// Holds: a frame is drawn only when something changed; nothing is asked for outside the page.
(() => {
'use strict';

// ------------------------------------------------------------------------------------------------ the scene

const { $, floats, integers, rgb, element, drawing, add, sub, scale, dot, cross, facing, makeCamera, turnedToEye, HOME_YAW, HOME_PITCH,
  faceNormals, cornerNormals, WIPE, LINE_VERTEX, LINE_FRAGMENT, gpuTools, pixelRatio, makeFrames, listenToPointers } = quadloomCommon;
const packed = JSON.parse($('scene').textContent);

function unpackFaces(part, degree) {
  if (!part) return null;
  const faces = integers(part.faces);
  return { positions: floats(part.positions), faces, degree, count: faces.length / degree, quality: floats(part.quality) };
}
const input = unpackFaces(packed.input, 3);
const quads = unpackFaces(packed.quads, 4);
const distance = packed.distance && { ...packed.distance, values: floats(packed.distance.values), points: floats(packed.distance.source_points) };
const tiles = packed.tiles && { tile: integers(packed.tiles.tile), colours: integers(packed.tiles.colours), uv: floats(packed.tiles.uv),
  arcs: integers(packed.tiles.arcs), points: floats(packed.tiles.multipoints), unfolded: packed.tiles.unfolded };
const singular = { positions: floats(packed.singularities.positions), valence: integers(packed.singularities.valence) };
const lines = Object.fromEntries(Object.entries(packed.lines).map(([name, text]) => [name, floats(text)]));
for (const name of ['isolines', 'paths', 'sources', 'cut_locus']) lines[name] = distance ? floats(distance[name]) : new Float32Array();
lines.cuts = floats(tiles ? packed.tiles.cuts : '');
const segmentCount = name => lines[name].length / 6;

// ------------------------------------------------------------------------------------------------ colours

const PALETTES = {
  usual: { valence3: '#d62839', valence5: '#1d5fd1', valenceOther: '#f0a202', features: '#e0620d', boundary: '#7c3aed',
    seams: '#0d9488', field: '#334155', grid_u: '#d62839', grid_v: '#1d5fd1',
    isolines: '#1f2933', sources: '#d1005c', paths: '#0b7a2b', cut_locus: '#0b1117',
    cuts: '#d62839', multipoints: '#f6f5f0' },
  // Okabe and Ito's colours: told apart with any kind of colour vision.
  safe: { valence3: '#e69f00', valence5: '#0072b2', valenceOther: '#cc79a7', features: '#d55e00', boundary: '#009e73',
    seams: '#111827', field: '#334155', grid_u: '#e69f00', grid_v: '#0072b2',
    isolines: '#1f2933', sources: '#d55e00', paths: '#cc79a7', cut_locus: '#000000',
    cuts: '#d55e00', multipoints: '#f6f5f0' },
};
const THEMES = {
  light: { paper: '#ffffff', quads: '#e9eef4', input: '#e6e3dc', back: '#c9b79c', ink: '#11151a', faint: '#7d838b' },
  dark: { paper: '#14171b', quads: '#b9c6d6', input: '#b8b5ae', back: '#7d6d55', ink: '#0a0c0f', faint: '#5b616a' },
};
// Scaled Jacobian to colour: inverted magenta, then dark red to blue; most quads are above 0.9, so is the detail.
const QUALITY_STOPS = [[0, '#7f1d1d'], [0.4, '#c2410c'], [0.7, '#f59e0b'], [0.88, '#fde68a'], [0.96, '#e2efe9'], [1, '#9cc7de']];
const INVERTED = '#c026d3';
// Distance to colour, near to far: brightness falls all the way, so that it can be read in grey too.
const DISTANCE_STOPS = {
  usual: [[0, '#fff3c9'], [0.2, '#fdbb63'], [0.4, '#f07a5a'], [0.6, '#c04a86'], [0.8, '#6d3c9a'], [1, '#2a2a72']],
  safe: [[0, '#fdea45'], [0.2, '#d0c05c'], [0.4, '#a59c74'], [0.6, '#7c7b78'], [0.8, '#4f5b6d'], [1, '#123570']],
};

// Tiles are pale so that cuts stand out; as many as COLOURS of tiles.rs. The safe ones are the light scheme of Paul Tol.
const TILE_COLOURS = {
  usual: ['#9cc3e6', '#f5bd8b', '#aed6a4', '#e9a9b4', '#c2b2e2', '#f1db86', '#93d1cb', '#cfb9a2'],
  safe: ['#77aadd', '#ee8866', '#eedd88', '#44bb99', '#ffaabb', '#bbcc33', '#99ddff', '#dddddd'],
};
// Letters tell apart arcs that share a colour.
const ARC_COLOURS = {
  usual: ['#d62839', '#1d5fd1', '#0b8a3a', '#e07b00', '#c2187a', '#00939e', '#8a5a16', '#5f7d00', '#4f6bd8', '#a3382a', '#00755e', '#b05bb8'],
  safe: ['#d55e00', '#0072b2', '#e69f00', '#882255', '#56b4e9', '#7f7f7f', '#cc79a7', '#332288'],
};
const NONE = 0xffffffff;   // tile or arc that is not known
const tileColour = tile => TILE_COLOURS[state.palette][tiles.colours[tile] ?? 0];
function arcColour(arc) {
  if (arc === NONE) return PALETTES[state.palette].cuts;
  arcColour.made ??= {};
  return (arcColour.made[state.palette] ??= colourArcs(ARC_COLOURS[state.palette])).get(arc);
}

// Arc by arc the colour that the fewest sides of its tiles have, and of these the one that the fewest arcs have.
function colourArcs(colours) {
  const used = colours.map(() => 0), beside = tiles.unfolded.map(() => colours.map(() => 0)), tilesOf = new Map(), chosen = new Map();
  tiles.unfolded.forEach(({ rings }, tile) => rings.flat().forEach(([, arc]) => tilesOf.set(arc, [...(tilesOf.get(arc) ?? []), tile])));
  for (const arc of [...tilesOf.keys()].sort((a, b) => a - b)) {
    const around = tilesOf.get(arc), cost = k => around.reduce((sum, tile) => sum + beside[tile][k], 0);
    const best = colours.reduce((best, _, k) => (cost(k) < cost(best) || (cost(k) === cost(best) && used[k] < used[best]) ? k : best), 0);
    used[best]++;
    for (const tile of around) beside[tile][best]++;
    chosen.set(arc, colours[best]);
  }
  return chosen;
}

function qualityColour(q) {
  if (!(q > 0)) return rgb(INVERTED);
  const k = Math.max(1, QUALITY_STOPS.findIndex(([at]) => at >= Math.min(q, 1)));
  const [[a, from], [b, to]] = [QUALITY_STOPS[k - 1], QUALITY_STOPS[k]];
  const t = (Math.min(q, 1) - a) / (b - a), [x, y] = [rgb(from), rgb(to)];
  return x.map((c, i) => c + t * (y[i] - c));
}

// ------------------------------------------------------------------------------------------------ layers

// side: which half of a comparison the layer belongs to; raise: how far lines are pulled towards the eye.
const LAYERS = [
  { id: 'quads', name: 'Quads', key: '1', side: 'right', count: quads?.count ?? 0 },
  { id: 'input', name: distance || tiles ? 'Surface' : 'Input surface', key: '2', side: 'left', count: input?.count ?? 0 },
  { id: 'triangles', name: distance || tiles ? 'Triangles' : 'Input triangles', key: '3', side: 'left', count: input?.count ?? 0 },
  { id: 'singularities', name: 'Irregular vertices', key: '4', side: quads ? 'right' : 'both', count: singular.valence.length },
  { id: 'features', name: 'Feature lines', key: '5', side: 'both', count: segmentCount('features'), width: 2.6, raise: 0.006 },
  { id: 'boundary', name: 'Boundary', key: '6', side: 'both', count: segmentCount('boundary'), width: 2.6, raise: 0.006 },
  { id: 'field', name: 'Cross field', key: '7', side: 'left', count: segmentCount('field') / 2, width: 1.3, raise: 0.005 },
  { id: 'seams', name: 'Seams', key: '8', side: 'left', count: segmentCount('seams'), width: 2.4, raise: 0.0055 },
  { id: 'grid', name: 'Map, integer lines', key: '9', side: 'left', count: segmentCount('grid_u') + segmentCount('grid_v'), width: 1.5, raise: 0.004 },
  { id: 'distance', name: 'Distance', key: '1', side: 'both', count: distance ? input?.count ?? 0 : 0 },
  { id: 'isolines', name: 'Isolines', key: '4', side: 'both', count: segmentCount('isolines'), width: 1.2, raise: 0.003 },
  { id: 'sources', name: 'Sources', key: '7', side: 'both', count: segmentCount('sources') + (distance?.points.length ?? 0) / 3, width: 3.4, raise: 0.006 },
  { id: 'paths', name: 'Shortest paths', key: '8', side: 'both', count: segmentCount('paths'), width: 3, raise: 0.0065 },
  { id: 'cut_locus', name: 'Cut locus', key: '9', side: 'both', count: segmentCount('cut_locus'), width: 1.6, raise: 0.0045 },
  { id: 'tiles', name: 'Tiles', key: '1', side: 'both', count: tiles && input ? tiles.colours.length : 0 },
  { id: 'cuts', name: 'Cuts', key: '4', side: 'both', count: segmentCount('cuts'), width: segmentCount('cuts') > 20000 ? 2 : 3, raise: 0.0065 },
  { id: 'multipoints', name: 'Multipoints', key: '7', side: 'both', count: (tiles?.points.length ?? 0) / 3 },
  { id: 'checker', name: 'Checkerboard', key: '8', side: 'both', count: input ? (tiles?.uv.length ?? 0) / 6 : 0 },
  { id: 'quality', name: 'Quality colours', key: '0', side: 'right', count: quads?.quality.length ?? 0 },
].filter(layer => layer.count > 0);
const layerOf = Object.fromEntries(LAYERS.map(layer => [layer.id, layer]));

const PRESETS = [
  { id: 'tiles', name: 'Tiles', layers: ['input', 'tiles', 'cuts', 'multipoints', 'boundary'], needs: ['tiles'] },
  { id: 'checker', name: 'Checkerboard', layers: ['input', 'tiles', 'checker', 'cuts', 'multipoints', 'boundary'], needs: ['checker'] },
  { id: 'distance', name: 'Distance', layers: ['input', 'distance', 'isolines', 'sources', 'paths'], needs: ['distance'] },
  { id: 'ridges', name: 'Cut locus', layers: ['input', 'distance', 'sources', 'cut_locus'], needs: ['distance', 'cut_locus'] },
  { id: 'result', name: 'Result', layers: ['quads', 'singularities', 'features', 'boundary'], needs: ['quads'] },
  { id: 'quality', name: 'Quality', layers: ['quads', 'quality', 'singularities'], needs: ['quality'] },
  { id: 'map', name: 'Map', layers: ['input', 'grid', 'seams', 'features', 'boundary', 'singularities'], needs: ['input', 'grid'] },
  { id: 'field', name: 'Field', layers: ['input', 'field', 'features', 'boundary', 'singularities'], needs: ['input', 'field'] },
  { id: 'input', name: 'Input', layers: ['input', 'triangles', 'features', 'boundary'], needs: ['input'] },
].filter(preset => preset.needs.every(id => layerOf[id]));

const state = { shown: new Set(), theme: 'light', palette: 'usual', compare: null, oversampling: true, tile: 0, marked: false };
// tile: the unfolded one; marked: whether it stands out on the surface.

// ------------------------------------------------------------------------------------------------ camera

const canvas = $('canvas');
const panelSpace = () => {
  const panel = $('panel').getBoundingClientRect();
  return panel.width && innerWidth > 720 ? { right: innerWidth - panel.left, bottom: 0 } : { right: 0, bottom: panel.width ? innerHeight - panel.top : 0 };
};

const { camera, currentView, rayAt, flyTo, fly, stop, follow, fitted, goHome, keepFitted, orbit, pan, zoom } =
  makeCamera({ canvas, space: panelSpace, positions: () => (quads ?? input)?.positions, redraw: () => redraw() });

// ------------------------------------------------------------------------------------------------ geometry for the GPU

// Triangles of a mesh with, per corner, the heights over the (up to three) sides that are edges of the face.
//
//   quad   d ── c      first triangle a b c: sides ab, bc     second triangle c d a: sides cd, da
//          │  ╱ │      the diagonal ac has no height, so it is never drawn
//          a ── b
const QUAD_CORNERS = [[0, [0, 1, 1]], [1, [0, 0, 1]], [2, [1, 0, 1]], [2, [0, 1, 1]], [3, [0, 0, 1]], [0, [1, 0, 1]]];
const TRIANGLE_CORNERS = [[0, [0, 1, 0]], [1, [0, 0, 1]], [2, [1, 0, 0]]];

const FLOATS_PER_CORNER = 11;   // position 3, normal 3, heights 3, quality 1, distance 1
function surfaceBuffer(mesh) {
  const values = mesh === input && distance ? distance.values : null;
  const { positions: p, faces, degree, count, quality } = mesh, normal = cornerNormals(mesh);
  const corners = degree === 4 ? QUAD_CORNERS : TRIANGLE_CORNERS;
  const data = new Float32Array(count * corners.length * FLOATS_PER_CORNER);
  let at = 0;
  for (let f = 0; f < count; f++) {
    const q = quality.length ? quality[f] : NaN, shown = Number.isNaN(q) ? -2 : q;
    for (const [k, heights] of corners) {
      const corner = f * degree + k, v = 3 * faces[corner], n = 3 * corner;
      data[at++] = p[v]; data[at++] = p[v + 1]; data[at++] = p[v + 2];
      data[at++] = normal[n]; data[at++] = normal[n + 1]; data[at++] = normal[n + 2];
      data[at++] = heights[0]; data[at++] = heights[1]; data[at++] = heights[2];
      data[at++] = shown;
      const value = values ? values[faces[corner]] : NaN;
      data[at++] = Number.isNaN(value) ? -1 : value;
    }
  }
  return data;
}

// Per corner the number of the tile and of its colour, and texture coordinates.
function tileBuffer() {
  const data = new Float32Array(4 * input.faces.length);
  for (let corner = 0; corner < input.faces.length; corner++) {
    const tile = tiles.tile[Math.floor(corner / 3)];
    data.set([tile === NONE ? -1 : tile, tiles.colours[tile] ?? 0, tiles.uv[2 * corner] ?? 0, tiles.uv[2 * corner + 1] ?? 0], 4 * corner);
  }
  return data;
}

// Eight squares along a unit square; of maps with lengths of their own, about 48 along the largest tile.
function squaresPerUnit() {
  const ranges = new Map();
  tiles.tile.forEach((tile, face) => {
    const range = ranges.get(tile) ?? [Infinity, Infinity, -Infinity, -Infinity];
    for (let i = 6 * face; i < 6 * face + 6; i++) { const k = i & 1, x = tiles.uv[i]; range[k] = Math.min(range[k], x); range[k + 2] = Math.max(range[k + 2], x); }
    ranges.set(tile, range);
  });
  const extent = [...ranges.values()].reduce((most, [u, v, s, t]) => Math.max(most, s - u, t - v), 0);
  return extent === 0 || (extent > 0.5 && extent < 2.5) ? 8 : 2 ** Math.round(Math.log2(48 / extent));
}

const valenceKind = valence => (valence === 3 ? 0 : valence === 5 ? 1 : 2);
function singularityBuffer() {
  const data = new Float32Array(4 * singular.valence.length);
  singular.valence.forEach((valence, i) => data.set([...singular.positions.subarray(3 * i, 3 * i + 3), valenceKind(valence)], 4 * i));
  return data;
}

// Radius of the balls: a share of a short quad side (a quarter are shorter), or of the surface without quads.
function singularityRadius() {
  if (!quads?.count) return 0.012;
  const { positions: p, faces } = quads, step = Math.max(1, Math.floor(quads.count / 2000));
  const sides = [];
  for (let f = 0; f < quads.count; f += step) {
    const [a, b] = [3 * faces[4 * f], 3 * faces[4 * f + 1]];
    sides.push(Math.hypot(p[a] - p[b], p[a + 1] - p[b + 1], p[a + 2] - p[b + 2]));
  }
  return 0.3 * sides.sort((a, b) => a - b)[sides.length >> 2];
}

// ------------------------------------------------------------------------------------------------ shaders

const SURFACE_VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 heights;
layout(location = 3) in float quality;
layout(location = 4) in float value;
layout(location = 5) in vec4 tile;       // number, colour, texture coordinates
uniform mat4 view, projection;
out vec3 vNormal, vHeights, vEye;
out vec2 vUv;
out float vValue;
flat out float vQuality;
flat out vec2 vTile;
void main() {
  vTile = tile.xy; vUv = tile.zw;
  vec4 eye = view * vec4(position, 1.0);
  vEye = eye.xyz; vNormal = mat3(view) * normal; vHeights = heights; vQuality = quality; vValue = value;
  gl_Position = projection * eye;
}`;

const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 vNormal, vHeights, vEye;
in vec2 vUv;
in float vValue;
flat in float vQuality;
flat in vec2 vTile;
uniform vec3 base, back, ink;
uniform float lineWidth, lineStrength, showQuality, showDistance, bands, showTiles, showChecker, perUnit, marked, alpha;
uniform vec3 tileColours[8];
uniform vec3 stops[6];
uniform float places[6];
uniform vec3 inverted;
out vec4 colour;
${WIPE}
vec3 ramp(float q) {
  vec3 c = stops[0];
  for (int k = 1; k < 6; k++) c = mix(c, stops[k], clamp((q - places[k - 1]) / (places[k] - places[k - 1]), 0.0, 1.0));
  return c;
}
vec3 qualityColour(float q) { return q <= 0.0 ? inverted : ramp(q); }
// Every second band is darker; where bands are narrower than a few pixels they fade into their mean.
vec3 distanceColour(float d) {
  float x = d * bands, pixel = max(fwidth(x), 1e-6), phase = abs(fract(0.5 * x) - 0.5) * 2.0;   // 1 and 0 amid bands
  float dark = smoothstep(0.5 - 0.6 * pixel, 0.5 + 0.6 * pixel, phase);
  return ramp(d) * (1.0 - 0.17 * mix(dark, 0.5, smoothstep(0.25, 0.7, pixel)));
}
// Squares in two tones, of mean 0; where they are narrower than a few pixels they fade.
float squares(vec2 x) {
  vec2 pixel = max(fwidth(x), vec2(1e-6)), phase = abs(fract(0.5 * x - 0.25) - 0.5) * 2.0 - 0.5;
  vec2 tone = clamp(phase / (0.6 * pixel), -1.0, 1.0);
  return tone.x * tone.y * (1.0 - smoothstep(0.25, 0.7, max(pixel.x, pixel.y)));
}
// Squares, and ones four times as wide, which are left from afar: towards white, or darker.
vec3 checker(vec3 c) {
  float tone = 0.75 * squares(perUnit * vUv) + 0.25 * squares(0.25 * perUnit * vUv);
  return tone > 0.0 ? mix(c, vec3(1.0), 0.42 * tone) : c * (1.0 + 0.4 * tone);
}
vec3 tileColour() {
  vec3 c = tileColours[clamp(int(vTile.y + 0.5), 0, 7)];
  return marked > -0.5 && abs(vTile.x - marked) > 0.5 ? mix(c, base, 0.72) : c;
}
vec3 shade(vec3 albedo, vec3 n, vec3 toEye) {
  float key = max(0.0, 0.5 + 0.5 * dot(n, normalize(vec3(-0.45, 0.65, 0.62))));
  float fill = max(0.0, dot(n, normalize(vec3(0.75, -0.15, 0.5))));
  float sky = 0.5 + 0.5 * n.y;
  float edge = pow(1.0 - clamp(dot(n, toEye), 0.0, 1.0), 3.0);
  float light = 0.56 + 0.40 * key + 0.05 * fill + 0.06 * sky;
  vec3 tint = mix(vec3(0.93, 0.96, 1.02), vec3(1.02, 1.0, 0.98), key);
  return min(albedo * light * tint, 1.0) * (1.0 - 0.30 * edge);
}
// Coverage of the pixel by the lines along the sides: screen-space distances from the heights' derivatives.
float lines() {
  vec3 slope = vec3(length(vec2(dFdx(vHeights.x), dFdy(vHeights.x))),
                    length(vec2(dFdx(vHeights.y), dFdy(vHeights.y))),
                    length(vec2(dFdx(vHeights.z), dFdy(vHeights.z))));
  vec3 pixels = 1.0 / max(slope, vec3(1e-7));
  vec3 covered = 1.0 - smoothstep(vec3(lineWidth - 0.55), vec3(lineWidth + 0.55), vHeights * pixels);
  // Where faces are only a few pixels wide the lines fade, otherwise they would fill them.
  vec3 fade = smoothstep(vec3(1.5), vec3(14.0), pixels / max(lineWidth, 0.5));
  vec3 c = covered * mix(vec3(0.18), vec3(1.0), fade);
  return max(c.x, max(c.y, c.z));
}
void main() {
  keepSide();
  float line = lines();
  vec3 n = normalize(vNormal), toEye = normalize(-vEye);
  vec3 albedo = base;
  if (showQuality > 0.5 && vQuality > -1.5) albedo = qualityColour(vQuality);
  if (showDistance > 0.5 && vValue >= -1e-4) albedo = distanceColour(vValue);
  if (showTiles > 0.5 && vTile.x > -0.5) albedo = tileColour();
  if (!gl_FrontFacing) { n = -n; if (showTiles > 0.5) albedo = mix(albedo, back, 0.45); else if (showDistance < 0.5) albedo = back; }
  if (showChecker > 0.5) albedo = checker(albedo);
  colour = vec4(mix(shade(albedo, n, toEye), ink, line * lineStrength), alpha);
}`;

const BALL_VERTEX = `#version 300 es
layout(location = 0) in vec2 corner;
layout(location = 1) in vec4 ball;        // centre, kind
uniform mat4 view, projection;
uniform float radius, pixel;              // scene units; size of a pixel at distance 1
uniform vec2 sizes;                       // smallest and largest radius, pixels
out vec2 vPlace;
out vec3 vCentre;
out float vRadius;
flat out int vKind;
void main() {
  vec4 eye = view * vec4(ball.xyz, 1.0);
  float perPixel = max(-eye.z, 1e-4) * pixel;
  vRadius = clamp(radius, sizes.x * perPixel, sizes.y * perPixel);
  vPlace = corner * 1.08; vCentre = eye.xyz; vKind = int(ball.w + 0.5);
  gl_Position = projection * vec4(eye.xy + vPlace * vRadius, eye.z, 1.0);
}`;

const BALL_FRAGMENT = `#version 300 es
precision highp float;
in vec2 vPlace;
in vec3 vCentre;
in float vRadius;
flat in int vKind;
uniform mat4 projection;
uniform vec3 kinds[3];
out vec4 colour;
${WIPE}
void main() {
  keepSide();
  float d = length(vPlace), soft = fwidth(d);
  float cover = 1.0 - smoothstep(1.0 - soft, 1.0 + soft * 0.5, d);
  if (cover < 0.03) discard;
  vec3 n = vec3(vPlace, sqrt(max(0.0, 1.0 - d * d)));
  vec4 clip = projection * vec4(vCentre + n * vRadius * vec3(1.0, 1.0, 1.15), 1.0);
  gl_FragDepth = clamp(0.5 + 0.5 * clip.z / clip.w, 0.0, 1.0);
  vec3 base = kinds[vKind];
  float key = 0.5 + 0.5 * dot(n, normalize(vec3(-0.45, 0.65, 0.62)));
  float gloss = pow(max(0.0, dot(n, normalize(vec3(-0.3, 0.45, 0.85)))), 28.0);
  vec3 lit = base * (0.5 + 0.62 * key * key) + 0.32 * gloss;
  colour = vec4(mix(lit, base * 0.35, smoothstep(0.78, 1.0, d) * 0.75), cover);
}`;

// ------------------------------------------------------------------------------------------------ drawing

let gl = null, gpu = null, program = null, vertexArray = null, bufferOf = null;

function makeSurface(mesh) {
  const data = surfaceBuffer(mesh), buffer = bufferOf(data), stride = 4 * FLOATS_PER_CORNER;
  const part = (at, size, offset) => ({ buffer, at, size, stride, offset: 4 * offset });
  const tile = tiles && mesh === input ? [{ buffer: bufferOf(tileBuffer()), at: 5, size: 4, stride: 16, offset: 0 }] : [];
  return { array: vertexArray([part(0, 3, 0), part(1, 3, 3), part(2, 3, 6), part(3, 1, 9), part(4, 1, 10), ...tile]), count: data.length / FLOATS_PER_CORNER };
}
// tints: one colour per segment, if they are not all of the colour that is set when they are drawn.
function makeLines(data, tints) {
  const buffer = bufferOf(data), part = (at, offset) => ({ buffer, at, size: 3, stride: 24, offset, perInstance: true });
  const corner = { buffer: gpu.strip, at: 0, size: 2, stride: 8, offset: 0 };
  const tint = tints ? [{ buffer: bufferOf(tints), at: 3, size: 3, stride: 12, offset: 0, perInstance: true }] : [];
  return { array: vertexArray([corner, part(1, 0), part(2, 12), ...tint]), count: data.length / 6 };
}
function makeBalls() {
  const corner = { buffer: gpu.square, at: 0, size: 2, stride: 8, offset: 0 };
  const ball = { buffer: bufferOf(singularityBuffer()), at: 1, size: 4, stride: 16, offset: 0, perInstance: true };
  return { array: vertexArray([corner, ball]), count: singular.valence.length, radius: singularityRadius() };
}

function makePointBalls(points, radius) {
  const data = new Float32Array(points.length / 3 * 4);
  for (let i = 0; i < points.length / 3; i++) data.set(points.subarray(3 * i, 3 * i + 3), 4 * i);
  const corner = { buffer: gpu.square, at: 0, size: 2, stride: 8, offset: 0 };
  const ball = { buffer: bufferOf(data), at: 1, size: 4, stride: 16, offset: 0, perInstance: true };
  return { array: vertexArray([corner, ball]), count: points.length / 3, radius };
}

// Programs now, buffers when first shown.
function startGpu() {
  ({ program, vertexArray, bufferOf } = gpuTools(gl));
  gpu = {
    surface: program(SURFACE_VERTEX, SURFACE_FRAGMENT), line: program(LINE_VERTEX, LINE_FRAGMENT), ball: program(BALL_VERTEX, BALL_FRAGMENT),
    strip: bufferOf(new Float32Array([0, -1, 0, 1, 1, -1, 1, 1])), square: bufferOf(new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1])), made: {},
  };
}
const made = (name, make) => (gpu.made[name] ??= make());

function wipeOf(layer, view, ratio) {
  if (state.compare === null || layer.side === 'both') return [0, 0];
  return [state.compare * view.width * ratio, layer.side === 'left' ? 1 : -1];
}

function useProgram({ linked, at }, view) {
  gl.useProgram(linked);
  gl.uniformMatrix4fv(at.view, false, view.view);
  gl.uniformMatrix4fv(at.projection, false, view.projection);
  return at;
}

// style: colour, edge lines, and whether it is a veil over the quads.
function drawSurface(layer, mesh, view, ratio, { base, back, ink, strength, quality, measured, tiled, checkered, alpha }) {
  const { array, count } = made(layer.id, () => makeSurface(mesh)), at = useProgram(gpu.surface, view);
  gl.uniform2fv(at.wipe, wipeOf(layer, view, ratio));
  gl.uniform3fv(at.base, rgb(base));
  gl.uniform3fv(at.back, rgb(back));
  gl.uniform3fv(at.ink, rgb(ink));
  gl.uniform1f(at.lineWidth, 0.62 * ratio);
  gl.uniform1f(at.lineStrength, strength);
  gl.uniform1f(at.showQuality, quality ? 1 : 0);
  gl.uniform1f(at.alpha, alpha);
  gl.uniform1f(at.showDistance, measured ? 1 : 0);
  gl.uniform1f(at.bands, distance?.bands ?? 1);
  gl.uniform1f(at.showTiles, tiled ? 1 : 0);
  gl.uniform1f(at.showChecker, checkered ? 1 : 0);
  gl.uniform1f(at.perUnit, checkered ? made('squares', squaresPerUnit) : 1);
  gl.uniform1f(at.marked, state.marked ? state.tile : -1);
  gl.uniform3fv(at.tileColours, TILE_COLOURS[state.palette].flatMap(rgb));
  const stops = measured ? DISTANCE_STOPS[state.palette] : QUALITY_STOPS;
  gl.uniform3fv(at.stops, stops.flatMap(([, hex]) => rgb(hex)));
  gl.uniform1fv(at.places, stops.map(([place]) => place));
  gl.uniform3fv(at.inverted, rgb(INVERTED));
  gl.bindVertexArray(array);
  gl.drawArrays(gl.TRIANGLES, 0, count);
}

function drawLines(layer, name, view, ratio, colour, { array, count } = made(name, () => makeLines(lines[name]))) {
  if (!lines[name].length) return;
  const at = useProgram(gpu.line, view);
  gl.uniform2fv(at.wipe, wipeOf(layer, view, ratio));
  gl.uniform2f(at.viewport, canvas.width, canvas.height);
  gl.vertexAttrib3fv(3, rgb(colour));
  gl.uniform1f(at.width, layer.width * ratio);
  gl.uniform1f(at.raise, layer.raise);
  gl.uniform1f(at.near, view.near);
  gl.uniform1f(at.alpha, 1);
  gl.bindVertexArray(array);
  gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
}

function drawBalls(layer, view, ratio, colours, { array, count, radius } = made('balls', makeBalls)) {
  const at = useProgram(gpu.ball, view);
  gl.uniform2fv(at.wipe, wipeOf(layer, view, ratio));
  gl.uniform1f(at.radius, radius);
  gl.uniform1f(at.pixel, 1 / view.focal);
  gl.uniform2f(at.sizes, 3.4, 13);
  gl.uniform3fv(at.kinds, colours.flatMap(rgb));
  gl.bindVertexArray(array);
  gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
}

// In the colours of their arcs, on a dark seam.
function drawCuts(layer, view, ratio) {
  const { array, count, palettes } = made('cuts', () => ({ ...makeLines(lines.cuts), palettes: {} }));
  const tints = () => makeLines(lines.cuts, Float32Array.from(Array.from(tiles.arcs).flatMap(arc => rgb(arcColour(arc)))));
  const seam = { ...layer, width: layer.width + 2.2 };
  gl.depthMask(false);   // a seam hides no cut
  drawLines(seam, 'cuts', view, ratio, THEMES[state.theme].ink, { array, count });
  gl.depthMask(true);
  drawLines(layer, 'cuts', view, ratio, THEMES[state.theme].ink, (palettes[state.palette] ??= tints()));
}

function draw(fine) {
  const ratio = pixelRatio(canvas, fine && state.oversampling), view = currentView();
  const [w, h] = [Math.round(view.width * ratio), Math.round(view.height * ratio)];
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  const theme = THEMES[state.theme], palette = PALETTES[state.palette];
  const shown = id => layerOf[id] && state.shown.has(id);
  gl.viewport(0, 0, w, h);
  gl.clearColor(...rgb(theme.paper), 1);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.disable(gl.BLEND);
  // 1. Surfaces; where both are shown in the same place the input becomes a veil.
  const inputShown = shown('input') || shown('triangles') || shown('distance') || shown('tiles') || shown('checker'), veil = shown('quads') && inputShown && state.compare === null;
  const solid = { back: theme.back, ink: theme.ink, alpha: 1, quality: false };
  if (shown('quads')) drawSurface(layerOf.quads, quads, view, ratio, { ...solid, base: theme.quads, strength: 0.92, quality: shown('quality') });
  if (inputShown) {
    const strength = shown('triangles') ? 0.55 : 0;
    if (veil) { gl.enable(gl.BLEND); gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA); gl.enable(gl.CULL_FACE); gl.depthMask(false); }
    drawSurface(layerOf.input, input, view, ratio, { ...solid, base: theme.input, ink: theme.faint, strength, measured: shown('distance'), tiled: shown('tiles'), checkered: shown('checker'), alpha: veil ? 0.45 : 1 });
    gl.disable(gl.CULL_FACE); gl.depthMask(true);
  }
  // 2. Lines and balls over them.
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  if (shown('grid')) { drawLines(layerOf.grid, 'grid_u', view, ratio, palette.grid_u); drawLines(layerOf.grid, 'grid_v', view, ratio, palette.grid_v); }
  for (const id of ['isolines', 'field', 'seams', 'cut_locus', 'boundary', 'features', 'sources', 'paths']) if (shown(id)) drawLines(layerOf[id], id, view, ratio, palette[id]);
  if (shown('cuts')) drawCuts(layerOf.cuts, view, ratio);
  if (shown('multipoints')) drawBalls(layerOf.multipoints, view, ratio, Array(3).fill(palette.multipoints), made('multipoints', () => makePointBalls(tiles.points, 0.017)));
  if (shown('sources') && distance.points.length) drawBalls(layerOf.sources, view, ratio, [palette.sources, palette.sources, palette.sources], made('sourceBalls', () => makePointBalls(distance.points, 0.012)));
  if (shown('singularities')) drawBalls(layerOf.singularities, view, ratio, [palette.valence3, palette.valence5, palette.valenceOther]);
}

const { redraw } = makeFrames({ step: fly, draw: fine => { if (gl && !gl.isContextLost()) draw(fine); } });

// ------------------------------------------------------------------------------------------------ picking

// Nearest face hit by a ray: { t, face } or null (Möller and Trumbore).
function hit(mesh, { origin, direction }) {
  const { positions: p, faces, degree, count } = mesh, fan = degree === 4 ? [[0, 1, 2], [2, 3, 0]] : [[0, 1, 2]];
  const at = i => [p[3 * i], p[3 * i + 1], p[3 * i + 2]];
  let best = null;
  for (let face = 0; face < count; face++) {
    for (const [i, j, k] of fan) {
      const a = at(faces[degree * face + i]), e = sub(at(faces[degree * face + j]), a), g = sub(at(faces[degree * face + k]), a);
      const n = cross(direction, g), det = dot(e, n);
      if (Math.abs(det) < 1e-20) continue;
      const s = sub(origin, a), u = dot(s, n) / det, m = cross(s, e), v = dot(direction, m) / det, t = dot(g, m) / det;
      if (u >= 0 && v >= 0 && u + v <= 1 && t > 0 && (!best || t < best.t)) best = { t, face, corners: [i, j, k], weights: [1 - u - v, u, v] };
    }
  }
  return best;
}

// What is seen at a pixel: mesh, hit and place, or null.
function pick(x, y) {
  const useQuads = quads && (state.shown.has('quads') && !(state.compare !== null && input && x < state.compare * innerWidth));
  const mesh = useQuads ? quads : input ?? quads;
  const ray = mesh && rayAt(x, y), found = mesh && hit(mesh, ray);
  return found && { mesh, found, target: add(ray.origin, scale(ray.direction, found.t)) };
}

function describe({ mesh, found, target }) {
  const place = target.map((c, k) => shortNumber(packed.centre[k] + c * packed.unit)).join(', ');
  const quality = mesh.quality.length ? `, scaled Jacobian ${shortNumber(mesh.quality[found.face])}` : '';
  const d = mesh === input && distance ? found.weights.reduce((s, w, i) => s + w * distance.values[mesh.faces[mesh.degree * found.face + found.corners[i]]], 0) : null;
  const measured = d === null ? '' : Number.isNaN(d) ? ', no source reaches it' : `, distance ${shortNumber(d * distance.largest)}`;
  const tile = tileAt({ mesh, found }), tiled = tile === null ? '' : `, tile ${tile}${tiles.unfolded[tile] ? `, ${sidesOf(tile)}` : ''}`;
  $('status').textContent = `${mesh === quads ? 'quad' : 'triangle'} ${found.face} at (${place})${quality}${measured}${tiled}`;
}

const tileAt = ({ mesh, found }) => (tiles && mesh === input && tiles.tile[found.face] !== NONE ? tiles.tile[found.face] : null);
function sidesOf(tile) {
  const { rings } = tiles.unfolded[tile], sides = rings.reduce((sum, ring) => sum + ring.length, 0);
  return `${grouped(sides)} ${sides === 1 ? 'side' : 'sides'}${rings.length > 1 ? ` on ${rings.length} boundaries` : ''}`;
}

function focusAt(x, y) {
  if (!(quads ?? input)) return;
  const picked = pick(x, y);
  if (!picked) return goHome();
  flyTo({ target: picked.target, distance: Math.min(camera.distance, Math.max(0.35 * camera.distance, 0.4)) });
  describe(picked);
  const tile = tileAt(picked);
  if (tile !== null) chooseTile(tile);
}

// A click chooses the tile there, or none.
function chooseAt(x, y) {
  const picked = tiles && pick(x, y), tile = picked ? tileAt(picked) : null;
  if (picked) describe(picked);
  if (tile !== null) chooseTile(tile); else if (state.marked) forgetTile();
}

// ------------------------------------------------------------------------------------------------ panel

const shortNumber = x => (x === 0 ? '0' : Math.abs(x) >= 1e6 || Math.abs(x) < 1e-4 ? x.toExponential(3) : String(Number(x.toPrecision(4))));
const grouped = n => n.toLocaleString('en').replaceAll(',', '\u202f');

function buildLayers() {
  for (const layer of LAYERS) {
    const box = element('input', { type: 'checkbox', 'data-layer': layer.id });
    box.addEventListener('change', () => setLayer(layer.id, box.checked));
    const swatch = element('span', { class: layer.width ? 'swatch line' : 'swatch' });
    const label = element('label', {}, box, swatch, element('span', { class: 'name', text: layer.name }),
      element('span', { class: 'count', text: ['quality', 'triangles', 'distance', 'checker'].includes(layer.id) || layer.width ? '' : grouped(layer.count) }),
      element('kbd', { text: layer.key }));
    Object.assign(layer, { box, swatch });
    $('layers').append(element('li', {}, label));
  }
  for (const preset of PRESETS.length > 1 ? PRESETS : []) {
    preset.button = element('button', { text: preset.name, 'data-preset': preset.id });
    preset.button.addEventListener('click', () => setPreset(preset.id));
    $('presets').append(preset.button);
  }
  $('presets').hidden = PRESETS.length < 2;
}

function swatchColour(id) {
  const palette = PALETTES[state.palette], theme = THEMES[state.theme];
  if (id === 'grid') return `linear-gradient(90deg, ${palette.grid_u} 50%, ${palette.grid_v} 50%)`;
  if (id === 'singularities') return `linear-gradient(135deg, ${palette.valence3} 50%, ${palette.valence5} 50%)`;
  if (id === 'quality') return 'linear-gradient(135deg, #9cc7de 30%, #fde68a 55%, #c2410c 85%)';
  if (id === 'distance') return `linear-gradient(90deg, ${DISTANCE_STOPS[state.palette].map(([, hex]) => hex).join(', ')})`;
  if (id === 'tiles') return `conic-gradient(${TILE_COLOURS[state.palette].slice(0, 4).map((hex, k) => `${hex} ${25 * k}% ${25 * k + 25}%`).join(', ')})`;
  if (id === 'cuts' && tiles.arcs[0] !== NONE) return `linear-gradient(90deg, ${ARC_COLOURS[state.palette].slice(0, 3).map((hex, k) => `${hex} ${34 * k}% ${34 * k + 34}%`).join(', ')})`;
  if (id === 'checker') return `conic-gradient(${theme.quads} 25%, ${theme.faint} 0 50%, ${theme.quads} 0 75%, ${theme.faint} 0) 0 0 / 8px 8px`;
  if (id === 'triangles') return `repeating-linear-gradient(45deg, ${theme.input} 0 3px, ${theme.faint} 3px 4px)`;
  if (id === 'quads') return `linear-gradient(${theme.ink} 0 0) center / 1px 100% no-repeat, linear-gradient(${theme.ink} 0 0) center / 100% 1px no-repeat, ${theme.quads}`;
  return palette[id] ?? theme[id];
}

function buildValenceLegend() {
  const count = new Map();
  for (const valence of singular.valence) count.set(valence, (count.get(valence) ?? 0) + 1);
  const rows = [...count.keys()].sort((a, b) => a - b).map(valence => {
    const dot = element('i', { 'data-kind': valenceKind(valence) });
    return element('li', { title: `${count.get(valence)} vertices where ${valence} quads meet` }, dot,
      element('span', { text: `valence ${valence}` }), element('b', { text: grouped(count.get(valence)) }));
  });
  $('valence-legend').replaceChildren(...rows);
  $('valence').hidden = rows.length === 0;
}

function buildQualityLegend() {
  const css = QUALITY_STOPS.map(([at, hex]) => `${hex} ${100 * at}%`).join(', ');
  $('quality-bar').style.background = `linear-gradient(90deg, ${css})`;
  for (const at of [0, 0.4, 0.7, 0.88, 1]) {
    $('quality-ticks').append(element('span', { text: at === 0 ? '≤ 0 inverted' : String(at), style: `left: ${100 * at}%` }));
  }
}

function buildDistanceLegend() {
  if (!distance) return;
  for (const at of [0, 0.25, 0.5, 0.75, 1]) {
    $('distance-ticks').append(element('span', { text: shortNumber(at * distance.largest), style: `left: ${100 * at}%` }));
  }
}

// The unfolded tile that is chosen.
function showUnfolded() {
  const tile = tiles?.unfolded[state.tile];
  $('unfolded').hidden = !tile || !['tiles', 'cuts', 'checker'].some(id => state.shown.has(id));
  if ($('unfolded').hidden || showUnfolded.shown === `${state.tile} ${state.palette}`) return;
  showUnfolded.shown = `${state.tile} ${state.palette}`;
  const palette = PALETTES[state.palette], [name] = tile.name.split(': ');
  const colours = { fill: tileColour(state.tile), corner: palette.multipoints, arc: ([, arc, flags]) => (flags & 2 ? palette.boundary : arcColour(arc)) };
  const svg = quadloomUnfolded.draw(tile.rings, colours, { drawing });
  svg.setAttribute('aria-label', tile.name);
  $('unfolded-drawing').replaceChildren(svg);
  $('unfolded-name').textContent = `${name || `tile ${state.tile}`}: ${sidesOf(state.tile)}`;
  $('unfolded-word').replaceChildren(...quadloomUnfolded.word(tile.rings, colours, { element }));
  $('unfolded-number').value = state.tile;
}

const CHART = { width: 254, height: 52, foot: 14 };
function buildHistogram({ title, unit, low, high, counts, mark, summary }) {
  const { width, height, foot } = CHART, most = Math.max(1, ...counts), step = width / counts.length;
  const svg = drawing('svg', { viewBox: `0 0 ${width} ${height + foot}`, role: 'img', 'aria-label': title });
  const total = counts.reduce((a, b) => a + b, 0) || 1;
  counts.forEach((n, k) => {
    const [from, to] = [k, k + 1].map(i => low + i * (high - low) / counts.length), tall = n ? Math.max(1, n / most * height) : 0;
    const note = drawing('title');
    note.textContent = `${shortNumber(from)} – ${shortNumber(to)}${unit}: ${grouped(n)} (${(100 * n / total).toFixed(1)} %)`;
    const bar = drawing('rect', { class: 'bar', x: k * step + 0.4, y: height - tall, width: Math.max(step - 0.8, 0.5), height: tall, rx: 0.8 });
    svg.append(drawing('g', {}, note, drawing('rect', { class: 'hit', x: k * step, y: 0, width: step, height }), bar));
  });
  const write = (x, anchor, text, kind = '') => {
    const label = drawing('text', { x, y: height + foot - 3, 'text-anchor': anchor, class: kind });
    label.textContent = text;
    svg.append(label);
  };
  svg.append(drawing('line', { class: 'axis', x1: 0, x2: width, y1: height + 0.5, y2: height + 0.5 }));
  write(0, 'start', shortNumber(low) + unit);
  const place = mark === null ? -1 : (mark - low) / (high - low) * width, inside = place > 24 && place < width - 24;
  if (place >= 0 && place <= width) svg.append(drawing('line', { class: 'mark', x1: place, x2: place, y1: -2, y2: height + 3 }));
  if (inside) write(place, 'middle', shortNumber(mark) + unit, 'marked');
  write(width, 'end', shortNumber(high) + unit);
  const digits = x => (Math.abs(x) >= 10 ? x.toFixed(1) : Math.abs(x) >= 1e-3 || x === 0 ? x.toFixed(3) : shortNumber(x));
  const figures = summary ? `${digits(summary[0])} to ${digits(summary[2])}, mean ${digits(summary[1])}` : 'no values';
  const head = element('div', { class: 'head' }, element('h3', { text: title }), element('span', { text: figures }));
  return element('div', { class: 'histogram' }, head, svg);
}

function buildPanel() {
  const parts = [quads && `${grouped(quads.count)} quads`, input && `${grouped(input.count)} ${distance || tiles ? '' : 'input '}triangles`,
    tiles && `${grouped(tiles.colours.length)} ${tiles.colours.length === 1 ? 'tile' : 'tiles'}`];
  $('subtitle').textContent = parts.filter(Boolean).join(' · ');
  buildLayers();
  buildValenceLegend();
  buildQualityLegend();
  buildDistanceLegend();
  $('unfolded-choice').hidden = !(tiles?.unfolded.length > 1);
  $('unfolded-number').max = (tiles?.unfolded.length ?? 0) - 1;
  $('help-tiles').hidden = !tiles;
  $('histograms').append(...packed.histograms.map(buildHistogram));
  const rows = packed.statistics.map(([name, value]) => element('tr', {}, element('td', { text: name }), element('td', { text: value })));
  $('statistics').hidden = rows.length === 0;
  $('statistics').querySelector('tbody').append(...rows);
  $('tool-compare').hidden = !(quads && input);
}

const HINT = `drag to turn · right-drag to move · wheel to zoom · ${tiles ? 'click to choose a tile · ' : ''}double-click to look closer · ? for keys`;

// Makes the panel agree with the state.
function refresh() {
  const root = document.documentElement, palette = PALETTES[state.palette];
  root.dataset.theme = state.theme;
  for (const layer of LAYERS) {
    layer.box.checked = state.shown.has(layer.id);
    layer.swatch.style.background = swatchColour(layer.id);
  }
  const same = preset => preset.layers.filter(id => layerOf[id]).length === state.shown.size && preset.layers.every(id => !layerOf[id] || state.shown.has(id));
  for (const preset of PRESETS) preset.button?.setAttribute('aria-pressed', String(state.compare === null && same(preset)));
  const kinds = [palette.valence3, palette.valence5, palette.valenceOther];
  for (const dot of $('valence-legend').querySelectorAll('i')) dot.style.background = kinds[dot.dataset.kind];
  $('distance').hidden = !state.shown.has('distance');
  $('distance-bar').style.background = `linear-gradient(90deg, ${DISTANCE_STOPS[state.palette].map(([at, hex]) => `${hex} ${100 * at}%`).join(', ')})`;
  showUnfolded();
  $('quality').hidden = !state.shown.has('quality');
  for (const [id, on] of [['compare', state.compare !== null], ['palette', state.palette === 'safe'], ['theme', state.theme === 'dark'], ['panel', root.dataset.panel !== 'off']]) {
    $(`tool-${id}`).setAttribute('aria-pressed', String(on));
  }
  for (const id of ['divider', 'side-left', 'side-right']) {
    $(id).hidden = state.compare === null;
    $(id).style.left = `${100 * (state.compare ?? 0)}%`;
  }
  redraw();
}

// ------------------------------------------------------------------------------------------------ actions

function setLayer(id, on = !state.shown.has(id)) {
  if (!layerOf[id]) return;
  if (on) state.shown.add(id); else state.shown.delete(id);
  if (on && id === 'quality') state.shown.add('quads');
  if (on && id === 'distance') state.shown.add('input');
  if (on && (id === 'tiles' || id === 'checker')) state.shown.add('input');
  if (!on && id === 'input') for (const colours of ['distance', 'tiles', 'checker']) state.shown.delete(colours);
  refresh();
}
// Turns a tile to the eye if on the whole it looks away.
function turnTo(tile) {
  const area = faceNormals(input), normal = [0, 0, 0];
  tiles.tile.forEach((t, face) => { if (t === tile) for (let k = 0; k < 3; k++) normal[k] += area[3 * face + k]; });
  const turned = turnedToEye(camera.rotation, normal);
  if (turned) flyTo(fitted(turned));
}
function chooseTile(tile) {
  if (!(tile >= 0 && tile < tiles?.colours.length)) return;
  Object.assign(state, { tile, marked: tiles.colours.length > 1 });
  refresh();
}
const turnToTile = tile => { chooseTile(tile); if (state.marked && state.tile === tile) turnTo(tile); };
function stepTile(step) {
  if (tiles) turnToTile((state.tile + step + tiles.colours.length) % tiles.colours.length);
}
function forgetTile() {
  state.marked = false;
  refresh();
}
function setPreset(id) {
  const preset = PRESETS.find(p => p.id === id);
  if (!preset) return;
  state.compare = null;
  state.shown = new Set(preset.layers.filter(layer => layerOf[layer]));
  refresh();
}
function nextPreset() {
  const now = PRESETS.findIndex(p => p.button?.getAttribute('aria-pressed') === 'true');
  if (PRESETS.length) setPreset(PRESETS[(now + 1) % PRESETS.length].id);
}
function setCompare(at) {
  if (!(quads && input)) return;
  state.compare = at === null ? null : Math.min(Math.max(at, 0.02), 0.98);
  if (at !== null) for (const id of ['quads', 'input']) state.shown.add(id); else state.shown.delete('input');
  refresh();
}
const toggleCompare = () => setCompare(state.compare === null ? currentView().centre[0] / innerWidth : null);
const togglePalette = () => { state.palette = state.palette === 'usual' ? 'safe' : 'usual'; refresh(); };
const toggleTheme = () => { state.theme = state.theme === 'light' ? 'dark' : 'light'; refresh(); };
function togglePanel() {
  const root = document.documentElement;
  root.dataset.panel = root.dataset.panel === 'off' ? 'on' : 'off';
  keepFitted();
  refresh();
}
function savePicture() {
  draw(true);
  canvas.toBlob(blob => {
    const link = element('a', { href: URL.createObjectURL(blob), download: `${packed.title.replace(/[^\p{L}\p{N}]+/gu, '-') || 'quadloom'}.png` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
}
function lookAlong(axis) {
  const views = { x: [facing(-90, 0), facing(90, 0)], y: [facing(0, 90), facing(0, -90)], z: [facing(0, 0), facing(180, 0)] }[axis];
  const close = (a, b) => Math.abs(a.reduce((s, x, i) => s + x * b[i], 0)) > 0.9999;
  flyTo(fitted(close(camera.rotation, views[0]) ? views[1] : views[0]));
}

const STEP = 8 * Math.PI / 180;
const KEYS = {
  w: toggleCompare, c: togglePalette, t: toggleTheme, r: goHome, s: savePicture, h: togglePanel, v: nextPreset,
  x: () => lookAlong('x'), y: () => lookAlong('y'), z: () => lookAlong('z'), '?': () => $('help').showModal(),
  n: () => stepTile(1), p: () => stepTile(-1), escape: forgetTile,
  '+': () => zoom(1 / 1.15, ...currentView().centre), '=': () => zoom(1 / 1.15, ...currentView().centre), '-': () => zoom(1.15, ...currentView().centre),
  arrowleft: () => orbit(-STEP, 0), arrowright: () => orbit(STEP, 0), arrowup: () => orbit(0, -STEP), arrowdown: () => orbit(0, STEP),
};

function listenToKeys() {
  addEventListener('keydown', event => {
    if (event.ctrlKey || event.metaKey || event.altKey || $('help').open || event.target === $('unfolded-number')) return;
    const layer = LAYERS.find(l => l.key === event.key), action = KEYS[event.key.toLowerCase()];
    if (!layer && !action) return;
    event.preventDefault();
    if (layer) setLayer(layer.id); else { stop(); action(); redraw(); }
  });
}

function listenToTools() {
  const tools = { compare: toggleCompare, palette: togglePalette, theme: toggleTheme, home: goHome, picture: savePicture, help: () => $('help').showModal(), panel: togglePanel };
  for (const [id, action] of Object.entries(tools)) $(`tool-${id}`).addEventListener('click', action);
  $('unfolded-previous').addEventListener('click', () => stepTile(-1));
  $('unfolded-next').addEventListener('click', () => stepTile(1));
  $('unfolded-number').addEventListener('change', () => turnToTile(Math.trunc($('unfolded-number').valueAsNumber)));
  const divider = $('divider');
  divider.addEventListener('pointerdown', event => { divider.setPointerCapture(event.pointerId); event.preventDefault(); });
  divider.addEventListener('pointermove', event => { if (divider.hasPointerCapture(event.pointerId)) setCompare(event.clientX / innerWidth); });
  addEventListener('resize', keepFitted);
}

// ------------------------------------------------------------------------------------------------ start

function readAddress() {
  const asked = new URLSearchParams(location.hash.slice(1)), number = (name, usual) => (asked.has(name) && Number.isFinite(+asked.get(name)) ? +asked.get(name) : usual);
  if (asked.get('theme') in THEMES) state.theme = asked.get('theme');
  if (asked.get('palette') in PALETTES) state.palette = asked.get('palette');
  if (asked.get('panel') === 'off') document.documentElement.dataset.panel = 'off';
  setPreset((PRESETS.find(p => p.id === asked.get('preset')) ?? PRESETS[0])?.id);
  if (!PRESETS.length) state.shown = new Set(LAYERS.map(l => l.id));
  if (asked.has('layers')) state.shown = new Set(asked.get('layers').split(',').filter(id => layerOf[id]));
  if (asked.has('compare')) setCompare(number('compare', 0.5));
  const start = fitted(facing(number('yaw', HOME_YAW), number('pitch', HOME_PITCH)));
  Object.assign(camera, start, { distance: start.distance / Math.min(Math.max(number('zoom', 1), 0.02), 100) });
  follow(!asked.has('zoom'));
  if (asked.has('tile')) chooseTile(number('tile', 0));
}

function fail(message) {
  $('failure').textContent = message;
  $('failure').hidden = false;
}

buildPanel();
readAddress();
listenToKeys();
listenToPointers(canvas, { orbit, pan, zoom, stop, redraw, click: chooseAt, doubleClick: focusAt });
listenToTools();
$('status').textContent = HINT;
gl = canvas.getContext('webgl2', { antialias: true, alpha: false, powerPreference: 'high-performance' });
if (gl) {
  canvas.addEventListener('webglcontextlost', event => event.preventDefault());
  canvas.addEventListener('webglcontextrestored', () => { startGpu(); redraw(); });
  startGpu();
} else {
  fail('This browser offers no WebGL2, so the surface cannot be drawn. The figures beside are complete.');
}
refresh();

window.quadloom = {
  layers: LAYERS.map(l => l.id), presets: PRESETS.map(p => p.id), camera,
  shown: () => [...state.shown], setOversampling: on => { state.oversampling = on; redraw(); }, setLayer, setPreset, setCompare, focusAt, redraw,
  tile: () => (state.marked ? state.tile : null), chooseTile,
};
})();
