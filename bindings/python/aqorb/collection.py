# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Features of many images as tables of pyarrow: what the command aqorb and the sample on a cluster have in common.

A table has a row for each image: its path as bytes; width and height of the upright image in pixels; the lists x, y,
size, angle, response and octave with an element for each keypoint, as cv2.KeyPoint has them; and descriptors, 32 bytes
for each keypoint, one after the other. Positions are in pixels of the upright image, also where features were detected
in a smaller one."""

import collections
import concurrent.futures

import numpy as np
import pyarrow as pa

import aqorb

# What Pillow may read, where it can. It hands others to programs: an EPS to Ghostscript, which runs what is in it.
FORMATS = 'PNG', 'JPEG', 'MPO', 'TIFF', 'WEBP', 'BMP', 'PPM', 'GIF', 'JPEG2000', 'SUN', 'HEIF', 'AVIF'
# By EXIF's number of an orientation, Pillow's of what makes it upright.
TURNS = {2: 0, 3: 3, 4: 1, 5: 5, 6: 4, 7: 6, 8: 2}
COLUMNS = (('x', 'float32'), ('y', 'float32'), ('size', 'float32'), ('angle', 'float32'), ('response', 'float32'),
           ('octave', 'int32'))
SCHEMA = pa.schema([('path', pa.binary()), ('width', pa.int32()), ('height', pa.int32())] +
                   [(name, pa.list_(pa.from_numpy_dtype(np.dtype(kind)))) for name, kind in COLUMNS] +
                   [('descriptors', pa.binary())])


def description(detector, max_size=None, orientation=True):
    """What features depend on besides the images, for the metadata of a file: a dict."""
    import PIL
    parameters = {name[3:]: getattr(detector, 'get' + name[3:])() for name in dir(detector) if name.startswith('set')}
    return {'version': aqorb.__version__, 'reader': 'Pillow ' + PIL.__version__, 'max size': max_size,
            'EXIF orientation': orientation, 'parameters': parameters}


def smaller(size, max_size):
    """A width and a height, reduced so that neither is greater than max_size."""
    longer = max(size)
    if not max_size or longer <= max_size:
        return size
    return tuple(max(1, round(side * max_size / longer)) for side in size)


def read_image(file, max_size=None, orientation=True):
    """Decodes a binary file that is open. Returns the grey image, in which neither side is longer than max_size, and
    the width and height that it had before. It is turned as its EXIF data say unless orientation is False. 16 bits are
    scaled to 8, and of an animation the first frame is taken. What is no image raises an exception."""
    from PIL import Image, UnidentifiedImageError
    if not file.read(1):
        raise ValueError('the file is empty')
    file.seek(0)
    Image.init()
    try:
        image = Image.open(file, formats=[name for name in FORMATS if name in Image.OPEN])
    except UnidentifiedImageError:
        raise ValueError('it is no image, or of a format that is not read') from None
    size = image.size
    if image.mode in ('L', 'RGB'):
        image.draft('L', smaller(size, max_size))  # of a JPEG only the brightness is decoded, not much larger than needed
    turn = image.getexif().get(0x0112)
    image.load()
    if image.format == 'TIFF':  # Pillow turns it
        if turn in range(2, 9) and not orientation:
            raise ValueError('its EXIF orientation cannot be ignored, because it is a TIFF')
        size = image.size
    is_turned = orientation and image.format != 'TIFF' and turn in TURNS
    if image.mode.startswith('I'):
        pixels = np.asarray(image)
        if not 0 <= pixels.min() <= pixels.max() <= 65535:
            raise ValueError('its pixels have more than 16 bits')
        image = Image.fromarray(((pixels.astype(np.uint32) + 128) // 257).astype(np.uint8))
    elif image.mode == 'F':
        raise ValueError('its pixels are floating-point numbers, whose range is not known')
    grey = image.convert('L')
    del image  # it may be large
    if is_turned:
        grey = grey.transpose(TURNS[turn])
        size = size[::-1] if turn >= 5 else size
    if grey.size != smaller(size, max_size):
        grey = grey.resize(smaller(size, max_size), Image.BICUBIC, reducing_gap=2)
    return np.asarray(grey), size


def scale_up(features, size, scaled):
    """Changes features of an image, which were detected at the width and height scaled, to what they are at size."""
    scales = [side / smaller for side, smaller in zip(size, scaled)]
    for positions, scale in zip((features.x, features.y), scales):  # the centre of the first pixel is 0
        positions[:] = (positions + .5) * scale - .5
    features.size[:] *= sum(scales) / 2


def to_table(paths, sizes, features):
    """The table of images of the given widths and heights, and an aqorb.FeatureBatch, which is not copied. It holds at
    most 2^26 - 1 features, because the offsets of descriptors in a table have 32 bits."""
    if features.offsets[-1] >= 2**26:
        raise ValueError(f'a table holds at most {2**26 - 1} features, got {features.offsets[-1]}')
    offsets = features.offsets.astype(np.int32)
    columns = [pa.array(paths, pa.binary())]
    columns += [pa.array([size[i] for size in sizes], pa.int32()) for i in (0, 1)]
    for name, _ in COLUMNS:
        columns.append(pa.ListArray.from_arrays(pa.array(offsets), pa.array(getattr(features, name))))
    buffers = [None, pa.py_buffer(offsets * np.int32(32)), pa.py_buffer(features.descriptors)]
    columns.append(pa.Array.from_buffers(pa.binary(), len(paths), buffers))
    return pa.Table.from_arrays(columns, schema=SCHEMA)


def descriptors_of(column):
    """The descriptors of all rows of a table's column as an array (n, 32)."""
    return np.frombuffer(b''.join(value.as_buffer() for value in column), np.uint8).reshape(-1, 32)


def extract(paths, open_file, detector, max_size=None, orientation=True, threads=1, progress=None):
    """Reads images and detects their features, in the given number of threads, each of which has one image at a time.
    open_file is a function that opens a path's file. Returns a table, in the order of the paths, and a list
    of those that are not in it, each with the reason. progress is called with the number of images that are done."""
    def features_of(path):
        try:
            with open_file(path) as file:
                image, size = read_image(file, max_size, orientation)
            features = detector.detectAndComputeBatch([image])
        except Exception as error:  # decoders raise errors of any kind
            return getattr(error, 'strerror', None) or str(error) or type(error).__name__
        if size != image.shape[::-1]:
            scale_up(features, size, image.shape[::-1])
        return to_table([path], [size], features)

    tables, failures = [SCHEMA.empty_table()], []
    with concurrent.futures.ThreadPoolExecutor(threads) as pool:
        for path, result in map_ahead(pool, features_of, paths, 2 * threads):
            if isinstance(result, str):
                failures.append((path, result))
            else:
                tables.append(result)
            if progress:
                progress(1)
    return pa.concat_tables(tables).combine_chunks(), failures


def map_ahead(pool, function, items, count):
    """Yields each item with the function's value. So many items are worked on, or done, before they are asked for."""
    ahead = collections.deque()
    for item in items:
        ahead.append((item, pool.submit(function, item)))
        if len(ahead) > count:
            item, future = ahead.popleft()
            yield item, future.result()
    for item, future in ahead:
        yield item, future.result()
