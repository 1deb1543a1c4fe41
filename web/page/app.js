// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

'use strict';

const LONGEST_SIDE = 1280;               // of a picture, in pixels
const GRID = { columns: 16, rows: 12 };  // of the places
const DISTINCT = 4;                      // pixels between two matches that count as distinct
const LINES = { least: 30, most: 120, pixels: 8 };  // between two pictures: one in so many pixels of their width
const COLOURS = ['#ff8126', '#1fc8e3'];  // of the keypoints of either detector, on pictures of any brightness
const CAMERA_ERRORS = {
    NotAllowedError: 'The camera was refused. Allow it for this page in the browser, or open a picture instead.',
    NotFoundError: 'No camera was found. Open a picture instead.',
    InsecureContext: 'The camera works only over HTTPS or from localhost. Open a picture instead.',
};

const element = id => document.getElementById(id);
const canvases = [...document.querySelectorAll('#figures canvas')];
const viewOf = () => document.querySelector('[name=view]:checked').value;

let worker = null;
let wanted = null;  // pictures that the worker does not have yet; an empty object if it has them, null if all is done
let sent = null;    // the job that the worker does
let openings = 0;   // of pictures that are being fetched or decoded
let failed = false;
let asked = [0, 0];  // how often a first and a second picture were asked for: the last one counts
let pictures = [];   // canvases of both pictures, as they were last detected in
let shown = null;    // what was found in them
let stream = null;   // of the camera
let drawnWidth = 0;
const video = document.createElement('video');

function say(sentence) {
    element('message').textContent = sentence;
    element('message').hidden = !sentence;
}

// There is nothing to do before the first picture is here.
const isWaiting = () => Boolean(wanted && (wanted.picture || pictures[0]));

