// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Times detectAndCompute of both detectors in Node.js, in turns: speed.mjs PAGE PLAIN
//
// PAGE and PLAIN are folders with an aqorb.js, of which the second one is compiled without SIMD.

import { createRequire } from 'node:module';
import path from 'node:path';

const require = createRequire(import.meta.url);
const ROUNDS = 40;
const builds = process.argv.slice(2).map(folder => require(path.resolve(folder, 'aqorb.js')));
const engines = await Promise.all(builds.map(create => create()));

const median = values => values.sort((a, b) => a - b)[values.length >> 1];

console.log('median of the times of one call, in ms, on the sample `street`, 960x640 pixels');
console.log('features   cv::ORB plain  SIMD   AdaptiveQuadtreeORB plain  SIMD   cv::ORB / AdaptiveQuadtreeORB, SIMD');
for (const nfeatures of [500, 1000, 2000]) {
    const times = engines.map(() => [[], []]);
    for (const engine of engines) {
        engine.drawSample('street', 960, 640);
        engine.setProperties({
            nfeatures, fastThreshold: 20, nlevels: 8, scaleFactor: 1.2, selectionType: 0, strengthWeight: 0.15,
            rankRadius: 1, minThresholdRatio: 4, adaptiveThreshold: 1,
        });
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
    const [[orb, ours], [plainOrb, plainOurs]] = times.map(both => both.map(median));
    const column = (value, width) => value.toFixed(1).padStart(width);
    console.log(String(nfeatures).padStart(8) + column(plainOrb, 16) + column(orb, 6) + column(plainOurs, 28) +
        column(ours, 6) + (orb / ours).toFixed(2).padStart(40));
}
