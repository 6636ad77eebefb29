// Pictures of at most 256 colours, a third as large as a browser's, for documents.
//
// In: a PNG, a page of a browser to decode it. Out: an indexed PNG. Holds: equal pictures give equal bytes; transparent
// pixels become white. Method: boxes of colours are split at their medians, then every colour takes the mean of its pixels;
// with noise, an even pattern of small steps hides where shading goes from one colour to the next.
import { crc32, deflateSync } from 'node:zlib';

const COLOURS = 256, ROUNDS = 3;
const PATTERN = [0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5].map(k => (k - 7.5) / 16);   // four by four

export async function indexed(page, png, noise = 0) {
  const { width, height, data } = await decoded(page, png);
  // 1. How many pixels have which colour.
  const counts = new Map();
  for (let k = 0; k < data.length; k += 4) {
    const colour = data[k] << 16 | data[k + 1] << 8 | data[k + 2];
    counts.set(colour, (counts.get(colour) ?? 0) + 1);
  }
  const colours = [...counts].sort(([a], [b]) => a - b).map(([c, size]) => ({ at: [c >> 16, c >> 8 & 255, c & 255], size }));
  // 2. Few colours, and the nearest of them for each.
  let palette = cutAtMedians(colours).map(meanOf);
  for (let round = 0; round < ROUNDS; round++) {
    const boxes = palette.map(() => []);
    for (const colour of colours) boxes[nearest(palette, colour.at)].push(colour);
    palette = palette.map((old, k) => (boxes[k].length ? meanOf(boxes[k]) : old));
  }
  // 3. The file: rows begin with their filter, none.
  const rows = Buffer.alloc((width + 1) * height), own = new Map();
  for (let y = 0; y < height; y++) for (let x = 0; x < width; x++) {
    const k = 4 * (y * width + x), place = (y % 4) * 4 + x % 4, at = [data[k], data[k + 1], data[k + 2]];
    const moved = noise && Math.min(...at) < 250 ? noise * PATTERN[place] : 0, key = (at[0] << 16 | at[1] << 8 | at[2]) + (moved ? place + 1 : 0) * 2 ** 24;
    if (!own.has(key)) own.set(key, nearest(palette, at.map(x => x + moved)));
    rows[y * (width + 1) + 1 + x] = own.get(key);
  }
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 3], 8);   // bits, indexed
  return Buffer.concat([Buffer.from('89504e470d0a1a0a', 'hex'), chunk('IHDR', header), chunk('PLTE', Buffer.from(palette.flat().map(Math.round))),
    chunk('IDAT', deflateSync(rows, { level: 9 })), chunk('IEND', Buffer.alloc(0))]);
}

// The pixels, four bytes each, as a browser reads them.
async function decoded(page, png) {
  const { width, height, data } = await page.evaluate(async address => {
    const image = await createImageBitmap(await (await fetch(address)).blob()), { width, height } = image;
    const context = new OffscreenCanvas(width, height).getContext('2d');
    context.fillStyle = '#fff';
    context.fillRect(0, 0, width, height);
    context.drawImage(image, 0, 0);
    const bytes = context.getImageData(0, 0, width, height).data;
    let text = '';
    for (let k = 0; k < bytes.length; k += 32768) text += String.fromCharCode(...bytes.subarray(k, k + 32768));
    return { width, height, data: btoa(text) };
  }, `data:image/png;base64,${png.toString('base64')}`);
  return { width, height, data: Buffer.from(data, 'base64') };
}

const sum = (list, of) => list.reduce((total, item) => total + of(item), 0);
const meanOf = box => [0, 1, 2].map(k => sum(box, c => c.size * c.at[k]) / sum(box, c => c.size));

function cutAtMedians(colours) {
  const measured = box => {
    const ranges = [0, 1, 2].map(k => { const own = box.map(c => c.at[k]); return own.reduce((a, b) => Math.max(a, b)) - own.reduce((a, b) => Math.min(a, b)); });
    const axis = ranges.indexOf(Math.max(...ranges));
    return { box, axis, weight: ranges[axis] ** 2 * Math.sqrt(sum(box, c => c.size)) };
  };
  const boxes = [measured(colours)];
  while (boxes.length < COLOURS) {
    const widest = boxes.reduce((best, next, k) => (next.weight > boxes[best].weight ? k : best), 0), { box, axis, weight } = boxes[widest];
    if (!weight) break;
    box.sort((a, b) => a.at[axis] - b.at[axis]);
    const half = sum(box, c => c.size) / 2;
    let cut = 0;
    for (let seen = 0; cut < box.length - 1 && (seen += box[cut].size) < half;) cut++;
    cut = Math.min(Math.max(cut, 1), box.length - 1);
    boxes.splice(widest, 1, measured(box.slice(0, cut)), measured(box.slice(cut)));
  }
  return boxes.map(({ box }) => box);
}

function nearest(palette, [r, g, b]) {
  let best = 0, least = Infinity;
  palette.forEach(([x, y, z], k) => {
    const distance = (r - x) ** 2 + (g - y) ** 2 + (b - z) ** 2;
    if (distance < least) { least = distance; best = k; }
  });
  return best;
}

function chunk(name, data) {
  const body = Buffer.concat([Buffer.from(name, 'latin1'), data]), out = Buffer.alloc(body.length + 8);
  out.writeUInt32BE(data.length, 0);
  body.copy(out, 4);
  out.writeUInt32BE(crc32(body) >>> 0, body.length + 4);
  return out;
}
