// Opens a page of `quadloom distance` in headless Chromium: bands, isolines, sources, paths, picking.
//
//     node tests/viewer/distance.mjs page.html
//
// Exits 0 when everything holds, 1 when a check fails; see browser.mjs for what it needs.
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { SIZE, fullyDrawn, launch } from './browser.mjs';

let checks = 0, failures = 0;
function check(holds, what) {
  checks++;
  if (!holds) failures++;
  console.log(`${holds ? 'ok' : 'FAILED'}: ${what}`);
}

const browser = await launch();
try {
  const page = await browser.newPage({ viewport: SIZE });
  const complaints = [];
  page.on('console', message => { if (message.type() === 'error') complaints.push(message.text()); });
  page.on('pageerror', error => complaints.push(String(error)));
  await page.goto(pathToFileURL(resolve(process.argv[2])).href);
  await fullyDrawn(page);
  const layers = await page.evaluate(() => quadloom.layers);
  for (const layer of ['input', 'distance', 'isolines', 'sources', 'paths', 'cut_locus']) check(layers.includes(layer), `a layer ${layer}`);
  check(await page.locator('#distance').isVisible() && await page.locator('#distance-ticks span').count() === 5, 'a legend of distances');
  // Each layer changes the picture.
  const clip = { x: 40, y: 60, width: SIZE.width - 380, height: SIZE.height - 120 };
  const picture = async () => { await fullyDrawn(page); return (await page.screenshot({ clip })).toString('base64'); };
  const whole = await picture();
  for (const layer of ['distance', 'isolines', 'sources', 'paths', 'cut_locus']) {
    const was = await page.evaluate(id => { const was = quadloom.shown().includes(id); quadloom.setLayer(id, !was); return was; }, layer);
    check(await picture() !== whole, `${layer} is seen when it is shown`);
    await page.evaluate(([id, on]) => quadloom.setLayer(id, on), [layer, was]);
  }
  check(await picture() === whole, 'layers come back as they were');
  await page.keyboard.press('c');
  check(await picture() !== whole, 'the colour-blind-safe palette has other colours');
  await page.evaluate(() => quadloom.setPreset('ridges'));
  check((await page.evaluate(() => quadloom.shown())).includes('cut_locus'), 'a view of the cut locus');
  await page.mouse.dblclick(clip.x + clip.width / 2, clip.y + clip.height / 2);
  await fullyDrawn(page);
  check(/^triangle \d+ at .*distance \d/.test(await page.textContent('#status')), 'a double-click tells the distance');
  check(complaints.length === 0, `no error in the console${complaints.length ? `: ${complaints[0]}` : ''}`);
} finally {
  await browser.close();
}
console.log(`${checks - failures} of ${checks} checks hold`);
process.exit(failures ? 1 : 0);
