// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Tests the page in headless Chromium: page.mjs PAGE NATIVE SCREENSHOTS IMAGE...
//
// PAGE is the folder of the page. NATIVE has what the native aqorb_fingerprint printed: ranked.txt and balanced.txt of
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
let elsewhere, other;  // a server of pictures, and its address
let asked = [];        // what it was asked for

before(async () => {
    fs.mkdirSync(screenshots, { recursive: true });
    server = http.createServer((request, response) => {
        const file = path.join(page, new URL(request.url, 'http://x').pathname.replace(/\/$/, '/index.html'));
        if (!file.startsWith(page) || !fs.existsSync(file)) {
            response.writeHead(404).end();
            return;
        }
        response.writeHead(200, { 'Content-Type': TYPES[path.extname(file)] });
        fs.createReadStream(file).pipe(response);
    });
    await new Promise(resolve => server.listen(0, '127.0.0.1', resolve));
    address = `http://127.0.0.1:${server.address().port}/`;
    elsewhere = http.createServer((request, response) => {
        asked.push(request);
        if (request.url === '/none.png') {
            response.writeHead(404, { 'Access-Control-Allow-Origin': '*' }).end();
            return;
        }
        const allowed = request.url.startsWith('/open') ? { 'Access-Control-Allow-Origin': '*' } : {};
        response.writeHead(200, { 'Content-Type': 'image/png', ...allowed });
        response.end(request.url.endsWith('text.png') ? 'no picture' : fs.readFileSync(images[0]));
    });
    await new Promise(resolve => elsewhere.listen(0, '127.0.0.1', resolve));
    other = `http://127.0.0.1:${elsewhere.address().port}`;
    const root = process.getuid() === 0 ? ['--no-sandbox'] : [];
    browser = await chromium.launch({
        executablePath: process.env.CHROMIUM || '/usr/bin/chromium',
        args: [...root, '--use-fake-device-for-media-stream', '--disable-gpu'],
    });
});

after(async () => {
    await browser?.close();
    server?.close();
    elsewhere?.close();
});

// The page in a context of its own. What it writes to the console, and what it fails to load, is in `problems`. `link` is
// what follows its address.
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
        if (!/^(http:\/\/127\.0\.0\.1|blob:|data:)/.test(request.url()))
            problems.push(`${request.url()} is of the network`);
        if (request.method() !== 'GET')
            problems.push(`${request.url()} is sent something`);
    });
    if (prepare)
        await tab.addInitScript(prepare);
    await tab.goto(address + link);
    await tab.waitForFunction(() => ['ready', 'failed'].includes(document.body.dataset.state));
    return { tab, problems, close: () => context.close() };
}

const idle = tab => tab.waitForFunction(() => document.body.dataset.state === 'ready');

// The cells of a row of the table, as numbers.
const measured = (tab, name) => tab.evaluate(name => [...document.querySelectorAll('#measures tr')]
    .filter(row => row.cells[0].firstChild.textContent === name)
    .flatMap(row => [...row.cells].slice(1).map(cell => parseFloat(cell.textContent))), name);

// What a canvas shows, as text.
const drawn = (tab, which = 1) => tab.evaluate(which => document.querySelectorAll('#figures canvas')[which].toDataURL(),
    which);

const setSlider = (tab, id, value) => tab.locator(`#${id}`).fill(String(value));

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

const fingerprint = (tab, balanced, name) => tab.evaluate(([balanced, name]) => new Promise((resolve, reject) => {
    const usual = worker.onmessage;
    worker.onmessage = ({ data }) => {
        worker.onmessage = usual;
        if (data.error)
            reject(new Error(data.error));
        else
            resolve(data.lines);
    };
    worker.postMessage({ fingerprint: true, balanced, name });
}), [balanced, name]);

// distributionUniformity takes the logarithm of the C library, whose last bit may be another one in WebAssembly.
const withoutMeasures = text => text.trim().replace(/ measures \w+/g, '').split('\n');
const linesOf = file => withoutMeasures(fs.readFileSync(path.join(native, file), 'utf8'));

