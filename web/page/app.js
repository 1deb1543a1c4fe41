// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

'use strict';

const LONGEST_SIDE = 1280;               // of a picture, in pixels
const GRID = { columns: 16, rows: 12 };  // of the occupied cells
const DISTINCT = 4;                      // pixels between two matches that count as distinct
const LINES = { least: 30, most: 120, pixels: 8 };  // between two pictures: one in so many pixels of their width
const COLOURS = ['#ff8126', '#1fc8e3'];  // of the keypoints of either detector, on pictures of any brightness
const CAMERA_ERRORS = {
    NotAllowedError: 'The camera was refused. Allow it for this page in the browser, or open a picture instead.',
    NotFoundError: 'No camera was found. Open a picture instead.',
    InsecureContext: 'The camera works only over HTTPS or from localhost. Open a picture instead.',
    NotReadableError: 'The camera is in use by another program. Open a picture instead.',
};

const element = id => document.getElementById(id);
const canvases = [...document.querySelectorAll('#figures canvas')];
const NAMES = ['cv::ORB', 'AdaptiveQuadtreeORB'];

let worker = null;
let wanted = null;  // pictures that the worker does not have yet; an empty object if it has them, null if all is done
let sent = null;    // the job that the worker does
let openings = 0;   // of pictures that are being fetched or decoded
let failed = false;
let asked = [0, 0];         // how often a first and a second picture were asked for: the last one counts
let addresses = ['', ''];   // of both pictures, where they have one
let pictures = [];  // canvases of both pictures, as they were last detected in
let shown = null;   // what was found in them
let stream = null;  // of the camera
let drawnWidth = 0;
const video = document.createElement('video');

function say(sentence) {
    element('message').textContent = sentence;
    element('message').hidden = !sentence;
}

// There is nothing to do before the first picture is here.
const isWaiting = () => Boolean(wanted && (wanted.picture || pictures[0]));

function setState() {
    document.body.dataset.state = openings || sent || isWaiting() ? 'busy' : failed ? 'failed' : 'ready';
}

// The worker

// Whether the browser has what aqorb.wasm is compiled for: a function that uses a vector, and one that catches.
function isSupported() {
    if (typeof WebAssembly !== 'object' || typeof Worker !== 'function' || typeof OffscreenCanvas !== 'function')
        return false;
    const head = [0, 97, 115, 109, 1, 0, 0, 0];
    const vector = [1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11];
    const exception = [1, 4, 1, 96, 0, 0, 3, 2, 1, 0, 10, 8, 1, 6, 0, 6, 64, 25, 11, 11];
    return [vector, exception].every(code => WebAssembly.validate(new Uint8Array([...head, ...code])));
}

function startWorker() {
    worker = new Worker('worker.js');
    worker.onmessage = ({ data }) => {
        const job = sent;
        sent = null;
        failed = Boolean(data.error);
        if (failed)
            say(`The detector reports an error: ${data.error}`);
        else
            receive(data, job);
        send();
        setState();
        if (stream)
            requestAnimationFrame(grabFrame);
    };
    worker.onerror = () => {
        say('The detector could not be loaded. Reload the page to try again.');
        sent = wanted = null;
        failed = true;
        setState();
    };
}

// Asks for what the controls say, in pictures that may be new: picture (a canvas), and second (a canvas, or the name of a
// simulated one). While the worker is busy nothing is sent, so a slider never leaves a queue.
function request(change = {}) {
    wanted = { ...wanted, ...change };
    send();
    setState();
}

function send() {
    if (!worker || sent || !isWaiting())
        return;
    const { picture, second } = wanted;
    wanted = null;
    const properties = {};
    for (const field of element('properties').querySelectorAll('input, select'))
        properties[field.id] = field.type === 'checkbox' ? Number(field.checked) : valueOf(field);
    const view = document.querySelector('[name=view]:checked').value;
    const degrees = Number(element('degrees').value);
    sent = { picture, second, view, degrees };
    const message = { view, degrees, properties, runs: stream ? 1 : 3 };
    if (picture)
        message.pixels = pixelsOf(picture);
    if (second)
        message.second = typeof second === 'string' ? second : pixelsOf(second);
    worker.postMessage(message);
}

