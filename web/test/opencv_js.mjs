// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

// What opencv.mjs and opencv_speed.mjs share.

import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';

/** OpenCV's functions, from a folder with opencv.js and opencv_js.wasm. */
export async function loadOpenCV(folder) {
    // The file is read here, because emscripten 3.1.6 would fetch it in a Node.js that can fetch.
    globalThis.Module = { wasmBinary: fs.readFileSync(path.join(folder, 'opencv_js.wasm')) };
    return createRequire(import.meta.url)(path.resolve(folder, 'opencv.js'));
}

/** A colour picture in a PPM file without comments, as the ImageData of a browser. */
export function readPicture(name) {
    const file = fs.readFileSync(name);
    const [header, width, height] = /^P6\s(\d+)\s(\d+)\s255\s/.exec(file.toString('latin1', 0, 40));
    const data = new Uint8ClampedArray(4 * width * height).fill(255);
    for (let i = 0; i < width * height; i++)
        data.set(file.subarray(header.length + 3 * i, header.length + 3 * i + 3), 4 * i);
    return { width: Number(width), height: Number(height), data };
}