test('a sample is shown at once, by both detectors, without an error', async () => {
    const { tab, problems, close } = await open();
    assert.deepEqual(await measured(tab, 'Keypoints'), [500, 500]);
    const [orb, ours] = await measured(tab, 'Occupied cells');
    assert.ok(ours > orb && orb > 0);
    assert.ok((await measured(tab, 'Time')).every(time => time > 0));
    assert.ok(await drawn(tab, 0) !== await drawn(tab, 1));
    await assertFits(tab);
    await tab.screenshot({ path: path.join(screenshots, 'desktop-keypoints.png') });
    await tab.locator('#cells').check();
    await tab.screenshot({ path: path.join(screenshots, 'desktop-cells.png') });
    const list = await tab.locator('#sample option:not([hidden])').evaluateAll(all => all.map(option => option.value));
    for (const sample of list) {
        await tab.locator('#sample').selectOption(sample);
        await idle(tab);
        assert.equal((await measured(tab, 'Keypoints'))[1], 500, sample);
        await tab.screenshot({ path: path.join(screenshots, `sample-${sample}.png`) });
    }
    assert.deepEqual(problems, []);
    await close();
});

test('the photographs are small, and the page leads to the licence of each', async () => {
    const { tab, problems, close } = await open();
    const list = await tab.locator('#sample option:not([hidden])').evaluateAll(all => all.map(e => e.dataset.file || e.value));
    const folder = path.join(page, 'photographs');
    const files = fs.readdirSync(folder).filter(name => name.endsWith('.jpg'));
    assert.deepEqual(files, [...new Set(list)].map(name => `${name}.jpg`).sort());
    const bytes = files.reduce((sum, name) => sum + fs.statSync(path.join(folder, name)).size, 0);
    assert.ok(bytes < 400000, `${bytes} bytes`);
    const licenses = await tab.locator('footer a', { hasText: 'Their licences' }).evaluate(
        link => fetch(link.href).then(response => response.text()));
    for (const name of files)
        assert.match(licenses, new RegExp(`^${name} .*(CC0|public domain),`, 'm'));
    assert.deepEqual(problems, []);
    await close();
});

test('the bytes are those of the native library, of scenes and of pictures that the browser decodes', async () => {
    const { tab, problems, close } = await open();
    for (const image of images) {
        const isFirst = image === images[0];
        await tab.locator('#sample').selectOption('brick');  // so that the next picture is another one
        await idle(tab);
        await tab.locator('#file').setInputFiles(image);
        await tab.waitForFunction(() => element('sample').value === '');
        await idle(tab);
        const expected = linesOf(isFirst ? 'ranked.txt' : `${image.replaceAll('/', '_')}.txt`);
        assert.equal(expected.length, 62);
        const lines = withoutMeasures(await fingerprint(tab, false, 'image'));
        assert.deepEqual(lines.slice(0, 60), expected.slice(0, 60));
        assert.deepEqual(lines.slice(60), expected.slice(60).map(line => line.replace(image, 'image')));
        if (isFirst) {
            const balanced = withoutMeasures(await fingerprint(tab, true, ''));
            assert.deepEqual(balanced, linesOf('balanced.txt').slice(0, 60));
        }
    }
    assert.deepEqual(problems, []);
    await close();
});

