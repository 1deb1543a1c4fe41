# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Files of features and of matches: .parquet, and .db, a database of COLMAP. They are made part by part, so that memory
does not grow with the number of images and that what was stopped can go on. A file gets its name when it is complete,
so that whoever is stopped at any moment leaves the old file or the new one. What is read is checked."""

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

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from tqdm import tqdm

from aqorb import _stop, collection, colmap

SUFFIXES = '.parquet', '.db'
OWN_FILES = r'part-\d{6,}\.parquet|unfinished|joined.*|lock'  # in a folder OUT.partial
MATCHES = pa.schema([('path1', pa.binary()), ('path2', pa.binary()), ('index1', pa.list_(pa.int32())),
                     ('index2', pa.list_(pa.int32())), ('distance', pa.list_(pa.int32()))])
VERIFIED = pa.schema([*MATCHES, ('inliers', pa.list_(pa.int32())), ('fundamental', pa.list_(pa.float64()))])
MIN_INLIERS = 15  # of a two-view geometry, for COLMAP


class Refused(ValueError):
    """What a command does not do, in a sentence."""


def suffix_of(path):
    try:
        path.encode()
    except UnicodeEncodeError:  # pyarrow and sqlite3 could not open it
        raise Refused(f'{path!r} must be a name in UTF-8') from None
    suffix = os.path.splitext(path)[1]
    if suffix not in SUFFIXES:
        raise Refused(f'{path} must end with .parquet or .db')
    return suffix


@contextlib.contextmanager
def reading(path):
    """Says in a sentence what is wrong with a file that is read meanwhile."""
    try:
        yield
    except (Refused, FileNotFoundError, IsADirectoryError, PermissionError):
        raise
    except Exception as error:  # what pyarrow and sqlite3 say of a file with anything in it has many types
        raise Refused(f'{path} is damaged, or no file that aqorb has written: {brief(error)}') from error


def brief(error):
    return ' '.join(str(error).split()) or type(error).__name__


def write_in_parts(out, items, total, unit, part_size, metadata, overwrite, make_table, write, name='features',
                   in_place=False):
    """Makes tables of part_size items each, puts them together and writes them to out. Each is saved in the folder
    OUT.partial when it is done, and is found there if the same call was stopped. make_table takes a list of items and a
    function that it calls as items are done, and returns a table and a list of failures: pairs of a path and a reason.
    write takes the name of a file, an iterable of all tables, the metadata, and the database that out is, if it is one.
    The name is that of the metadata in a database. If matches are written in place, only matches are in their way.
    Returns all failures."""
    partial = out + '.partial'
    if os.path.isdir(out):
        raise Refused(f'{out} is a folder')
    if os.path.exists(out) and not os.stat(out).st_mode & 0o222:
        raise Refused(f'{out} is write-protected')
    with locked(partial) as was_begun:
        theirs = None
        if os.path.exists(out) and not overwrite:
            theirs = read_matches_metadata(out) if in_place else read_metadata(out, name) if was_begun else {}
        if theirs is None:
            return join_parts(out, partial, items, total, unit, part_size, metadata, make_table, write)
        if not was_begun or theirs != metadata:
            raise Refused(f'{out} has matches; --overwrite replaces them' if in_place else
                          f'{out} exists; --overwrite replaces it')
        return []  # it was stopped when only the folder was left


@contextlib.contextmanager
def locked(folder):
    """Makes a folder that no other process has at the same time, where the system has such locks. It is removed at the
    end, but kept if what is done meanwhile fails. Returns whether it was there."""
    was_there = os.path.isdir(folder)
    lock = os.path.join(folder, 'lock')
    os.makedirs(folder, exist_ok=True)
    foreign = [name for name in os.listdir(folder) if not re.fullmatch(OWN_FILES, name)]
    if foreign:
        raise Refused(f'{folder} has files that are not of this command, such as {foreign[0]}')
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(ImportError):  # on Windows
            import fcntl
            try:
                file = stack.enter_context(open(lock, 'w'))
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                if not os.path.samestat(os.fstat(file.fileno()), os.stat(lock)):
                    raise FileNotFoundError
            except (BlockingIOError, FileNotFoundError):  # the latter has just removed it
                raise Refused(f'another process is writing to {folder}') from None
        try:
            yield was_there
        finally:
            if not set(os.listdir(folder)) - {'lock', 'joined'}:
                shutil.rmtree(folder)
        shutil.rmtree(folder, ignore_errors=True)


def join_parts(out, partial, items, total, unit, part_size, metadata, make_table, write):
    """Makes the parts that are not in the folder partial yet, and the file out of all of them."""
    def name_of(part):
        return os.path.join(partial, f'part-{part:06}.parquet')

    done, failures = 0, []
    begun = dict(metadata, **{'part size': part_size})
    while os.path.exists(name_of(done)):
        with reading(name_of(done)):
            kept = pq.read_schema(name_of(done)).metadata
            theirs = dict(json.loads(kept[b'aqorb']), **{'part size': int(kept[b'part_size'])})
            failures += [(path, reason) for path, reason in json.loads(kept[b'failures'])]
        for key, value in begun.items():
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
            table, failed = make_table(chunk, bar.update)
            failed = [(os.fsdecode(path), reason) for path, reason in failed]
            table = table.replace_schema_metadata(
                {'aqorb': json.dumps(metadata), 'part_size': str(part_size), 'failures': json.dumps(failed)})
            unfinished = os.path.join(partial, 'unfinished')
            pq.write_table(table, unfinished, write_page_checksum=True)
            os.replace(unfinished, name_of(part))
            failures += failed
            done += 1

    joined = os.path.join(partial, 'joined')
    for name in os.listdir(partial):
        if name.startswith('joined'):
            os.remove(os.path.join(partial, name))
    with held(out) as database:
        write(joined, tables_in(map(name_of, range(done))), metadata, database)
        with open(joined, 'rb+') as file:
            os.fsync(file.fileno())
        if os.path.exists(out):
            shutil.copymode(out, joined)
        _stop.finish()
        os.replace(joined, os.path.realpath(out))
    return failures


def tables_in(names):
    """Yields the table in each file."""
    for name in names:
        with reading(name):
            table = pq.read_table(name, page_checksum_verification=True)
        yield table


@contextlib.contextmanager
def held(path):
    """Opens a database, if the path is one, so that nobody else has it open, and there is no other file that belongs to
    it: a file that takes its place would be changed by that."""
    if not path.endswith('.db') or not os.path.exists(path):
        for name in path + '-wal', path + '-journal':
            if os.path.exists(name):
                raise Refused(f'{name} is left of another database: remove it')
        yield None
        return
    with contextlib.closing(sqlite3.connect(path, timeout=1)) as database:
        try:
            for command in ('PRAGMA locking_mode = EXCLUSIVE', 'PRAGMA journal_mode = DELETE', 'BEGIN EXCLUSIVE',
                            'COMMIT'):
                database.execute(command).fetchall()
        except sqlite3.Error as error:
            raise Refused(f'{path} cannot be replaced: {error}') from error
        yield database


def write_parquet(path, tables, metadata, database=None, schema=collection.SCHEMA):
    # Most columns are numbers of which hardly two are the same.
    repeated = [name + '.list.element' for name in ('size', 'octave') if name in schema.names]
    with pq.ParquetWriter(path, schema.with_metadata({'aqorb': json.dumps(metadata)}),
                          use_dictionary=repeated, write_page_checksum=True) as writer:
        for table in tables:
            writer.write_table(table.cast(schema), row_group_size=max(1, len(table)))


def write_database(path, tables, metadata, database=None):
    """A new database of COLMAP. Images of the same size have a camera in common. A table aqorb has the metadata, and a
    digest of the features."""
    with contextlib.closing(colmap.create(path)) as made:
        cameras = {}
        for table in tables:
            for row in range(len(table)):
                name, width, height = (table[column][row].as_py() for column in ('path', 'width', 'height'))
                if (width, height) not in cameras:
                    cameras[width, height] = colmap.write_camera(made, width, height)
                x, y, size, angle = (table[column][row].values.to_numpy() for column in ('x', 'y', 'size', 'angle'))
                colmap.write_image(made, name, cameras[width, height],
                                   np.column_stack([x, y, size / 2, np.radians(angle)]),
                                   collection.descriptors_of(table['descriptors'].slice(row, 1)))
        made.execute('CREATE TABLE aqorb (name TEXT PRIMARY KEY, metadata TEXT)')
        set_metadata(made, 'features', metadata)
        set_metadata(made, 'sha256', digest_of(made))
        made.commit()


def write_matches(path, tables, metadata, database, features):
    """A database of COLMAP with features, and the matches in the tables. If the features are in one, it is a copy."""
    if suffix_of(features.path) == '.parquet':
        write_database(path, features.tables(), features.metadata)
    else:
        is_held = database and os.path.samefile(features.path,
                                                database.execute('PRAGMA database_list').fetchone()[2])
        with contextlib.nullcontext(database) if is_held else read_only(features.path) as source:
            if digest_of(source) != features.metadata['sha256']:
                raise Refused(f'{features.path} was changed while it was matched')
            source.execute('VACUUM INTO ?', (path,))
    with contextlib.closing(colmap.open_alone(path)) as made:
        made.execute('DELETE FROM matches')
        made.execute('DELETE FROM two_view_geometries')
        numbers = dict(made.execute('SELECT CAST(name AS BLOB), image_id FROM images').fetchall())
        for table in tables:
            for row in range(len(table)):
                first, second = (numbers[table[name][row].as_py()] for name in ('path1', 'path2'))
                pairs = np.column_stack([table[name][row].values.to_numpy() for name in ('index1', 'index2')])
                colmap.write_matches(made, first, second, pairs)
                inliers = table['inliers'][row].values.to_numpy() if 'inliers' in table.schema.names else ()
                if len(inliers) >= MIN_INLIERS:
                    colmap.write_two_view_geometry(made, first, second, pairs[inliers],
                                                   table['fundamental'][row].values.to_numpy().reshape(3, 3))
        set_metadata(made, 'matches', metadata)
        made.commit()


def set_metadata(database, name, metadata):
    database.execute('REPLACE INTO aqorb VALUES (?, ?)', (name, json.dumps(metadata)))


def get_metadata(database, name):
    row = database.execute('SELECT metadata FROM aqorb WHERE name = ?', (name,)).fetchone()
    return json.loads(row[0]) if row else None


def rows_of(database, number=None):
    """Yields the number of each image, or of one, its name, its keypoints and its descriptors."""
    rows = database.execute(
        'SELECT images.image_id, CAST(name AS BLOB), k.rows, k.cols, k.data, d.rows, d.cols, d.data FROM images '
        'LEFT JOIN keypoints AS k USING (image_id) LEFT JOIN descriptors AS d USING (image_id) '
        'WHERE ?1 IS NULL OR images.image_id = ?1 ORDER BY images.image_id', (number,))
    for found, name, count, columns, keypoints, described, width, descriptors in rows:
        if not isinstance(keypoints, bytes) or not isinstance(descriptors, bytes) or width != 32 or columns < 2 or \
                not count == described == len(keypoints) / 4 / columns == len(descriptors) / 32:
            raise ValueError(f'{os.fsdecode(name)} has not a descriptor of 32 bytes for each keypoint')
        yield (found, name, np.frombuffer(keypoints, '<f4').reshape(count, columns),
               np.frombuffer(descriptors, np.uint8).reshape(count, 32))


def digest_of(database):
    """The SHA-256 of all features in a database."""
    state = hashlib.sha256()
    for number, name, keypoints, descriptors in rows_of(database):
        state.update(b'%d %s %d %d' % (number, name, *keypoints.shape))
        state.update(keypoints.tobytes())
        state.update(descriptors.tobytes())
    return state.hexdigest()


def digest_of_file(path):
    """The SHA-256 of a file."""
    state = hashlib.sha256()
    with open(path, 'rb') as file:
        for block in iter(lambda: file.read(1 << 20), b''):
            state.update(block)
    return state.hexdigest()


@contextlib.contextmanager
def read_only(path):
    """Opens a database to read it. If it were opened read-only, one of COLMAP's would be left with two more files."""
    with contextlib.closing(sqlite3.connect(f'{pathlib.Path(path).absolute().as_uri()}?mode=rw', uri=True)) as database:
        yield database


