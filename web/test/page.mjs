// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Tests the page in headless Chromium: page.mjs PAGE NATIVE SCREENSHOTS IMAGE...
//
// PAGE is the folder of the page. NATIVE has what the native aqorb_fingerprint printed: ranked.txt and quadtree.txt of
// its scenes, and after them of the first image; IMAGE.txt for each of the other images. Screenshots of every view are
// left in the folder SCREENSHOTS.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import http from 'node:http';
import { createRequire } from 'node:module';
import path from 'node:path';
import test, { after, before } from 'node:test';

const require = createRequire(path.join(process.env.PLAYWRIGHT || '.', 'package.json'));
const { chromium } = require('playwright-core');
const [page, native, screenshots, ...images] = process.argv.slice(2).map(name => path.resolve(name));
const TYPES = {
    '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.svg': 'image/svg+xml',
    '.wasm': 'application/wasm', '.txt': 'text/plain', '.jpg': 'image/jpeg', '.png': 'image/png',
};
const DESKTOP = { width: 1280, height: 900 }, PHONE = { width: 360, height: 740 };

let server, browser, address;
let held = null;  // a promise for which aqorb.wasm waits

before(async () => {
    fs.mkdirSync(screenshots, { recursive: true });
    server = http.createServer(async (request, response) => {
        const file = path.join(page, new URL(request.url, 'http://x').pathname.replace(/\/$/, '/index.html'));
        if (!file.startsWith(page) || !fs.existsSync(file)) {
            response.writeHead(404).end();
            return;
        }
        if (file.endsWith('.wasm'))
            await held;
        response.writeHead(200, { 'Content-Type': TYPES[path.extname(file)] });
        fs.createReadStream(file).pipe(response);
    });
    await new Promise(resolve => server.listen(0, '127.0.0.1', resolve));
    address = `http://127.0.0.1:${server.address().port}/`;
    const root = process.getuid() === 0 ? ['--no-sandbox'] : [];
    browser = await chromium.launch({
        executablePath: process.env.CHROMIUM || '/usr/bin/chromium',
        args: [...root, '--use-fake-device-for-media-stream', '--disable-gpu'],
    });
});

after(async () => {
    await browser?.close();
    server?.close();
});

// The page in a context of its own. `link` is what follows its address. What it writes to the console, and what it fails
// to load or sends, is a problem that `close` reports.
async function open(options = {}, prepare = null, link = '') {
    const context = await browser.newContext({ viewport: DESKTOP, ...options });
    const tab = await context.newPage();
    tab.setDefaultTimeout(120000);
    const problems = [];
    tab.on('console', message => {
        if (['error', 'warning'].includes(message.type()))
            problems.push(message.text());
    });
    tab.on('pageerror', error => problems.push(String(error)));
    tab.on('requestfailed', request => problems.push(`${request.url()} failed`));
    tab.on('response', response => response.ok() || problems.push(`${response.url()}: ${response.status()}`));
    tab.on('request', request => {
        if (!/^(http:\/\/127\.0\.0\.1|blob:|data:)/.test(request.url()) || request.method() !== 'GET')
            problems.push(`${request.url()} is of the network, or is sent something`);
    });
    if (prepare)
        await tab.addInitScript(prepare);
    await tab.goto(address + link);
    await tab.waitForFunction(() => ['ready', 'failed'].includes(document.body.dataset.state));
    return { tab, close: async () => {
        assert.deepEqual(problems, []);
        await context.close();
    } };
}

const idle = tab => tab.waitForFunction(() => document.body.dataset.state === 'ready');

// The cells of a row of the table, as numbers.
const measured = (tab, name) => tab.evaluate(name => [...document.querySelectorAll('#measures tr')]
    .filter(row => row.cells[0].firstChild.textContent === name)
    .flatMap(row => [...row.cells].slice(1).map(cell => parseFloat(cell.textContent))), name);

// What a canvas shows, as text.
const drawn = (tab, which = 1) => tab.evaluate(which => document.querySelectorAll('#figures canvas')[which].toDataURL(),
    which);