test('sliders change the keypoints, and Defaults changes them back', async () => {
    const { tab, problems, close } = await open();
    const before = await drawn(tab);
    const moved = await tab.evaluate(() => [...document.querySelectorAll('#properties input[type=range]')]
        .filter(slider => Number(slider.getAttribute('value')) !== Number(slider.value)).map(slider => slider.id));
    assert.deepEqual(moved, [], 'these cannot stand at their defaults');
    await setSlider(tab, 'nfeatures', 1500);
    await idle(tab);
    assert.equal((await measured(tab, 'Keypoints'))[1], 1500);
    assert.equal(await tab.locator('output[for=nfeatures]').textContent(), '1500');
    const more = await drawn(tab);
    assert.ok(more !== before);
    for (const [id, value] of [['strengthWeight', 9], ['rankRadius', 3], ['fastThreshold', 55], ['nlevels', 3],
        ['scaleFactor', 1.6], ['minThresholdRatio', 1]]) {
        const last = await drawn(tab);
        await setSlider(tab, id, value);
        await idle(tab);
        assert.ok(await drawn(tab) !== last, id);
    }
    await tab.locator('#adaptiveThreshold').uncheck();
    await idle(tab);
    await tab.locator('#selectionType').selectOption('1');
    await idle(tab);
    await tab.locator('button[type=reset]').click();
    await tab.waitForTimeout(50);
    await idle(tab);
    assert.ok(await drawn(tab) === before);
    assert.deepEqual(problems, []);
    await close();
});

test('a slider that moves all the time leaves no queue behind', async () => {
    const { tab, problems, close } = await open();
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
    assert.deepEqual(problems, []);
    await close();
});

test('a picture can be dropped', async () => {
    const { tab, problems, close } = await open();
    const before = await drawn(tab);
    await drop(tab, 'picture.png', 'image/png', fs.readFileSync(images[0]));
    await tab.waitForFunction(() => element('sample').value === '');
    await idle(tab);
    assert.ok(await drawn(tab) !== before);
    assert.ok((await measured(tab, 'Keypoints'))[1] > 100);
    assert.match(await tab.locator('#size').textContent(), /\d+×\d+/);
    await tab.screenshot({ path: path.join(screenshots, 'desktop-dropped.png') });
    assert.deepEqual(problems, []);
    await close();
});

test('a file that is no picture gets a sentence, and the next picture works', async () => {
    const { tab, problems, close } = await open();
    const before = await drawn(tab);
    await drop(tab, 'notes.txt', 'text/plain', Buffer.from('no picture'));
    await tab.waitForSelector('#message:not([hidden])');
    assert.match(await tab.locator('#message').textContent(), /^“notes.txt” is not a picture .*\.$/);
    assert.ok(await drawn(tab) === before);
    await tab.screenshot({ path: path.join(screenshots, 'desktop-no-picture.png') });
    await tab.locator('#file').setInputFiles(images[0]);
    await tab.waitForFunction(() => element('sample').value === '');
    await idle(tab);
    assert.ok(await tab.locator('#message').isHidden());
    assert.deepEqual(problems, []);
    await close();
});

test('a turn shows what stays', async () => {
    const { tab, problems, close } = await open();
    await choose(tab, 'turn');
    assert.ok(await tab.locator('#degrees').isVisible());
    const [orb, ours] = await measured(tab, 'Found again');
    assert.ok(orb > 20 && orb < 100 && ours > 20 && ours < 100, `${orb} ${ours}`);
    await tab.screenshot({ path: path.join(screenshots, 'desktop-turn.png') });
    const before = await drawn(tab);
    await setSlider(tab, 'degrees', 0);
    await idle(tab);
    assert.ok((await measured(tab, 'Found again')).every(share => share >= 98));
    assert.ok(await drawn(tab) !== before);
    assert.deepEqual(problems, []);
    await close();
});

test('a paste opens a picture, or the address of one', async () => {
    const { tab, problems, close } = await open();
    const paste = (bytes, text) => tab.evaluate(([bytes, text]) => {
        const transfer = new DataTransfer();
        if (bytes)
            transfer.items.add(new File([Uint8Array.from(atob(bytes), c => c.charCodeAt(0))], 'a.png', { type: 'image/png' }));
        else
            transfer.setData('text/plain', text);
        document.body.dispatchEvent(new ClipboardEvent('paste', { clipboardData: transfer, bubbles: true }));
    }, [bytes && bytes.toString('base64'), text]);
    const sample = await drawn(tab);
    await paste(fs.readFileSync(images[0]));
    await tab.waitForFunction(() => element('sample').value === '');
    await idle(tab);
    const pasted = await drawn(tab);
    assert.ok(pasted !== sample);
    await tab.locator('#sample').selectOption('coffee');
    await idle(tab);
    assert.ok(await drawn(tab) === sample);
    await paste(null, 'some words');
    await idle(tab);
    assert.ok(await drawn(tab) === sample);
    await paste(null, `${other}/open/picture.png`);
    await idle(tab);
    assert.ok(await drawn(tab) === pasted);
    assert.equal(await tab.locator('#address').inputValue(), `${other}/open/picture.png`);
    assert.deepEqual(problems, []);
    await close();
});

