# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Finds and decodes images in the formats that people have."""

import contextlib
import fnmatch
import functools
import importlib
import io
import math
import os
import re
import struct
import typing

import numpy as np
from PIL import Image

from aqorb_photographs import InputError, sentence_of

# Formats that Pillow may read. It passes others to programs: an EPS to Ghostscript, which executes the file.
FORMATS = 'PNG', 'JPEG', 'MPO', 'TIFF', 'WEBP', 'BMP', 'PPM', 'GIF', 'JPEG2000', 'SUN', 'HEIF', 'AVIF'
# Pillow's transposition to the upright image for each EXIF orientation.
TURNS = {2: 0, 3: 3, 4: 1, 5: 5, 6: 4, 7: 6, 8: 2}
# Files and folders of other programs: trash, thumbnails, parts of features, and the masks of COLMAP.
CLUTTER = re.compile(r'\._.*|\.DS_Store|Thumbs\.db|desktop\.ini|@eaDir|#recycle|@Recycle|\$RECYCLE\.BIN|\.Trash.*'
                     r'|\.?thumbnails|part-.*\.parquet|.*\.(jpe?g|png|tiff?|webp|bmp|heic)\.png', re.IGNORECASE)
STRETCHED = .5, 99.5  # percentiles of black and white


class Reading(typing.NamedTuple):
    """Options of reading images. Reading reduces images to at most max_size pixels a side. stretch maps the darkest and
    brightest pixels of images with more than 8 bits to black and white. An image of more than max_pixels is an error; a
    JPEG counts as reduced by its decoder for max_size."""

    max_size: typing.Optional[int] = None
    stretch: bool = False
    max_pixels: int = 178956970


class Picture(typing.NamedTuple):
    """A grey image as an array, its width and height before the reduction, the EXIF orientation by which it was turned,
    the camera's EXIF data, and a note if the file is incomplete."""

    pixels: np.ndarray
    size: typing.Tuple[int, int]
    orientation: int
    camera: dict
    note: str


def list_files(sources, include=(), exclude=(), out=None):
    """Lists the files in folders and their subfolders, except the folder out. It follows links to folders, and
    visits each folder once. Files among the sources may have any name. Returns the paths of the files, the number of
    names left out, and each folder that cannot be listed, with the reason."""
    found, left_out, failures, seen = {}, 0, [], {os.path.realpath(out)} if out else set()

    def failed(error):
        if error.filename in sources:
            raise error
        failures.append((error.filename, error.strerror))

    def fits(path, patterns):
        return any(fnmatch.fnmatch(name, pattern) for name in (path, os.path.basename(path)) for pattern in patterns)

    for source in sources:
        tops = [source] if os.path.isdir(source) else []
        if not tops:
            found[source] = None
        for top in tops:  # links append to tops
            for parent, folders, names in os.walk(top, onerror=failed):
                if os.path.realpath(parent) in seen:
                    folders.clear()
                    continue
                seen.add(os.path.realpath(parent))
                for listed, patterns in (folders, '*'), (names, include or '*'):
                    paths = {name: os.path.relpath(os.path.join(parent, name), source) for name in sorted(listed)}
                    left_out += len(listed)
                    listed[:] = [name for name, path in paths.items() if fits(path, patterns)
                                 and not fits(path, exclude) and not CLUTTER.fullmatch(name)]
                    left_out -= len(listed)
                tops += filter(os.path.islink, [os.path.join(parent, name) for name in folders])
                found.update(dict.fromkeys(os.path.join(parent, name) for name in names))
    return list(found), left_out, failures


def open_file(path):
    if not os.path.isfile(path):
        raise InputError('it is not a regular file' if os.path.exists(path) else 'there is no such file')
    return open(path, 'rb')


def read_file(path, reading):
    """Returns the Picture of the image in a file."""
    try:
        with open_file(path) as file:
            return read_image(file, reading)
    except Exception as error:  # decoders raise errors of any kind
        raise InputError(f'{os.fsdecode(path)}: {sentence_of(error)}') from error