function receive(answer, job) {
    pictures[0] = job.picture || pictures[0];
    if (answer.second)
        pictures[1] = canvasOf(answer.second);
    else if (job.second && typeof job.second !== 'string')
        pictures[1] = job.second;
    shown = { found: answer.found, view: job.view, degrees: job.degrees };
    for (const { turned, pair } of shown.found) {
        if (turned || pair)
            (turned || pair).distinct = distinct((turned || pair).matches);
    }
    draw();
    fillTable();
    element('size').textContent = `Now ${pictures[0].width}×${pictures[0].height} pixels.`;
}

function pixelsOf(canvas) {
    return canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
}

function canvasOf({ width, height, pixels }) {
    const canvas = new OffscreenCanvas(width, height);
    canvas.getContext('2d').putImageData(new ImageData(new Uint8ClampedArray(pixels.buffer), width, height), 0, 0);
    return canvas;
}

// Pictures

// A picture, or a frame of a video, at a size that is processed in a moment.
function scaled(image, width, height) {
    const scale = Math.min(1, LONGEST_SIDE / Math.max(width, height));
    const canvas = new OffscreenCanvas(Math.max(1, Math.round(width * scale)), Math.max(1, Math.round(height * scale)));
    const context = canvas.getContext('2d', { willReadFrequently: true });
    context.fillStyle = '#fff';  // behind what is transparent
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.imageSmoothingQuality = 'high';
    context.drawImage(image, 0, 0, canvas.width, canvas.height);
    return canvas;
}

// The picture in a file, as a canvas, or null if the browser cannot read it or if another one was asked for meanwhile.
// `read` returns the file; the sentence for an error is that of the error, or `sorry`.
async function decoded(which, read, sorry) {
    const ticket = ++asked[which];
    openings++;
    setState();
    let picture = null, sentence = sorry;
    try {
        const file = await read().catch(error => {
            sentence = error.message;
            throw error;
        });
        const image = await createImageBitmap(file, { colorSpaceConversion: 'none' });
        picture = scaled(image, image.width, image.height);
    } catch {
        if (ticket === asked[which])
            say(sentence);
    }
    openings--;
    setState();
    return ticket === asked[which] ? picture : null;
}

// A picture of the visitor's own, with its address if it has one.
async function openOwn(which, read, sorry, address = '') {
    say('');
    const picture = await decoded(which, read, sorry);
    if (!picture)
        return false;
    addresses[which] = address;
    showOwn(which, true);
    if (which)
        request({ second: picture });
    else {
        stopCamera();
        request({ picture });
    }
    return true;
}

function openFile(which, file) {
    if (file) {
        openOwn(which, async () => file,
            `“${file.name}” is not a picture that this browser can read. Open a JPEG, PNG or WebP file.`);
    }
}

function openAddress(which, address) {
    return openOwn(which, () => fetched(address),
        `${address} is not a picture that this browser can read. It should lead to a JPEG, PNG or WebP file.`, address);
}

// The file at an address. Its server is not told which page asks.
async function fetched(address) {
    let url;
    try {
        url = new URL(address, location.href);
    } catch { /* below */ }
    if (!url || !/^https?:$/.test(url.protocol))
        throw new Error(`“${address}” is not the address of a picture. It should begin with https://.`);
    let response, file;
    try {
        response = await fetch(url, { referrerPolicy: 'no-referrer' });
        file = await response.blob();
    } catch {
        throw new Error(`${url.host} cannot be reached, or it does not allow other pages to read its pictures. Save the ` +
            'picture and open the file.');
    }
    if (!response.ok)
        throw new Error(`${url.host} does not have this picture; it answers ${response.status}.`);
    return file;
}

async function openSample(sentence = '') {
    stopCamera();
    addresses[0] = '';
    showOwn(0, false);
    say(sentence);
    const { value, dataset } = element('sample').selectedOptions[0];
    const picture = await decoded(0, () => fetched(`photographs/${dataset.file || value}.jpg`),
        'The sample cannot be read. Reload the page to try again.');
    if (!picture)
        return;
    if (dataset.light)
        darken(picture, Number(dataset.light));
    const change = { picture };
    if (!element('other').value) {
        // A picture of one's own shows something else than a sample, so the second one is simulated again.
        element('other').selectedIndex = 0;
        change.second = element('other').value;
        showOwn(1, false);
    }
    request(change);
}

// Leaves a share of the light, as if the picture were taken in the dark.
function darken(canvas, light) {
    const image = pixelsOf(canvas);
    image.data.forEach((value, i) => {
        if (i % 4 < 3)
            image.data[i] = Math.round(value * light);
    });
    canvas.getContext('2d').putImageData(image, 0, 0);
}