test('it is known which matches of a simulated picture are correct', async () => {
    const { tab, problems, close } = await open({ viewport: { width: 1440, height: 900 } });
    await choose(tab, 'pair');
    const views = [];
    for (const view of ['side', 'far', 'night']) {
        await tab.locator('#other').selectOption(view);
        await idle(tab);
        for (const name of ['Distinct correct matches', 'Places']) {
            const [orb, ours] = await measured(tab, name);
            assert.ok(ours > orb && orb > 10, `${view}: ${name} ${orb}, ${ours}`);
        }
        views.push(await drawn(tab));
        await tab.screenshot({ path: path.join(screenshots, `desktop-pair-${view}.png`) });
    }
    assert.equal(new Set(views).size, 3);
    await tab.locator('#sample').selectOption('camera');
    await idle(tab);
    const bottom = await tab.locator('#figures').evaluate(e => e.getBoundingClientRect().bottom);
    assert.ok(bottom <= 900, `both pairs of square pictures are in sight, to ${bottom}`);
    await tab.screenshot({ path: path.join(screenshots, 'desktop-pair-camera.png') });
    await tab.locator('#sample').selectOption('rocket');
    await idle(tab);
    assert.equal(await tab.locator('#other').inputValue(), 'night');
    await tab.screenshot({ path: path.join(screenshots, 'desktop-pair-rocket.png') });
    assert.deepEqual(problems, []);
    await close();
});

test('lines between two pictures are few enough to be told apart, and can be left out', async () => {
    const { tab, problems, close } = await open({}, null, '#sample=camera&view=pair&nfeatures=3000');
    const counts = await tab.evaluate(() => shown.found.map(found => found.pair.distinct.length));
    const lines = await tab.evaluate(() => shown.found.map(found => Math.ceil(found.pair.distinct.length / lineStep())));
    assert.ok(Math.max(...counts) > 200 && Math.max(...lines) <= 120 && Math.min(...lines) > 20, `${counts}: ${lines}`);
    assert.ok(Math.abs(lines[0] / lines[1] - counts[0] / counts[1]) < .1, `${counts}: ${lines}`);
    assert.match(await tab.locator('#share').textContent(), /^for one in \d+ distinct matches$/);
    const pixels = () => tab.evaluate(() => {
        const { width, height } = canvases[1];
        const context = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
        context.drawImage(canvases[1], 0, 0);
        window.last = window.now;
        window.now = context.getImageData(0, 0, width, height).data;
        return window.last ? window.now.filter((value, i) => i % 4 === 0 && value !== window.last[i]).length * 4 /
            window.now.length : 1;
    });
    await pixels();
    await tab.screenshot({ path: path.join(screenshots, 'desktop-pair-3000.png') });
    await tab.locator('#lines').uncheck();
    const changed = await pixels();
    assert.ok(changed > .02 && changed < .3, `${changed} of the pixels are of lines`);
    assert.deepEqual(problems, []);
    await close();
});

