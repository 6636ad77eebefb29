// Headless Chromium for scripts that work with pages of the viewer.
//
// Out: `launch()`, a browser; `folder`, a temporary one that is removed at the end; `fullyDrawn(page)`. Without Chromium
// or playwright-core the process ends with a line `skipped: …` and exit code 0. CHROMIUM names another browser, and
// PLAYWRIGHT_CORE the folder of the package where it is installed neither beside the repository nor globally.
import { existsSync, mkdtempSync, realpathSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

export const ROOT = resolve(dirname(fileURLToPath(import.meta.url)), '../..');
export const SIZE = { width: 1280, height: 800 };
const FLAGS = ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update',
  '--disable-sync', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-gpu-compositing', '--hide-scrollbars'];

function skip(reason) {
  console.log(`skipped: ${reason}`);
  process.exit(0);
}

function findPlaywright() {
  const places = [process.env.PLAYWRIGHT_CORE, join(ROOT, 'package.json'), join(process.cwd(), 'package.json')].filter(Boolean);
  for (const place of places) {
    try {
      return place === process.env.PLAYWRIGHT_CORE ? createRequire(join(place, 'x'))(resolve(place)) : createRequire(place)('playwright-core');
    } catch (error) {
      if (error.code !== 'MODULE_NOT_FOUND') throw error;
    }
  }
  // Packages that were installed globally are beside npm itself.
  try {
    return createRequire(join(dirname(realpathSync(process.execPath)), '../lib/node_modules/x'))('playwright-core');
  } catch (error) {
    if (error.code !== 'MODULE_NOT_FOUND') throw error;
  }
  return skip('the npm package playwright-core is not installed');
}

const browserPath = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(p => p && existsSync(p))
  ?? skip('no Chromium found (Debian: apt-get install chromium)');
const { chromium } = findPlaywright();

export const folder = mkdtempSync(join(tmpdir(), 'quadloom-viewer-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));

export const launch = () => chromium.launch({ executablePath: browserPath, headless: true, args: FLAGS });

// Waits until the picture at rest is there.
export async function fullyDrawn(page) {
  await page.waitForFunction(() => document.documentElement.dataset.drawn === 'finely', null, { timeout: 60000 });
  await page.evaluate(() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))));
}
