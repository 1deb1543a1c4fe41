# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The command aqorb: features of a folder of images, their matches, and pictures of matches."""

import argparse
import concurrent.futures
import functools
import hashlib
import itertools
import os
import re
import sqlite3
import sys
import warnings
import zipfile

import aqorb

NEEDS = 'the command needs packages that are not installed with aqorb: pip install pillow pyarrow pycolmap tqdm'


def main(arguments=None):
    parser = argparse.ArgumentParser(prog='aqorb', description=__doc__)
    parser.add_argument('--version', action='version', version=aqorb._build_information())
    commands = parser.add_subparsers(required=True, metavar='COMMAND')

    one = commands.add_parser('extract', help='detect the features of all images in a folder',
                              description='Detects the features of all images in a folder. If it is stopped, the same '
                              'command goes on where it was. Files that are no images are listed at the end.')
    one.add_argument('folder', metavar='FOLDER')
    one.add_argument('--out', required=True, metavar='FILE', help='.parquet, .npz, or .db for COLMAP')
    one.add_argument('--recursive', action='store_true', help='with the folders in the folder')
    one.add_argument('--part-size', type=positive, default=256, metavar='N',
                     help='images after which what is done is saved (%(default)s)')
    one.set_defaults(run=extract)

    two = commands.add_parser('match', help='match the features of pairs of images',
                              description='Matches descriptors that are the nearest of each other.')
    two.add_argument('features', metavar='FEATURES', help='file of aqorb extract')
    two.add_argument('--pairs', required=True,
                     help='sequential:K, each image with the next K in the order of their paths; exhaustive; or a file '
                     'with two paths a line, with a tab or a space between them')
    two.add_argument('--out', metavar='FILE', help='.parquet, or .db for COLMAP; FEATURES by default if that is a .db')
    two.add_argument('--ratio', type=float, help='keep what is nearer than this times the second nearest')
    two.add_argument('--max-distance', type=at_least(0), metavar='N', help='keep what differs in at most so many bits')
    two.add_argument('--part-size', type=positive, default=4096, metavar='N',
                     help='pairs after which what is done is saved (%(default)s)')
    two.set_defaults(run=match)

    three = commands.add_parser('draw', help='draw the matches of two images',
                                description='Matches two images by a ratio test and draws what was found.')
    three.add_argument('images', nargs=2, metavar=('A', 'B'))
    three.add_argument('--out', default='matches.png', metavar='FILE', help='%(default)s by default')
    three.add_argument('--ratio', type=float, default=.8, help='%(default)s by default')
    three.set_defaults(run=draw)

    for command in one, three:
        command.add_argument('--num-features', type=positive, default=1000, metavar='N',
                             help='features of an image, at most (%(default)s)')
        command.add_argument('--max-size', type=positive, metavar='PIXELS',
                             help='reduce images whose longer side is longer')
        command.add_argument('--reader', choices=('pillow', 'cv2'), default='pillow',
                             help='what decodes images (%(default)s)')
        command.add_argument('--ignore-orientation', action='store_true',
                             help='do not turn images as their EXIF data say; COLMAP does not. The reader cv2 turns '
                             'TIFF files all the same')
    for command in one, two:
        command.add_argument('--threads', type=positive, default=len(os.sched_getaffinity(0)) if hasattr(
            os, 'sched_getaffinity') else os.cpu_count(), metavar='N', help='as many as processors by default')
    for command in one, two, three:
        command.add_argument('--overwrite', action='store_true', help='replace a file that exists')

    options = parser.parse_args(arguments)
    warnings.simplefilter('ignore')  # what decoders say of images that they can read
    if hasattr(sys.stdout, 'reconfigure'):
        sys.stdout.reconfigure(errors='backslashreplace')  # a name that the terminal cannot show is no failure
    # Arrow's own allocator gives less back, so that memory would grow with the folder.
    os.environ.setdefault('ARROW_DEFAULT_MEMORY_POOL', 'system')
    try:
        from aqorb import files
        options.run(options)
    except KeyboardInterrupt:
        print('aqorb: stopped; the same command goes on', file=sys.stderr)
        sys.exit(130)
    except ImportError as error:
        sys.exit(f'aqorb: {error}; {NEEDS}')
    except OSError as error:
        has_path = isinstance(error.filename, (bytes, str))
        sys.exit(f'aqorb: {os.fsdecode(error.filename)}: {error.strerror}' if has_path else f'aqorb: {error}')
    except (ValueError, EOFError, RuntimeError, sqlite3.Error, zipfile.BadZipFile) as error:  # of damaged files, too
        sys.exit(f'aqorb: {error}')