function setState() {
    const state = openings || sent || isWaiting() ? 'busy' : failed ? 'failed' : 'ready';
    document.body.dataset.state = state;
    element('loading').hidden = Boolean(shown) || state !== 'busy';
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

// Asks for what the controls say, in pictures that may be new: picture (a canvas), and second (a canvas, or the name of
// a simulated one). While the worker is busy nothing is sent, so a slider never leaves a queue.
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
    sent = { picture, second, view: viewOf() };
    const message = { view: sent.view, properties, runs: stream ? 1 : 3, refines: element('refine').checked };
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
    shown = { found: answer.found, isPair: job.view === 'pair' };
    if (shown.isPair) {
        for (const { pair } of shown.found)
            pair.distinct = distinct(pair.matches);
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

// The picture that `read` returns as a file, as a canvas, or null if the browser cannot read it or if another one was
// asked for meanwhile.
async function decoded(which, read, sorry) {
    const ticket = ++asked[which];
    openings++;
    setState();
    let picture = null;
    try {
        const image = await createImageBitmap(await read(), { colorSpaceConversion: 'none' });
        picture = scaled(image, image.width, image.height);
    } catch {
        if (ticket === asked[which])
            say(sorry);
    }
    openings--;
    setState();
    return ticket === asked[which] ? picture : null;
}

async function openFile(which, file) {
    if (!file)
        return;
    say('');
    const picture = await decoded(which, async () => file,
        `“${file.name}” is not a picture that this browser can read. Open a JPEG, PNG or WebP file.`);
    if (!picture)
        return;
    showOwn(which, true);
    if (!which)
        stopCamera();
    request(which ? { second: picture } : { picture });
}

async function openSample(sentence = '') {
    stopCamera();
    showOwn(0, false);
    say(sentence);
    const { value, dataset } = element('sample').selectedOptions[0];
    const picture = await decoded(0, async () => (await fetch(`photographs/${dataset.file || value}.jpg`)).blob(),
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
    const context = canvas.getContext('2d');
    context.globalCompositeOperation = 'multiply';
    context.fillStyle = `rgb(${100 * light}% ${100 * light}% ${100 * light}%)`;
    context.fillRect(0, 0, canvas.width, canvas.height);
}

function openOther() {
    asked[1]++;
    showOwn(1, false);
    request({ second: element('other').value });
}

// A list says so when none of its pictures is shown.
function showOwn(which, isOwn) {
    const [list, own] = which ? ['other', 'own-second'] : ['sample', 'own'];
    element(own).hidden = !isOwn;
    if (isOwn)
        element(list).value = '';
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
    const { isPair } = shown;
    const [first, second] = pictures;
    element('figures').classList.toggle('wide', isPair);
    // On a wide screen both pairs are in sight at once.
    const widest = isPair && matchMedia('(min-width: 62rem)').matches ?
        `${Math.max(560, Math.round(.76 * innerHeight * first.width / first.height))}px` : '';
    for (const figure of document.querySelectorAll('#figures figure'))
        figure.style.maxWidth = widest;
    drawnWidth = canvases[0].clientWidth;
    const oneIn = isPair ? lineStep() : 0;
    canvases.forEach((canvas, detector) => {
        const width = canvas.clientWidth;
        const stacked = width < 560;
        const [columns, rows] = !isPair ? [1, 1] : stacked ? [1, 2] : [2, 1];
        const scale = width / columns / first.width;
        const cell = { width: width / columns, height: first.height * scale };
        canvas.width = Math.round(width * devicePixelRatio);
        canvas.height = Math.round(cell.height * rows * devicePixelRatio);
        const context = canvas.getContext('2d');
        context.scale(canvas.width / width, canvas.width / width);
        context.drawImage(first, 0, 0, cell.width, cell.height);
        const found = shown.found[detector];
        if (isPair) {
            const fit = Math.min(cell.width / second.width, cell.height / second.height);
            const at = { x: stacked ? 0 : cell.width, y: stacked ? cell.height : 0, scale: fit };
            context.drawImage(second, at.x, at.y, second.width * fit, second.height * fit);
            drawMatches(context, found.pair, scale, at, COLOURS[detector], oneIn);
        } else {
            circles(context, pointsOf(found.keypoints), scale, width < 300 ? 1.5 : 2.75);
            strokeTwice(context, [], 'rgb(0 0 0 / 55%)', width < 300 ? .75 : 1.25, COLOURS[detector]);
        }
    });
}

const pointsOf = numbers =>
    Array.from({ length: numbers.length / 2 }, (_, i) => ({ x: numbers[2 * i], y: numbers[2 * i + 1] }));

function circles(context, points, scale, radius) {
    context.beginPath();
    for (const { x, y } of points) {
        context.moveTo((x + .5) * scale + radius, (y + .5) * scale);
        context.arc((x + .5) * scale, (y + .5) * scale, radius, 0, 2 * Math.PI);
    }
}

// A dark edge makes a line visible on a bright picture.
function strokeTwice(context, path, edge, width, colour) {
    context.strokeStyle = edge;
    context.lineWidth = 2.25 * width;
    context.stroke(...path);
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.stroke(...path);
}

function drawSpots(context, points, scale, colour) {
    circles(context, points, scale, drawnWidth < 400 ? 1.25 : 1.75);
    context.strokeStyle = 'rgb(0 0 0 / 60%)';
    context.lineWidth = .75;
    context.stroke();
    context.fillStyle = colour;
    context.fill();
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

function drawMatches(context, { matches, distinct, homography }, scale, at, colour, oneIn) {
    drawSpots(context, matchesOf(matches).filter(match => !match.isRight), scale, 'rgb(255 255 255 / 60%)');
    if (element('lines').checked) {
        const lines = new Path2D();
        for (let i = 0; i < distinct.length; i += oneIn) {
            const { x, y, x2, y2 } = distinct[i];
            lines.moveTo((x + .5) * scale, (y + .5) * scale);
            lines.lineTo(at.x + (x2 + .5) * at.scale, at.y + (y2 + .5) * at.scale);
        }
        context.globalAlpha = .65;
        strokeTwice(context, [lines], 'rgb(0 0 0 / 35%)', 1, colour);
        context.globalAlpha = 1;
    }
    drawSpots(context, distinct, scale, colour);
    context.translate(at.x, at.y);
    drawSpots(context, distinct.map(({ x2, y2 }) => ({ x: x2, y: y2 })), at.scale, colour);
    if (!homography)
        return;
    const { width, height } = pictures[0];
    const outline = new Path2D();
    for (const [x, y] of [[0, 0], [width, 0], [width, height], [0, height]]) {
        const [u, v, w] = [0, 3, 6].map(row => homography[row] * x + homography[row + 1] * y + homography[row + 2]);
        outline.lineTo(u / w * at.scale, v / w * at.scale);
    }
    outline.closePath();
    context.beginPath();
    context.rect(0, 0, pictures[1].width * at.scale, pictures[1].height * at.scale);
    context.clip();
    strokeTwice(context, [outline], 'rgb(0 0 0 / 60%)', 2, '#fff');
}

// Matches: x and y in the first picture, those in the second, and whether it is right. The nearest descriptors come
// first.
function matchesOf(numbers) {
    return Array.from({ length: numbers.length / 5 }, (_, i) => {
        const [x, y, x2, y2, isRight] = numbers.subarray(5 * i, 5 * i + 5);
        return { x, y, x2, y2, isRight };
    });
}

// The first of those right matches that lie together in either picture: several keypoints on one corner of the scene
// say no more about it than one.
function distinct(numbers) {
    const kept = [];
    for (const match of matchesOf(numbers)) {
        if (match.isRight && kept.every(({ x, y, x2, y2 }) => Math.hypot(x - match.x, y - match.y) >= DISTINCT &&
                Math.hypot(x2 - match.x2, y2 - match.y2) >= DISTINCT))
            kept.push(match);
    }
    return kept;
}

// How many cells of the grid over the first picture hold a right match.
const places = pair => new Set(matchesOf(pair.matches).filter(match => match.isRight).map(({ x, y }) =>
    Math.floor(y * GRID.rows / pictures[0].height) * GRID.columns +
    Math.floor(x * GRID.columns / pictures[0].width))).size;

// The table

// For each row: whether it is of a pair, its name, what it is, whether more or less is better, and the value. A value
// of null is none.
const MEASURES = [
    [true, 'Distinct correct matches', '', Math.max,
        ({ pair }) => pair.known || pair.homography ? pair.distinct.length : null],
    [true, 'Places', 'cells with a correct match', Math.max,
        ({ pair }) => pair.known || pair.homography ? places(pair) : null],
    [true, 'Matches in all', 'and how many are correct', null, ({ pair }) => `${pair.count}, ${pair.agreeing}`],
    [true, 'Error', 'pixels, median of the correct ones', Math.min, ({ pair }) => pair.agreeing ? pair.medianError : null,
        value => value.toFixed(2)],
    [false, 'Keypoints', '', null, found => found.count],
    [false, 'Uniformity', 'less is more uniform', Math.min, found => found.count ? found.uniformity : null,
        value => value.toFixed(1)],
    [false, 'Occupied cells', '', Math.max, found => found.occupancy,
        value => `${(100 * value).toFixed(1)} %`],
    [false, 'Time', '', Math.min, found => found.time, value => `${value.toFixed(1)} ms`],
];

function fillTable() {
    const rows = [];
    for (const [isOfPair, name, note, best, valueIn, text = String] of MEASURES) {
        if (isOfPair && !shown.isPair)
            continue;
        const values = shown.found.map(valueIn);
        const row = document.createElement('tr');
        row.innerHTML = '<th scope="row"><small></small></th><td></td><td></td>';
        row.cells[0].prepend(name);
        row.cells[0].lastChild.textContent = note;
        values.forEach((value, i) => {
            const other = values[1 - i];
            row.cells[i + 1].textContent = value === null ? 'none found' : text(value);
            row.cells[i + 1].classList.toggle('better', Boolean(best) && value !== null && value !== other &&
                (other === null || best(value, other) === value));
        });
        rows.push(row);
    }
    element('measures').replaceChildren(...rows);
    element('advice').hidden = !shown.isPair || shown.found.every(found => found.pair.homography);
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

function showControls() {
    for (const output of document.querySelectorAll('output')) {
        const slider = element(output.htmlFor);
        const digits = (slider.step.split('.')[1] || '').length;
        output.textContent = slider.dataset.values ? String(valueOf(slider)) : Number(slider.value).toFixed(digits);
        slider.setAttribute('aria-valuetext', output.textContent);
    }
    for (const part of document.querySelectorAll('.of-view'))
        part.hidden = part.dataset.view !== viewOf();
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

// The link. What differs from the defaults is after the #, which a browser does not send to a server: sample, second,
// view, and the ids of the fields below.

const linkedFields = () => [...element('properties').querySelectorAll('input, select'), element('refine'), element('lines')];

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

async function copyLink() {
    const words = new URLSearchParams();
    const add = (name, value, usual) => String(value) === String(usual) || words.set(name, value);
    add('sample', element('sample').value, '');
    add('view', viewOf(), 'keypoints');
    add('second', element('other').value, element('other').options[0].value);
    for (const field of linkedFields()) {
        if (field.type === 'checkbox')
            add(field.id, Number(field.checked), Number(field.defaultChecked));
        else if (field.value !== (field.defaultValue ?? field.options[0].value))
            words.set(field.id, valueOf(field));
    }
    const link = `${location.href.split('#')[0]}#${words}`;
    history.replaceState(null, '', link);
    element('link').value = link;
    element('link-field').hidden = element('copied').hidden = false;
    const isCopied = await navigator.clipboard?.writeText(link).then(() => true, () => false);
    element('copied').textContent = (isCopied ? 'The link is copied.' : 'Copy the link from the field.') +
        (element('sample').value && element('other').value ? '' : ' Your own picture stays on your device.');
}

// Opens what the address of the page says.
function followLink() {
    const words = new URLSearchParams(location.hash.slice(1));
    for (const field of linkedFields())
        setField(field, words.get(field.id));
    const views = [...document.querySelectorAll('[name=view]')];
    (views.find(view => view.value === words.get('view')) || views[0]).checked = true;
    showControls();
    const sample = words.get('sample');
    setField(element('sample'), sample);
    setField(element('other'), words.get('second'));
    openOther();
    openSample(sample && sample !== element('sample').value ? `There is no sample “${sample}” here.` : '');
}

function listen() {
    element('sample').onchange = () => openSample();
    ['file', 'second'].forEach((id, which) => {
        element(id).onchange = ({ target }) => {
            openFile(which, target.files[0]);
            target.value = '';  // so that the same file can be opened again
        };
    });
    element('camera').onclick = toggleCamera;
    element('other').onchange = openOther;
    element('copy').onclick = copyLink;
    element('link').onfocus = ({ target }) => target.select();
    window.onhashchange = followLink;
    element('views').onchange = () => {
        enlarge(false);
        showControls();
        request();
    };
    element('properties').oninput = () => {
        showControls();
        request();
    };
    element('properties').onreset = () => setTimeout(element('properties').oninput);
    element('properties').onsubmit = event => event.preventDefault();
    element('lines').onchange = draw;
    element('refine').onchange = () => request();
    element('large').onchange = ({ target }) => enlarge(target.checked);
    canvases.forEach((canvas, i) => {
        const frame = canvas.parentElement, other = canvases[1 - i].parentElement;
        canvas.onclick = event => enlarge(!element('large').checked, event.offsetX / canvas.clientWidth,
            event.offsetY / canvas.clientHeight);
        frame.onscroll = () => other.scrollTo(frame.scrollLeft, frame.scrollTop);
    });
    new ResizeObserver(() => canvases[0].clientWidth === drawnWidth || draw()).observe(element('figures'));

    document.onpaste = event => openFile(0, event.clipboardData.files[0]);
    document.ondragover = event => {
        event.preventDefault();
        document.body.classList.toggle('dropping', event.dataTransfer.types.includes('Files'));
    };
    document.ondragleave = event => event.relatedTarget || document.body.classList.remove('dropping');
    document.ondrop = event => {
        event.preventDefault();
        document.body.classList.remove('dropping');
        openFile(event.target.closest('[data-view=pair]') ? 1 : 0, event.dataTransfer.files[0]);
    };
}

// A slider with a list begins, and begins again, at the number of the list that is nearest to its default.
for (const slider of document.querySelectorAll('[data-values]'))
    slider.defaultValue = placeOf(slider, slider.dataset.default);
showControls();
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