function openOther() {
    asked[1]++;
    addresses[1] = '';
    showOwn(1, false);
    request({ second: element('other').value });
}

// A list says so when none of its pictures is shown.
function showOwn(which, isOwn) {
    const [list, own] = which ? ['other', 'own-second'] : ['sample', 'own'];
    element(own).hidden = !isOwn;
    if (isOwn)
        element(list).value = '';
    element('address').value = addresses[0];
}

async function toggleCamera() {
    if (stream) {
        stopCamera();
        request();
        return;
    }
    say('');
    try {
        if (!navigator.mediaDevices)
            throw new DOMException('', 'InsecureContext');
        stream = await navigator.mediaDevices.getUserMedia({
            video: { facingMode: 'environment', width: { ideal: 640 }, height: { ideal: 480 } } });
        video.srcObject = stream;
        video.muted = video.playsInline = true;
        await video.play();
    } catch (error) {
        stopCamera();
        say(CAMERA_ERRORS[error.name] || `The camera could not be used (${error.name}). Open a picture instead.`);
        return;
    }
    asked[0]++;
    addresses[0] = '';
    element('camera').textContent = 'Stop camera';
    element('camera').setAttribute('aria-pressed', 'true');
    showOwn(0, true);
    grabFrame();
}

function grabFrame() {
    if (stream && !sent)
        request({ picture: scaled(video, video.videoWidth, video.videoHeight) });
}

function stopCamera() {
    if (stream)
        stream.getTracks().forEach(track => track.stop());
    stream = null;
    element('camera').textContent = 'Camera';
    element('camera').setAttribute('aria-pressed', 'false');
}

// Drawing. Sizes are in CSS pixels; the canvas has as many pixels as the screen.

function draw() {
    if (!shown)
        return;
    const isPair = shown.view === 'pair';
    element('figures').classList.toggle('wide', isPair);
    // On a wide screen both pairs are in sight at once.
    const widest = isPair && matchMedia('(min-width: 62rem)').matches ?
        `${Math.max(560, Math.round(.76 * innerHeight * pictures[0].width / pictures[0].height))}px` : '';
    for (const figure of document.querySelectorAll('#figures figure'))
        figure.style.maxWidth = widest;
    drawnWidth = canvases[0].clientWidth;
    const oneIn = isPair ? lineStep() : 0;
    canvases.forEach((canvas, detector) => {
        const width = canvas.clientWidth;
        const stacked = width < 560;
        const [first, second] = pictures;
        let columns = 1, rows = 1;
        if (isPair)
            [columns, rows] = stacked ? [1, 2] : [2, 1];
        const scale = width / columns / first.width;
        const cell = { width: width / columns, height: first.height * scale };
        canvas.width = Math.round(width * devicePixelRatio);
        canvas.height = Math.round(cell.height * rows * devicePixelRatio);
        const context = canvas.getContext('2d');
        context.scale(canvas.width / width, canvas.width / width);
        const found = shown.found[detector];
        const colour = COLOURS[detector];
        if (isPair) {
            const fit = Math.min(cell.width / second.width, cell.height / second.height);
            const at = { x: stacked ? 0 : cell.width, y: stacked ? cell.height : 0, scale: fit };
            context.drawImage(first, 0, 0, cell.width, cell.height);
            context.drawImage(second, at.x, at.y, second.width * fit, second.height * fit);
            drawMatches(context, found.pair, scale, at, colour, oneIn);
        } else if (shown.view === 'turn') {
            context.save();
            context.translate(cell.width / 2, cell.height / 2);
            context.rotate(shown.degrees * Math.PI / 180);
            context.drawImage(first, -cell.width / 2, -cell.height / 2, cell.width, cell.height);
            context.restore();
            const { keypoints, stays } = found.turned;
            const points = [...stays].map((stay, i) => ({ stay, x: keypoints[4 * i], y: keypoints[4 * i + 1] }));
            drawRings(context, points.filter(point => !point.stay), scale, colour);
            drawDots(context, points.filter(point => point.stay), scale, colour);
        } else {
            context.drawImage(first, 0, 0, cell.width, cell.height);
            const points = pointsOf(found.keypoints);
            if (element('cells').checked)
                shadeEmptyCells(context, points, first, scale);
            drawRings(context, points, scale, colour);
        }
        canvas.setAttribute('aria-label', `Picture with ${found.count} keypoints of ${NAMES[detector]}`);
    });
}

