# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Folders of Parquet parts: features, a row for each image, and matches, a row for each pair of images.

A part appears under its name when it is complete, and is never changed. So whoever is stopped at any moment, or works
at the same time, leaves parts that are whole. Where several parts have a row of the same image, that of the last name
counts; parts that have such rows are written anew without them. Parts that were copied from other machines, or written
by other programs in the same columns, count as well.

Positions and sizes are in pixels of the upright image, also where features were detected in a smaller one."""

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
from aqorb_photographs import Refused, images, map_ahead

FLOATS, INTEGERS = pa.list_(pa.float32()), pa.list_(pa.int32())
KEYPOINTS = [(name, FLOATS) for name in ('x', 'y', 'size', 'angle', 'response')] + [('octave', INTEGERS)]
# mask is the time of the mask's file, and digest tells features from others of the same image.
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
GROUP = 64  # rows that are read at a time
ABANDONED = 3600  # seconds after which an unfinished part is of a process that was killed


# Parts

def parts_in(folder):
    """The names of the parts in a folder. Those of other programs may have any name."""
    return sorted(name for name in os.listdir(folder) if name.endswith('.parquet') and name[0] not in '._')


def write_part(folder, table, name=None, group=GROUP):
    """Writes a part. Its name is after those of all parts in the folder unless it is given. So many rows are read at a
    time."""
    os.makedirs(folder, exist_ok=True)
    if name is None:
        times = [int(found[1]) + 1 for found in map(re.compile(r'part-(\d{15})-').match, parts_in(folder)) if found]
        name = f'part-{max([time.time_ns() // 10**6] + times):015}-{secrets.token_hex(4)}.parquet'
    unfinished = os.path.join(folder, f'.{name}.{secrets.token_hex(4)}.unfinished')  # what no program reads
    try:
        with open(unfinished, 'wb') as file:
            # Most columns of lists are numbers of which hardly two are the same.
            repeated = [field.name for field in table.schema if not pa.types.is_list(field.type)]
            pq.write_table(table, file, max(1, group), write_page_checksum=True,
                           use_dictionary=repeated + ['size.list.element', 'octave.list.element'])
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, os.path.join(folder, name))
    except BaseException:
        with contextlib.suppress(OSError):
            os.remove(unfinished)
        raise


def write_rows(folder, rows):
    """Writes tables of rows as a part, if there are any, and returns how many they are."""
    if rows:
        write_part(folder, pa.concat_tables(rows))
    return len(rows)


def clean(folder):
    """Removes what processes that were killed have left in a folder."""
    for name in os.listdir(folder):
        if name.endswith('.unfinished'):
            with contextlib.suppress(OSError):  # another process removes it, too
                path = os.path.join(folder, name)
                if time.time() - os.stat(path).st_mtime > ABANDONED:
                    os.remove(path)


@contextlib.contextmanager
def reading(path):
    """Says in a sentence what is wrong with a file that is read meanwhile."""
    try:
        yield
    except (Refused, FileNotFoundError, IsADirectoryError, PermissionError):
        raise
    except Exception as error:  # what pyarrow says of a file with anything in it has many types
        raise Refused(f'{path} is damaged, or no part that aqorb has written: '
                      f'{" ".join(str(error).split()) or type(error).__name__}') from error


def check(table):
    """Raises ValueError if rows are not as a part has them."""
    lengths = {}  # of the lists that have an element for each keypoint, or for each match
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
    """The parts in a folder, of a kind and a schema, and the table head with the first columns of all rows: of each the
    number of its part, and of the row in it. columns are those that are read when a row is."""

    kind, schema, heads = '', pa.schema([]), ['']

    def __init__(self, folder, columns):
        self.folder, self.columns = folder, columns
        self._file = functools.lru_cache(256)(
            lambda part: pq.ParquetFile(self._path(part), page_checksum_verification=True))
        self._group = functools.lru_cache(16)(self._read_group)
        for attempts_left in reversed(range(10)):
            try:
                self._read_heads()
                break
            except FileNotFoundError:  # another process has just written this part anew
                self._file.cache_clear()
                if not attempts_left:
                    raise

    def _read_heads(self):
        self.names = parts_in(self.folder) if os.path.isdir(self.folder) else []
        heads, self._starts = [self.schema.empty_table().select(self.heads)], []
        for part in range(len(self.names)):
            with reading(self._path(part)):
                file = self._file(part)
                theirs = file.schema_arrow
                for field in self.schema:
                    if field.name not in theirs.names or theirs.field(field.name).type != field.type:
                        raise Refused(f'{self._path(part)} has no {field.name}: {self.kind} of aqorb 0.5 have it')
                heads.append(check(file.read(self.heads)))
                groups = [file.metadata.row_group(group).num_rows for group in range(file.num_row_groups)]
            self._starts.append([0, *itertools.accumulate(groups)])
        self.head = pa.concat_tables(heads).combine_chunks()
        lengths = [len(head) for head in heads[1:]]
        self.part = np.repeat(np.arange(len(lengths)), lengths)
        self.row = np.concatenate([np.arange(0), *map(np.arange, lengths)])

    def _path(self, part):
        return os.path.join(self.folder, self.names[part])

    def _read_group(self, part, group):
        with reading(self._path(part)):
            return check(self._file(part).read_row_group(group, self.columns))

    def row_at(self, index):
        """A row of the head, as a table of one row with the columns."""
        part, row = self.part[index], self.row[index]
        group = bisect.bisect_right(self._starts[part], row) - 1
        return self._group(part, group).slice(row - self._starts[part][group], 1)

    def groups(self, part):
        """Yields the rows of a part, in tables with the columns."""
        for group in range(len(self._starts[part]) - 1):
            yield self._read_group(part, group)

    def keep(self, kept):
        """Writes parts anew that have rows of the head that are not kept, of which there is a flag for each."""
        for part in range(len(self.names)):
            flags = kept[self.part == part]
            with contextlib.suppress(FileNotFoundError):  # another process has done the same
                if flags.any() and not flags.all():
                    with reading(self._path(part)):
                        table = self._file(part).read(self.schema.names)
                    write_part(self.folder, table.filter(pa.array(flags)))
                if not flags.all():
                    os.remove(self._path(part))

    def parameters(self):
        """The parameters of all rows, which must be the same, or None without rows."""
        found = pc.unique(self.head['parameters']).to_pylist()
        if len(found) > 1:
            raise Refused(f'{self.folder} has {self.kind} of different parameters: {found[0]} and {found[1]}')
        with reading(self.folder):
            return dict(json.loads(found[0])) if found else None

    def agree(self, parameters):
        """Refuses parameters that are not those of the rows."""
        theirs = self.parameters()
        for name in parameters if theirs else ():
            if theirs.get(name) != parameters[name]:
                raise Refused(f'{self.folder} was made with {name} {theirs.get(name)}, not {parameters[name]}: go '
                              f'on with that, or give --out another folder')


# Features

def parameters_of(detector, how):
    """What features depend on besides the images: a dict."""
    values = {name[3:]: getattr(detector, 'get' + name[3:])() for name in dir(detector) if name.startswith('set')}
    return {**{name: value for name, value in how._asdict().items() if name != 'max_pixels'}, **values}


def detector_of(parameters):
    """The detector and the way of reading images that parameters_of describes."""
    detector = aqorb.AdaptiveQuadtreeORB_create()
    for name, value in parameters.items():
        if name not in images.Reading._fields:
            getattr(detector, 'set' + name)(value)
    return detector, images.Reading(**{name: parameters[name] for name in images.Reading._fields if name in parameters})


class File(typing.NamedTuple):
    """An image to extract features from: its name in the collection, a function that opens it, and what its row says of
    the file. mask is the path of a mask."""

    name: str
    open: typing.Callable
    folder: typing.Optional[str] = None
    file_size: typing.Optional[int] = None
    file_time: typing.Optional[int] = None
    mask: typing.Optional[str] = None
    mask_time: int = 0


def extract(files, detector, how=images.Reading(), threads=1):
    """Reads images and detects their features, in the given number of threads, each of which has one image at a time.
    Yields each File in order, with a table of one row or None, and what there is to say of it, such as why not."""
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
            return None, getattr(error, 'strerror', None) or str(error) or type(error).__name__

    with concurrent.futures.ThreadPoolExecutor(threads) as pool:
        for file, (row, note) in map_ahead(pool, row_of, files, 2 * threads):
            yield file, row, note


def scale_up(features, picture):
    """Changes features that were detected in the pixels of a picture to what they are at its size."""
    scales = [side / smaller for side, smaller in zip(picture.size, picture.pixels.shape[::-1])]
    if scales != [1, 1]:
        for positions, scale in zip((features.x, features.y), scales):  # the centre of the first pixel is 0
            positions[:] = (positions + .5) * scale - .5
        features.size[:] *= sum(scales) / 2


def to_row(file, picture, features, parameters):
    """The table of one image."""
    if len(features.x) >= 2**26:
        raise ValueError(f'an image has at most {2**26 - 1} features, got {len(features.x)}')  # 2 GB of descriptors
    digest = hashlib.blake2b(digest_size=8)
    for array in features[:7]:
        digest.update(array)
    row = dict(picture.camera, name=file.name, folder=file.folder, file_size=file.file_size, file_time=file.file_time,
               mask=file.mask_time, width=picture.size[0], height=picture.size[1], orientation=picture.orientation,
               parameters=parameters, version=f'aqorb {aqorb.__version__}, Pillow {PIL.__version__}',
               digest=digest.hexdigest())
    columns = []
    for field in FEATURES:
        if field.name == 'descriptors':
            columns.append(pa.array([features.descriptors.tobytes()], field.type))
        elif pa.types.is_list(field.type):
            values = pa.array(getattr(features, field.name))
            columns.append(pa.ListArray.from_arrays(pa.array([0, len(values)], pa.int32()), values))
        else:
            columns.append(pa.array([row.get(field.name)], field.type))
    return pa.Table.from_arrays(columns, schema=FEATURES)


class Features(Parts):
    """The features in a folder. images are the names of the images in ascending order, and chosen the images' rows."""

    kind, schema = 'features', FEATURES
    heads = FEATURES.names[:8] + ['parameters', 'digest']

    def __init__(self, folder, columns=('x', 'y', 'descriptors')):
        if not os.path.isdir(folder):
            raise Refused(f'{folder} is no folder' if os.path.exists(folder) else f'{folder}: there is no such folder')
        super().__init__(folder, list(columns))
        last = {name: row for row, name in enumerate(self.head['name'].to_pylist())}
        self.images = sorted(last)
        self.chosen = np.array([last[name] for name in self.images], int)
        self.index = {name: index for index, name in enumerate(self.images)}

    def value(self, name):
        """A column of the head, with an element for each image."""
        return self.head[name].take(pa.array(self.chosen)).to_pylist()

    def of(self, image):
        """The columns of an image, given by its index, that have an element for each keypoint: a dict of arrays,
        descriptors as rows of 32 bytes."""
        row = self.row_at(self.chosen[image])
        lists = set(self.columns) & set(dict(KEYPOINTS))
        found = {name: row[name].combine_chunks().flatten().to_numpy() for name in lists}
        return dict(found, descriptors=np.frombuffer(row['descriptors'][0].as_buffer(), np.uint8).reshape(-1, 32))

    def keypoints(self, image):
        """The positions and the descriptors of an image: arrays (n, 2) and (n, 32)."""
        found = self.of(image)
        return np.column_stack([found['x'], found['y']]), found['descriptors']

    def path(self, image, folder=None):
        """The path of an image's file."""
        return path_of(folder or self.head['folder'][int(self.chosen[image])].as_py() or '.', self.images[image])


