// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory of this distribution.
// SPDX-License-Identifier: Apache-2.0

// Detects and matches, so that the page stays responsive. The page sends one job at a time:
//
//   pixels             of the picture, if it is another one than before
//   second             the second picture's pixels, or the name of a simulated one, if it is another one than before
//   view               'keypoints' or 'pair'
//   properties, runs   of the detectors, and how often they are called
//   refines            whether the matches are refined
//
// The answer holds the second picture if it was drawn here, and for each detector what was found.

'use strict';

importScripts('aqorb.js');

const loading = createAqorb();
const DETECTORS = [0, 1];  // cv::ORB, AdaptiveQuadtreeORB

let first = [];    // what was found in the picture, for each detector
let current = '';  // the properties with which it was found, as JSON
let second = 'side';
let drawn = false;  // whether the engine has it

function checked(result) {
    if (result.error)
        throw new Error(result.error);
    return result;
}

function run(engine, job) {
    const answer = {};
    if (job.pixels) {
        checked(engine.setPicture(0, job.pixels.width, job.pixels.height, job.pixels.data));
        first = [];
        drawn = false;
    }
    if (job.second) {
        second = job.second;
        drawn = false;
    }

    const properties = JSON.stringify(job.properties);
    if (!first.length || properties !== current) {
        checked(engine.setProperties(job.properties));
        first = DETECTORS.map(detector => checked(engine.detect(0, detector, job.runs)));
        current = properties;
    }
    answer.found = first.map(found => ({ ...found }));

    if (job.view === 'pair') {
        if (!drawn && typeof second === 'string')
            answer.second = checked(engine.drawOtherView(second));
        else if (!drawn)
            checked(engine.setPicture(1, second.width, second.height, second.data));
        drawn = true;
        for (const detector of DETECTORS) {
            checked(engine.detect(1, detector, 1));
            answer.found[detector].pair = checked(engine.match(detector, job.refines));
        }
    }
    return answer;
}

onmessage = async ({ data }) => {
    try {
        const loaded = await loading;
        postMessage(data.fingerprint ? checked(loaded.fingerprint(data.quadtree, data.name)) : run(loaded, data));
    } catch (error) {
        postMessage({ error: String(error.message || error) });
    }
};
