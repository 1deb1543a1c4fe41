# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of how the command aqorb decodes images."""

import io

import numpy as np
import pytest

from command_support import Image, collection, encoded, expected, noise, rows, run


def read(content, **options):
    return collection.read_image(io.BytesIO(content), **options)


def oriented(orientation):
    exif = Image.Exif()
    exif[0x0112] = orientation
    return exif


@pytest.mark.parametrize('orientation', range(1, 9))
def test_orientation(orientation):
    upright = Image.fromarray(noise(1))
    # What undoes the turn of each orientation.
    stored = {2: Image.FLIP_LEFT_RIGHT, 3: Image.ROTATE_180, 4: Image.FLIP_TOP_BOTTOM, 5: Image.TRANSPOSE,
              6: Image.ROTATE_90, 7: Image.TRANSVERSE, 8: Image.ROTATE_270}
    turned = upright.transpose(stored[orientation]) if orientation > 1 else upright
    for kind in 'PNG', 'TIFF':
        pixels, size = read(encoded(turned, kind, exif=oriented(orientation)))
        assert np.array_equal(pixels, noise(1)) and size == (160, 120), kind
    jpeg = encoded(turned, 'JPEG', quality=95, exif=oriented(orientation))
    pixels, size = read(jpeg)
    assert size == (160, 120) and np.abs(pixels.astype(int) - noise(1)).mean() < 5
    pixels, size = read(jpeg, max_size=40)
    assert size == (160, 120) and pixels.shape == (30, 40)
    pixels, size = read(jpeg, orientation=False)
    assert size == turned.size and pixels.shape == turned.size[::-1]


def test_orientations_that_do_not_exist():
    for orientation in 0, 9:
        for kind in 'PNG', 'JPEG', 'TIFF':
            pixels, size = read(encoded(Image.fromarray(noise(1)), kind, exif=oriented(orientation)))
            assert pixels.shape == (120, 160) and size == (160, 120), (orientation, kind)
    text = b'Exif\0\0MM\0*\0\0\0\x08\0\1\x01\x12\0\2\0\0\0\x026\0\0\0\0\0\0\0'  # not a number, but text
    assert read(encoded(Image.fromarray(noise(1)), 'JPEG', exif=text))[1] == (160, 120)


def test_a_turned_tiff_is_no_image_that_is_not_to_be_turned():
    assert read(encoded(Image.fromarray(noise(1)), 'TIFF', exif=oriented(1)), orientation=False)[1] == (160, 120)
    with pytest.raises(ValueError, match='cannot be ignored'):
        read(encoded(Image.fromarray(noise(1)), 'TIFF', exif=oriented(6)), orientation=False)


def test_images_that_are_too_wide(orb):
    contents = {name: encoded(Image.new('L', (width, 1))) for name, width in ((b'widest', 2**20 - 1), (b'wider', 2**20))}
    for max_size, count in (None, 1), (1000, 2):
        table, failures = collection.extract(contents, lambda path: io.BytesIO(contents[path]), orb, max_size)
        assert len(table) == count and all('at most 1048575 pixels a side' in reason for _, reason in failures)


def test_sixteen_bits():
    wide = noise(2).astype(np.uint16) * 257
    for kind in 'PNG', 'TIFF', 'PPM':
        content = encoded(Image.fromarray(wide.astype(np.int32) if kind == 'PPM' else wide), kind)
        assert np.array_equal(read(content)[0], noise(2)), kind
    assert np.array_equal(read(encoded(Image.fromarray(wide // 2)))[0], (wide // 2 + 128) // 257)
    with pytest.raises(ValueError, match='more than 16 bits'):
        read(encoded(Image.fromarray(wide.astype(np.int32) * 2), 'TIFF'))
    with pytest.raises(ValueError, match='floating-point'):
        read(encoded(Image.fromarray(wide.astype(np.float32)), 'TIFF'))


@pytest.mark.parametrize('kind', ['GIF', 'PNG', 'TIFF', 'WEBP'])
def test_of_an_animation_the_first_frame(kind):
    frames = [Image.fromarray(noise(i)) for i in (3, 4, 5)]
    options = {'lossless': True} if kind == 'WEBP' else {}
    content = encoded(frames[0], kind, save_all=True, append_images=frames[1:], **options)
    assert np.abs(read(content)[0].astype(int) - noise(3)).max() <= 1


@pytest.mark.parametrize('mode', ['1', 'L', 'LA', 'P', 'RGB', 'RGBA', 'CMYK'])
def test_modes(mode):
    grey = noise(6) // 128 * 255
    image = Image.fromarray(grey)
    image = (image.convert('RGB') if mode in ('P', 'CMYK') else image).convert(mode)
    kind = 'TIFF' if mode == 'CMYK' else 'PNG'
    assert np.abs(read(encoded(image, kind))[0].astype(int) - grey).max() <= 1
    if mode in ('L', 'RGB', 'CMYK'):
        for progressive in False, True:
            pixels, _ = read(encoded(image, 'JPEG', quality=95, progressive=progressive))
            assert np.abs(pixels.astype(int) - grey).mean() < 8


def test_max_size():
    image = Image.fromarray(noise(7)).resize((640, 480), Image.NEAREST).convert('RGB')
    for content in encoded(image), encoded(image, 'JPEG', quality=95):
        for max_size, shape in ((None, (480, 640)), (640, (480, 640)), (639, (479, 639)), (100, (75, 100)), (1, (1, 1))):
            pixels, size = read(content, max_size=max_size)
            assert pixels.shape == shape and size == (640, 480)
    large, small = (read(encoded(image, kind, **options), max_size=160)[0].astype(int)
                    for kind, options in (('PNG', {}), ('JPEG', {'quality': 95})))
    assert np.abs(large - small).mean() < 3


def test_positions_are_those_of_the_large_image(tmp_path):
    (tmp_path / 'images').mkdir()
    pixels = noise(8, 480, 640)
    Image.fromarray(pixels).save(str(tmp_path / 'images' / 'a.png'))
    (tmp_path / 'images' / 'text').write_text('no image')
    finished = run('extract', tmp_path / 'images', '--out', tmp_path / 'f.parquet', '--max-size', 320)
    assert 'f.parquet: 1 image\n' in finished.stdout and '\n1 file left out:\n' in finished.stderr
    row = rows(tmp_path / 'f.parquet')[b'a.png']
    half = expected(read(encoded(Image.fromarray(pixels)), max_size=320)[0])
    assert (row['width'], row['height']) == (640, 480)
    assert np.allclose(row['x'], np.float32(half['x']) * 2 + .5) and np.allclose(row['y'], np.float32(half['y']) * 2 + .5)
    assert np.allclose(row['size'], np.float32(half['size']) * 2) and row['descriptors'] == half['descriptors']