def name_of(path, folder):
    """The name of a file in a collection: its path relative to a folder, as text."""
    relative = os.fsencode(os.path.relpath(path, folder).replace(os.sep, '/'))
    return relative.decode('utf-8', 'backslashreplace')  # bytes that are no UTF-8 are shown


def path_of(folder, name):
    """The path of what name_of has named."""
    path = os.path.join(os.fsencode(folder), name.encode())
    if not os.path.exists(path):
        path = re.sub(rb'\\x([89a-f][0-9a-f])', lambda found: bytes([int(found[1], 16)]), path)
    return os.fsdecode(path)


# Matches

class Matches(Parts):
    """The matches in a folder that are of the given features. Of each pair of images, given by rows of their indices in
    pairs, the last row of the head is in chosen."""

    kind, schema, heads = 'matches', MATCHES, MATCHES.names[:5]

    def __init__(self, folder, features):
        super().__init__(folder, MATCHES.names[5:])
        self._count = len(features.images)
        names, digests = pa.array(features.images, pa.string()), pa.array(features.value('digest'), pa.string())
        ends, is_valid = [], np.ones(len(self.head), bool)
        for side in '12':
            index = pc.index_in(self.head['name' + side].combine_chunks(), names)
            same = pc.equal(digests.take(index), self.head['digest' + side].combine_chunks())
            is_valid &= np.asarray(pc.fill_null(same, False), bool)
            ends.append(np.asarray(pc.fill_null(index, 0), np.int64))
        codes = self.codes(np.column_stack(ends))
        rows = np.flatnonzero(is_valid)[::-1]  # of those of the same pair the last
        self.known, first = np.unique(codes[rows], return_index=True)
        self.chosen = np.sort(rows[first])
        self.pairs = np.column_stack(ends)[self.chosen]

    def codes(self, pairs):
        """A number for each pair of images, the same in both orders."""
        return pairs.min(1) * np.int64(self._count) + pairs.max(1)

    def of(self, pair):
        """The columns of a pair, given by its index in pairs: a dict of arrays."""
        row = self.row_at(self.chosen[pair])
        return {name: row[name].combine_chunks().flatten().to_numpy() for name in self.columns}


def to_matches(features, pairs, found, parameters):
    """The table of pairs of images, given by rows of two indices, of what was found for each: its columns of lists."""
    names, digests = features.images, features.value('digest')
    columns = [[column[image] for image in pairs[:, side]] for column in (names, digests) for side in (0, 1)]
    columns += [[json.dumps(parameters)] * len(pairs), *zip(*found)]
    arrays = [pa.array(column, field.type) for column, field in zip(columns, MATCHES)]
    return pa.Table.from_arrays(arrays, schema=MATCHES)