def read_metadata(path, name='features'):
    """The metadata of a file that a command of this package has written. In a database features and matches have each
    their own."""
    suffix = suffix_of(path)
    with open(path, 'rb'), reading(path):  # what cannot be opened says so itself
        if suffix == '.parquet':
            metadata = json.loads((pq.read_schema(path).metadata or {}).get(b'aqorb', 'null'))
        else:
            with read_only(path) as database:
                metadata = get_metadata(database, name)
        if not isinstance(metadata, dict):
            raise ValueError(f'it does not say how its {name} were made')
    return metadata


def read_matches_metadata(path):
    """The metadata of the matches in a database, {} if they are of another program, or None without matches."""
    with open(path, 'rb'), reading(path), read_only(path) as database:
        if database.execute("SELECT name FROM sqlite_master WHERE name = 'aqorb'").fetchone():
            metadata = get_metadata(database, 'matches')
            if metadata is not None:
                return metadata
        return {} if database.execute('SELECT pair_id FROM matches').fetchone() else None


def count_matches(path):
    """How many matches a file has."""
    with reading(path):
        if suffix_of(path) == '.parquet':
            file = pq.ParquetFile(path)
            groups = (file.read_row_group(group, ['index1'])['index1'] for group in range(file.num_row_groups))
            return sum(pc.sum(pc.list_value_length(column)).as_py() or 0 for column in groups)
        with read_only(path) as database:
            return database.execute('SELECT ifnull(sum(rows), 0) FROM matches').fetchone()[0]


