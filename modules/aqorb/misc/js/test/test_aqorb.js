// This file is part of aqorb. Copyright (C) The aqorb developers.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution.
// SPDX-License-Identifier: Apache-2.0

// A grey image full of corners: squares of random place, size and brightness, the same at every run.
function squares(width, height) {
  let state = 1;
  let random = (end) => {
    state = (state * 48271) % 2147483647;
    return state % end;
  };
  let image = new cv.Mat(height, width, cv.CV_8UC1, new cv.Scalar(128));
  for (let i = 0; i < 1500; i++) {
    let side = 5 + random(25);
    let corner = new cv.Point(random(width), random(height));
    let opposite = new cv.Point(corner.x + side, corner.y + side);
    cv.rectangle(image, corner, opposite, new cv.Scalar(random(256)), cv.FILLED);
  }
  return image;
}

function describe(image, nfeatures) {
  let orb = new cv.aqorb_AdaptiveQuadtreeORB(nfeatures);
  let keypoints = new cv.KeyPointVector();
  let descriptors = new cv.Mat();
  orb.detectAndCompute(image, new cv.Mat(), keypoints, descriptors);
  return { keypoints, descriptors };
}

function toArray(vector) {
  return Array.from({ length: vector.size() }, (_, i) => vector.get(i));
}

QUnit.module('Aqorb', {});
QUnit.test('AdaptiveQuadtreeORB', function(assert) {
  let orb = new cv.aqorb_AdaptiveQuadtreeORB(400);
  assert.ok(orb instanceof cv.ORB);
  assert.equal(orb.getDefaultName(), 'Feature2D.AdaptiveQuadtreeORB');

  let image = squares(640, 480);
  let { keypoints, descriptors } = describe(image, 400);
  assert.equal(keypoints.size(), 400);
  assert.deepEqual([descriptors.rows, descriptors.cols, descriptors.type()], [400, 32, cv.CV_8UC1]);

  let detected = new cv.KeyPointVector();
  let mask = cv.Mat.zeros(480, 640, cv.CV_8UC1);
  orb.detect(image, detected);
  assert.deepEqual(toArray(detected), toArray(keypoints));
  orb.detect(image, detected, mask);
  assert.equal(detected.size(), 0);

  let levels = new cv.MatVector();
  orb.buildPyramid(image, levels);
  assert.equal(levels.size(), 8);
  assert.deepEqual(levels.get(0).data, image.data);
});

QUnit.test('Properties', function(assert) {
  let orb = new cv.aqorb_AdaptiveQuadtreeORB();
  let values = { StrengthWeight: 0.5, OctaveSuppression: 1.5, SubPixel: false, AdaptiveThreshold: false,
    MinThresholdRatio: 3, CellSize: 50, MaxDepth: 4, RankRadius: 1.5,
    SelectionType: cv.aqorb_AdaptiveQuadtreeORB_SelectionType.BALANCED_SELECTION };
  for (let name in values) {
    assert.notEqual(orb['get' + name](), values[name], name);
    orb['set' + name](values[name]);
    assert.equal(orb['get' + name](), values[name], name);
  }
});

QUnit.test('retainUniform', function(assert) {
  let size = new cv.Size(640, 480);
  let keypoints = new cv.KeyPointVector();
  new cv.FastFeatureDetector().detect(squares(640, 480), keypoints);
  assert.ok(keypoints.size() > 300);

  let strongest = new cv.KeyPointVector();
  toArray(keypoints).sort((a, b) => b.response - a.response).slice(0, 300).forEach((k) => strongest.push_back(k));
  cv.aqorb_retainUniform(keypoints, size, 300);
  assert.equal(keypoints.size(), 300);
  assert.ok(cv.aqorb_distributionUniformity(keypoints, size) < cv.aqorb_distributionUniformity(strongest, size));
  assert.ok(cv.aqorb_distributionOccupancy(keypoints, size) > cv.aqorb_distributionOccupancy(strongest, size));
});

QUnit.test('HammingMatcher', function(assert) {
  let { descriptors } = describe(squares(640, 480), 400);
  let query = descriptors.rowRange(0, 300);
  let train = descriptors.rowRange(100, 400);  // query row 100 + i is train row i

  for (let crossCheck of [false, true]) {
    let matches = new cv.DMatchVector();
    let expected = new cv.DMatchVector();
    new cv.aqorb_HammingMatcher(cv.NORM_HAMMING, crossCheck).match(query, train, matches);
    new cv.BFMatcher(cv.NORM_HAMMING, crossCheck).match(query, train, expected);
    assert.deepEqual(toArray(matches), toArray(expected));
    assert.equal(toArray(matches).filter((m) => m.queryIdx === 100 + m.trainIdx && m.distance === 0).length, 200);
  }

  let matches = new cv.DMatchVectorVector();
  let expected = new cv.DMatchVectorVector();
  new cv.aqorb_HammingMatcher().knnMatch(query, train, matches, 2);
  new cv.BFMatcher(cv.NORM_HAMMING).knnMatch(query, train, expected, 2);
  assert.equal(matches.size(), 300);
  assert.deepEqual(toArray(matches).map(toArray), toArray(expected).map(toArray));
});

QUnit.test('Matches as arrays', function(assert) {
  let { keypoints, descriptors } = describe(squares(640, 480), 400);
  let pairs = new cv.Mat();
  let distances = new cv.Mat();
  let matches = new cv.DMatchVector();
  new cv.aqorb_HammingMatcher(cv.NORM_HAMMING, true).match(descriptors, descriptors, matches);
  cv.aqorb_matchArrays(descriptors, descriptors, pairs, distances);
  assert.deepEqual(Array.from(pairs.data32S), toArray(matches).flatMap((m) => [m.queryIdx, m.trainIdx]));
  assert.deepEqual(Array.from(distances.data32S), toArray(matches).map((m) => m.distance));

  cv.aqorb_knnMatchArrays(descriptors, descriptors, pairs, distances, 2);
  assert.deepEqual([pairs.rows, pairs.cols], [400, 2]);
  assert.ok(distances.data32S.every((distance, i) => i % 2 ? distance >= distances.data32S[i - 1] : distance === 0));

  let predicted = new cv.Point2fVector();
  toArray(keypoints).forEach((keypoint) => predicted.push_back(keypoint.pt));
  cv.aqorb_matchByPosition(descriptors, predicted, descriptors, keypoints, new cv.Size(2, 2), pairs, distances);
  assert.equal(pairs.rows, 400);
  assert.ok(pairs.data32S.every((row, i) => row === i >> 1));
});
