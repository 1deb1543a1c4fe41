#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Compares ORB detectors that pip installs, on the same images. scripts/measure.sh peers runs it.

peers.py features METHOD DATA FOLDER   the features of all images, in FOLDER/METHOD.npz
peers.py time METHOD DATA FOLDER       the time on one image after the other, in FOLDER/METHOD-THREADS.txt
peers.py report DATA FOLDER METHOD...  prints a table of the methods, and draws FOLDER/peers.jpg

DATA is the folder images_datasets of opencv_extra's testdata.
"""

import os
import re
import sys
import time

SETS = 'bark', 'bikes', 'graf', 'leuven', 'trees', 'ubc'
IMAGES = 6
COUNT = 1000
KORNIA_COUNT = 640  # asked for so many, kornia-rs finds about 1000 in the mean over these images
SEEDS = 7


def detector(method):
    """Two functions: from a grey image to what the detector returns, and from that to the positions, as an array of
    shape (n, 2), and the descriptors. The time of the first one is measured."""
    import numpy as np
    if method == 'aqorb-arrays':
        import aqorb
        return (aqorb.AdaptiveQuadtreeORB_create(COUNT).detectAndComputeArrays,
                lambda found: (found[0]['pt'], found[1]))
    if method == 'aqorb' or method.startswith('cv2'):
        if method == 'aqorb':
            import aqorb
            orb = aqorb.AdaptiveQuadtreeORB_create(COUNT)
        else:
            import cv2
            orb = cv2.ORB_create(COUNT)
        return (lambda image: orb.detectAndCompute(image, None),
                lambda found: (np.array([k.pt for k in found[0]], np.float32), found[1]))
    if method.startswith('kornia'):
        from kornia_rs.features import orb_detect_and_compute
        count = COUNT if method == 'kornia' else KORNIA_COUNT
        return (lambda image: orb_detect_and_compute(image, count),
                lambda found: (found.keypoints_xy, found.descriptors))
    if method == 'scikit':
        import skimage.feature

        def detect(image):
            orb = skimage.feature.ORB(n_keypoints=COUNT)
            orb.detect_and_extract(image)
            return orb
        return (detect,
                lambda orb: (orb.keypoints[:, ::-1].astype(np.float32), np.packbits(orb.descriptors, axis=1)))
    return sys.exit('peers.py: there is no method ' + method)


def version(method):
    from importlib import metadata
    names = {'aqorb': 'aqorb', 'cv2': 'opencv-python-headless', 'kornia': 'kornia-rs', 'scikit': 'scikit-image'}
    name = names[method.split('-')[0]]
    shown = '{} {}'.format('`cv2.ORB`, ' + name if method.startswith('cv2') else name, metadata.version(name))
    return shown + {'aqorb-arrays': ', `detectAndComputeArrays`', 'aqorb': ', `detectAndCompute`',
                    'kornia-fewer': ', asked for {}'.format(KORNIA_COUNT)}.get(method, '')


def read(data, name, index):
    import cv2
    image = cv2.imread(os.path.join(data, name, 'img{}.png'.format(index)), cv2.IMREAD_GRAYSCALE)
    if image is None:
        sys.exit('peers.py: no images in ' + data)
    return image


def features(method, data, folder):
    import numpy as np
    detect, converted = detector(method)
    found = {'version': version(method)}
    for name in SETS:
        for i in range(1, IMAGES + 1):
            points, descriptors = converted(detect(read(data, name, i)))
            found['{}{}points'.format(name, i)] = points
            found['{}{}descriptors'.format(name, i)] = descriptors
    np.savez(os.path.join(folder, method + '.npz'), **found)


def measure_time(method, data, folder):
    """The sum over the first images of the sets of the median time of a call, in milliseconds. The number of threads is
    that of the processors that the process may use."""
    detect = detector(method)[0]
    total = 0
    for name in SETS:
        image = read(data, name, 1)
        times = []
        end = time.perf_counter() + 2
        while len(times) < 5 or (time.perf_counter() < end and len(times) < 200):
            start = time.perf_counter()
            detect(image)
            times.append(time.perf_counter() - start)
        total += 1000 * sorted(times)[len(times) // 2]
    threads = len(os.sched_getaffinity(0))
    with open(os.path.join(folder, '{}-{}.txt'.format(method, threads)), 'w') as file:
        file.write('{:.3f}\n'.format(total / len(SETS)))


def homography(data, name, index):
    """That from the first image of a set to another one."""
    import numpy as np
    with open(os.path.join(data, name, 'H1to{}p.xml'.format(index))) as file:
        numbers = re.search(r'<data>(.*?)</data>', file.read(), re.DOTALL).group(1).split()
    return np.array(numbers, float).reshape(3, 3)


def mapped(points, matrix):
    import cv2
    return cv2.perspectiveTransform(points.reshape(-1, 1, 2), matrix).reshape(-1, 2)


def match(found, name, i):
    """Positions of the mutual nearest neighbours, the best first."""
    import cv2
    import numpy as np
    a, b = name + '1', name + str(i)
    matches = cv2.BFMatcher(cv2.NORM_HAMMING, True).match(found[a + 'descriptors'], found[b + 'descriptors'])
    matches = sorted(matches, key=lambda m: m.distance)
    return (np.float32([found[a + 'points'][m.queryIdx] for m in matches]).reshape(-1, 2),
            np.float32([found[b + 'points'][m.trainIdx] for m in matches]).reshape(-1, 2))


def distinct(source, target, matrix):
    """Indices of the matches within 3 pixels of the homography, 4 pixels away from every better one in both images."""
    import numpy as np
    kept = []
    if len(source) == 0:
        return kept
    for i in np.nonzero(np.linalg.norm(mapped(source, matrix) - target, axis=1) <= 3)[0]:
        if not kept or (np.linalg.norm(source[kept] - source[i], axis=1).min() >= 4 and
                        np.linalg.norm(target[kept] - target[i], axis=1).min() >= 4):
            kept.append(i)
    return kept


def corner_error(source, target, matrix, size, seed):
    """The mean distance between the corners of the first image mapped by the estimated and by the known homography."""
    import cv2
    import numpy as np
    if len(source) < 4:
        return np.inf
    params = cv2.UsacParams()
    params.score, params.sampler = cv2.SCORE_METHOD_MAGSAC, cv2.SAMPLING_UNIFORM
    params.loMethod, params.loIterations = cv2.LOCAL_OPTIM_SIGMA, 10
    params.maxIterations, params.confidence, params.threshold = 5000, 0.9999, 3
    params.randomGeneratorState = seed
    estimate = cv2.findHomography(source, target, params)[0]
    if estimate is None:
        return np.inf
    right, bottom = size[0] - 1, size[1] - 1
    corners = np.float32([(0, 0), (right, 0), (right, bottom), (0, bottom)])
    error = np.linalg.norm(mapped(corners, estimate) - mapped(corners, matrix), axis=1).mean()
    return error if np.isfinite(error) else np.inf


def row(method, data, folder):
    """A method's line of the table."""
    import aqorb
    import numpy as np
    found = np.load(os.path.join(folder, method + '.npz'))
    counts, uniformity, matches, places, scores = [], [], [], [], []
    for name in SETS:
        size = read(data, name, 1).shape[::-1]
        for i in range(1, IMAGES + 1):
            points = found['{}{}points'.format(name, i)]
            keypoints = np.zeros(len(points), aqorb.keypoint_dtype)
            keypoints['pt'] = points
            counts.append(len(points))
            uniformity.append(aqorb.distributionUniformity(keypoints, read(data, name, i).shape[::-1]))
            if i == 1:
                continue
            matrix = homography(data, name, i)
            source, target = match(found, name, i)
            kept = distinct(source, target, matrix)
            matches.append(len(kept))
            places.append(len({(int(x * 16 / size[0]), int(y * 12 / size[1])) for x, y in source[kept]}))
            scores += [max(0, 1 - corner_error(source, target, matrix, size, 7919 * seed) / 5)
                       for seed in range(1, SEEDS + 1)]
    times = []
    for threads in 1, 2:
        with open(os.path.join(folder, '{}-{}.txt'.format(method, threads))) as file:
            times.append(float(file.read()))
    return '| {} | {:.2f} | {:.2f} | {:.0f} | {:.1f} | {:.1f} | {:.1f} | {:.3f} |'.format(
        found['version'], *times, np.mean(counts), np.mean(uniformity), np.mean(matches), np.mean(places),
        np.mean(scores))