// Sets a slider, and waits for what it changes.
async function setSlider(tab, id, value) {
    await tab.locator(`#${id}`).fill(String(value));
    await idle(tab);
}

const shoot = (tab, name, options = {}) => tab.screenshot({ path: path.join(screenshots, `${name}.png`), ...options });

// Opens a file by its button.
async function openFile(tab, button, list, file) {
    await tab.locator(`#${button}`).setInputFiles(file);
    await tab.waitForFunction(list => element(list).value === '', list);
    await idle(tab);
}

async function choose(tab, view) {
    await tab.locator(`[name=view][value=${view}]`).check({ force: true });
    await idle(tab);
}

async function assertFits(tab) {
    const { wide, inner, name } = await tab.evaluate(() => {
        const inner = document.documentElement.clientWidth;
        const over = [...document.body.querySelectorAll('*')].find(e => e.getBoundingClientRect().right > inner + .5 &&
            getComputedStyle(e).position !== 'absolute' && !e.parentElement.closest('.large .frame'));  // which scrolls
        return { wide: document.documentElement.scrollWidth, inner, name: over && over.outerHTML.slice(0, 80) };
    });
    assert.ok(wide <= inner && !name, `${wide} > ${inner} pixels: ${name}`);
}

function drop(tab, name, type, bytes, target = 'body') {
    return tab.evaluate(([name, type, bytes, target]) => {
        const transfer = new DataTransfer();
        transfer.items.add(new File([Uint8Array.from(atob(bytes), c => c.charCodeAt(0))], name, { type }));
        for (const event of ['dragover', 'drop']) {
            document.querySelector(target).dispatchEvent(
                new DragEvent(event, { dataTransfer: transfer, bubbles: true, cancelable: true }));
        }
    }, [name, type, bytes.toString('base64'), target]);
}

const fingerprint = (tab, quadtree, name) => tab.evaluate(([quadtree, name]) => new Promise((resolve, reject) => {
    const usual = worker.onmessage;
    worker.onmessage = ({ data }) => {
        worker.onmessage = usual;
        if (data.error)
            reject(new Error(data.error));
        else
            resolve(data.lines);
    };
    worker.postMessage({ fingerprint: true, quadtree, name });
}), [quadtree, name]);

// distributionUniformity takes the logarithm of the C library, whose last bit may be another one in WebAssembly.
const withoutMeasures = text => text.trim().replace(/ measures \w+/g, '').split('\n');
const linesOf = file => withoutMeasures(fs.readFileSync(path.join(native, file), 'utf8'));

test('each sample is shown at once by both detectors, and has its licence', async () => {
    const { tab, close } = await open();
    assert.deepEqual(await measured(tab, 'Keypoints'), [500, 500]);
    const [orb, ours] = await measured(tab, 'Occupied cells');
    assert.ok(ours > orb && orb > 0);
    assert.ok((await measured(tab, 'Time')).every(time => time > 0));
    assert.ok(await drawn(tab, 0) !== await drawn(tab, 1));
    await assertFits(tab);
    const licenses = await tab.evaluate(() => fetch('photographs/licenses.txt').then(response => response.text()));
    const samples = await tab.locator('#sample option:not([hidden])').evaluateAll(
        all => all.map(({ value, dataset }) => [value, dataset.file || value]));
    for (const [sample, file] of samples) {
        await tab.locator('#sample').selectOption(sample);
        await idle(tab);
        assert.equal((await measured(tab, 'Keypoints'))[1], 500, sample);
        assert.match(licenses, new RegExp(`^${file}.jpg .*(CC0|public domain),`, 'm'));
        await shoot(tab, `sample-${sample}`);
    }
    await close();
});

test('the page says that it loads while it loads', async () => {
    let release;
    held = new Promise(resolve => { release = resolve; });
    const tab = await browser.newPage({ viewport: DESKTOP });
    await tab.goto(address);
    assert.match(await tab.locator('#loading:visible').textContent(), /^Loading the detectors/);
    await tab.waitForTimeout(300);
    assert.ok(await tab.locator('#loading').isVisible());
    await shoot(tab, 'loading');
    release();
    await idle(tab);
    assert.ok(await tab.locator('#loading').isHidden());
    await tab.close();
});

