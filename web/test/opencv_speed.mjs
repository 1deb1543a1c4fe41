// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Times what the page asks of its engine for two pictures, by the engine and by opencv.js, in turns:
// opencv_speed.mjs PAGE FOLDER PICTURE...
//
// PAGE is the folder of the page, FOLDER has opencv.js and opencv_js.wasm, and each PICTURE is a PPM file. The second
// pictures are the three that the page makes. Both detectors are timed, as the page shows both. The ratio is the median
// of those of all turns, which depends least on what else the machine does.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { loadOpenCV, readPicture } from './opencv_js.mjs';

const ROUNDS = 14, WARM_UP = 4;  // the first ones are compiled for speed meanwhile
const SAME_PLACE = 3;           // pixels, as in web/src/engine.cpp
const [page, folder, ...names] = process.argv.slice(2);
const engine = await createRequire(import.meta.url)(path.resolve(page, 'aqorb.js'))({
    wasmBinary: fs.readFileSync(path.join(page, 'aqorb.wasm')),
});
const cv = await loadOpenCV(folder);

// As web/page/worker.js does it.
const own = {
    setPictures(pictures) {
        pictures.forEach(({ width, height, data }, i) => engine.setPicture(i, width, height, data));
    },
    setFeatures: nfeatures => engine.setProperties({ nfeatures }),
    detect: (picture, detector) => engine.detect(picture, detector, 1),
    match: detector => engine.match(detector),
};

// The same results by opencv.js, in the same form. Its objects are made once.
const mats = n => Array.from({ length: n }, () => new cv.Mat());
const greys = mats(2), [noMask, pairs, distances, inliers] = mats(4);
const newFeatures = () => ({ keypoints: new cv.KeyPointVector(), descriptors: new cv.Mat() });
const features = [0, 1].map(() => [newFeatures(), newFeatures()]);
let detectors = [];

const opencv = {
    setPictures(pictures) {
        pictures.forEach((picture, i) => {
            const rgba = cv.matFromImageData(picture);
            cv.cvtColor(rgba, greys[i], cv.COLOR_RGBA2GRAY);
            rgba.delete();
        });
    },

    setFeatures(nfeatures) {
        detectors.forEach(detector => detector.delete());
        detectors = [new cv.ORB(nfeatures), new cv.aqorb_AdaptiveQuadtreeORB(nfeatures)];
    },

    detect(picture, detector) {
        const found = features[picture][detector], size = greys[picture].size();
        const start = performance.now();
        detectors[detector].detectAndCompute(greys[picture], noMask, found.keypoints, found.descriptors);
        const time = performance.now() - start;
        const count = found.keypoints.size();
        const array = found.array = new Float32Array(4 * count);
        for (let i = 0; i < count; i++) {
            const { pt, size, angle } = found.keypoints.get(i);
            [array[4 * i], array[4 * i + 1], array[4 * i + 2], array[4 * i + 3]] = [pt.x, pt.y, size, angle];
        }
        return {
            keypoints: array, count, time,
            uniformity: cv.aqorb_distributionUniformity(found.keypoints, size),
            occupancy: cv.aqorb_distributionOccupancy(found.keypoints, size),
        };
    },

    match(detector) {
        const [a, b] = features.map(found => found[detector]);
        cv.aqorb_matchArrays(a.descriptors, b.descriptors, pairs, distances);
        const count = pairs.rows, rows = pairs.data32S, bits = distances.data32S;
        const order = Array.from({ length: count }, (_, i) => i).sort((i, j) => bits[i] - bits[j]);
        const from = new cv.Mat(count, 1, cv.CV_32FC2), to = new cv.Mat(count, 1, cv.CV_32FC2);
        const fromData = from.data32F, toData = to.data32F, matches = new Float32Array(5 * count);
        order.forEach((pair, i) => {
            for (const axis of [0, 1]) {
                fromData[2 * i + axis] = matches[5 * i + axis] = a.array[4 * rows[2 * pair] + axis];
                toData[2 * i + axis] = matches[5 * i + 2 + axis] = b.array[4 * rows[2 * pair + 1] + axis];
            }
        });
        // Of OpenCV's methods that find as many right matches this is the fastest.
        const found = cv.findHomography(from, to, cv.RHO, SAME_PLACE, inliers, 2000, 0.999);
        const homography = found.empty() ? null : found.data64F.slice();
        let agreeing = 0;
        for (let i = 0; homography && i < matches.length; i += 5) {
            const h = homography, [x, y, x2, y2] = matches.subarray(i, i + 4), w = h[6] * x + h[7] * y + h[8];
            const error = Math.hypot((h[0] * x + h[1] * y + h[2]) / w - x2, (h[3] * x + h[4] * y + h[5]) / w - y2);
            agreeing += matches[i + 4] = w > 0 && error <= SAME_PLACE ? 1 : 0;
        }
        [from, to, found].forEach(mat => mat.delete());
        return { matches, count, agreeing, homography };
    },
};