test('a link opens what was shown, and names only what is not the default', async () => {
    const { tab, problems, close } = await open({ permissions: ['clipboard-read', 'clipboard-write'] });
    const copied = async () => {
        await tab.locator('#copy').click();
        await tab.waitForSelector('#copied:not([hidden])');
        const link = await tab.locator('#link').inputValue();
        assert.equal(await tab.evaluate(() => navigator.clipboard.readText()), link);
        assert.equal(await tab.evaluate(() => location.href), link);
        return link;
    };
    assert.equal(await copied(), `${address}#sample=coffee`);
    assert.equal(await tab.locator('#copied').textContent(), 'The link is copied.');
    await tab.locator('#sample').selectOption('rocket');
    await choose(tab, 'pair');
    await tab.locator('#other').selectOption('far');
    await setSlider(tab, 'nfeatures', 800);
    await setSlider(tab, 'strengthWeight', 6);
    await tab.locator('#adaptiveThreshold').uncheck();
    await tab.locator('#selectionType').selectOption('1');
    await tab.locator('#lines').uncheck();
    await idle(tab);
    const link = await copied();
    assert.equal(link, `${address}#sample=rocket&view=pair&second=far&nfeatures=800&strengthWeight=0.5&` +
        'adaptiveThreshold=0&selectionType=1&lines=0');
    const seen = [await measured(tab, 'Distinct correct matches'), await drawn(tab)];
    assert.ok((await tab.locator('#nfeatures').inputValue()) === '800');
    const second = await open({}, null, link.slice(address.length));
    assert.deepEqual([await measured(second.tab, 'Distinct correct matches'), await drawn(second.tab)], seen);
    // Another link in the same tab changes back what it does not name.
    await second.tab.evaluate(() => { location.hash = '#sample=brick&view=turn&degrees=90&nfeatures=nonsense&rankRadius=99'; });
    await second.tab.waitForFunction(() => element('sample').value === 'brick');
    await idle(second.tab);
    assert.equal(await second.tab.locator('#degrees').inputValue(), '90');
    assert.equal(await second.tab.locator('#nfeatures').inputValue(), '500');
    assert.equal(await second.tab.locator('#rankRadius').inputValue(), '4');
    assert.ok(await second.tab.locator('#adaptiveThreshold').isChecked());
    assert.ok((await measured(second.tab, 'Found again')).every(share => share > 0));
    await second.tab.evaluate(() => { location.hash = '#sample=nothing'; });
    await second.tab.waitForSelector('#message:not([hidden])');
    assert.match(await second.tab.locator('#message').textContent(), /^There is no sample “nothing” here\.$/);
    assert.deepEqual([...problems, ...second.problems], []);
    await second.close();
    await close();
});

test('a link has the address of a picture that can be read, and not a picture of the device', async () => {
    const picture = `${other}/open/picture.png`;
    const { tab, problems, close } = await open({}, null, `#${new URLSearchParams({ picture, second: picture, view: 'pair' })}`);
    assert.equal(await tab.locator('#sample').inputValue(), '');
    assert.equal(await tab.locator('#address').inputValue(), picture);
    assert.equal(await tab.locator('#other').inputValue(), '');
    const [orb, ours] = await measured(tab, 'Distinct matches');
    assert.ok(orb > 100 && ours > 100, `${orb} ${ours}`);  // a picture with itself
    await tab.locator('#copy').click();
    await tab.waitForSelector('#copied:not([hidden])');
    assert.doesNotMatch(await tab.locator('#copied').textContent(), /stays on your device/);
    const link = new URLSearchParams(new URL(await tab.locator('#link').inputValue()).hash.slice(1));
    assert.deepEqual([...link], [['picture', picture], ['view', 'pair'], ['second', picture]]);
    assert.ok(asked.length && asked.every(({ method, headers }) => method === 'GET' && !headers.referer && !headers.cookie));
    await tab.locator('#file').setInputFiles(images[0]);
    await idle(tab);
    await tab.locator('#copy').click();
    await tab.waitForFunction(() => /stays on your device/.test(element('copied').textContent));
    assert.doesNotMatch(await tab.locator('#link').inputValue(), /sample=|picture=/);
    await tab.screenshot({ path: path.join(screenshots, 'desktop-link.png'), fullPage: true });
    assert.deepEqual(problems, []);
    await close();
});