class Features:
    """The features in a file, which is opened and checked: the paths of the images, as bytes, and the metadata, with a
    digest, so that what is made of other features of the same images is refused. Those of few images are in memory."""

    def __init__(self, path):
        self.path, self.metadata = path, read_metadata(path)
        with reading(path):
            if suffix_of(path) == '.parquet':
                self._open_parquet()
            else:
                self._open_database()
            if len(set(self.paths)) < len(self.paths):
                raise ValueError('it has an image twice')

    def keypoints(self, image):
        """The positions and the descriptors of an image, given by its index in paths: arrays (n, 2) and (n, 32)."""
        with reading(self.path):
            return self._read(image)

    def images(self):
        """Yields the path of each image, its descriptors, and its responses, or None from a database, which has none."""
        with reading(self.path):
            if suffix_of(self.path) == '.db':
                with read_only(self.path) as database:
                    for _, name, _, descriptors in rows_of(database):
                        yield name, descriptors, None
                return
            for group in range(self._file.num_row_groups):
                table = self._read_group(group, ['path', 'x', 'response', 'descriptors'])
                for path, response, descriptors in zip(table['path'], table['response'], table['descriptors']):
                    yield path.as_py(), collection.descriptors_of([descriptors]), response.values.to_numpy()

    @contextlib.contextmanager
    def opened(self):
        """Meanwhile images are read faster from a database. Nobody can replace it."""
        if suffix_of(self.path) == '.parquet':
            yield
        else:
            with read_only(self.path) as self._database:
                yield
            self._database = None

    def tables(self):
        """All features of a .parquet, in tables as those of aqorb.collection."""
        for group in range(self._file.num_row_groups):
            with reading(self.path):
                table = self._read_group(group)
            yield table

    def _open_parquet(self):
        self.metadata['sha256'] = digest_of_file(self.path)
        self._file = pq.ParquetFile(self.path, page_checksum_verification=True)
        if not self._file.schema_arrow.remove_metadata().equals(collection.SCHEMA):
            raise Refused(f'{self.path} has no features, or other columns than aqorb writes')
        self.paths = self._file.read(['path'])['path'].to_pylist()
        groups = [self._file.metadata.row_group(group).num_rows for group in range(self._file.num_row_groups)]
        starts = [0, *itertools.accumulate(groups)]
        if None in self.paths or len(self.paths) != starts[-1]:
            raise ValueError('an image has no path')
        read_group = functools.lru_cache(8)(lambda group: self._read_group(group, ['x', 'y', 'descriptors']))

        def read(image):
            group = bisect.bisect_right(starts, image) - 1
            row = read_group(group).slice(image - starts[group], 1)
            return (np.column_stack([row[name].combine_chunks().flatten().to_numpy() for name in ('x', 'y')]),
                    collection.descriptors_of(row['descriptors']))
        self._read = read

    def _read_group(self, group, columns=None):
        table = self._file.read_row_group(group, columns)
        counts = np.asarray(pc.list_value_length(table['x']))
        for name in table.schema.names:
            column = table[name].combine_chunks()
            is_list = pa.types.is_list(column.type)
            if column.null_count or (is_list and column.flatten().null_count):
                raise ValueError(f'{name} is missing')
            if is_list and not np.array_equal(pc.list_value_length(column), counts):
                raise ValueError(f'there are not as many of {name} as of x')
            if name == 'descriptors' and not np.array_equal(pc.binary_length(column), counts * 32):
                raise ValueError('there are not 32 bytes of descriptors for each keypoint')
            if name in ('width', 'height') and len(column) and pc.min(column).as_py() < 1:
                raise ValueError(f'{name} is less than 1')
        return table

    def _open_database(self):
        self._database = None
        with read_only(self.path) as database:
            self.metadata['sha256'] = get_metadata(database, 'sha256')
            if digest_of(database) != self.metadata['sha256']:
                raise ValueError('its features are not those that were written')
            numbers, self.paths = list(zip(*database.execute(
                'SELECT image_id, CAST(name AS BLOB) FROM images ORDER BY image_id'))) or ((), ())

        def read(image):
            with contextlib.nullcontext(self._database) if self._database else read_only(self.path) as database:
                (_, _, keypoints, descriptors), = rows_of(database, numbers[image])
            return keypoints[:, :2] - np.float32(.5), descriptors
        self._read = read