function pointsOf(keypoints) {
    const points = [];
    for (let i = 0; i < keypoints.length; i += 4)
        points.push({ x: keypoints[i], y: keypoints[i + 1] });
    return points;
}

function circles(context, points, scale, radius) {
    context.beginPath();
    for (const { x, y } of points) {
        context.moveTo((x + .5) * scale + radius, (y + .5) * scale);
        context.arc((x + .5) * scale, (y + .5) * scale, radius, 0, 2 * Math.PI);
    }
}

// A dark edge makes the colour visible on a bright picture.
function drawRings(context, points, scale, colour) {
    circles(context, points, scale, 2.75);
    context.strokeStyle = 'rgb(0 0 0 / 55%)';
    context.lineWidth = 2.75;
    context.stroke();
    context.strokeStyle = colour;
    context.lineWidth = 1.25;
    context.stroke();
}

function drawDots(context, points, scale, colour) {
    circles(context, points, scale, 3);
    context.strokeStyle = 'rgb(0 0 0 / 70%)';
    context.lineWidth = 1.5;
    context.stroke();
    context.fillStyle = colour;
    context.fill();
}

// The grid of distributionOccupancy.
function shadeEmptyCells(context, points, picture, scale) {
    const { columns, rows } = GRID;
    const occupied = new Set(points.map(({ x, y }) =>
        Math.floor(y * rows / picture.height) * columns + Math.floor(x * columns / picture.width)));
    const width = picture.width * scale / columns, height = picture.height * scale / rows;
    context.fillStyle = 'rgb(20 0 30 / 62%)';
    for (let cell = 0; cell < columns * rows; cell++) {
        if (!occupied.has(cell))
            context.fillRect(cell % columns * width, Math.floor(cell / columns) * height, width, height);
    }
}

// One in how many distinct matches gets a line: the same for both detectors, so that the one with more matches has more
// lines, and so many that the lines of the other one can be told apart.
function lineStep() {
    const most = Math.max(...shown.found.map(found => found.pair.distinct.length));
    const room = Math.min(LINES.most, Math.max(LINES.least, Math.round(drawnWidth / LINES.pixels)));
    const oneIn = Math.max(1, Math.ceil(most / room));
    element('share').textContent = oneIn > 1 ? `for one in ${oneIn} distinct matches` : 'for each distinct match';
    return oneIn;
}

function drawMatches(context, pair, scale, at, colour, oneIn) {
    const { matches, homography } = pair;
    const others = [];
    for (let i = 0; i < matches.length; i += 5) {
        if (!matches[i + 4])
            others.push({ x: matches[i], y: matches[i + 1] });
    }
    drawSpots(context, others, scale, 'rgb(255 255 255 / 60%)');
    if (element('lines').checked) {
        const lines = new Path2D();
        for (let i = 0; i < pair.distinct.length; i += oneIn) {
            const { x, y, x2, y2 } = pair.distinct[i];
            lines.moveTo((x + .5) * scale, (y + .5) * scale);
            lines.lineTo(at.x + (x2 + .5) * at.scale, at.y + (y2 + .5) * at.scale);
        }
        context.strokeStyle = 'rgb(0 0 0 / 25%)';
        context.lineWidth = 2.5;
        context.stroke(lines);
        context.globalAlpha = .65;
        context.strokeStyle = colour;
        context.lineWidth = 1;
        context.stroke(lines);
        context.globalAlpha = 1;
    }
    drawSpots(context, pair.distinct, scale, colour);
    context.save();
    context.translate(at.x, at.y);
    drawSpots(context, pair.distinct.map(({ x2, y2 }) => ({ x: x2, y: y2 })), at.scale, colour);
    context.restore();
    if (!homography)
        return;
    const { width, height } = pictures[0];
    const outline = new Path2D();
    for (const [x, y] of [[0, 0], [width, 0], [width, height], [0, height]]) {
        const w = homography[6] * x + homography[7] * y + homography[8];
        outline.lineTo(at.x + (homography[0] * x + homography[1] * y + homography[2]) / w * at.scale,
            at.y + (homography[3] * x + homography[4] * y + homography[5]) / w * at.scale);
    }
    outline.closePath();
    context.save();
    context.beginPath();
    context.rect(at.x, at.y, pictures[1].width * at.scale, pictures[1].height * at.scale);
    context.clip();
    context.strokeStyle = 'rgb(0 0 0 / 60%)';
    context.lineWidth = 4;
    context.stroke(outline);
    context.strokeStyle = '#fff';
    context.lineWidth = 2;
    context.stroke(outline);
    context.restore();
}

