// Saves pictures of a regular map's pages, and copies flat ones: how the gallery of docs/regular-maps.md is made.
//
//     node tests/viewer/gallery.mjs FILE picture.png OPTIONS [FILE picture.png OPTIONS …]
//
// FILE is a page, whose options are those of its address, as in yaw=40&face=12: the picture shows the surface alone, or
// with whole=WIDTHxHEIGHT among them the whole page, as large. Or FILE is a picture, which has no options. All of them
// end with few colours (palette.mjs). See browser.mjs for what it needs.
import { readFileSync, writeFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { fullyDrawn, launch } from './browser.mjs';
import { indexed } from './palette.mjs';

const SURFACE = { width: 520, height: 480 }, TOOLS = 60;   // what the page keeps free below a surface
const NOISE = 10, LESS_NOISE = 3;   // of 255; pages have areas of one colour
const ALONE = '#stage header, #stage footer, #side { display: none !important } body { display: block !important } '
  + '#stage { height: 100vh !important; min-height: 0 !important; background: #fff !important }';

const words = process.argv.slice(2), browser = await launch();

async function shot(file, asked) {
  const options = new URLSearchParams(asked), whole = options.get('whole');
  const [width, height] = whole ? whole.split('x').map(Number) : [SURFACE.width, SURFACE.height + TOOLS];
  const page = await browser.newPage({ viewport: { width, height }, colorScheme: 'light' });
  const style = css => addEventListener('DOMContentLoaded', () => document.head.append(Object.assign(document.createElement('style'), { textContent: css })));
  if (!whole) await page.addInitScript(style, ALONE);
  await page.goto(`${pathToFileURL(file).href}#${asked}`);
  await page.waitForFunction(() => window.quadloomMap?.ready, null, { timeout: 120000 });
  await page.evaluate(() => dispatchEvent(new Event('resize')));   // the style came after the surface had been fitted
  await fullyDrawn(page);
  const png = await page.screenshot(whole ? {} : { clip: { x: 0, y: 0, ...SURFACE } });
  await page.close();
  return png;
}

try {
  const blank = await browser.newPage();
  for (let k = 0; k + 2 < words.length; k += 3) {
    const [file, picture] = [words[k], words[k + 1]].map(word => resolve(word));
    const shaded = file.endsWith('.html'), png = shaded ? await shot(file, words[k + 2]) : readFileSync(file);
    const small = await indexed(blank, png, !shaded ? 0 : words[k + 2].includes('whole=') ? LESS_NOISE : NOISE);
    writeFileSync(picture, small);
    console.log(`${words[k + 1]}: ${Math.ceil(small.length / 1000)} kB`);
  }
} finally {
  await browser.close();
}