test('the bytes are those of the native library, of scenes and of pictures that the browser decodes', async () => {
    const { tab, close } = await open();
    for (const image of images) {
        await tab.locator('#sample').selectOption('brick');  // so that the next picture is another one
        await idle(tab);
        await openFile(tab, 'file', 'sample', image);
        const expected = linesOf(image === images[0] ? 'ranked.txt' : `${image.replaceAll('/', '_')}.txt`);
        assert.equal(expected.length, 62);
        assert.deepEqual(withoutMeasures(await fingerprint(tab, false, 'image')),
            expected.map(line => line.replace(image, 'image')));
    }
    await close();
});

test('sliders change the keypoints, and Defaults changes them back', async () => {
    const { tab, close } = await open();
    const before = await drawn(tab);
    const moved = await tab.evaluate(() => [...document.querySelectorAll('#properties input[type=range]')]
        .filter(slider => Number(slider.getAttribute('value')) !== Number(slider.value)).map(slider => slider.id));
    assert.deepEqual(moved, [], 'these cannot stand at their defaults');
    await setSlider(tab, 'nfeatures', 1500);
    assert.equal((await measured(tab, 'Keypoints'))[1], 1500);
    assert.equal(await tab.locator('output[for=nfeatures]').textContent(), '1500');
    for (const [id, value] of [['strengthWeight', 9], ['rankRadius', 3], ['fastThreshold', 55], ['nlevels', 3],
        ['scaleFactor', 1.6], ['minThresholdRatio', 1]]) {
        const last = await drawn(tab);
        await setSlider(tab, id, value);
        assert.ok(await drawn(tab) !== last, id);
    }
    await tab.locator('#adaptiveThreshold').uncheck();
    await tab.locator('button[type=reset]').click();
    await tab.waitForTimeout(50);
    await idle(tab);
    assert.ok(await drawn(tab) === before);
    await close();
});

test('a slider that moves all the time leaves no queue behind', async () => {
    const { tab, close } = await open();
    await tab.evaluate(() => {
        window.answers = 0;
        worker.addEventListener('message', () => window.answers++);
        for (let n = 100; n <= 3000; n += 50) {
            element('nfeatures').value = n;
            element('nfeatures').dispatchEvent(new Event('input', { bubbles: true }));
        }
    });
    await idle(tab);
    assert.ok(await tab.evaluate(() => window.answers) <= 2);
    assert.equal((await measured(tab, 'Keypoints'))[1], 3000);
    await close();
});

test('a picture can be dropped, and a file that is none gets a sentence', async () => {
    const { tab, close } = await open();
    const before = await drawn(tab);
    await drop(tab, 'notes.txt', 'text/plain', Buffer.from('no picture'));
    await tab.waitForSelector('#message:not([hidden])');
    assert.match(await tab.locator('#message').textContent(), /^“notes.txt” is not a picture .*\.$/);
    assert.ok(await drawn(tab) === before);
    await shoot(tab, 'no-picture');
    await drop(tab, 'picture.png', 'image/png', fs.readFileSync(images[0]));
    await tab.waitForFunction(() => element('sample').value === '');
    await idle(tab);
    assert.ok(await tab.locator('#message').isHidden());
    assert.ok(await drawn(tab) !== before);
    await close();
});