def at_least(least):
    def number(text):
        if not least <= int(text) < 2**31:
            raise argparse.ArgumentTypeError(f'{text} is not from {least} to {2**31 - 1}')
        return int(text)
    return number


positive = at_least(1)


def list_files(folder, recursive, out):
    """The files in a folder, as sorted paths relative to it, bytes; and the folders in it that cannot be listed, each
    with the reason. The file out and the folder beside it are left out."""
    found, failures = [], []
    folder, out = os.fsencode(folder), os.fsencode(os.path.realpath(out))
    beside, own = os.path.dirname(out), {os.path.basename(out), os.path.basename(out) + b'.partial'}

    def failed(error):
        if error.filename == folder:
            raise error
        failures.append((os.path.relpath(error.filename, folder), error.strerror))

    for parent, folders, names in os.walk(folder, onerror=failed):
        if os.path.realpath(parent) == beside:
            folders[:], names = set(folders) - own, set(names) - own
        paths = [os.path.relpath(os.path.join(parent, name), folder) for name in names]
        found += [path.replace(os.fsencode(os.sep), b'/') for path in paths]
        if not recursive:
            break
    return sorted(found), failures


def open_file(folder, path):
    path = os.path.join(folder, path)
    if not os.path.isfile(path):
        raise ValueError('it is no regular file')
    return open(path, 'rb')


def extract(options):
    from aqorb import collection, files
    suffix = files.suffix_of(options.out)
    write = {'.parquet': files.write_parquet, '.npz': files.write_npz, '.db': files.write_database}[suffix]
    if suffix == '.db':
        import pycolmap  # noqa: F401 # rather than at the end
    paths, unlisted = list_files(options.folder, options.recursive, options.out)
    detector = aqorb.AdaptiveQuadtreeORB_create(options.num_features)
    how = {'reader': options.reader, 'max_size': options.max_size, 'orientation': not options.ignore_orientation}
    metadata = dict(collection.description(detector, **how),
                    files=hashlib.sha256(b'\0'.join(paths)).hexdigest())
    aqorb.setNumThreads(options.threads)

    def make_table(chunk, progress):
        return collection.extract(chunk, functools.partial(open_file, os.fsencode(options.folder)), detector,
                                  threads=options.threads, progress=progress, **how)

    failures = files.write_in_parts(options.out, paths, len(paths), 'image', options.part_size, metadata,
                                    options.overwrite, make_table, write)
    failures += [(os.fsdecode(path), reason) for path, reason in unlisted]
    print(f'{options.out}: {len(paths) + len(unlisted) - len(failures)} images')
    if failures:
        print(f'{len(failures)} files were left out:', file=sys.stderr)
        for path, reason in failures:
            print(f'  {path}: {reason}', file=sys.stderr)


def pairs_of(text, paths):
    """Pairs of indices of images, and how many they are."""
    from aqorb import files
    count = len(paths)
    if text == 'exhaustive':
        return itertools.combinations(range(count), 2), count * (count - 1) // 2
    sequential = re.fullmatch('sequential:([1-9][0-9]*)', text)
    if sequential:
        reach = int(sequential.group(1))
        pairs = ((i, j) for i in range(count) for j in range(i + 1, min(i + 1 + reach, count)))
        return pairs, sum(min(reach, count - 1 - i) for i in range(count))
    if not os.path.isfile(text):
        raise files.Refused(f'--pairs must be sequential:K, exhaustive or a file, got {text}')
    indices = {path: i for i, path in enumerate(paths)}
    pairs = {}  # by the set of the two, as those in both orders are one
    with open(text, 'rb') as file:
        for number, line in enumerate(file, 1):
            names = line.rstrip(b'\r\n').split(b'\t' if b'\t' in line else b' ')
            if names == [b'']:
                continue
            if len(names) != 2 or not all(name in indices for name in names):
                raise files.Refused(f'{text}, line {number}: must be the paths of two images in the features')
            pairs.setdefault(frozenset(names), (indices[names[0]], indices[names[1]]))
    return iter(pairs.values()), len(pairs)