def draw(data, folder, methods):
    """The keypoints of each method on one image, if no picture has the same yet."""
    import cv2
    import numpy as np
    pictures, drawn = [], []
    for method in [m for m in methods if m != 'kornia-fewer']:
        found = np.load(os.path.join(folder, method + '.npz'))
        if any(np.array_equal(found['leuven1points'], points) for points in drawn):
            continue
        drawn.append(found['leuven1points'])
        picture = cv2.cvtColor(read(data, 'leuven', 1), cv2.COLOR_GRAY2BGR) // 2 + 64
        for x, y in found['leuven1points']:
            cv2.circle(picture, (int(round(float(x))), int(round(float(y)))), 3, (0, 220, 255), -1, cv2.LINE_AA)
        picture = cv2.resize(picture, None, fx=0.6, fy=0.6, interpolation=cv2.INTER_AREA)
        cv2.rectangle(picture, (0, 0), (picture.shape[1], 26), (40, 40, 40), -1)
        title = str(found['version']).replace('`', '').replace(', detectAndCompute', '')
        cv2.putText(picture, title, (8, 19), cv2.FONT_HERSHEY_SIMPLEX, 0.55, (255, 255, 255), 1, cv2.LINE_AA)
        pictures.append(picture)
    while len(pictures) % 2:
        pictures.append(np.full_like(pictures[0], 255))
    rows = [np.hstack(pictures[i:i + 2]) for i in range(0, len(pictures), 2)]
    cv2.imwrite(os.path.join(folder, 'peers.jpg'), np.vstack(rows), [cv2.IMWRITE_JPEG_QUALITY, 85])


def report(data, folder, *methods):
    print('| detector | ms, 1 thread | ms, 2 threads | keypoints | u | distinct matches | places | AUC at 5 px |')
    print('|---|---|---|---|---|---|---|---|')
    for method in methods:
        print(row(method, data, folder))
    draw(data, folder, methods)


if __name__ == '__main__':
    commands = {'features': features, 'time': measure_time, 'report': report}
    if len(sys.argv) < 4 or sys.argv[1] not in commands:
        sys.exit(__doc__)
    commands[sys.argv[1]](*sys.argv[2:])
