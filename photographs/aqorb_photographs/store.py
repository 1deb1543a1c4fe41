# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Folders of Parquet parts: features, a row for each image, and matches, a row for each pair of images.

A part appears under its name when it is complete, and never changes. Parts therefore stay whole if a process is stopped
or several processes work at the same time. If several parts have a row for the same image, the row of the last part
counts, and the other parts are written anew without theirs. Parts from other machines, or from other programs with the
same columns, count as well.

Positions and sizes are in pixels of the upright image, even if features were detected in a reduced image."""

import bisect
import concurrent.futures
import contextlib
import functools
import hashlib
import itertools
import json
import os
import re
import secrets
import time
import typing

import numpy as np
import PIL
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

import aqorb
from aqorb_photographs import InputError, images, map_ahead, sentence_of

FLOATS, INTEGERS = pa.list_(pa.float32()), pa.list_(pa.int32())
KEYPOINTS = [(name, FLOATS) for name in ('x', 'y', 'size', 'angle', 'response')] + [('octave', INTEGERS)]
# mask is the time of the mask's file. digest distinguishes different features of the same image.
FEATURES = pa.schema(
    [('name', pa.string()), ('folder', pa.string()), ('file_size', pa.int64()), ('file_time', pa.int64()),
     ('mask', pa.int64()), ('width', pa.int32()), ('height', pa.int32()), ('orientation', pa.int32()),
     ('make', pa.string()), ('model', pa.string())] +
    [(name, pa.float64()) for name in ('focal_length', 'focal_length_35mm', 'latitude', 'longitude', 'altitude')] +
    [('parameters', pa.string()), ('version', pa.string()), ('digest', pa.string())] + KEYPOINTS +
    [('descriptors', pa.binary())])
MATCHES = pa.schema(
    [('name1', pa.string()), ('name2', pa.string()), ('digest1', pa.string()), ('digest2', pa.string()),
     ('parameters', pa.string()), ('index1', INTEGERS), ('index2', INTEGERS), ('distance', INTEGERS),
     ('inliers', INTEGERS), ('fundamental', pa.list_(pa.float64()))])
OPTIONAL = FEATURES.names[1:4] + FEATURES.names[8:15]
GROUP = 64  # rows in a row group, which is read at once
ABANDONED = 3600  # seconds after which an unfinished part belongs to a killed process


# Parts

def parts_in(folder):
    """Returns the names of the parts in a folder. Parts of other programs may have any name."""
    return sorted(name for name in os.listdir(folder) if name.endswith('.parquet') and name[0] not in '._')


@contextlib.contextmanager
def replacing(path):
    """Opens a binary file that appears under its name when it is complete, or not at all."""
    folder, name = os.path.split(path)
    unfinished = os.path.join(folder, f'.{name}.{secrets.token_hex(4)}.unfinished')  # no program reads this name
    try:
        with open(unfinished, 'wb') as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, path)
    finally:
        with contextlib.suppress(OSError):  # it has its name, if all went well
            os.remove(unfinished)


def write_part(folder, table, name=None, group=GROUP):
    """Writes a part with row groups of `group` rows. Without a name, it gets a name after all parts of the folder."""
    os.makedirs(folder, exist_ok=True)
    if name is None:
        times = [int(found[1]) + 1 for found in map(re.compile(r'part-(\d{15})-').match, parts_in(folder)) if found]
        name = f'part-{max([time.time_ns() // 10**6] + times):015}-{secrets.token_hex(4)}.parquet'
    with replacing(os.path.join(folder, name)) as file:
        # No dictionaries for most columns of lists: hardly two numbers are equal.
        repeated = [field.name for field in table.schema if not pa.types.is_list(field.type)]
        pq.write_table(table, file, max(1, group), write_page_checksum=True,
                       use_dictionary=repeated + ['size.list.element', 'octave.list.element'])


def write_rows(folder, rows):
    """Writes tables of one row each as a part, if there are any, and returns their number."""
    if rows:
        write_part(folder, pa.concat_tables(rows))
    return len(rows)


def clean(folder):
    """Removes unfinished parts of killed processes from a folder."""
    for name in os.listdir(folder):
        if name.endswith('.unfinished'):
            with contextlib.suppress(OSError):  # another process removes it, too
                path = os.path.join(folder, name)
                if time.time() - os.stat(path).st_mtime > ABANDONED:
                    os.remove(path)


@contextlib.contextmanager
def reading(path):
    """Turns errors of reading a file into an InputError with a sentence."""
    try:
        yield
    except (InputError, FileNotFoundError, IsADirectoryError, PermissionError):
        raise
    except (pa.ArrowException, EOFError, OSError, TypeError, ValueError) as error:
        raise InputError(f'{path} is damaged, or not a part of aqorb: '
                         f'{" ".join(str(error).split()) or type(error).__name__}') from error


def check(table):
    """Returns the rows of a part. Raises ValueError if they are invalid."""
    lengths = {}  # lengths of the lists with one element for each keypoint or match
    for name in table.schema.names:
        column = table[name].combine_chunks()
        is_list = pa.types.is_list(column.type)
        if is_list and column.flatten().null_count or column.null_count and name not in OPTIONAL:
            raise ValueError(f'{name} is missing')
        if name == 'descriptors':
            lengths[name] = np.asarray(pc.binary_length(column)) / 32
        elif is_list and name not in ('inliers', 'fundamental'):
            lengths[name] = np.asarray(pc.list_value_length(column))
        if name in ('width', 'height') and len(column) and pc.min(column).as_py() < 1:
            raise ValueError(f'{name} is less than 1')
    for name, length in lengths.items():
        if not np.array_equal(length, next(iter(lengths.values()))):
            raise ValueError(f'there are not as many of {name} as of {next(iter(lengths))}')
    return table


class Parts:
    """The Parquet parts of a folder. `head` has one row for each image or pair, with the leading columns; `part` and
    `row` have the number of its part and of its row in the part. `chosen` has the rows of the head that count. row_of,
    of and groups read `columns`."""

    kind, schema, head_columns = '', pa.schema([]), ['']

    def __init__(self, folder, columns):
        self.folder, self.columns = folder, columns
        self._file = functools.lru_cache(256)(
            lambda part: pq.ParquetFile(self._path(part), page_checksum_verification=True))
        self._group = functools.lru_cache(16)(self._read_group)
        for attempts_left in reversed(range(10)):
            try:
                self._read_head()
                break
            except FileNotFoundError:  # another process has just rewritten this part
                self._file.cache_clear()
                if not attempts_left:
                    raise

    def _read_head(self):
        self.names = parts_in(self.folder) if os.path.isdir(self.folder) else []
        tables, self._starts = [self.schema.empty_table().select(self.head_columns)], []
        for part in range(len(self.names)):
            with reading(self._path(part)):
                file = self._file(part)
                theirs = file.schema_arrow
                for field in self.schema:
                    if field.name not in theirs.names or theirs.field(field.name).type != field.type:
                        raise InputError(f'{self._path(part)} has no {field.name}: {self.kind} of aqorb 0.5 have it')
                tables.append(check(file.read(self.head_columns)))
                groups = [file.metadata.row_group(group).num_rows for group in range(file.num_row_groups)]
            self._starts.append([0, *itertools.accumulate(groups)])
        self.head = pa.concat_tables(tables).combine_chunks()
        lengths = [len(table) for table in tables[1:]]
        self.part = np.repeat(np.arange(len(lengths)), lengths)
        self.row = np.concatenate([np.arange(0), *map(np.arange, lengths)])

    def _path(self, part):
        return os.path.join(self.folder, self.names[part])

    def _read_group(self, part, group):
        with reading(self._path(part)):
            return check(self._file(part).read_row_group(group, self.columns))

    def row_of(self, index):
        """Returns the row of the image or pair with this index, as a table of one row with the columns."""
        part, row = self.part[self.chosen[index]], self.row[self.chosen[index]]
        group = bisect.bisect_right(self._starts[part], row) - 1
        return self._group(part, group).slice(row - self._starts[part][group], 1)

    def of(self, index):
        """Returns arrays_of the image or pair with this index."""
        return arrays_of(self.row_of(index))

    def groups(self, part):
        """Yields the rows of a part, in tables with the columns."""
        for group in range(len(self._starts[part]) - 1):
            yield self._read_group(part, group)

    def keep(self, kept):
        """Rewrites parts without the rows whose flag in `kept`, one for each row of the head, is not set."""
        for part in range(len(self.names)):
            flags = kept[self.part == part]
            with contextlib.suppress(FileNotFoundError):  # another process has rewritten the part
                if flags.any() and not flags.all():
                    with reading(self._path(part)):
                        table = self._file(part).read(self.schema.names)
                    write_part(self.folder, table.filter(pa.array(flags)))
                if not flags.all():
                    os.remove(self._path(part))

    def parameters(self):
        """Returns the parameters of all rows, which must be equal, or None without rows."""
        found = pc.unique(self.head['parameters']).to_pylist()
        if len(found) > 1:
            raise InputError(f'{self.folder} has {self.kind} of different parameters: {found[0]} and {found[1]}')
        with reading(self.folder):
            return dict(json.loads(found[0])) if found else None

    def agree(self, parameters):
        """Raises InputError unless parameters equal the parameters of the rows."""
        theirs = self.parameters()
        for name in parameters if theirs else ():
            if theirs.get(name) != parameters[name]:
                raise InputError(f'{self.folder} was made with {name} {theirs.get(name)}, not {parameters[name]}: '
                                 f'continue with {theirs.get(name)}, or give --out another folder')


# Features

def parameters_of(detector, how):
    """Returns the parameters of features, of the detector and of reading, as a dict."""
    values = {name[3:]: getattr(detector, 'get' + name[3:])() for name in dir(detector) if name.startswith('set')}
    return {**{name: value for name, value in how._asdict().items() if name != 'max_pixels'}, **values}


def detector_of(parameters):
    """Returns the detector and the images.Reading that parameters_of describes."""
    detector = aqorb.AdaptiveQuadtreeORB_create()
    for name, value in parameters.items():
        if name not in images.Reading._fields:
            getattr(detector, 'set' + name)(value)
    return detector, images.Reading(**{name: parameters[name] for name in images.Reading._fields if name in parameters})


class File(typing.NamedTuple):
    """An image to extract features from: its name in the collection, a function that opens it, and the file's
    columns in its row. mask is the path of a mask."""

    name: str
    open: typing.Callable
    folder: typing.Optional[str] = None
    file_size: typing.Optional[int] = None
    file_time: typing.Optional[int] = None
    mask: typing.Optional[str] = None
    mask_time: int = 0


def extract(files, detector, how=images.Reading(), threads=1):
    """Reads images and detects their features, one image at a time on each thread. Yields (file, row, message) in input
    order. `row` is a table of one row, or None if the image failed; `message` then says why."""
    parameters = json.dumps(parameters_of(detector, how))

    def row_of(file):
        try:
            with file.open() as stream:
                picture = images.read_image(stream, how)
            masks = [images.read_mask(file.mask, picture)] if file.mask else None
            features = detector.detectAndComputeBatch([picture.pixels], masks)
            scale_up(features, picture)
            return to_row(file, picture, features, parameters), picture.note
        except Exception as error:  # decoders raise errors of any kind
            return None, sentence_of(error)

    with concurrent.futures.ThreadPoolExecutor(threads) as pool:
        for file, (row, note) in map_ahead(pool, row_of, files, 2 * threads):
            yield file, row, note


def scale_up(features, picture):
    """Scales features, in place, from the pixels of a picture to its size."""
    scales = [side / smaller for side, smaller in zip(picture.size, picture.pixels.shape[::-1])]
    if scales != [1, 1]:
        for positions, scale in zip((features.x, features.y), scales):  # the centre of the first pixel is 0
            positions[:] = (positions + .5) * scale - .5
        features.size[:] *= sum(scales) / 2


def to_row(file, picture, features, parameters):
    """Returns the row of one image as a table."""
    if len(features.x) >= 2**26:
        raise InputError(f'an image has at most {2**26 - 1} features, got {len(features.x)}')  # 2 GB of descriptors
    digest = hashlib.blake2b(digest_size=8)
    for array in features[:7]:
        digest.update(array)
    row = dict(picture.camera, name=file.name, folder=file.folder, file_size=file.file_size, file_time=file.file_time,
               mask=file.mask_time, width=picture.size[0], height=picture.size[1], orientation=picture.orientation,
               parameters=parameters, version=f'aqorb {aqorb.__version__}, Pillow {PIL.__version__}',
               digest=digest.hexdigest(), descriptors=features.descriptors.tobytes(),
               **{name: getattr(features, name) for name, _ in KEYPOINTS})
    return pa.Table.from_pylist([row], FEATURES)


def arrays_of(row):
    """Returns the lists in a table of one row as a dict of arrays. descriptors are rows of 32 bytes."""
    found = {field.name: row[field.name][0].values.to_numpy() for field in row.schema if pa.types.is_list(field.type)}
    if 'descriptors' in row.schema.names:
        found['descriptors'] = np.frombuffer(row['descriptors'][0].as_buffer(), np.uint8).reshape(-1, 32)
    return found


def keypoints_of(row):
    """Returns the positions and the descriptors in a table of one row: arrays (n, 2) and (n, 32)."""
    found = arrays_of(row)
    return np.column_stack([found['x'], found['y']]), found['descriptors']


class Features(Parts):
    """The features in a folder. images has the images' names in ascending order, and chosen their rows in the head."""

    kind, schema = 'features', FEATURES
    head_columns = FEATURES.names[:8] + ['parameters', 'digest']

    def __init__(self, folder, columns=('x', 'y', 'descriptors')):
        if not os.path.isdir(folder):
            fault = 'it is not a folder' if os.path.exists(folder) else 'there is no such folder'
            raise InputError(f'{folder}: {fault}')
        super().__init__(folder, list(columns))
        last = {name: row for row, name in enumerate(self.head['name'].to_pylist())}
        self.images = sorted(last)
        self.chosen = np.array([last[name] for name in self.images], int)
        self.index = {name: index for index, name in enumerate(self.images)}

    def value(self, name):
        """Returns a column of the head, with an element for each image."""
        return self.head[name].take(pa.array(self.chosen)).to_pylist()

    def keypoints(self, image):
        """Returns keypoints_of the image with this index."""
        return keypoints_of(self.row_of(image))

    def read(self, images):
        """Returns the keypoints of images, as a dict. Reads in the order of parts: one read gives many images."""
        needed = np.unique(images)
        return {image: self.keypoints(image) for image in needed[np.argsort(self.chosen[needed])].tolist()}

    def path(self, image, folder=None):
        """Returns the path of an image's file."""
        return path_of(folder or self.head['folder'][int(self.chosen[image])].as_py() or '.', self.images[image])


