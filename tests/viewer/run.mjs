// Opens a page of the viewer in headless Chromium and works with it: layers, views, keys, orbit, comparison.
//
//     npm install --no-save playwright-core
//     cargo xtask viewer                     a page that the command makes
//     node tests/viewer/run.mjs [page.html [folder for the pictures]]
//
// Exits 0 when everything holds, 1 when a check fails; see browser.mjs for what it needs. Without a page it builds the
// demo with cargo.
import { execFileSync } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { ROOT, SIZE, folder, fullyDrawn, launch } from './browser.mjs';


const page_file = process.argv[2] ? resolve(process.argv[2]) : join(folder, 'demo.html');
if (!process.argv[2]) execFileSync('cargo', ['run', '--release', '-q', '-p', 'quadloom', '--example', 'demo_view', '--', page_file], { cwd: ROOT, stdio: 'inherit' });
const pictures = process.argv[3] ? resolve(process.argv[3]) : null;
if (pictures) mkdirSync(pictures, { recursive: true });

const failures = [];
let checks = 0;
function check(holds, what) {
  checks++;
  if (!holds) failures.push(what);
  console.log(`${holds ? 'ok' : 'FAILED'}: ${what}`);
}

const browser = await launch();
try {
  const page = await browser.newPage({ viewport: SIZE });
  const complaints = [], requests = [];
  page.on('console', message => { if (['error', 'warning'].includes(message.type()) && !/GPU stall|GL Driver Message/.test(message.text())) complaints.push(message.text()); });
  page.on('pageerror', error => complaints.push(String(error)));
  page.on('request', request => { if (!/^(data|blob):/.test(request.url())) requests.push(request.url()); });

  // The picture as numbers, counted by a second, blank page: what is left when nothing draws it.
  const counter = await browser.newPage();
  async function picture(name, clip) {
    await fullyDrawn(page);
    const png = await page.screenshot({ clip });
    if (pictures) writeFileSync(join(pictures, `${name}.png`), png);
    return png;
  }
  const compare = (a, b) => counter.evaluate(async ([first, second]) => {
    const pixels = async text => {
      const image = new Image();
      image.src = `data:image/png;base64,${text}`;
      await image.decode();
      const canvas = new OffscreenCanvas(image.width, image.height), context = canvas.getContext('2d');
      context.drawImage(image, 0, 0);
      return context.getImageData(0, 0, image.width, image.height).data;
    };
    const [p, q] = [await pixels(first), await pixels(second)];
    const colours = new Set();
    let changed = 0, white = 0;
    for (let i = 0; i < p.length; i += 4) {
      if (Math.abs(p[i] - q[i]) + Math.abs(p[i + 1] - q[i + 1]) + Math.abs(p[i + 2] - q[i + 2]) > 24) changed++;
      if (p[i] + p[i + 1] + p[i + 2] > 750) white++;
      colours.add((p[i] >> 3 << 10) | (p[i + 1] >> 3 << 5) | (p[i + 2] >> 3));
    }
    const total = p.length / 4;
    return { changed: changed / total, white: white / total, colours: colours.size };
  }, [a.toString('base64'), b.toString('base64')]);
  const surface = { x: 40, y: 60, width: SIZE.width - 380, height: SIZE.height - 120 };

  // 1. The page stands, and the canvas shows a surface on white.
  await page.goto(pathToFileURL(page_file).href);
  check((await picture('result')).length > 20000, 'the whole page is not blank');
  // Software rendering is slow: from here on a picture at rest is as coarse as one in motion.
  await page.evaluate(() => quadloom.setOversampling(false));
  const first = await picture('result-coarse');
  const start = await picture('start', surface), itself = await compare(start, await picture('start', surface));
  check(await page.evaluate(() => Boolean(document.createElement('canvas').getContext('webgl2'))), 'WebGL2 is there');
  check(itself.changed === 0, 'a picture at rest stays the same');
  check(itself.colours > 40 && itself.white > 0.15 && itself.white < 0.95, `a shaded surface on white (${itself.colours} colours, ${Math.round(100 * itself.white)} % white)`);

  // 2. Every layer changes the picture when it is toggled, and comes back.
  const { layers, presets } = await page.evaluate(() => ({ layers: quadloom.layers, presets: quadloom.presets }));
  const home = presets[0];
  for (const layer of layers) {
    const base = layer === 'triangles' ? ['input'] : layer === 'quality' ? ['quads'] : [];
    await page.evaluate(([ids, all]) => { for (const id of all) quadloom.setLayer(id, ids.includes(id)); }, [base, layers]);
    const off = await picture(`layer-${layer}-off`, surface);
    await page.locator(`#layers input[data-layer="${layer}"]`).dispatchEvent('click');
    const on = await picture(`layer-${layer}`, surface), difference = await compare(on, off);
    check(difference.changed > 0.0005, `layer ${layer} shows (${(100 * difference.changed).toFixed(2)} % of the pixels)`);
    await page.locator(`#layers input[data-layer="${layer}"]`).dispatchEvent('click');
    check((await compare(await picture('back', surface), off)).changed === 0, `layer ${layer} hides`);
  }

  // 3. Views, themes, palettes, comparison, by mouse and keys.
  const shown = {};
  for (const preset of presets) {
    await page.evaluate(id => quadloom.setPreset(id), preset);
    shown[preset] = await picture(`view-${preset}`);
    check(preset === home || (await compare(shown[preset], shown[home])).changed > 0.005, `view ${preset}`);
  }
  await page.evaluate(id => quadloom.setPreset(id), home);
  for (const [key, name, least] of [['t', 'dark', 0.3], ['w', 'compare', 0.01], ['h', 'no-panel', 0.05]]) {
    await page.keyboard.press(key);
    check((await compare(await picture(name), first)).changed > least, `key ${key}: ${name}`);
    await page.keyboard.press(key);
    check((await compare(await picture('back'), first)).changed === 0, `key ${key} again: as before`);
  }
  await page.keyboard.press('c');
  check((await compare(await picture('safe-palette'), first)).changed > 0.0003, 'key c: colour-blind-safe colours');
  await page.keyboard.press('c');

  // 4. Orbit, move, zoom, look closer, and home again.
  const [x, y] = [surface.x + surface.width / 2, surface.y + surface.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 120, y + 40, { steps: 4 });
  await page.mouse.up();
  const turned = await picture('turned', surface);
  check((await compare(turned, start)).changed > 0.02, 'dragging turns');
  await page.mouse.down({ button: 'right' });
  await page.mouse.move(x + 40, y, { steps: 3 });
  await page.mouse.up({ button: 'right' });
  const moved = await picture('moved', surface);
  check((await compare(moved, turned)).changed > 0.02, 'dragging with the right button moves');
  await page.mouse.wheel(0, -400);
  check((await compare(await picture('zoomed', surface), moved)).changed > 0.02, 'the wheel zooms');
  const distance = () => page.evaluate(() => quadloom.camera.distance);
  const before = await distance();
  await page.mouse.dblclick(x, y);
  await picture('closer');
  check(await distance() < before && /^(quad|triangle) \d+ at/.test(await page.textContent('#status')), 'a double-click looks closer and names the face');
  await page.keyboard.press('r');
  check((await compare(await picture('home', surface), start)).changed < 0.02, 'R returns home');

  // 5. The panel tells figures.
  check(await page.locator('#statistics tr').count() > 0, 'a table of figures');
  check(await page.locator('.histogram svg').count() === 3 && await page.locator('.histogram rect.bar').count() > 30, 'three histograms');
  check(await page.locator('#valence-legend li').count() > 0, 'a legend of valences');

  // 6. A phone.
  await page.setViewportSize({ width: 420, height: 860 });
  await picture('phone');
  const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  check(overflow <= 0, 'nothing sticks out on a narrow screen');

  // 7. Quietly and alone.
  check(complaints.length === 0, `no error in the console${complaints.length ? `: ${complaints[0]}` : ''}`);
  check(requests.length === 1 && requests[0].startsWith('file:'), `no request but the page itself${requests.length > 1 ? `: ${requests[1]}` : ''}`);
} finally {
  await browser.close();
}
console.log(`${checks - failures.length} of ${checks} checks hold`);
process.exit(failures.length ? 1 : 0);