test('it is known which matches of a simulated picture are correct', async () => {
    const { tab, close } = await open({ viewport: { width: 1400, height: 900 } });
    await choose(tab, 'pair');
    for (const view of ['side', 'far', 'night']) {
        await tab.locator('#other').selectOption(view);
        await idle(tab);
        for (const name of ['Distinct correct matches', 'Places']) {
            const [orb, ours] = await measured(tab, name);
            assert.ok(ours > orb && orb > 10, `${view}: ${name} ${orb}, ${ours}`);
        }
        await shoot(tab, `pair-${view}`);
    }
    const [coarse] = await measured(tab, 'Error');
    await tab.locator('#refine').check();
    await idle(tab);
    const [exact] = await measured(tab, 'Error');
    assert.ok(exact < coarse, `${exact}, ${coarse} pixels`);
    await shoot(tab, 'pair-refined');
    const before = await drawn(tab);
    await tab.locator('#lines').uncheck();
    assert.ok(await drawn(tab) !== before);
    await close();
});

test('pictures of different things have no homography, and a sample is matched with the simulated one again', async () => {
    const { tab, close } = await open({}, null, '#view=pair');
    const simulated = await measured(tab, 'Distinct correct matches');
    await openFile(tab, 'second', 'other', images[0]);
    assert.match(await tab.locator('#measures').textContent(), /none found/);
    assert.match(await tab.locator('#advice').textContent(), /Try more features, or a\s+larger strength weight/);
    await openFile(tab, 'file', 'sample', images[0]);
    assert.ok((await measured(tab, 'Distinct correct matches')).every(count => count > 100));  // a picture with itself
    await tab.locator('#sample').selectOption('coffee');
    await tab.waitForFunction(() => element('other').value === 'side');
    await idle(tab);
    assert.deepEqual(await measured(tab, 'Distinct correct matches'), simulated);
    assert.ok(await tab.locator('#advice').isHidden());
    await close();
});

test('a link opens what was shown, and names only what is not the default', async () => {
    const { tab, close } = await open({ permissions: ['clipboard-read', 'clipboard-write'] }, null,
        '#sample=rocket&view=pair&second=far&nfeatures=800&strengthWeight=0.5&adaptiveThreshold=0&lines=0');
    await tab.locator('#copy').click();
    await tab.waitForFunction(() => /^The link is copied/.test(element('copied').textContent));
    const link = await tab.evaluate(() => navigator.clipboard.readText());
    assert.equal(link, `${address}#sample=rocket&view=pair&second=far&nfeatures=800&strengthWeight=0.5&` +
        'adaptiveThreshold=0&lines=0');
    assert.equal(await tab.locator('#link').inputValue(), link);
    // Another link in the same tab changes back what it does not name, and what it cannot show.
    await tab.evaluate(() => { location.hash = '#sample=nothing&nfeatures=nonsense&rankRadius=99'; });
    await tab.waitForSelector('#message:not([hidden])');
    await idle(tab);
    assert.match(await tab.locator('#message').textContent(), /^There is no sample “nothing” here\.$/);
    const fields = ['sample', 'nfeatures', 'rankRadius', 'other'];
    assert.deepEqual(await tab.evaluate(ids => ids.map(id => element(id).value), fields), ['coffee', '500', '4', 'side']);
    assert.ok(await tab.locator('#adaptiveThreshold').isChecked());
    await close();
});

test('a click enlarges both pictures, and another one brings them back', async () => {
    const { tab, close } = await open();
    const widths = () => tab.locator('#figures canvas').evaluateAll(all => all.map(canvas => canvas.clientWidth));
    const [before] = await widths();
    await tab.locator('#figures canvas').first().click();
    assert.deepEqual(await widths(), [3 * before, 3 * before]);
    await tab.locator('.frame').first().evaluate(frame => frame.scrollTo(40, 30));
    await tab.waitForFunction(() => document.querySelectorAll('.frame')[1].scrollLeft === 40);
    await assertFits(tab);
    await shoot(tab, 'large');
    await tab.locator('#large').uncheck();
    assert.deepEqual(await widths(), [before, before]);
    await close();
});