def name_of(path, folder):
    """Returns the name of a file in a collection: its path relative to a folder, as text."""
    relative = os.fsencode(os.path.relpath(path, folder).replace(os.sep, '/'))
    return relative.decode('utf-8', 'backslashreplace')  # escapes bytes that are not UTF-8


def path_of(folder, name):
    """Returns the path of a file from its name_of."""
    path = os.path.join(os.fsencode(folder), name.encode())
    if not os.path.exists(path):
        path = re.sub(rb'\\x([89a-f][0-9a-f])', lambda found: bytes([int(found[1], 16)]), path)
    return os.fsdecode(path)


# Matches

class Matches(Parts):
    """The matches in a folder that belong to the given features. pairs has two image indices for each pair, and chosen
    its last row in the head."""

    kind, schema, head_columns = 'matches', MATCHES, MATCHES.names[:5]

    def __init__(self, folder, features):
        super().__init__(folder, self.schema.names[5:])
        self._count = len(features.images)
        names, digests = pa.array(features.images, pa.string()), pa.array(features.value('digest'), pa.string())
        ends, is_valid, is_here = [], np.ones(len(self.head), bool), np.ones(len(self.head), bool)
        for side in '12':
            index = pc.index_in(self.head['name' + side].combine_chunks(), names)
            same = pc.equal(digests.take(index), self.head['digest' + side].combine_chunks())
            is_valid &= np.asarray(pc.fill_null(same, False), bool)
            is_here &= np.asarray(index.is_valid(), bool)
            ends.append(np.asarray(pc.fill_null(index, 0), np.int64))
        codes = self.codes(np.column_stack(ends))
        rows = np.flatnonzero(is_valid)[::-1]  # reversed, because np.unique keeps the first row of a pair
        self.known, first = np.unique(codes[rows], return_index=True)
        self.chosen = np.sort(rows[first])
        self.pairs = np.column_stack(ends)[self.chosen]
        self._stale = np.flatnonzero(is_here & ~is_valid & ~np.isin(codes, self.known))
        self._features = features.folder

    def check(self):
        """Raises InputError if there are no matches, or if features of a pair have changed since it was matched."""
        fault = '' if len(self.pairs) else f'has no matches of {self._features}'
        if len(self._stale):
            pair = self.head.slice(int(self._stale[0]), 1).to_pylist()[0]
            fault = (f'has {len(self._stale)} pairs, such as {pair["name1"]} and {pair["name2"]}, whose features have '
                     'changed since they were matched')
        if fault:
            raise InputError(f'{self.folder} {fault}: run aqorb match {self._features} with --out {self.folder}')

    def tidy(self):
        """Rewrites parts without rows of superseded pairs, and removes what killed processes have left."""
        if len(self.head):
            clean(self.folder)
            self.keep(np.isin(np.arange(len(self.head)), self.chosen))

    def codes(self, pairs):
        """Returns a number for each pair of images, the same in both orders."""
        return pairs.min(1) * np.int64(self._count) + pairs.max(1)


def to_matches(features, pairs, found, parameters, schema=MATCHES):
    """Returns the table of pairs of images. pairs are rows of two indices, and found the columns of lists of each
    pair."""
    names, digests = features.images, features.value('digest')
    columns = [[column[image] for image in pairs[:, side]] for column in (names, digests) for side in (0, 1)]
    columns += [[json.dumps(parameters)] * len(pairs), *zip(*found)]
    return pa.table(columns, schema=schema)
