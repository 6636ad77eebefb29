// Opens pages of a regular map in headless Chromium: surface and flat picture light the same face, turntable, zoom, keys,
// themes, a narrow screen, scenes without a flat picture and with a hostile one.
//
//     node tests/viewer/map.mjs page.html [folder for the pictures]
//
// Exits 0 when everything holds, 1 when a check fails; see browser.mjs for what it needs. Without a page it builds the
// example 06_map_page with cargo.
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { ROOT, SIZE, folder, fullyDrawn, launch } from './browser.mjs';

const file = process.argv[2] ? resolve(process.argv[2]) : join(folder, 'map.html');
if (!process.argv[2]) execFileSync('cargo', ['run', '--release', '-q', '-p', 'quadloom', '--example', '06_map_page', '--', file], { cwd: ROOT, stdio: 'inherit' });
const pictures = process.argv[3] ? resolve(process.argv[3]) : null;
if (pictures) mkdirSync(pictures, { recursive: true });

let checks = 0, failures = 0;
function check(holds, what) {
  checks++;
  if (!holds) failures++;
  console.log(`${holds ? 'ok' : 'FAILED'}: ${what}`);
}

const SCENE = /(id="scene">)(.*?)(<\/script>)/s;
const sceneOf = page => JSON.parse(SCENE.exec(readFileSync(page, 'utf8'))[2]);

// A copy of the page whose scene was changed.
function changed(name, change) {
  const scene = sceneOf(file), copy = join(folder, name);
  change(scene);
  writeFileSync(copy, readFileSync(file, 'utf8').replace(SCENE, (_, before, __, after) => before + JSON.stringify(scene).replaceAll('<', '\\u003c') + after));
  return copy;
}

const browser = await launch(), complaints = [], requests = [];
async function open(page_file, options = {}) {
  const page = await browser.newPage({ viewport: SIZE, colorScheme: 'light', ...options });
  page.on('console', message => { if (['error', 'warning'].includes(message.type()) && !/GPU stall|GL Driver Message/.test(message.text())) complaints.push(message.text()); });
  page.on('pageerror', error => complaints.push(String(error)));
  page.on('request', request => { if (!/^(data|blob):/.test(request.url())) requests.push(request.url()); });
  page.on('dialog', dialog => { complaints.push(`a dialog: ${dialog.message()}`); dialog.dismiss(); });
  await page.goto(pathToFileURL(page_file).href);
  await page.waitForFunction(() => window.quadloomMap?.ready, null, { timeout: 120000 });
  await page.evaluate(() => quadloomMap.setOversampling(false));
  await fullyDrawn(page);
  return page;
}
const lit = page => page.evaluate(() => [quadloomMap.lit(), quadloomMap.litFlat(), quadloomMap.kept()]);
const status = page => page.textContent('#status');
// Without the frame that a browser draws around what has the focus.
async function picture(page, name) {
  await page.evaluate(() => document.activeElement?.blur());
  await fullyDrawn(page);
  const png = await page.locator('#stage').screenshot();
  if (pictures) writeFileSync(join(pictures, `map-${name}.png`), await page.screenshot());
  return png.toString('base64');
}
async function middleOf(page, selector) {
  const box = await page.locator(selector).first().boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
}

// A place of the face's first group that no other group covers.
const placeInFlat = (page, face) => page.evaluate(face => {
  for (const group of document.querySelectorAll(`#flat [data-face="${face}"]`)) {
    const box = group.getBoundingClientRect();
    for (let k = 0; k < 100; k++) {
      const [x, y] = [box.x + box.width * ((k * 0.618) % 1), box.y + box.height * (k + 0.5) / 100];
      if (document.elementFromPoint(x, y)?.closest('[data-face]')?.dataset.face === String(face)) return [x, y];
    }
  }
  return null;
}, face);

