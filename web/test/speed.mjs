// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Times detectAndCompute of both detectors in Node.js, in turns: speed.mjs PAGE PLAIN
//
// PAGE and PLAIN are folders with an aqorb.js; in the second one the module, but not OpenCV, is compiled without SIMD.

import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';

const require = createRequire(import.meta.url);
const ROUNDS = 40;
const engines = await Promise.all(process.argv.slice(2).map(folder => require(path.resolve(folder, 'aqorb.js'))({
    wasmBinary: fs.readFileSync(path.join(folder, 'aqorb.wasm')),
})));

const median = values => values.sort((a, b) => a - b)[values.length >> 1];

console.log('median of the times of one call, in ms, on the drawn scene `street`, 960x640 pixels');
console.log('features   cv::ORB   AdaptiveQuadtreeORB without SIMD   with SIMD   cv::ORB / AdaptiveQuadtreeORB');
for (const nfeatures of [500, 1000, 2000]) {
    const times = engines.map(() => [[], []]);
    for (const engine of engines) {
        engine.drawScene('street', 960, 640);
        engine.setProperties({ nfeatures });
    }
    for (let round = -10; round < ROUNDS; round++) {
        engines.forEach((engine, build) => {
            for (const detector of [0, 1]) {
                const { time } = engine.detect(0, detector, 1);
                if (round >= 0)  // the first ones are compiled for speed meanwhile
                    times[build][detector].push(time);
            }
        });
    }
    const [[orb, ours], [, plain]] = times.map(both => both.map(median));
    const column = (value, width, digits = 1) => value.toFixed(digits).padStart(width);
    console.log(column(nfeatures, 8, 0) + column(orb, 10) + column(plain, 35) + column(ours, 12) +
        column(orb / ours, 32, 2));
}