function drawSpots(context, points, scale, colour) {
    circles(context, points, scale, drawnWidth < 400 ? 1.25 : 1.75);
    context.strokeStyle = 'rgb(0 0 0 / 60%)';
    context.lineWidth = .75;
    context.stroke();
    context.fillStyle = colour;
    context.fill();
}

// Matches. Each is five numbers: x and y in the first picture, those in the second, and whether it is right. The nearest
// descriptors come first.

// The first of those right matches that lie together in either picture: several keypoints on one corner of the scene say
// no more about it than one.
function distinct(matches) {
    const kept = [];
    for (let i = 0; i < matches.length; i += 5) {
        const [x, y, x2, y2, isRight] = matches.subarray(i, i + 5);
        if (isRight && kept.every(k => Math.hypot(k.x - x, k.y - y) >= DISTINCT &&
                Math.hypot(k.x2 - x2, k.y2 - y2) >= DISTINCT))
            kept.push({ x, y, x2, y2 });
    }
    return kept;
}

// How many cells of the grid over the first picture hold a right match.
function places(matches) {
    const cells = new Set();
    for (let i = 0; i < matches.length; i += 5) {
        const [x, y, , , isRight] = matches.subarray(i, i + 5);
        if (isRight)
            cells.add(Math.floor(y * GRID.rows / pictures[0].height) * GRID.columns +
                Math.floor(x * GRID.columns / pictures[0].width));
    }
    return cells.size;
}

// The table

const percent = value => `${(100 * value).toFixed(1)} %`;
const MEASURES = [
    { view: 'turn', name: 'Distinct correct matches', best: Math.max, value: found => found.turned.distinct.length },
    { view: 'turn', name: 'Places', note: 'cells with a correct match', best: Math.max,
        value: found => places(found.turned.matches) },
    { view: 'turn', name: 'Correct matches in all', value: found => found.turned.correct },
    { view: 'turn', name: 'Found again', note: 'of those in both frames', best: Math.max,
        value: found => found.turned.share, text: percent },
    { view: 'pair', known: true, name: 'Distinct correct matches', best: Math.max,
        value: found => found.pair.distinct.length },
    { view: 'pair', known: true, name: 'Places', note: 'cells with a correct match', best: Math.max,
        value: found => places(found.pair.matches) },
    { view: 'pair', known: true, name: 'Matches in all', note: 'and how many are correct',
        value: found => `${found.pair.count}, ${found.pair.agreeing}` },
    { view: 'pair', known: false, name: 'Distinct matches', note: 'in the homography', best: Math.max,
        value: found => found.pair.homography ? found.pair.distinct.length : null, none: 'none found' },
    { view: 'pair', known: false, name: 'Places', note: 'cells with such a match', best: Math.max,
        value: found => found.pair.homography ? places(found.pair.matches) : null },
    { view: 'pair', known: false, name: 'Matches in all', note: 'and how many are in the homography',
        value: found => `${found.pair.count}, ${found.pair.agreeing}` },
    { name: 'Keypoints', value: found => found.count },
    { name: 'Uniformity', note: 'less is more uniform', best: Math.min,
        value: found => found.count ? found.uniformity : null, text: value => value.toFixed(1) },
    { name: 'Occupied cells', best: Math.max, value: found => found.occupancy, text: percent },
    { name: 'Time', best: Math.min, value: found => found.time, text: value => `${value.toFixed(1)} ms` },
];

function fillTable() {
    const isOf = ({ view, known }) => (!view || view === shown.view) &&
        (known === undefined || known === shown.found[0].pair.known);
    const rows = MEASURES.filter(isOf).map(measure => {
        const values = shown.found.map(measure.value);
        const row = document.createElement('tr');
        const head = document.createElement('th');
        head.scope = 'row';
        head.textContent = measure.name;
        if (measure.note) {
            const note = document.createElement('small');
            note.textContent = measure.note;
            head.append(note);
        }
        row.append(head);
        values.forEach((value, i) => {
            const cell = row.insertCell();
            cell.textContent = value === null ? measure.none || '–' : (measure.text || String)(value);
            const other = values[1 - i];
            cell.classList.toggle('better', Boolean(measure.best) && value !== null && value !== other &&
                (other === null || measure.best(value, other) === value));
        });
        return row;
    });
    element('measures').replaceChildren(...rows);
    element('advice').hidden = shown.view !== 'pair' || shown.found.every(found => found.pair.homography);
}