async function checkPage() {
  const page = await open(file), scene = sceneOf(file);
  // 1. What is there.
  check(await page.textContent('h1') === scene.title && await page.locator('#facts div').count() === scene.facts.length, 'title and facts');
  const faces = await page.evaluate(() => quadloomMap.faces), drawn = await page.locator('#flat [data-face]').count();
  check(faces.length > 1 && drawn >= faces.length, `${faces.length} faces, ${drawn} groups in the flat picture`);
  check((await lit(page)).every(face => face === null), 'no face is lit at first');
  const first = await picture(page, 'first');
  check(await picture(page, 'first') === first, 'a picture at rest stays the same');
  // 2. From the surface to the flat picture.
  const centre = await middleOf(page, '#canvas'), under = await page.evaluate(([x, y]) => quadloomMap.pick(x, y), centre);
  let target = centre, face = under;
  for (let k = 1; k < 200 && face === null; k++) {   // the middle may be a hole
    target = [centre[0] + 14 * Math.sqrt(k) * Math.cos(2.4 * k), centre[1] + 14 * Math.sqrt(k) * Math.sin(2.4 * k)];
    face = await page.evaluate(([x, y]) => quadloomMap.pick(x, y), target);
  }
  check(faces.includes(face), `the surface shows face ${face}`);
  await page.mouse.move(...target);
  check((await lit(page)).join() === [face, face, null].join(), 'the pointer on the surface lights the face in both pictures');
  check((await status(page)).includes(`face ${face}`), `the status line says: ${await status(page)}`);
  check(await picture(page, 'hover') !== first, 'the surface changes where it is lit');
  await page.mouse.move(4, centre[1]);
  check((await lit(page)).every(f => f === null), 'beside the surface no face is lit');
  await page.mouse.click(...target);
  check((await lit(page)).join() === [face, face, face].join(), 'a click keeps the face');
  await page.mouse.move(4, centre[1]);
  check((await lit(page)).join() === [face, face, face].join(), 'it stays lit when the pointer leaves');
  await page.keyboard.press('Escape');
  check((await lit(page)).every(f => f === null), 'Escape lets it go');
  check(await picture(page, 'released') === first, 'and the picture is as before');
  // 3. From the flat picture to the surface, and to a face behind.
  for (const other of faces.slice(0, 6)) {
    const place = await placeInFlat(page, other);
    if (!place) continue;
    await page.mouse.move(...place);
    check((await lit(page)).join() === [other, other, null].join(), `the pointer on the flat picture lights face ${other} in both`);
  }
  await page.mouse.move(4, centre[1]);
  let behind = null, place = null;   // pieces of faces at the rim may be smaller than a pixel
  for (const other of [...faces].reverse()) if ((place = await placeInFlat(page, behind = other))) break;
  check(place !== null, `face ${behind} has a place in the flat picture`);
  await page.mouse.click(...place);
  check((await lit(page)).join() === [behind, behind, behind].join(), `a click on the flat picture keeps face ${behind}`);
  check(await picture(page, 'kept') !== first && await page.locator('#flat .halo').count() >= 1, 'it has an outline');
  await page.keyboard.press('Escape');
  // 4. Keys and tools choose faces.
  await page.keyboard.press('n');
  check((await lit(page))[0] === faces[0], 'N goes to the first face');
  await page.locator('#next').click();
  check((await lit(page))[0] === faces[1], 'the button goes to the next one');
  await page.keyboard.press('p');
  check((await lit(page))[0] === faces[0], 'P goes back');
  await page.locator('#number').fill(String(faces.at(-1)));
  await page.locator('#number').press('Enter');
  check((await lit(page)).join() === Array(3).fill(faces.at(-1)).join(), 'a number goes to its face');
  await page.keyboard.press('Escape');
  await page.mouse.move(4, centre[1]);
  await page.keyboard.press('r');
  await page.waitForTimeout(500);
  check(await picture(page, 'home') === first, 'R returns home');
  // 5. Turning, zooming, the turntable.
  await page.mouse.move(...centre);
  await page.mouse.down();
  await page.mouse.move(centre[0] + 120, centre[1] + 40, { steps: 4 });
  await page.mouse.up();
  check((await lit(page))[2] === null, 'a drag keeps no face');
  await page.mouse.move(4, centre[1]);
  const turned = await picture(page, 'turned');
  check(turned !== first, 'dragging turns');
  await page.mouse.move(...centre);
  await page.mouse.wheel(0, -300);
  await page.mouse.move(4, centre[1]);
  const zoomed = await picture(page, 'zoomed');
  check(zoomed !== turned, 'the wheel zooms');
  await page.keyboard.press('ArrowLeft');
  check(await picture(page, 'arrow') !== zoomed, 'arrows turn');
  const pose = () => page.evaluate(() => quadloomMap.camera.rotation.join());
  const still = await pose();
  await page.keyboard.press(' ');
  await page.waitForTimeout(900);
  const [one, turning] = [await pose(), await page.getAttribute('#tool-turntable', 'aria-pressed')];
  check(one !== still && turning === 'true' && await page.evaluate(() => quadloomMap.turning()), 'space starts the turntable');
  await page.locator('#tool-turntable').click();
  const stopped = await pose();
  const after = await picture(page, 'turntable');
  check(stopped !== one && after !== zoomed, 'the turntable changes the picture');
  await page.waitForTimeout(300);
  check(await pose() === stopped && await page.getAttribute('#tool-turntable', 'aria-pressed') === 'false', 'the button stops it');
  // 6. The flat picture moves and zooms too.
  const frame = () => page.getAttribute('#flat > svg', 'viewBox'), whole = await frame(), flat = await middleOf(page, '#flat');
  await page.mouse.move(...flat);
  await page.mouse.wheel(0, -300);
  const closer = await frame();
  check(closer !== whole, 'the wheel zooms the flat picture');
  await page.mouse.down();
  await page.mouse.move(flat[0] + 60, flat[1] + 20, { steps: 3 });
  await page.mouse.up();
  check(await frame() !== closer && (await lit(page))[2] === null, 'dragging moves it, and keeps no face');
  await page.mouse.dblclick(...flat);
  check(await frame() === whole, 'a double-click shows all of it');
  await page.keyboard.press('Escape');
  // 7. Themes, and a phone.
  await page.keyboard.press('t');
  check(await page.evaluate(() => document.documentElement.dataset.theme) === 'dark' && await picture(page, 'dark') !== after, 'T: dark');
  await page.setViewportSize({ width: 420, height: 860 });
  await picture(page, 'phone');
  check(await page.evaluate(() => document.documentElement.scrollWidth - innerWidth) <= 0, 'nothing sticks out on a narrow screen');
  await page.close();
  const dark = await open(file, { colorScheme: 'dark' });
  check(await dark.evaluate(() => document.documentElement.dataset.theme) === 'dark', 'who prefers dark gets dark');
  await dark.close();
}

