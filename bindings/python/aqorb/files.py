# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Files of features: .parquet, .npz, and .db, a database of COLMAP. They are written part by part, so that memory does
not grow with the number of images and that what was stopped can go on."""

import bisect
import contextlib
import functools
import hashlib
import itertools
import json
import os
import pathlib
import re
import shutil
import sqlite3
import zipfile

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from tqdm import tqdm

import aqorb
from aqorb import collection

SUFFIXES = '.parquet', '.npz', '.db'
OWN_FILES = r'part-\d{6,}\.parquet|unfinished|joined.*|lock'  # in a folder OUT.partial
MATCHES = pa.schema([('path1', pa.binary()), ('path2', pa.binary()), ('index1', pa.list_(pa.int32())),
                     ('index2', pa.list_(pa.int32())), ('distance', pa.list_(pa.int32()))])


class Refused(ValueError):
    """What a command does not do, in a sentence."""


def suffix_of(path, accepted=SUFFIXES):
    try:
        path.encode()
    except UnicodeEncodeError:  # pyarrow and pycolmap could not open it
        raise Refused(f'{path!r} must be a name in UTF-8') from None
    suffix = os.path.splitext(path)[1]
    if suffix not in accepted:
        raise Refused(f'{path} must end with one of {", ".join(accepted)}')
    return suffix


def write_in_parts(out, items, total, unit, part_size, metadata, overwrite, make_table, write):
    """Makes tables of part_size items each, puts them together and writes them to out. Each is saved in the folder
    OUT.partial when it is done, and is found there if the same call was stopped. make_table takes a list of items and a
    function that it calls as items are done, and returns a table and a list of failures: pairs of a path and a reason.
    write takes the name of a file, an iterable of all tables, and the metadata. Returns all failures."""
    partial = out + '.partial'
    if os.path.isdir(out):
        raise Refused(f'{out} is a folder')
    is_done = os.path.exists(out) and not overwrite  # it was stopped when only the folder was left
    if is_done and (not os.path.isdir(partial) or read_metadata(out) != metadata):
        raise Refused(f'{out} exists; --overwrite replaces it')
    os.makedirs(partial, exist_ok=True)
    foreign = [name for name in os.listdir(partial) if not re.fullmatch(OWN_FILES, name)]
    if foreign:
        raise Refused(f'{partial} has files that are not of this command, such as {foreign[0]}')
    with locked(os.path.join(partial, 'lock')):
        failures = [] if is_done else join_parts(out, partial, items, total, unit, part_size, metadata, make_table, write)
    shutil.rmtree(partial)
    return failures


@contextlib.contextmanager
def locked(name):
    """Holds a file that no other process can hold at the same time, where the system has such locks."""
    with open(name, 'w') as file:
        with contextlib.suppress(ImportError):  # on Windows
            import fcntl
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise Refused(f'another process is writing to {os.path.dirname(name)}') from None
        yield


def join_parts(out, partial, items, total, unit, part_size, metadata, make_table, write):
    """Makes the parts that are not in the folder partial yet, and the file out of all of them."""
    def name_of(part):
        return os.path.join(partial, f'part-{part:06}.parquet')

    done = 0
    while os.path.exists(name_of(done)):
        try:
            kept = pq.read_schema(name_of(done)).metadata
        except pa.ArrowException as error:
            raise Refused(f'{name_of(done)} is damaged: {error}. Remove {partial}') from error
        theirs = dict(json.loads(kept[b'aqorb']), **{'part size': int(kept[b'part_size'])})
        for key, value in dict(metadata, **{'part size': part_size}).items():
            if theirs.get(key) != value:
                raise Refused(f'{partial} was begun with another value of "{key}": {theirs.get(key)}, not {value}. '
                              'Go on with that, or remove it')
        done += 1
    items = itertools.islice(items, done * part_size, None)
    with tqdm(total=total, initial=min(done * part_size, total), unit=unit, smoothing=.05) as bar:
        for part in itertools.count(done):
            chunk = list(itertools.islice(items, part_size))
            if not chunk:
                break
            table, failures = make_table(chunk, bar.update)
            listed = [(os.fsdecode(path), reason) for path, reason in failures]
            table = table.replace_schema_metadata(
                {'aqorb': json.dumps(metadata), 'part_size': str(part_size), 'failures': json.dumps(listed)})
            pq.write_table(table, os.path.join(partial, 'unfinished'))
            os.replace(os.path.join(partial, 'unfinished'), name_of(part))
            done += 1

    parts = [name_of(part) for part in range(done)]
    joined = os.path.join(partial, 'joined')
    if os.path.exists(joined):
        os.remove(joined)
    write(joined, Parts(parts), metadata)
    failures = [failure for name in parts for failure in json.loads(pq.read_schema(name).metadata[b'failures'])]
    os.replace(joined, out)
    return failures


class Parts:
    """The tables in files, one after the other, any number of times."""

    def __init__(self, names):
        self.names = names

    def __iter__(self):
        return (pq.read_table(name) for name in self.names)


def write_parquet(path, tables, metadata, schema=collection.SCHEMA):
    # Most columns are numbers of which hardly two are the same.
    repeated = [name + '.list.element' for name in ('size', 'octave') if name in schema.names]
    with pq.ParquetWriter(path, schema.with_metadata({'aqorb': json.dumps(metadata)}),
                          use_dictionary=repeated) as writer:
        for table in tables:
            writer.write_table(table.cast(schema), row_group_size=max(1, len(table)))


def write_npz(path, tables, metadata):
    """Arrays of all features, those of image i from offsets[i] to offsets[i + 1], and of all images. They are collected
    in files, as they may be greater than the memory."""
    counts = [(len(table), max(map(len, table['path'].to_pylist()), default=1), pc.list_value_length(table['x']))
              for table in tables]
    images = sum(rows for rows, _, _ in counts)
    offsets = np.zeros(images + 1, np.int64)
    offsets[1:] = np.concatenate([lengths for _, _, lengths in counts] or [[]]).cumsum()
    shapes = {'path': (f'S{max([longest for _, longest, _ in counts], default=1)}', (images,)),
              'width': (np.int32, (images,)), 'height': (np.int32, (images,)),
              'descriptors': (np.uint8, (offsets[-1], 32))}
    shapes.update((name, (kind, (offsets[-1],))) for name, kind in collection.COLUMNS)
    os.makedirs(path + '.arrays', exist_ok=True)
    arrays = {}
    for name, (kind, shape) in shapes.items():
        array = os.path.join(path + '.arrays', name)
        arrays[name] = np.lib.format.open_memmap(array, 'w+', kind, shape)
        if hasattr(os, 'posix_fallocate'):  # to write to memory without room on the disk would end the process
            with open(array, 'r+b') as file:
                os.posix_fallocate(file.fileno(), 0, os.path.getsize(array))
    row = 0
    for table in tables:
        rows = slice(row, row + len(table))
        features = slice(offsets[rows.start], offsets[rows.stop])
        arrays['path'][rows] = table['path'].to_pylist()
        for name in 'width', 'height':
            arrays[name][rows] = table[name]
        for name, _ in collection.COLUMNS:
            arrays[name][features] = values_of(table[name])
        arrays['descriptors'][features] = collection.descriptors_of(table['descriptors'])
        row = rows.stop
    with open(path, 'wb') as file:
        np.savez(file, offsets=offsets, metadata=json.dumps(metadata), **arrays)


def values_of(column):
    """The elements of a column of lists, as an array."""
    return column.combine_chunks().flatten().to_numpy()


def write_database(path, tables, metadata):
    """A new database of COLMAP. Images of the same size have a camera in common. The metadata is in a table aqorb."""
    import pycolmap
    from aqorb import colmap
    loose = path + '.loose'
    for name in path, loose, loose + '-wal', loose + '-shm':  # of a call that was killed
        if os.path.exists(name):
            os.remove(name)
    database = pycolmap.Database.open(loose)
    cameras = {}
    for table in tables:
        with pycolmap.DatabaseTransaction(database):
            for row in range(len(table)):
                name, width, height = (table[column][row].as_py() for column in ('path', 'width', 'height'))
                if (width, height) not in cameras:
                    cameras[width, height] = colmap.write_camera(database, width, height)
                x, y, size, angle = (table[column][row].values.to_numpy() for column in ('x', 'y', 'size', 'angle'))
                colmap.write_image(database, name, cameras[width, height],
                                   np.column_stack([x, y, size / 2, np.radians(angle)]),
                                   collection.descriptors_of(table['descriptors'].slice(row, 1)))
    database.close()
    set_metadata(loose, 'features', metadata)
    with contextlib.closing(sqlite3.connect(loose)) as connection:
        connection.execute('VACUUM INTO ?', (path,))  # the same bytes for the same content
    os.remove(loose)


def read_only(database):
    return sqlite3.connect(f'{pathlib.Path(database).absolute().as_uri()}?mode=ro', uri=True)


def set_metadata(database, name, metadata):
    with contextlib.closing(sqlite3.connect(database)) as connection, connection:
        connection.execute('CREATE TABLE IF NOT EXISTS aqorb (name TEXT PRIMARY KEY, metadata TEXT)')
        connection.execute('REPLACE INTO aqorb VALUES (?, ?)', (name, json.dumps(metadata)))


def read_metadata(path, name='features'):
    """The metadata of a file that a command of this package has written. In a database features and matches have each
    their own."""
    try:
        suffix = suffix_of(path)
        if suffix == '.parquet':
            return json.loads(pq.read_schema(path).metadata[b'aqorb'])
        if suffix == '.npz':
            with np.load(path) as file:
                return json.loads(str(file['metadata']))
        with contextlib.closing(read_only(path)) as file:
            return json.loads(file.execute('SELECT metadata FROM aqorb WHERE name = ?', (name,)).fetchone()[0])
    except (OSError, ValueError, TypeError, KeyError, pa.ArrowException, sqlite3.Error, zipfile.BadZipFile) as error:
        raise Refused(f'{path} is no file that aqorb has written: {error}') from error


class Features:
    """The features in a file, of which those in memory are few unless it is an .npz."""

    def __init__(self, path):
        self.path, self.metadata = path, read_metadata(path)
        suffix = suffix_of(path)
        if suffix != '.db':  # what is made of other features of the same images is refused
            self.metadata['sha256'] = digest(path)
        if suffix == '.parquet':
            file = pq.ParquetFile(path)
            if 'descriptors' not in file.schema_arrow.names:
                raise Refused(f'{path} has no features')
            groups = range(file.num_row_groups)
            starts = [0] + list(itertools.accumulate(file.metadata.row_group(group).num_rows for group in groups))
            self.paths = file.read(['path'])['path'].to_pylist()

            @functools.lru_cache(8)
            def read_group(group):
                return file.read_row_group(group, ['descriptors'])['descriptors']

            def descriptors(image):
                group = bisect.bisect_right(starts, image) - 1
                return collection.descriptors_of(read_group(group).slice(image - starts[group], 1))
            self.descriptors = descriptors
            self.tables = lambda: (file.read_row_group(group) for group in groups)
        elif suffix == '.npz':
            with np.load(path) as file:
                arrays = dict(file)
            self.paths, offsets = arrays['path'].tolist(), arrays['offsets']
            self.descriptors = lambda image: arrays['descriptors'][offsets[image]:offsets[image + 1]]
            sizes = list(zip(arrays['width'].tolist(), arrays['height'].tolist()))

            def tables(images=1000):
                for first in range(0, len(self.paths), images):
                    rows = slice(*offsets[[first, min(first + images, len(self.paths))]])
                    batch = aqorb.FeatureBatch(**dict({name: arrays[name][rows] for name in aqorb.FeatureBatch._fields},
                                                      offsets=offsets[first:first + images + 1] - rows.start))
                    yield collection.to_table(self.paths[first:first + images], sizes[first:first + images], batch)
            self.tables = tables
        else:
            ids, self.paths = images_of(path)
            database = read_only(path)

            def descriptors(image):
                found = database.execute('SELECT data FROM descriptors WHERE image_id = ?', (ids[image],)).fetchall()
                return np.frombuffer(b''.join(row[0] or b'' for row in found), np.uint8).reshape(-1, 32)
            self.descriptors = descriptors
            self.tables = None


def digest(path):
    """The SHA-256 of a file."""
    state = hashlib.sha256()
    with open(path, 'rb') as file:
        for block in iter(lambda: file.read(1 << 20), b''):
            state.update(block)
    return state.hexdigest()


def write_matches(path, features, pairs, total, metadata, overwrite, match_pairs):
    """Writes the matches of pairs of images into a database of COLMAP, made of the features unless it is their file.
    What is there already is not matched again."""
    import pycolmap
    from aqorb import colmap
    if features.tables:
        if os.path.exists(path) and not overwrite:
            if read_metadata(path) != features.metadata:
                raise Refused(f'{path} has other features; --overwrite replaces it')
        else:
            write_database(path + '.partial', features.tables(), features.metadata)
            os.replace(path + '.partial', path)
    elif not os.path.exists(path) or not os.path.samefile(path, features.path):
        raise Refused(f'a database is matched in place: copy {features.path}, and match the copy')
    database = pycolmap.Database.open(path)
    try:
        try:
            theirs = read_metadata(path, 'matches')
        except Refused:
            theirs = None
        if database.num_matched_image_pairs() and theirs != metadata:
            if not overwrite:
                raise Refused(f'{path} has other matches; --overwrite replaces them')
            database.clear_matches()
            database.clear_two_view_geometries()
        set_metadata(path, 'matches', metadata)
        ids = dict(zip(*reversed(images_of(path))))
        ids = [ids[name] for name in features.paths]
        with tqdm(total=total, unit='pair', smoothing=.05) as bar:
            for chunk in iter(lambda: list(itertools.islice(pairs, 1000)), []):
                absent = [(i, j) for i, j in chunk if not database.exists_matches(ids[i], ids[j])]
                with pycolmap.DatabaseTransaction(database):
                    for (i, j), found, _ in match_pairs(absent):
                        colmap.write_matches(database, ids[i], ids[j], found)
                bar.update(len(chunk))
    finally:
        database.close()


def images_of(database):
    """The numbers of the images in a database, and their names as bytes."""
    with contextlib.closing(read_only(database)) as connection:
        connection.text_factory = bytes
        images = connection.execute('SELECT image_id, name FROM images ORDER BY image_id').fetchall()
    return [number for number, _ in images], [name for _, name in images]
