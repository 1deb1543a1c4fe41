// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Tests aqorb.js and aqorb.wasm in Node.js: engine.mjs PAGE NATIVE
//
// PAGE is the folder of the page, and NATIVE one with what the native aqorb_fingerprint printed: ranked.txt and
// quadtree.txt.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';

const [page, native] = process.argv.slice(2).map(folder => path.resolve(folder));
// The file is read here, because emscripten 3.1.6 would fetch it in a Node.js that can fetch.
const engine = await createRequire(import.meta.url)(path.join(page, 'aqorb.js'))({
    wasmBinary: fs.readFileSync(path.join(page, 'aqorb.wasm')),
});
const BOTH = [0, 1];

function ok(result) {
    assert.equal(result.error, undefined);
    return result;
}

function detectAll(index) {
    return BOTH.map(detector => ok(engine.detect(index, detector, 1)));
}

// distributionUniformity takes the logarithm of the C library, whose last bit may be another one in WebAssembly.
const withoutMeasures = lines => lines.map(line => line.replace(/ measures \w+/, ''));

for (const [name, quadtree] of [['ranked', false], ['quadtree', true]]) {
    test(`the bytes of 60 scenes with random parameters are those of the native library, ${name}`, () => {
        const expected = fs.readFileSync(path.join(native, `${name}.txt`), 'utf8').split('\n')
            .filter(line => line.startsWith('scene '));
        assert.equal(expected.length, 60);
        assert.deepEqual(withoutMeasures(ok(engine.fingerprint(quadtree, '')).lines.trim().split('\n')),
            withoutMeasures(expected));
    });
}

test('a property out of its range is reported by name, with its value', () => {
    const { error } = engine.setProperties({ rankRadius: 99 });
    assert.match(error, /rankRadius.*99/is);
    ok(engine.setProperties({}));
});

test('pictures of any size can be detected in', () => {
    for (const properties of [{}, { nlevels: 12, scaleFactor: 2 }]) {
        ok(engine.setProperties(properties));
        for (const [width, height] of [[1, 1], [7, 300], [33, 33], [641, 479], [1280, 1280]]) {
            const pixels = new Uint8ClampedArray(width * height * 4).map((_, i) => (i * 2654435761) >>> 13);
            ok(engine.setPicture(0, width, height, pixels));
            detectAll(0);
            for (const view of ['side', 'far', 'night']) {
                ok(engine.drawOtherView(view));
                detectAll(1);
            }
        }
    }
});

const SIZES = [[960, 640], [1280, 720], [1000, 700], [700, 1000], [1920, 1080]];

// Where a point of the first picture is in a view, by the words of its description.
function turned([x, y], [width, height], degrees, scale) {
    const [cos, sin] = [Math.cos, Math.sin].map(f => scale * f(degrees * Math.PI / 180));
    const centre = [(width - 1) / 2, (height - 1) / 2], [dx, dy] = [x - centre[0], y - centre[1]];
    return [centre[0] + cos * dx - sin * dy, centre[1] + sin * dx + cos * dy];
}

function mapped(h, [x, y]) {
    const w = h[6] * x + h[7] * y + h[8];
    return [(h[0] * x + h[1] * y + h[2]) / w, (h[3] * x + h[4] * y + h[5]) / w];
}

for (const [width, height] of SIZES) {
    test(`what is right in each view of a picture of ${width}x${height} follows from how it was drawn`, () => {
        ok(engine.setProperties({ nfeatures: 1000 }));
        ok(engine.drawScene(width, height));
        detectAll(0);
        for (const [view, degrees, scale] of [['side', 0, 1], ['far', 40, .5], ['night', 8, 1]]) {
            ok(engine.drawOtherView(view));
            detectAll(1);
            for (const detector of BOTH) {
                const { homography, known, matches, count, agreeing } = ok(engine.match(detector, false));
                assert.equal(known, true);
                assert.equal(matches.length, 5 * count);
                assert.ok(agreeing > 30 && agreeing < count, `${view}, ${detector}: ${agreeing} of ${count}`);
                let right = 0;
                for (let i = 0; i < matches.length; i += 5) {
                    const [x, y, x2, y2, isRight] = matches.subarray(i, i + 5);
                    right += isRight;
                    const [u, v] = view === 'side' ? mapped(homography, [x, y]) :
                        turned([x, y], [width, height], degrees, scale);
                    const error = Math.hypot(u - x2, v - y2);
                    // The homography of a view from the side is estimated, and is exact to two pixels.
                    if (Math.abs(error - 3) > (view === 'side' ? 2 : .001))
                        assert.equal(isRight, error < 3 ? 1 : 0, `${view}: ${error} pixels`);
                }
                assert.equal(right, agreeing);
                const refined = ok(engine.match(detector, true));
                assert.ok(refined.agreeing > .6 * agreeing && refined.count - refined.agreeing < count - agreeing);
                if (view !== 'side')
                    continue;
                const corners = [[0, 0], [width, 0], [width, height], [0, height]];
                const expected = [[-.06, .1], [.92, -.14], [1.02, 1.04], [.05, .88]];
                corners.forEach((corner, i) => {
                    const [u, v] = mapped(refined.homography, corner);
                    const error = Math.hypot(u - expected[i][0] * width, v - expected[i][1] * height);
                    assert.ok(error < 2, `corner ${i}: ${error}`);
                });
            }
        }
    });
}