/** What is found in two pictures, and the times of the steps in ms. */
function run(by, pictures) {
    const times = [performance.now()];
    by.setPictures(pictures);
    times.push(performance.now());
    const found = [0, 1].map(picture => [0, 1].map(detector => by.detect(picture, detector)));
    times.push(performance.now());
    const matched = [0, 1].map(detector => by.match(detector));
    times.push(performance.now());
    const [pictureTime, featureTime, matchTime] = times.slice(1).map((time, i) => time - times[i]);
    const detectTime = found.flat().reduce((sum, { time }) => sum + time, 0);
    const all = times[3] - times[0];
    return { found, matched, times: [pictureTime, detectTime, featureTime - detectTime, matchTime, all] };
}

const median = values => values.sort((a, b) => a - b)[values.length >> 1];
const column = (value, width, digits = 1) => value.toFixed(digits).padStart(width);

const jobs = names.map(readPicture).flatMap(first => ['side', 'far', 'night'].map(view => {
    engine.setPicture(0, first.width, first.height, first.data);
    const { width, height, pixels } = engine.drawOtherView(view);
    return [first, { width, height, data: pixels }];
}));

console.log(`median of the times of one pair of pictures with both detectors, in ms, over ${jobs.length} pairs`);
console.log('features  step                     engine  opencv.js  opencv.js / engine');
for (const nfeatures of [500, 1000, 2000]) {
    const steps = ['grey pictures', 'detectAndCompute', 'keypoints, measures', 'matches, homography', 'all'];
    const times = steps.map(() => [[], []]), agreeing = [0, 0];
    for (const by of [own, opencv])
        by.setFeatures(nfeatures);
    for (const pictures of jobs) {
        for (let round = -WARM_UP; round < ROUNDS; round++) {
            const results = [];
            for (const by of round % 2 ? [0, 1] : [1, 0])
                results[by] = run([own, opencv][by], pictures);
            const [ofEngine, ofOpenCV] = results.map(({ found }) => found.flat().map(({ keypoints }) => keypoints));
            assert.deepEqual(ofEngine, ofOpenCV);
            for (let by = 0; round >= 0 && by < 2; by++) {
                steps.forEach((_, step) => times[step][by].push(results[by].times[step]));
                agreeing[by] += results[by].matched[0].agreeing + results[by].matched[1].agreeing;
            }
        }
    }
    steps.forEach((step, i) => {
        const ratio = median(times[i][1].map((time, turn) => time / times[i][0][turn]));
        const columns = times[i].map(ofOne => column(median(ofOne), 11)).join('') + column(ratio, 20, 2);
        console.log(column(nfeatures, 8, 0) + '  ' + step.padEnd(20) + columns);
    });
    console.log(column(nfeatures, 8, 0) + '  ' + 'matches that agree'.padEnd(20) +
        agreeing.map(number => column(number / ROUNDS, 11, 0)).join('') + column(agreeing[1] / agreeing[0], 20, 2));
}