test('an address that cannot be read gets a sentence, and the sample is shown', async () => {
    for (const [picture, sentence] of [
        [`${other}/closed/picture.png`, /^127\.0\.0\.1:\d+ cannot be reached, or it does not allow .* open the file\.$/],
        [`${other}/none.png`, /^127\.0\.0\.1:\d+ does not have this picture; it answers 404\.$/],
        [`${other}/open/text.png`, /text\.png is not a picture that this browser can read/],
        ['file:///etc/hostname', /^“file:.*” is not the address of a picture\. It should begin with https:\/\/\.$/],
    ]) {
        const { tab, problems, close } = await open({}, null, `#${new URLSearchParams({ picture, nfeatures: 800 })}`);
        assert.match(await tab.locator('#message').textContent(), sentence);
        assert.equal(await tab.locator('#sample').inputValue(), 'coffee');
        assert.equal((await measured(tab, 'Keypoints'))[1], 800);
        await assertFits(tab);
        assert.deepEqual(problems.filter(problem => !/127\.0\.0\.1.*(picture|none)\.png|Failed to load resource/.test(problem)), []);
        await close();
    }
    const { tab, close } = await open();
    const before = await drawn(tab);
    await tab.locator('#address').fill(`${other}/closed/picture.png`);
    await tab.keyboard.press('Enter');
    await tab.waitForSelector('#message:not([hidden])');
    assert.ok(await drawn(tab) === before);
    await tab.screenshot({ path: path.join(screenshots, 'desktop-refused.png') });
    await tab.locator('#address').fill(`${other}/open/picture.png`);
    await tab.keyboard.press('Enter');
    await tab.waitForFunction(() => element('sample').value === '');
    await idle(tab);
    assert.ok(await drawn(tab) !== before);
    assert.ok(await tab.locator('#message').isHidden());
    await close();
});

test('two pictures are matched, simulated or opened', async () => {
    const { tab, problems, close } = await open();
    await choose(tab, 'pair');
    const simulated = await measured(tab, 'Distinct correct matches');
    assert.ok(simulated.every(count => count > 50), `${simulated}`);
    await tab.screenshot({ path: path.join(screenshots, 'desktop-pair.png'), fullPage: true });
    await tab.locator('#second').setInputFiles(images[0]);
    const noneFound = () => [...document.querySelectorAll('#measures td')].some(cell => cell.textContent === 'none found');
    await tab.waitForFunction(noneFound);
    await idle(tab);
    assert.match(await tab.locator('#advice').textContent(), /Try more features, or a\s+larger strength weight/);
    assert.ok(await tab.locator('#advice').isVisible());
    // A sample after two pictures of one's own is matched with the simulated one again.
    await tab.locator('#file').setInputFiles(images[0]);
    await idle(tab);
    await tab.locator('#sample').selectOption('coffee');
    await tab.waitForFunction(`!(${noneFound})()`);
    await idle(tab);
    assert.deepEqual(await measured(tab, 'Distinct correct matches'), simulated);
    await tab.locator('#second').setInputFiles(images[0]);
    await tab.waitForFunction(noneFound);
    await tab.locator('#other').selectOption('side');
    await tab.waitForFunction(`!(${noneFound})()`);
    await idle(tab);
    assert.deepEqual(await measured(tab, 'Distinct correct matches'), simulated);
    assert.ok(await tab.locator('#advice').isHidden());
    assert.deepEqual(problems, []);
    await close();
});

test('a click enlarges both pictures, and another one brings them back', async () => {
    const { tab, problems, close } = await open();
    const widths = () => tab.locator('#figures canvas').evaluateAll(all => all.map(canvas => canvas.clientWidth));
    const [before] = await widths();
    await tab.locator('#figures canvas').first().click();
    assert.deepEqual(await widths(), [3 * before, 3 * before]);
    assert.ok(await tab.locator('#large').isChecked());
    await tab.locator('.frame').first().evaluate(frame => frame.scrollTo(40, 30));
    await tab.waitForFunction(() => document.querySelectorAll('.frame')[1].scrollLeft === 40);
    await assertFits(tab);
    await tab.screenshot({ path: path.join(screenshots, 'desktop-large.png') });
    await tab.locator('#large').uncheck();
    assert.deepEqual(await widths(), [before, before]);
    assert.deepEqual(problems, []);
    await close();
});

