// The drawing of an unfolded tile: a polygon, or a disk with holes where the tile has several boundaries.
//
// In: rings of sides [letter, arc, flags], as tiles.rs packs them; colours. Out: an SVG and the word as HTML.
// Holds: rings run counter-clockwise around the tile, holes clockwise; the outer ring is the one with the most sides;
// letters are thinned out where they would touch, and beyond MOST_SIDES only the outline is drawn.
const quadloomUnfolded = (() => {
'use strict';

const SIZE = 254, MIDDLE = SIZE / 2;
const REACH = 121, APOTHEM = 99;      // of corners and of the sides' middles, at most
const LETTER = 11, LETTER_GAP = 13;   // size, and distance from the side where it is level
const MOST_SIDES = 4000;              // a browser stays quick
const MOST_LETTERS = 600;             // of a word

const REVERSED = 1, BORDER = 2;
const reversed = side => (side[2] & REVERSED) !== 0;
const border = side => (side[2] & BORDER) !== 0;
const letterOf = side => side[0] + (reversed(side) ? '⁻¹' : '');

const at = (centre, radius, angle) => [centre[0] + radius * Math.cos(angle), centre[1] - radius * Math.sin(angle)];
const text = ([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`;

// Per boundary its sides, each with path, middle, direction along the ring, direction away from the tile, length.
function layout(rings) {
  if (rings.length === 1 && rings[0].length > 2) return [polygon(rings[0].length)];
  const outer = rings.reduce((best, ring, k) => (ring.length > rings[best].length ? k : best), 0), holes = rings.length - 1;
  let hole = 0;
  return rings.map((ring, k) => {
    if (k === outer) return circle([MIDDLE, MIDDLE], APOTHEM, ring.length, 1);
    const angle = Math.PI / 2 + 2 * Math.PI * (hole++ + 0.5) / holes, away = holes === 1 ? 0 : 0.5 * APOTHEM;
    const radius = holes === 1 ? 0.42 * APOTHEM : Math.min(0.3 * APOTHEM, 0.66 * away * Math.sin(Math.PI / holes));
    return circle(at([MIDDLE, MIDDLE], away, angle), radius, ring.length, -1);
  });
}

function polygon(count) {
  const radius = Math.min(REACH, APOTHEM / Math.cos(Math.PI / count));
  const corner = k => at([MIDDLE, MIDDLE], radius, -Math.PI / 2 + (2 * k - 1) * Math.PI / count);
  const sides = Array.from({ length: count }, (_, k) => {
    const [a, b] = [corner(k), corner(k + 1)], length = Math.hypot(b[0] - a[0], b[1] - a[1]), middle = [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2];
    const along = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    return { path: `M${text(a)}L${text(b)}`, end: `L${text(b)}`, from: a, middle, along, out: [-along[1], along[0]], length };
  });
  return { sides, start: text(corner(0)), room: 2 * Math.PI * (radius + LETTER_GAP) };
}

// turn: 1 counter-clockwise with letters outside, -1 clockwise with letters inside.
function circle(centre, radius, count, turn) {
  const angle = k => -Math.PI / 2 + turn * (2 * k - 1) * Math.PI / Math.max(count, 1), sweep = turn > 0 ? 0 : 1;
  const arc = to => `A${radius.toFixed(2)} ${radius.toFixed(2)} 0 0 ${sweep} ${text(to)}`;
  const sides = Array.from({ length: Math.max(count, 1) }, (_, k) => {
    const [a, b] = [angle(k), angle(k + 1)].map(t => at(centre, radius, t)), t = angle(k + 0.5), middle = at(centre, radius, t);
    const end = arc(middle) + arc(b), along = [-turn * Math.sin(t), -turn * Math.cos(t)];
    return { path: `M${text(a)}${end}`, end, from: a, middle, along, out: [-along[1], along[0]], length: 2 * Math.PI * radius / Math.max(count, 1) };
  });
  return { sides, start: text(at(centre, radius, angle(0))), room: 2 * Math.PI * Math.max(radius + turn * LETTER_GAP, 0) };
}

// How many sides a letter stands for, and its size: smaller first, then only every so many.
function letters(ring, room) {
  const widest = ring.reduce((most, side) => Math.max(most, [...letterOf(side)].length), 1), width = 6.3 * widest + 5;
  if (ring.length * width <= room) return { step: 1, size: LETTER };
  if (ring.length * width * 0.8 <= room) return { step: 1, size: 0.8 * LETTER };
  const fit = Math.floor(room / (0.8 * width));
  return { step: fit > 3 ? Math.ceil(ring.length / fit) : Infinity, size: 0.8 * LETTER };
}

// The last letter keeps away from the first.
const lettered = (k, count, step) => step === 1 || (k % step === 0 && (k === 0 || count - k >= step));

// The places of every arc, as [ring, side].
function placesOf(rings) {
  const places = new Map();
  rings.forEach((ring, r) => ring.forEach((side, k) => {
    if (!places.has(side[1])) places.set(side[1], []);
    places.get(side[1]).push([r, k]);
  }));
  return places;
}

function note(rings, places, r, k) {
  const side = rings[r][k], what = `side ${k + 1} of ${rings[r].length}${rings.length > 1 ? `, boundary ${r + 1}` : ''}: ${letterOf(side)}`;
  if (border(side)) return `${what}, on the boundary`;
  const others = places.get(side[1]).filter(([s, j]) => s !== r || j !== k).map(([s, j]) => `side ${j + 1}${s === r ? '' : ` of boundary ${s + 1}`}`);
  return `${what}, ${others.length ? `glued to ${others.join(' and ')}` : 'glued to another tile'}`;
}

// colours: fill, corner, and arc(side). make: the page's `drawing` and `element`.
function draw(rings, colours, make) {
  const total = rings.reduce((sum, ring) => sum + ring.length, 0);
  const places = placesOf(rings), parts = total > MOST_SIDES ? [circle([MIDDLE, MIDDLE], APOTHEM, 1, 1)] : layout(rings);
  const heights = parts.flatMap(({ sides }) => sides.flatMap(s => [s.from[1], s.middle[1] + (LETTER_GAP + 0.4 * LETTER) * s.out[1]]));
  const [top, bottom] = [Math.max(0, Math.min(...heights) - 5), Math.min(SIZE, Math.max(...heights) + 5)];
  const svg = make.drawing('svg', { viewBox: `0 ${top.toFixed(1)} ${SIZE} ${(bottom - top).toFixed(1)}`, role: 'img' });
  svg.append(make.drawing('path', { class: 'tile', d: parts.map(p => `M${p.start}${p.sides.map(s => s.end).join('')}Z`).join(''), fill: colours.fill, 'fill-rule': 'evenodd' }));
  if (total > MOST_SIDES) return svg;
  rings.forEach((ring, r) => {
    const { sides, room } = parts[r], { step, size } = letters(ring, room);
    ring.forEach((side, k) => svg.append(drawSide(side, sides[k], lettered(k, ring.length, step) ? size : 0, colours.arc(side), note(rings, places, r, k), make)));
    if (ring.length && sides[0].length >= 12) for (const { from: [cx, cy] } of sides) svg.append(make.drawing('circle', { cx, cy, r: 3.2, class: 'corner', fill: colours.corner }));
  });
  // Sides of one arc light up together.
  const light = arc => svg.querySelectorAll('.side').forEach(side => side.classList.toggle('same', side.dataset.arc === arc));
  svg.addEventListener('pointerover', event => light(event.target.closest('.side')?.dataset.arc));
  svg.addEventListener('pointerleave', () => light());
  return svg;
}

function drawSide(side, { path, middle, along, out, length }, size, colour, note, { drawing }) {
  const title = drawing('title'), width = length > 20 ? 4 : length > 6 ? 3 : 2.4;
  title.textContent = note;
  const made = drawing('g', { class: border(side) ? 'side border' : 'side', 'data-arc': side[1], style: `--arc: ${colour}` }, title);
  made.append(drawing('path', { class: 'line', d: path, 'stroke-width': border(side) ? 0.7 * width : width }));
  if (!border(side) && length >= 9) {
    const s = Math.min(8, 0.36 * length) * (reversed(side) ? -1 : 1), wide = Math.min(6, 0.3 * length);
    const point = (t, w) => text([middle[0] + t * along[0] + w * out[0], middle[1] + t * along[1] + w * out[1]]);
    made.append(drawing('path', { class: 'arrow', d: `M${point(s, 0)}L${point(-s * 0.7, wide)}L${point(-s * 0.7, -wide)}Z` }));
  }
  if (size) {
    const half = 0.3 * size * [...letterOf(side)].length, away = LETTER_GAP - 3 + Math.max(half, 3);
    const letter = drawing('text', { x: middle[0] + away * out[0], y: middle[1] + LETTER_GAP * out[1] + 0.35 * size, 'font-size': size });
    letter.textContent = letterOf(side);
    made.append(letter);
  }
  made.append(drawing('path', { class: 'hit', d: path }));
  return made;
}

// The words of the rings, letters in the colours of their arcs.
function word(rings, colours, { element }) {
  let left = MOST_LETTERS;
  const words = rings.map(ring => {
    const shown = ring.slice(0, left), letters = shown.map(side => element('span', { text: letterOf(side), style: `--arc: ${colours.arc(side)}` }));
    left -= shown.length;
    return element('p', {}, ...letters.flatMap(letter => [letter, ' ']), shown.length < ring.length ? '…' : '');
  });
  return words.filter(p => p.textContent);
}

return { draw, word };
})();
