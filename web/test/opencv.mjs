// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Tests opencv.js with the module in Node.js: opencv.mjs FOLDER MODULE NATIVE PICTURE...
//
// FOLDER has opencv.js and opencv_js.wasm. The test in MODULE has the form of OpenCV's own ones, and runs in the test
// runner of Node.js, whose assertions have the same names. Each PICTURE is a PPM file, and NATIVE what the native
// aqorb_fingerprint printed of them.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import vm from 'node:vm';

const [folder, module, native, ...pictures] = process.argv.slice(2).map(name => path.resolve(name));
// The file is read here, because emscripten 3.1.6 would fetch it in a Node.js that can fetch.
globalThis.Module = { wasmBinary: fs.readFileSync(path.join(folder, 'opencv_js.wasm')) };
const cv = await createRequire(import.meta.url)(path.join(folder, 'opencv.js'));
const expected = fs.readFileSync(native, 'utf8');

const QUnit = { module() {}, test: (name, run) => test(name, () => run(assert)) };
const script = path.join(module, 'misc/js/test/test_aqorb.js');
vm.runInThisContext(`(function (cv, QUnit) {${fs.readFileSync(script, 'utf8')}\n})`, script)(cv, QUnit);

// A colour picture in a PPM file without comments, as the ImageData of a browser.
function readPicture(name) {
    const file = fs.readFileSync(name);
    const [header, width, height] = /^P6\s(\d+)\s(\d+)\s255\s/.exec(file.toString('latin1', 0, 40));
    const data = new Uint8ClampedArray(4 * width * height).fill(255);
    for (let i = 0; i < width * height; i++)
        data.set(file.subarray(header.length + 3 * i, header.length + 3 * i + 3), 4 * i);
    return { width: Number(width), height: Number(height), data };
}

// As in test/hash.hpp, of numbers of four bytes and of bytes.
function hash(...parts) {
    let state = 0xcbf29ce484222325n;
    for (const { buffer, byteOffset, byteLength } of parts) {
        for (const byte of new Uint8Array(buffer, byteOffset, byteLength))
            state = (state ^ BigInt(byte)) * 0x100000001b3n & 0xffffffffffffffffn;
    }
    return state.toString(16).padStart(16, '0');
}

const hashOfMat = mat => hash(Int32Array.of(mat.rows, mat.cols), mat.data);

function hashOfKeypoints(keypoints) {
    const floats = new Float32Array(7 * keypoints.size()), integers = new Int32Array(floats.buffer);
    for (let i = 0; i < keypoints.size(); i++) {
        const { pt, size, angle, response, octave, class_id } = keypoints.get(i);
        floats.set([pt.x, pt.y, size, angle, response], 7 * i);
        integers.set([octave, class_id], 7 * i + 5);
    }
    return hash(floats);
}

for (const name of pictures) {
    test(`the bytes of ${path.basename(name)} are those of the native library`, () => {
        const image = new cv.Mat(), keypoints = new cv.KeyPointVector(), descriptors = new cv.Mat();
        cv.cvtColor(cv.matFromImageData(readPicture(name)), image, cv.COLOR_RGBA2BGR);
        new cv.aqorb_AdaptiveQuadtreeORB(1000).detectAndCompute(image, new cv.Mat(), keypoints, descriptors);
        const line = expected.split('\n').find(line => line.startsWith(`${name} by default `));
        assert.equal(line.replace(/ (pyramid|measures) \w+/g, ''), `${name} by default image ${hashOfMat(image)} ` +
            `keypoints ${keypoints.size()} ${hashOfKeypoints(keypoints)} descriptors ${hashOfMat(descriptors)}`);
    });
}