test('a refused camera gets a sentence', async () => {
    const { tab, problems, close } = await open();
    await tab.locator('#camera').click();
    await tab.waitForSelector('#message:not([hidden])');
    assert.match(await tab.locator('#message').textContent(), /^The camera was refused\. .*\.$/);
    assert.equal(await tab.locator('#camera').getAttribute('aria-pressed'), 'false');
    assert.deepEqual(problems, []);
    await close();
});

test('the camera shows one frame after the other, until it is stopped', async () => {
    const { tab, problems, close } = await open({ permissions: ['camera'] });
    await tab.locator('#camera').click();
    await tab.waitForSelector('#camera[aria-pressed=true]');
    await tab.waitForFunction(() => /640×480/.test(element('size').textContent));
    const before = await drawn(tab);
    await tab.waitForTimeout(1500);
    assert.ok(await drawn(tab) !== before);
    await tab.locator('#camera').click();
    await idle(tab);
    const last = await drawn(tab);
    await tab.waitForTimeout(500);
    assert.ok(await drawn(tab) === last);
    assert.deepEqual(problems, []);
    await close();
});

test('a browser without SIMD gets a sentence', async () => {
    const { tab, problems, close } = await open({}, () => { WebAssembly.validate = () => false; });
    assert.match(await tab.locator('#message').textContent(), /does not run WebAssembly with SIMD.*\.$/);
    assert.ok(await tab.locator('#nfeatures').isDisabled());
    await tab.screenshot({ path: path.join(screenshots, 'desktop-no-simd.png') });
    assert.deepEqual(problems, []);
    await close();
});

for (const colorScheme of ['light', 'dark']) {
    test(`the page fits a phone, ${colorScheme}`, async () => {
        const { tab, problems, close } = await open({
            viewport: PHONE, deviceScaleFactor: 2, isMobile: true, hasTouch: true, colorScheme });
        for (const view of ['keypoints', 'turn', 'pair']) {
            await choose(tab, view);
            await assertFits(tab);
            await tab.screenshot({ path: path.join(screenshots, `phone-${colorScheme}-${view}.png`), fullPage: true });
        }
        const low = await tab.evaluate(() => [...document.querySelectorAll('button, .button, select, #views label, .check')]
            .filter(e => e.offsetParent && e.getBoundingClientRect().height < 44).map(e => e.outerHTML));
        assert.deepEqual(low, [], 'a finger needs 44 pixels');
        assert.deepEqual(problems, []);
        await close();
    });
}

test('on a phone the pictures stay in sight above every slider', async () => {
    const { tab, problems, close } = await open({
        viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true },
    null, '#sample=camera&view=pair');
    await assertFits(tab);
    const sliders = await tab.locator('input[type=range]').evaluateAll(all => all.filter(e => e.offsetParent).map(e => e.id));
    assert.ok(sliders.length >= 7);
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
    await tab.screenshot({ path: path.join(screenshots, 'phone-390-slider.png') });
    const before = await drawn(tab);
    await setSlider(tab, 'nfeatures', 1500);
    await idle(tab);
    assert.ok(await drawn(tab) !== before);
    await tab.evaluate(() => scrollTo(0, 0));
    await tab.screenshot({ path: path.join(screenshots, 'phone-390-pair.png'), fullPage: true });
    assert.deepEqual(problems, []);
    await close();
});

