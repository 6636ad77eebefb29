// Saves the picture of a page of the viewer, without its panel: how the pictures of the documents are made.
//
//     node tests/viewer/picture.mjs page.html picture.png [options of the address, as in preset=ridges&yaw=40]
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { fullyDrawn, launch } from './browser.mjs';

const [page_file, picture, options = ''] = process.argv.slice(2);
const browser = await launch();
try {
  const page = await browser.newPage({ viewport: { width: 900, height: 640 } });
  await page.goto(`${pathToFileURL(resolve(page_file)).href}#panel=off&${options}`);
  await page.addStyleTag({ content: '#tools, #status { display: none }' });
  await fullyDrawn(page);
  await page.screenshot({ path: resolve(picture) });
} finally {
  await browser.close();
}
