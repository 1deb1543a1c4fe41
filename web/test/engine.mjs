// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Tests aqorb.js and aqorb.wasm in Node.js: engine.mjs PAGE NATIVE
//
// PAGE is the folder of the page, and NATIVE one with what the native aqorb_fingerprint printed: ranked.txt and
// balanced.txt.

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

for (const [name, balanced] of [['ranked', false], ['balanced', true]]) {
    test(`the bytes of 60 scenes with random parameters are those of the native library, ${name}`, () => {
        const expected = fs.readFileSync(path.join(native, `${name}.txt`), 'utf8').split('\n')
            .filter(line => line.startsWith('scene '));
        assert.equal(expected.length, 60);
        assert.deepEqual(withoutMeasures(ok(engine.fingerprint(balanced, '')).lines.trim().split('\n')),
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

test('the homography of the simulated view is the one by which it was drawn, within 2 pixels at the corners', () => {
    ok(engine.setProperties({ nfeatures: 1000 }));
    ok(engine.drawScene(960, 640));
    ok(engine.drawOtherView('side'));
    detectAll(0);
    detectAll(1);
    const corners = [[0, 0], [960, 0], [960, 640], [0, 640]];
    const expected = [[-.06, .1], [.92, -.14], [1.02, 1.04], [.05, .88]];
    for (const detector of BOTH) {
        const { homography: h, matches, count, agreeing } = ok(engine.match(detector));
        assert.equal(matches.length, 5 * count);
        assert.equal(matches.filter((value, i) => i % 5 === 4 && value).length, agreeing);
        corners.forEach(([x, y], i) => {
            const w = h[6] * x + h[7] * y + h[8];
            const error = Math.hypot((h[0] * x + h[1] * y + h[2]) / w - expected[i][0] * 960,
                (h[3] * x + h[4] * y + h[5]) / w - expected[i][1] * 640);
            assert.ok(error < 2, `corner ${i}: ${error}`);
        });
    }
});