// WCAG's ratio of the luminances of a text and of what is behind it.
test('text stands out from its background, light and dark', async () => {
    for (const colorScheme of ['light', 'dark']) {
        const { tab, close } = await open({ colorScheme });
        const faint = await tab.evaluate(() => {
            const parse = colour => (colour.match(/[\d.]+/g) || []).map(Number);
            const luminance = colour => parse(colour).slice(0, 3).map(v => v / 255)
                .map(v => v <= .03928 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4)
                .reduce((sum, v, i) => sum + v * [.2126, .7152, .0722][i], 0);
            const behind = e => {
                for (; e; e = e.parentElement) {
                    const colour = getComputedStyle(e).backgroundColor;
                    if (parse(colour)[3] !== 0)
                        return colour;
                }
                return 'rgb(255, 255, 255)';
            };
            return [...document.body.querySelectorAll('*')]
                .filter(e => e.offsetParent && [...e.childNodes].some(n => n.nodeType === 3 && n.data.trim()))
                .map(e => {
                    const [a, b] = [luminance(getComputedStyle(e).color), luminance(behind(e))].sort((x, y) => y - x);
                    return { ratio: (a + .05) / (b + .05), text: e.textContent.trim().slice(0, 30) };
                }).filter(({ ratio }) => ratio < 4.5);
        });
        assert.deepEqual(faint, [], colorScheme);
        await tab.screenshot({ path: path.join(screenshots, `desktop-${colorScheme}.png`), fullPage: true });
        await close();
    }
});

test('the keyboard alone is enough, and the focus is visible', async () => {
    const { tab, problems, close } = await open();
    const focused = () => tab.evaluate(() => {
        const e = document.activeElement;
        const shown = e.matches('.button input, #views input') ? e.nextElementSibling : e;
        const { outlineStyle, outlineWidth } = getComputedStyle(shown);
        return { id: e.id || e.value || e.type || e.tagName, isVisible: outlineStyle !== 'none' && parseFloat(outlineWidth) >= 2 };
    });
    const order = [];
    for (let i = 0; i < 30; i++) {
        await tab.keyboard.press('Tab');
        const { id, isVisible } = await focused();
        if (id === 'BODY' || order.includes(id))
            break;
        assert.ok(isVisible, `the focus of ${id}`);
        order.push(id);
        const before = await drawn(tab);
        if (id === 'sample') {
            await tab.keyboard.press('ArrowDown');
            await idle(tab);
            assert.ok(await drawn(tab) !== before, id);
        } else if (id === 'keypoints') {
            await tab.screenshot({ path: path.join(screenshots, 'desktop-focus.png') });
            await tab.keyboard.press('ArrowRight');
            await idle(tab);
            assert.ok(await tab.locator('#degrees').isVisible());
            await tab.keyboard.press('Tab');
            assert.equal((await focused()).id, 'degrees');
            await tab.keyboard.press('ArrowRight');
            await idle(tab);
            assert.equal(await tab.locator('#degrees').inputValue(), '26');
            await tab.keyboard.press('Shift+Tab');
            await tab.keyboard.press('ArrowLeft');
            await idle(tab);
            assert.ok(await tab.locator('#degrees').isHidden());
        } else if (id === 'file') {
            const chooser = tab.waitForEvent('filechooser');
            await tab.keyboard.press('Space');
            await chooser;
        } else if (id === 'cells') {
            await tab.keyboard.press('Space');
            assert.ok(await drawn(tab) !== before, id);
        } else if (['nfeatures', 'strengthWeight'].includes(id)) {
            for (let press = 0; press < 4; press++)
                await tab.keyboard.press('ArrowRight');
            await idle(tab);
            assert.ok(await drawn(tab) !== before, id);
        } else if (id === 'reset') {
            await tab.keyboard.press('Enter');
            await tab.waitForTimeout(50);
            await idle(tab);
            assert.equal(await tab.locator('#nfeatures').inputValue(), '500');
        }
    }
    for (const id of ['sample', 'file', 'camera', 'address', 'keypoints', 'copy', 'cells', 'nfeatures', 'fastThreshold', 'nlevels',
        'scaleFactor', 'strengthWeight', 'rankRadius', 'minThresholdRatio', 'adaptiveThreshold', 'selectionType', 'reset'])
        assert.ok(order.includes(id), `${id} is not reached: ${order}`);
    assert.deepEqual(problems, []);
    await close();
});