def match(options):
    import pyarrow as pa
    from aqorb import collection, files
    features = files.Features(options.features)
    out = options.out or options.features
    suffix = files.suffix_of(out, ('.parquet', '.db'))
    if suffix == '.parquet' and os.path.realpath(out) == os.path.realpath(options.features):
        raise files.Refused('--out must name a file for the matches')
    pairs, total = pairs_of(options.pairs, features.paths)
    metadata = {'version': aqorb.__version__, 'pairs': options.pairs, 'ratio': options.ratio,
                'max distance': options.max_distance, 'features': features.metadata}
    if os.path.isfile(options.pairs):
        with open(options.pairs, 'rb') as file:
            metadata['pairs'] = hashlib.sha256(file.read()).hexdigest()
    aqorb.setNumThreads(1)  # the pairs are what is divided among threads

    def match_pairs(pairs):
        """Yields each pair with its matches and distances."""
        with concurrent.futures.ThreadPoolExecutor(options.threads) as pool:
            described = ((pair, features.descriptors(pair[0]), features.descriptors(pair[1])) for pair in pairs)
            for (pair, _, _), found in collection.map_ahead(pool, lambda item: aqorb.matchArrays(
                    item[1], item[2], options.ratio, True, options.max_distance), described, 4 * options.threads):
                yield pair, *found

    def make_table(chunk, progress):
        matched = []
        for _, found, distances in match_pairs(chunk):
            matched.append((found, distances))
            progress(1)
        columns = [pa.array([features.paths[pair[i]] for pair in chunk], pa.binary()) for i in (0, 1)]
        columns += [pa.array([found[:, i] for found, _ in matched], pa.list_(pa.int32())) for i in (0, 1)]
        columns.append(pa.array([distances for _, distances in matched], pa.list_(pa.int32())))
        return pa.Table.from_arrays(columns, schema=files.MATCHES), []

    if suffix == '.parquet':
        files.write_in_parts(out, pairs, total, 'pair', options.part_size, metadata, options.overwrite, make_table,
                             functools.partial(files.write_parquet, schema=files.MATCHES))
    else:
        files.write_matches(out, features, pairs, total, metadata, options.overwrite, match_pairs)
    print(f'{out}: {total} pairs')


def draw(options):
    import numpy as np
    from PIL import Image, ImageDraw
    from aqorb import collection, files
    if os.path.exists(options.out) and not options.overwrite:
        raise files.Refused(f'{options.out} exists; --overwrite replaces it')
    detector = aqorb.AdaptiveQuadtreeORB_create(options.num_features)
    images = []
    for path in options.images:
        try:
            with open_file('', path) as file:
                images.append(collection.read_image(file, options.reader, options.max_size,
                                                    not options.ignore_orientation)[0])
        except Exception as error:  # decoders raise errors of any kind
            raise files.Refused(f'{path}: {error}') from error
    (keypoints1, descriptors1), (keypoints2, descriptors2) = map(detector.detectAndComputeArrays, images)
    pairs, _ = aqorb.matchArrays(descriptors1, descriptors2, options.ratio)
    width = images[0].shape[1]
    picture = Image.new('RGB', (width + images[1].shape[1], max(len(image) for image in images)))
    for image, left in zip(images, (0, width)):
        picture.paste(Image.fromarray(image), (left, 0))
    canvas = ImageDraw.Draw(picture)
    ends = np.hstack([keypoints1['pt'][pairs[:, 0]], keypoints2['pt'][pairs[:, 1]] + [width, 0]])
    for i, line in enumerate(ends):
        colour = f'hsl({360 * i // len(ends)}, 90%, 60%)'
        canvas.line(line.tolist(), colour)
        for x, y in line.reshape(2, 2):
            canvas.ellipse((x - 3, y - 3, x + 3, y + 3), outline=colour)
    picture.save(options.out)
    print(f'{options.out}: {len(pairs)} matches of {len(keypoints1)} and {len(keypoints2)} features')