def smaller(size, max_size):
    """Returns a width and a height, reduced to at most max_size each."""
    longer = max(size)
    if not max_size or longer <= max_size:
        return size
    return tuple(max(1, round(side * max_size / longer)) for side in size)


def read_image(file, reading=Reading()):
    """Decodes an open binary file, and returns a Picture. It scales 16 bits to 8, and takes the first frame of an
    animation. A file that is no image raises an exception."""
    try:
        return decode(file, reading)
    except InputError:
        raise
    except ValueError:  # Pillow limits the texts of a PNG
        file.seek(0)
        content = file.read()
        if without_texts(content) == content:
            raise
        return decode(io.BytesIO(without_texts(content)), reading)


def decode(file, reading):
    image, size, box = open_image(file, reading)
    exif, note = image.getexif(), ''
    turn = exif.get(0x0112) if exif.get(0x0112) in TURNS else 1
    camera = camera_of(exif)
    try:
        image.load()
    except OSError as error:
        if image.format not in ('JPEG', 'MPO') or 'truncated' not in str(error):
            raise
        file.seek(0)
        image, size, box = open_image(io.BytesIO(file.read() + b'\xff\xd9'), reading)
        image.load()
        note = 'its end is missing'
    grey = to_grey(image, reading.stretch)
    is_upright = turn == 1 or image.format == 'TIFF'  # which Pillow has turned
    if image.format == 'TIFF':
        size, box = grey.size, (0, 0, *grey.size)
    del image  # it may be large
    scaled = smaller(size, reading.max_size)
    if grey.size != scaled or box != (0, 0, *scaled):
        grey = grey.resize(scaled, Image.BICUBIC, box, reducing_gap=2)
    if not is_upright:
        grey = grey.transpose(TURNS[turn])
        size = size[::-1] if turn >= 5 else size
    return Picture(np.asarray(grey), size, turn, camera, note)


def without_texts(content):
    """Returns a PNG without its texts and profiles of colours, and other content as it is."""
    if not content.startswith(b'\x89PNG'):
        return content
    kept, at = [content[:8]], 8
    while at < len(content):
        end = at + 12 + int.from_bytes(content[at:at + 4], 'big')
        if content[at + 4:at + 8] not in (b'tEXt', b'zTXt', b'iTXt', b'iCCP'):
            kept.append(content[at:end])
        at = end
    return b''.join(kept)


@functools.lru_cache(None)
def formats():
    """Returns the FORMATS that this Pillow reads."""
    with contextlib.suppress(ImportError):
        heif = importlib.import_module('pillow_heif')
        heif.register_heif_opener()
        getattr(heif, 'register_avif_opener', int)()  # later versions leave AVIF to Pillow
    Image.init()
    return [name for name in FORMATS if name in Image.OPEN]


def recognise(file, head):
    """Opens an image as Image.open does, but for its limit of pixels, which protects the rest of the program: open_image
    checks max_pixels after the draft. Returns None for other files."""
    for name in formats():
        factory, accepts = Image.OPEN[name]
        if not accepts or accepts(head) and not isinstance(accepts(head), str):
            with contextlib.suppress(SyntaxError, IndexError, TypeError, struct.error):
                file.seek(0)
                return factory(file, '')
    return None