test('the camera shows one frame after the other until it is stopped, and a refusal gets a sentence', async () => {
    const refused = await open();
    await refused.tab.locator('#camera').click();
    await refused.tab.waitForSelector('#message:not([hidden])');
    assert.match(await refused.tab.locator('#message').textContent(), /^The camera was refused\. .*\.$/);
    await refused.close();
    const { tab, close } = await open({ permissions: ['camera'] });
    await tab.locator('#camera').click();
    await tab.waitForFunction(() => /640×480/.test(element('size').textContent));
    const before = await drawn(tab);
    await tab.waitForTimeout(1500);
    assert.ok(await drawn(tab) !== before);
    await tab.locator('#camera').click();
    await idle(tab);
    const last = await drawn(tab);
    await tab.waitForTimeout(500);
    assert.ok(await drawn(tab) === last);
    await close();
});

test('a browser without SIMD gets a sentence', async () => {
    const { tab, close } = await open({}, () => { WebAssembly.validate = () => false; });
    assert.match(await tab.locator('#message').textContent(), /does not run WebAssembly with SIMD.*\.$/);
    assert.ok(await tab.locator('#nfeatures').isDisabled());
    await close();
});

for (const colorScheme of ['light', 'dark']) {
    test(`the page fits a phone, ${colorScheme}`, async () => {
        const { tab, close } = await open({
            viewport: PHONE, deviceScaleFactor: 2, isMobile: true, hasTouch: true, colorScheme });
        for (const view of ['keypoints', 'pair']) {
            await choose(tab, view);
            await assertFits(tab);
            await shoot(tab, `phone-${colorScheme}-${view}`, { fullPage: true });
        }
        const low = await tab.evaluate(() => [...document.querySelectorAll('button, .button, select, #views label, .check')]
            .filter(e => e.offsetParent && e.getBoundingClientRect().height < 44).map(e => e.outerHTML));
        assert.deepEqual(low, [], 'a finger needs 44 pixels');
        await close();
    });
}

test('on a phone the pictures stay in sight above every slider', async () => {
    const { tab, close } = await open({
        viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true },
    null, '#sample=camera&view=pair');
    await assertFits(tab);
    const sliders = await tab.locator('input[type=range]').evaluateAll(all => all.filter(e => e.offsetParent).map(e => e.id));
    assert.ok(sliders.length >= 6);
    for (const id of sliders) {
        const [top, bottom, slider, isOnTop] = await tab.evaluate(id => {
            scrollBy(0, element(id).getBoundingClientRect().top - 700);
            const figures = element('figures').getBoundingClientRect(), { left, top, width, height } = element(id)
                .getBoundingClientRect();
            return [figures.top, figures.bottom, top, document.elementFromPoint(left + width / 2, top + height / 2) ===
                element(id)];
        }, id);
        assert.ok(top >= 0 && bottom > 200 && bottom < slider && isOnTop, `${id}: ${top} ${bottom} ${slider} ${isOnTop}`);
    }
    await shoot(tab, 'phone-390-slider');
    await tab.evaluate(() => scrollTo(0, 0));
    await shoot(tab, 'phone-390-pair', { fullPage: true });
    await close();
});

test('the keyboard alone reaches every control, and the focus is visible', async () => {
    const { tab, close } = await open({}, null, '#view=pair');
    const controls = await tab.evaluate(() => [...document.querySelectorAll('input, select, button')]
        .filter(e => e.offsetParent && (e.type !== 'radio' || e.checked)).map(e => e.id || e.value || e.type));
    const order = new Set();
    for (let i = 0; i < controls.length + 5; i++) {
        await tab.keyboard.press('Tab');
        const { id, isVisible } = await tab.evaluate(() => {
            const e = document.activeElement;
            const { outlineStyle, outlineWidth } = getComputedStyle(
                e.matches('.button input, #views input') ? e.nextElementSibling : e);
            return { id: e.id || e.value || e.type, isVisible: outlineStyle !== 'none' && parseFloat(outlineWidth) >= 2 };
        });
        assert.ok(isVisible || !controls.includes(id), `the focus of ${id}`);
        order.add(id);
    }
    assert.deepEqual(controls.filter(id => !order.has(id)), []);
    const before = await drawn(tab);
    await tab.locator('#nfeatures').press('ArrowRight');
    await idle(tab);
    assert.ok(await drawn(tab) !== before);
    await close();
});