// Flat pictures that are missing, broken or hostile, and texts that look like tags.
async function checkOdd() {
  const alone = await open(changed('alone.html', scene => { scene.flat = ''; }));
  check(!await alone.locator('#flat').isVisible() && await alone.locator('#facts').isVisible(), 'without a flat picture the surface is alone');
  await picture(alone, 'alone');
  await alone.keyboard.press('n');
  const [face, none] = await lit(alone);
  check(face !== null && none === null, 'faces are lit there too');
  await alone.close();
  const broken = await open(changed('broken.html', scene => { scene.flat = '<svg><g data-face="1"></svg>'; scene.left_out = 3; }));
  check(!await broken.locator('#flat').isVisible() && /not well-formed.*3 of/.test(await broken.textContent('#remark')), 'the page tells of a broken flat picture and of triangles left out');
  await broken.close();
  const hostile = await open(changed('hostile.html', scene => {
    scene.title = '<b>title</b>';
    scene.facts = [['<i>name</i>', '<img src=x onerror=alert(1)>']];
    scene.flat = '<svg viewBox="0 0 9 9" onload="alert(2)"><script>alert(3)</script><foreignObject><p xmlns="http://www.w3.org/1999/xhtml">x</p></foreignObject>'
      + '<a href="javascript:alert(4)"><rect width="1" height="1"/></a><image href="https://example.org/x.png"/><g transform="translate(2 2)"><g data-face="1" onclick="alert(5)"><rect width="3" height="3" fill="red"/></g></g><g data-face="x"/></svg>';
  }));
  check(await hostile.locator('#flat script, #flat foreignObject, #flat a, #flat image, #flat p, #facts img, #facts i, h1 b').count() === 0, 'nothing but drawing is taken over, and texts stay texts');
  await hostile.mouse.click(...await placeInFlat(hostile, 1));
  check((await lit(hostile)).join() === '1,1,1', 'and its faces can be chosen');
  const [copy, own] = await hostile.evaluate(() => ['.halo rect', '.lit rect'].map(s => { const b = document.querySelector(`#flat ${s}`).getBoundingClientRect(); return [b.x, b.y, b.width].join(); }));
  check(copy === own, 'the outline is where the face is');
  await hostile.close();
}

try {
  await checkPage();
  await checkOdd();
  check(complaints.length === 0, `no error in the console${complaints.length ? `: ${complaints[0]}` : ''}`);
  const outside = requests.filter(url => !url.startsWith('file:') || !url.endsWith('.html'));
  check(outside.length === 0, `no request but the pages themselves${outside.length ? `: ${outside[0]}` : ''}`);
} finally {
  await browser.close();
}
console.log(`${checks - failures} of ${checks} checks hold`);
process.exit(failures ? 1 : 0);
