// check.mjs SITE PLAYWRIGHT CHROMIUM: the gallery as a reader's browser has it: nothing is wrong, nothing comes from a
// network, everything is there at any width, and the tree viewer draws what its JSON says. Prints `ok gallery-NAME` or
// `FAILED gallery-NAME: why` for each rule.
import { readFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [site, playwright, executablePath] = process.argv.slice(2);
const { chromium } = await import(pathToFileURL(resolve(playwright, 'index.mjs')));
const page_url = pathToFileURL(resolve(site, 'index.html')).href;
const SWITCHES = ['--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync', '--use-gl=angle',
    '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
const scenes = ['knot', 'city', 'terrain', 'crowd'];
const browser = await chromium.launch({ executablePath, args: SWITCHES });
let bad = 0;

async function rule(name, check) {
    try {
        const count = await check();
        console.log(`ok gallery-${name}${count ? `\n    ${count}` : ''}`);
    } catch (error) {
        bad = 1;
        console.log(`FAILED gallery-${name}: ${error.message.split('\n')[0]}`);
    }
}

function demand(truth, why) {
    if (!truth) throw new Error(why);
}

// A page of its own; page.wrong collects what a reader would find in the browser's console.
async function open(options, script) {
    const context = await browser.newContext({ viewport: { width: 1200, height: 900 }, reducedMotion: 'reduce', ...options });
    const page = await context.newPage();
    page.wrong = [];
    page.on('console', (message) => message.type() === 'error' && page.wrong.push(message.text()));
    page.on('pageerror', (error) => page.wrong.push(error.message));
    page.on('request', (request) => /^(file|data|blob):/.test(request.url()) || page.wrong.push(`asks for ${request.url()}`));
    page.on('requestfailed', (request) => page.wrong.push(`${request.url()} failed`));
    if (script) await page.addInitScript(script);
    await page.goto(page_url);
    await page.waitForSelector('#viewer.ready, #viewer.failed', { timeout: 30000 });
    return page;
}

const probe = (page) => page.evaluate(() => window.htreeViewer.draw.probe());

async function slide(page, level) {
    await page.locator('#level').fill(String(level));
}

// ---- The page ------------------------------------------------------------------------------------------

// Lazy pictures come when they are scrolled to.
async function see_all(page) {
    await page.evaluate(async () => {
        for (const image of document.images) {
            image.scrollIntoView();
            await image.decode().catch(() => {});
        }
        window.scrollTo(0, 0);
    });
}

async function images_load(page) {
    await see_all(page);
    const images = await page.evaluate(() =>
        [...document.images].map(({ src, alt, naturalWidth }) => ({ src, alt, naturalWidth })));
    demand(images.length >= 25, `only ${images.length} images`);
    for (const { src, alt, naturalWidth } of images) {
        demand(naturalWidth > 0, `${src} does not load`);
        demand(alt.length > 10, `${src} has no words for those who do not see it`);
    }
    return `${images.length} images`;
}

async function fits(page) {
    await see_all(page);
    const [wide, width, culprit] = await page.evaluate(() => {
        const width = document.documentElement.clientWidth;
        const over = [...document.body.querySelectorAll('*')].find((e) => e.getBoundingClientRect().right > width + 1);
        return [document.documentElement.scrollWidth, width, over?.outerHTML.slice(0, 80)];
    });
    demand(wide <= width && !culprit, `${wide} pixels on a screen of ${width}: ${culprit}`);
}

// ---- The tree viewer -----------------------------------------------------------------------------------

async function draws(page) {
    const { drawn, width, height } = await probe(page);
    demand(drawn > 0.02 * width * height, `${drawn} of ${width * height} pixels are drawn`);
    demand(drawn < 0.95 * width * height, 'no background is left');
}

async function changes(page, what, act) {
    const before = await probe(page);
    await act();
    const after = await probe(page);
    demand(before.sum !== after.sum, `${what} changes nothing`);
}

async function controls_work(page) {
    await slide(page, 4);
    await changes(page, 'the slider', () => slide(page, 6));
    await changes(page, 'this level alone', () => page.locator('#only').check());
    await changes(page, 'the tick at triangles', () => page.locator('#mesh').uncheck());
    await changes(page, 'a row of the legend', () => page.locator('#legend [data-type=skd]').click());
    await changes(page, 'another tree', () => page.locator('#kind').selectOption('bvh-sah'));
    await changes(page, 'another scene', async () => {
        await page.locator('#scene').selectOption('city');
        await page.waitForFunction(() => window.htreeViewer.shown.scene === 'city');
    });
}

async function turns_by_mouse(page) {
    const { x, y, width, height } = await page.locator('#canvas').boundingBox();
    await changes(page, 'dragging', async () => {
        await page.mouse.move(x + width / 2, y + height / 2);
        await page.mouse.down();
        await page.mouse.move(x + width / 2 + 60, y + height / 2 + 20, { steps: 4 });
        await page.mouse.up();
    });
}

async function turns_by_finger(page) {
    await page.locator('#canvas').scrollIntoViewIfNeeded();
    const { x, y, width, height } = await page.locator('#canvas').boundingBox();
    const session = await page.context().newCDPSession(page);
    const touch = (type, dx) => session.send('Input.dispatchTouchEvent', {
        type, touchPoints: type === 'touchEnd' ? [] : [{ x: x + width / 2 + dx, y: y + height / 2 }] });
    await changes(page, 'a finger', async () => {
        await touch('touchStart', 0);
        for (let dx = 10; dx <= 60; dx += 10) await touch('touchMove', dx);
        await touch('touchEnd', 0);
    });
}

// What the legend says, against the JSON that htree-nodes wrote.
async function legend_is(page, nodes, level, only) {
    const said = await page.evaluate(() => Object.fromEntries(
        [...document.querySelectorAll('#legend button')].map((row) => [row.dataset.type, row.querySelector('b').textContent])));
    const shown = (l) => (only ? l === level : l <= level);
    for (const [type, { level: levels, box }] of Object.entries(nodes)) {
        const right = `${levels.filter(shown).length} of ${levels.length}`;
        demand(box.length === 6 * levels.length, `${type}: ${box.length} planes for ${levels.length} nodes`);
        demand(said[type]?.replace(/,/g, '') === right, `${type} at level ${level}: ${said[type]}, not ${right}`);
    }
    demand(Object.keys(said).length === Object.keys(nodes).length, `the legend has ${Object.keys(said)}`);
}

async function counts_match(page) {
    let compared = 0;
    for (const scene of scenes) {
        const json = JSON.parse(readFileSync(join(site, 'trees', `${scene}.json`)));
        demand(json.positions.length === 9 * json.triangles, `${scene}: ${json.positions.length} coordinates`);
        await page.locator('#scene').selectOption(scene);
        await page.waitForFunction((name) => window.htreeViewer.shown.scene === name, scene);
        for (const { kind, levels, nodes } of json.trees) {
            await page.locator('#kind').selectOption(kind);
            for (const only of levels > 1 ? [false, true] : [false]) {
                await page.locator('#only').setChecked(only);
                for (const level of new Set([0, levels >> 1, levels - 1])) {
                    if (levels > 1) await slide(page, level);
                    await legend_is(page, nodes, level, only);
                    ++compared;
                }
            }
        }
    }
    return `${compared} legends`;
}

// ---- All -----------------------------------------------------------------------------------------------

const desk = await open({});
await rule('images-load', () => images_load(desk));
await rule('fits-desktop', () => fits(desk));
await rule('draws', () => draws(desk));
await rule('controls-work', () => controls_work(desk));
await rule('turns-by-mouse', () => turns_by_mouse(desk));
await rule('counts-match', () => counts_match(desk));

const phone = await open({ viewport: { width: 360, height: 740 }, hasTouch: true, isMobile: true, colorScheme: 'dark' });
await rule('fits-phone', () => fits(phone));
await rule('draws-on-phone', () => draws(phone));
await rule('turns-by-finger', () => turns_by_finger(phone));
await rule('is-dark', async () => {
    const paper = (page) => page.evaluate(() => getComputedStyle(document.body).backgroundColor.match(/\d+/g).map(Number));
    demand(Math.max(...await paper(phone)) < 64 && Math.min(...await paper(desk)) > 192, 'one paper for day and night');
});

const blind = await open({}, () => {
    HTMLCanvasElement.prototype.getContext = () => null;
});
await rule('says-sorry', async () => {
    demand((await blind.locator('#sorry').textContent()).includes('WebGL'), 'nothing is said where there is no WebGL');
});
await rule('no-errors', () => {
    const wrong = [desk, phone, blind].flatMap((page) => page.wrong);
    demand(!wrong.length, wrong.join('; '));
});
await browser.close();
process.exit(bad);
