// Opens pages of `quadloom tile` in headless Chromium: tiles, cuts, multipoints, unfolded polygons, picking; a
// checkerboard, for which the script adds coordinates to the page if it has none.
//
//     node tests/viewer/tiles.mjs page.html [another page.html …]
//
// Exits 0 when everything holds, 1 when a check fails; see browser.mjs for what it needs.
import { readFileSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { SIZE, folder, fullyDrawn, launch } from './browser.mjs';

let checks = 0, failures = 0;
function check(holds, what) {
  checks++;
  if (!holds) failures++;
  console.log(`${holds ? 'ok' : 'FAILED'}: ${what}`);
}

const SCENE = /(id="scene">)(.*?)(<\/script>)/s;
const sceneOf = file => JSON.parse(SCENE.exec(readFileSync(file, 'utf8'))[2]);
const bytes = text => { const b = Buffer.from(text, 'base64'); return b.buffer.slice(b.byteOffset, b.byteOffset + b.length); };
const packed = numbers => Buffer.from(numbers.buffer).toString('base64');

// A copy of the page whose scene was changed.
function changed(file, name, change) {
  const scene = sceneOf(file), copy = join(folder, name);
  change(scene);
  writeFileSync(copy, readFileSync(file, 'utf8').replace(SCENE, (_, before, __, after) => before + JSON.stringify(scene).replaceAll('<', '\\u003c') + after));
  return copy;
}

// The map that looks along z.
function addMap(scene) {
  const positions = new Float32Array(bytes(scene.input.positions)), corners = new Uint32Array(bytes(scene.input.faces));
  scene.tiles.uv = packed(Float32Array.from([...corners].flatMap(v => [positions[3 * v], positions[3 * v + 1]])));
}

// Many tiles, one of them with many sides, one with none, names that look like tags.
function addMany(scene) {
  const sides = Array.from({ length: 532 }, (_, k) => [`a${k >> 1}`, k >> 1, k & 1]), count = 300;
  scene.tiles.colours = packed(Uint32Array.from({ length: count }, (_, k) => k % 8));
  scene.tiles.unfolded = Array.from({ length: count }, (_, k) => ({ name: `tile ${k}`, rings: [[['a', 0, 0], ['b', 1, 2], ['c', 2, 1]]] }));
  scene.tiles.unfolded[1] = { name: '<b>tile</b>', rings: [[...sides, ['<i>', 266, 0]]] };
  scene.tiles.unfolded[2].rings = [[]];
  scene.tiles.unfolded[3].rings = [Array.from({ length: 5000 }, (_, k) => ['a', k, 0])];
  scene.tiles.unfolded[4].rings = Array.from({ length: 9 }, () => [['a', 0, 0]]);
}

const browser = await launch(), complaints = [];
async function open(file) {
  const page = await browser.newPage({ viewport: SIZE });
  page.on('console', message => { if (message.type() === 'error') complaints.push(message.text()); });
  page.on('pageerror', error => complaints.push(String(error)));
  await page.goto(pathToFileURL(resolve(file)).href);
  await fullyDrawn(page);
  await page.evaluate(() => quadloom.setOversampling(false));
  return page;
}
const clip = { x: 40, y: 60, width: SIZE.width - 380, height: SIZE.height - 120 };
const picture = async page => { await fullyDrawn(page); return (await page.screenshot({ clip })).toString('base64'); };
const status = page => page.textContent('#status');

async function checkPage(file) {
  const { unfolded, uv } = sceneOf(file).tiles, page = await open(uv ? file : changed(file, 'mapped.html', addMap));
  console.log(`${file}: ${unfolded.length} tiles`);
  // 1. Each layer changes the picture.
  for (const preset of ['tiles', 'checker', 'input']) check((await page.evaluate(() => quadloom.presets)).includes(preset), `a view ${preset}`);
  const missing = new Set(['tiles', 'cuts', 'multipoints', 'checker']);
  for (const side of ['r', 'x', 'x', 'y', 'y', 'z', 'z', 'r']) {
    await page.keyboard.press(side);
    const whole = await picture(page);
    for (const layer of missing) {
      await page.evaluate(id => quadloom.setLayer(id), layer);
      if (await picture(page) !== whole) missing.delete(layer);
      await page.evaluate(id => quadloom.setLayer(id), layer);
    }
    if (side === 'r') check(await picture(page) === whole, 'layers come back as they were');
  }
  check(!missing.size, `tiles, cuts, multipoints and checkerboard are seen when they are shown${missing.size ? `, not ${[...missing].join(', ')}` : ''}`);
  const whole = await picture(page);
  const palette = () => page.locator('#unfolded-drawing .side').first().getAttribute('style');
  const usual = await palette();
  await page.keyboard.press('c');
  check(await picture(page) !== whole && await palette() !== usual, 'the colour-blind-safe palette has other colours');
  await page.keyboard.press('c');
  // 2. Every tile unfolds to its sides.
  for (const [k, { rings }] of unfolded.entries()) {
    await page.evaluate(tile => quadloom.chooseTile(tile), k);
    const sides = rings.flat(), shown = page.locator('#unfolded-drawing .side'), letters = await page.locator('#unfolded-drawing text').allTextContents();
    const words = sides.map(([letter, , flags]) => letter + (flags & 1 ? '⁻¹' : ''));
    const named = await page.textContent('#unfolded-name'), word = (await page.textContent('#unfolded-word')).split(/\s+/).filter(Boolean);
    const holds = await shown.count() === sides.length && named.includes(`${sides.length} side`) && word.join() === words.join() && letters.every(l => words.includes(l));
    if (k < 5 || !holds) check(holds, `tile ${k}: ${named}`);
  }
  // 3. A click tells the tile and unfolds it; the void takes the choice back.
  const several = unfolded.length > 1;
  check(await page.locator('#unfolded-choice').isVisible() === several, 'a choice where there are several tiles');
  let found = null;
  for (let k = 0; k < 60 && !found; k++) {
    await page.mouse.click(clip.x + clip.width * (0.5 + 0.05 * Math.cos(k) * Math.sqrt(k)), clip.y + clip.height * (0.5 + 0.05 * Math.sin(k) * Math.sqrt(k)));
    found = /^triangle \d+ at .*, tile (\d+), (\d+) sides?/.exec(await status(page));
  }
  check(found && Number(found[2]) === unfolded[Number(found[1])].rings.flat().length, 'a click tells the tile and its sides');
  check((await page.textContent('#unfolded-name')).startsWith(`tile ${found?.[1]}`), 'a click unfolds the tile');
  check(await page.evaluate(() => quadloom.tile()) === (several ? Number(found?.[1]) : null), 'the tile stands out if there are others');
  await page.keyboard.press('Escape');
  check(await page.evaluate(() => quadloom.tile()) === null, 'Escape takes the choice back');
  if (several) {
    const next = (Number(found[1]) + 1) % unfolded.length;
    await page.locator('#unfolded-next').click();
    check(await page.evaluate(() => quadloom.tile()) === next, 'the button goes to the next tile');
    const marked = await picture(page);
    await page.keyboard.press('p');
    check(await page.evaluate(() => quadloom.tile()) === Number(found[1]) && await picture(page) !== marked, 'P goes to the previous tile');
    await page.locator('#unfolded-number').fill('0');
    await page.locator('#unfolded-number').press('Enter');
    check(await page.evaluate(() => quadloom.tile()) === 0, 'a number goes to its tile');
  }
  await page.evaluate(() => quadloom.setPreset('input'));
  check(!await page.locator('#unfolded').isVisible(), 'nothing is unfolded beside the mere surface');
  await page.close();
}

async function checkMany(file) {
  const page = await open(changed(file, 'many.html', addMany)), drawing = page.locator('#unfolded-drawing');
  const choose = tile => page.evaluate(t => quadloom.chooseTile(t), tile);
  check(await drawing.locator('svg').count() === 1, 'of hundreds of tiles one is unfolded');
  await choose(1);
  const letters = await drawing.locator('text').count();
  check(await drawing.locator('.side').count() === 533 && letters > 4 && letters < 60, `533 sides have ${letters} letters`);
  check((await page.textContent('#unfolded-name')).startsWith('<b>tile</b>') && await page.locator('#unfolded b, #unfolded i').count() === 0, 'names and letters stay text');
  await choose(2);
  check(await drawing.locator('.side').count() === 0 && await drawing.locator('.tile').count() === 1, 'a tile without sides');
  await choose(3);
  check(await drawing.locator('.side').count() === 0 && await drawing.locator('.tile').count() === 1, 'thousands of sides are an outline');
  await choose(4);
  check(await drawing.locator('.side').count() === 9 && await drawing.locator('.tile').count() === 1, 'a tile with eight holes');
  await page.setViewportSize({ width: 420, height: 860 });
  await fullyDrawn(page);
  check(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth) <= 0, 'nothing sticks out on a narrow screen');
  await page.close();
}

try {
  const files = process.argv.slice(2);
  for (const file of files) await checkPage(file);
  await checkMany(files[0]);
  check(complaints.length === 0, `no error in the console${complaints.length ? `: ${complaints[0]}` : ''}`);
} finally {
  await browser.close();
}
console.log(`${checks - failures} of ${checks} checks hold`);
process.exit(failures ? 1 : 0);
