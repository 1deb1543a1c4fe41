#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Measures how fast the features of many images are extracted: by aqorb extract, by a loop of cv2.ORB, and by COLMAP's own
extraction of SIFT, each in a process of its own; then the stages of the former on one thread, and what so many images
cost. The images are made of the photographs in the given folder. Needs aqorb[cli] and cv2."""

import argparse
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import time

import numpy as np
from PIL import Image

import aqorb
from aqorb.collection.images import Reading, read_image

# name: size, suffix, options of Pillow
KINDS = {'PNG 1000 x 700': ((1000, 700), 'png', {}), 'JPEG 1920 x 1080': ((1920, 1080), 'jpg', {'quality': 90})}

WAYS = {
    'aqorb extract': 'from aqorb.cli.main import main; main(["extract", folder, "--out", out, '
                     '"--num-features", "1000"])',
    'loop of cv2.ORB': '''
import os, cv2
orb = cv2.ORB_create(1000)
for name in sorted(os.listdir(folder)):
    orb.detectAndCompute(cv2.imread(os.path.join(folder, name), cv2.IMREAD_GRAYSCALE), None)
''',
    'SIFT of COLMAP': '''
import os, pycolmap
pycolmap.logging.minloglevel = 2
options = pycolmap.FeatureExtractionOptions(use_gpu=False)
options.sift.max_num_features = 1000
pycolmap.extract_features(out + '.db', folder, sorted(os.listdir(folder))[::5], extraction_options=options,
                          device=pycolmap.Device.cpu)
'''}
SHARE = {'SIFT of COLMAP': 5}  # takes every fifth image, as it takes long


def make_images(photographs, folder, count, size, suffix, options):
    """Photographs at that size, no two of which are the same."""
    part = folder.with_suffix('.part')
    part.mkdir(parents=True)
    for i in range(count):
        image = Image.open(str(photographs[i % len(photographs)])).convert('RGB')
        shift = i // len(photographs)
        image.crop((shift, shift, *image.size)).resize(size, Image.BICUBIC).save(str(part / f'{i:05}.{suffix}'), **options)
    part.rename(folder)


def run(way, folder, out):
    """Seconds, and seconds of processors, of a process."""
    start = time.perf_counter()
    code = f'folder, out = {str(folder)!r}, {str(out)!r}\n' + WAYS[way]
    process = subprocess.Popen([sys.executable, '-c', code], stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        sys.exit(f'rates.py: {way} failed')
    return time.perf_counter() - start, usage.ru_utime + usage.ru_stime


def milliseconds(function, items):
    """The median."""
    times = []
    for item in items:
        start = time.perf_counter()
        function(item)
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


def read(path, **options):
    with open(path, 'rb') as file:
        return read_image(file, Reading(**options))


def read_colours(path):
    return np.asarray(Image.open(str(path)).convert('L'))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--images', type=int, default=200, help='of each kind (%(default)s)')
    parser.add_argument('--passes', type=int, default=3, help='in turns, of which the median counts (%(default)s)')
    parser.add_argument('--out', default='rates',
                        help='folder for what is made; images that are there already are taken (%(default)s)')
    parser.add_argument('photographs', type=pathlib.Path)
    options = parser.parse_args()
    photographs = sorted(options.photographs.rglob('*.png'))
    out = pathlib.Path(options.out)
    stages = []
    print('| images | way | images/s | core ms per image |\n|---|---|---|---|')
    for kind, (size, suffix, saved) in KINDS.items():
        folder = out / kind
        if not folder.exists():
            make_images(photographs, folder, options.images, size, suffix, saved)
        number = len(os.listdir(str(folder)))
        found = {way: [] for way in WAYS}
        for i in range(options.passes):
            result = out / f'{suffix}-{i}'
            for made in result, out / f'{suffix}-nothing':
                shutil.rmtree(str(made), ignore_errors=True)
            result.with_suffix('.db').unlink(missing_ok=True)
            for way in WAYS:
                found[way].append(run(way, folder, result))
        (out / 'nothing').mkdir(exist_ok=True)
        Image.new('L', (8, 8)).save(str(out / 'nothing' / 'black.png'))
        started = run('aqorb extract', out / 'nothing', out / f'{suffix}-nothing')[1]
        size_of = sum(part.stat().st_size for part in (out / f'{suffix}-0').iterdir()) / number
        for way, times in found.items():
            count = number // SHARE.get(way, 1)
            wall, busy = (statistics.median(column) / count for column in zip(*times))
            print(f'| {kind} | {way} | {1 / wall:.3g} | {1e3 * busy:.3g} |', flush=True)
            if way == 'aqorb extract':
                busy -= started / number
                costs = [f'{images:.0e} images: {busy * images / 3600:.3g} core hours, {size_of * images / 1e9:.3g} GB'
                         for images in (1e6, 1e9)]
                stages.append([kind, '; '.join(costs)])
        aqorb.setNumThreads(1)
        detector = aqorb.AdaptiveQuadtreeORB_create(1000)
        files = sorted(folder.iterdir())[:60]
        images = [read(path)[0] for path in files]
        stages[-1][1:1] = [f'{value:.1f}' for value in (
            milliseconds(read_colours, files), milliseconds(read, files),
            milliseconds(lambda path: read(path, max_size=960), files),
            milliseconds(lambda image: detector.detectAndComputeBatch([image]), images))]
    print('\n| images | decoding colours, ms | decoding as the command, ms | the same with --max-size 960, ms | features, ms |'
          ' cost |\n|---|---|---|---|---|---|')
    for row in stages:
        print('| ' + ' | '.join(row) + ' |')


if __name__ == '__main__':
    main()