// The controls

// A slider stands for a number, or for a place in its list of them.
function valueOf(field) {
    return Number(field.dataset.values ? field.dataset.values.split(' ')[field.value] : field.value);
}

// The place of a number in the list of a slider, or of the nearest one.
function placeOf(slider, number) {
    const distances = slider.dataset.values.split(' ').map(value => Math.abs(value - number));
    return distances.indexOf(Math.min(...distances));
}

// A slider with a list begins, and begins again, at the number of the list that is nearest to its default.
function placeSliders() {
    for (const slider of document.querySelectorAll('[data-values]'))
        slider.defaultValue = placeOf(slider, slider.dataset.default);
}

function showValues() {
    for (const output of document.querySelectorAll('output')) {
        const slider = element(output.htmlFor);
        const digits = (slider.step.split('.')[1] || '').length;
        const text = slider.dataset.values ? String(valueOf(slider)) : Number(slider.value).toFixed(digits);
        output.textContent = text + (slider.dataset.unit || '');
        slider.setAttribute('aria-valuetext', output.textContent);
    }
}

// Pictures at three times their size can be moved, both together, in frames that stay as they are.
function enlarge(isLarge, x = .5, y = .5) {
    element('large').checked = isLarge;
    for (const { parentElement: frame } of canvases)
        frame.style.height = isLarge ? `${frame.clientHeight}px` : '';
    element('figures').classList.toggle('large', isLarge);
    draw();
    for (const { parentElement: frame } of canvases)
        frame.scrollTo(x * frame.scrollWidth - frame.clientWidth / 2, y * frame.scrollHeight - frame.clientHeight / 2);
}

function listenToPictures() {
    element('large').onchange = ({ target }) => enlarge(target.checked);
    canvases.forEach((canvas, i) => {
        const frame = canvas.parentElement, other = canvases[1 - i].parentElement;
        canvas.onclick = event => enlarge(!element('large').checked, event.offsetX / canvas.clientWidth,
            event.offsetY / canvas.clientHeight);
        frame.onscroll = () => other.scrollTo(frame.scrollLeft, frame.scrollTop);
    });
}

function showView() {
    const view = document.querySelector('[name=view]:checked').value;
    for (const part of document.querySelectorAll('.of-view'))
        part.hidden = part.dataset.view !== view;
}

// The link. What differs from the defaults is after the #, which a browser does not send to a server. The words there are
// those of the page: sample or picture (an address), second (a simulated one, or an address), view, and the ids of the
// fields below.

const linkedFields = () => [...element('properties').querySelectorAll('input, select'),
    ...['degrees', 'cells', 'lines'].map(element)];

function textOf(field) {
    return String(field.type === 'checkbox' ? Number(field.checked) : valueOf(field));
}

// Sets a field to the text of a link, or to its default where there is none, or none that it can show.
function setField(field, text) {
    const isNumber = text !== null && text.trim() !== '' && Number.isFinite(Number(text));
    if (field.type === 'checkbox')
        field.checked = isNumber ? Number(text) !== 0 : field.defaultChecked;
    else if (field.tagName === 'SELECT')
        field.value = [...field.options].some(option => option.value === text) ? text : field.options[0].value;
    else if (!isNumber)
        field.value = field.defaultValue;
    else
        field.value = field.dataset.values ? placeOf(field, Number(text)) : text;
}

function linkToView() {
    const link = new URLSearchParams();
    if (addresses[0])
        link.set('picture', addresses[0]);
    else if (element('sample').value)
        link.set('sample', element('sample').value);
    const view = document.querySelector('[name=view]:checked');
    if (!view.defaultChecked)
        link.set('view', view.value);
    const second = addresses[1] || element('other').value;
    if (second && second !== element('other').options[0].value)
        link.set('second', second);
    for (const field of linkedFields()) {
        const text = textOf(field), now = field.type === 'checkbox' ? field.checked : field.value;
        setField(field, null);
        if (text !== textOf(field))
            link.set(field.id, text);
        field[field.type === 'checkbox' ? 'checked' : 'value'] = now;
    }
    return `${location.href.split('#')[0]}#${link}`;
}