def open_image(file, reading):
    """Opens an image without decoding it. Returns the image, its width and height, and the crop box for JPEGs
    decoded at reduced size."""
    file.seek(0)
    head = file.read(16)
    if not head:
        raise InputError('the file is empty')
    file.seek(0)
    if head[:2] in (b'II', b'MM'):  # Pillow closes a TIFF's descriptor twice, by then perhaps another file's
        file = io.BytesIO(file.read())
    image = recognise(file, head)
    if image is None:
        if head[4:12] in (b'ftypheic', b'ftypheix', b'ftypmif1', b'ftypmsf1', b'ftypavif'):
            raise InputError('it is HEIC or AVIF, which needs another package: pip install pillow-heif')
        raise InputError('it is no image, or its format is not supported')
    tags = getattr(image, 'tag_v2', {})
    if image.format == 'TIFF' and (0xc612 in tags or head[8:10] == b'CR' or tags.get(0x00fe) == 1):
        raise InputError('it is a RAW file, whose first picture is a preview: convert it to JPEG or TIFF')
    size, box = image.size, (0, 0, *image.size)
    if image.mode in ('L', 'RGB'):  # decodes only the brightness of a JPEG, at reduced size
        drafted = image.draft('L', smaller(size, reading.max_size))
        box = drafted[1] if drafted else box
    if image.size[0] * image.size[1] > reading.max_pixels:
        raise InputError(f'{image.size[0]} x {image.size[1]} pixels are more than --max-pixels {reading.max_pixels}')
    return image, size, box


def to_grey(image, stretch):
    """Returns a decoded image as a grey image of 8 bits."""
    if image.mode != 'F' and not image.mode.startswith('I'):
        return image.convert('L')
    pixels = np.asarray(image)
    if stretch:
        low, high = np.percentile(pixels[np.isfinite(pixels)], STRETCHED)
        levels = (np.nan_to_num(pixels).astype(np.float32) - low) * (255 / max(high - low, 1e-9)) + .5
        return Image.fromarray(np.clip(levels, 0, 255).astype(np.uint8))
    if image.mode == 'F':
        raise InputError('its pixels are floating-point numbers, whose range is not known: --stretch reads them')
    if pixels.min() < 0:
        raise InputError('its pixels have negative values: --stretch reads them')
    if pixels.max() > 65535:
        raise InputError('its pixels have more than 16 bits: --stretch reads them')
    return Image.fromarray(((pixels.astype(np.uint32) + 128) // 257).astype(np.uint8))


def camera_of(exif):
    """Returns the readable EXIF data of the camera and its place: focal lengths in millimetres, the place in degrees
    and metres."""
    found = {name: exif[tag].strip('\0 ') for tag, name in ((0x010f, 'make'), (0x0110, 'model'))
             if isinstance(exif.get(tag), str)}
    details, place = exif.get_ifd(0x8769), exif.get_ifd(0x8825)

    def note(name, value, *arguments):
        try:
            number = float(value(*arguments))
            if math.isfinite(number):
                found[name] = number
        except (ArithmeticError, LookupError, TypeError, ValueError):  # absent or malformed
            pass

    def degrees(tag, negative):
        sign = -1 if place[tag - 1] in (negative, negative.encode()) else 1
        return sign * sum(float(part) / 60**i for i, part in enumerate(place[tag]))

    note('focal_length', lambda: details[0x920a])
    note('focal_length_35mm', lambda: details[0xa405] or None)
    note('latitude', degrees, 2, 'S')
    note('longitude', degrees, 4, 'W')
    note('altitude', lambda: -place[6] if place.get(5) in (1, b'\1') else place[6])
    return found


def mask_of(folder, name):
    """Returns the path of an image's mask, by COLMAP's naming, or None."""
    for path in (name + '.png', os.path.splitext(name)[0] + '.png'):
        if os.path.isfile(os.path.join(folder, path)):
            return os.path.join(folder, path)
    return None


def read_mask(path, picture):
    """Reads the mask of an image file, and turns and reduces it like the picture."""
    with open(path, 'rb') as file:
        mask = Image.fromarray(read_image(file).pixels)
    if picture.orientation > 1:
        mask = mask.transpose(TURNS[picture.orientation])
    if mask.size != picture.size:
        raise InputError(f'its mask {path} has another size')
    return np.asarray(mask.resize(picture.pixels.shape[::-1], Image.NEAREST))
