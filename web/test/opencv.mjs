// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Tests opencv.js with the module in Node.js: opencv.mjs FOLDER MODULE
//
// FOLDER has opencv.js and opencv_js.wasm. The test in MODULE has the form of OpenCV's own ones, and runs in the test
// runner of Node.js, whose assertions have the same names.

import assert from 'node:assert/strict';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import test from 'node:test';
import vm from 'node:vm';

const [folder, module] = process.argv.slice(2).map(name => path.resolve(name));
// The file is read here, because emscripten 3.1.6 would fetch it in a Node.js that can fetch.
globalThis.Module = { wasmBinary: fs.readFileSync(path.join(folder, 'opencv_js.wasm')) };
const cv = await createRequire(import.meta.url)(path.join(folder, 'opencv.js'));

const QUnit = { module() {}, test: (name, run) => test(name, () => run(assert)) };
const script = path.join(module, 'misc/js/test/test_aqorb.js');
vm.runInThisContext(`(function (cv, QUnit) {${fs.readFileSync(script, 'utf8')}\n})`, script)(cv, QUnit);