async function copyLink() {
    const link = linkToView();
    history.replaceState(null, '', link);
    const notes = [];
    try {
        await navigator.clipboard.writeText(link);
        notes.push('The link is copied.');
    } catch {
        notes.push('This browser does not let the page copy the link. Copy it from the field.');
    }
    const isOnDevice = !addresses[0] && !element('sample').value, isSecondOnDevice = !addresses[1] && !element('other').value;
    if (isOnDevice || isSecondOnDevice) {
        notes.push(`${isOnDevice ? 'Your picture' : 'Your second picture'} stays on your device and is not in the link. ` +
            'Whoever opens the link can drop, paste or open it there.');
    }
    element('link').value = link;
    element('link-field').hidden = false;
    element('copied').textContent = notes.join(' ');
    element('copied').hidden = false;
}

// Opens what the address of the page says.
async function followLink() {
    const link = new URLSearchParams(location.hash.slice(1));
    for (const field of linkedFields())
        setField(field, link.get(field.id));
    const views = [...document.querySelectorAll('[name=view]')];
    (views.find(view => view.value === link.get('view')) || views.find(view => view.defaultChecked)).checked = true;
    showView();
    showValues();
    const isListed = (list, name) => name && [...element(list).options].some(option => option.value === name);
    const sample = link.get('sample'), picture = link.get('picture'), second = link.get('second');
    setField(element('sample'), isListed('sample', sample) ? sample : null);
    setField(element('other'), isListed('other', second) ? second : null);
    openOther();
    if (!picture)
        await openSample(sample && !isListed('sample', sample) ? `There is no sample “${sample}” here.` : '');
    else {
        const turn = asked[0] + 1;
        if (!await openAddress(0, picture) && asked[0] === turn)
            await openSample(element('message').textContent);
    }
    if (second && !isListed('other', second))
        await openAddress(1, second);
}

function listen() {
    element('sample').onchange = () => openSample();
    ['file', 'second'].forEach((id, which) => {
        element(id).onchange = ({ target }) => {
            openFile(which, target.files[0]);
            target.value = '';  // so that the same file can be opened again
        };
    });
    element('address').onchange = ({ target }) => target.value.trim() && openAddress(0, target.value.trim());
    element('camera').onclick = toggleCamera;
    element('other').onchange = openOther;
    element('copy').onclick = copyLink;
    element('link').onfocus = ({ target }) => target.select();
    window.onhashchange = followLink;
    element('views').onchange = () => {
        enlarge(false);
        showView();
        request();
    };
    for (const control of [element('properties'), element('degrees')]) {
        control.oninput = () => {
            showValues();
            request();
        };
    }
    element('properties').onreset = () => setTimeout(element('properties').oninput);
    element('properties').onsubmit = event => event.preventDefault();
    element('cells').onchange = element('lines').onchange = draw;
    listenToPictures();
    new ResizeObserver(() => canvases[0].clientWidth === drawnWidth || draw()).observe(element('figures'));

    const hasPicture = event => event.dataTransfer &&
        ['Files', 'text/uri-list'].some(type => event.dataTransfer.types.includes(type));
    // The file of a drop or of the clipboard, or otherwise the address there.
    const openGiven = (which, data) => {
        const address = (data.getData('text/uri-list') || data.getData('text/plain')).trim().split(/\s/)[0];
        if (data.files.length)
            openFile(which, data.files[0]);
        else if (/^https?:/.test(address))
            openAddress(which, address);
    };
    document.onpaste = event => {
        if (event.target.type !== 'url')
            openGiven(0, event.clipboardData);
    };
    document.ondragover = event => {
        event.preventDefault();
        document.body.classList.toggle('dropping', Boolean(hasPicture(event)));
    };
    document.ondragleave = event => {
        if (!event.relatedTarget)
            document.body.classList.remove('dropping');
    };
    document.ondrop = event => {
        event.preventDefault();
        document.body.classList.remove('dropping');
        openGiven(event.target.closest('[data-view=pair]') ? 1 : 0, event.dataTransfer);
    };
}

placeSliders();
showView();
showValues();
if (isSupported()) {
    listen();
    startWorker();
    followLink();
} else {
    say('This browser does not run WebAssembly with SIMD and exceptions, which this page needs. A current version of ' +
        'Chrome, Edge, Firefox or Safari does.');
    element('result').hidden = true;
    for (const control of document.querySelectorAll('input, select, button'))
        control.disabled = true;
    failed = true;
    setState();
}
