# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of how the command aqorb decodes images."""

import concurrent.futures
import io
import os
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import PngImagePlugin
from PIL.TiffImagePlugin import IFDRational

from aqorb_photographs import images
from conftest import Image, encoded, expected, noise, rows, run, save


def read(content, **options):
    return images.read_image(io.BytesIO(content), images.Reading(**options))[:2]


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


def test_orientations_that_do_not_exist():
    for orientation in 0, 9:
        for kind in 'PNG', 'JPEG', 'TIFF':
            pixels, size = read(encoded(Image.fromarray(noise(1)), kind, exif=oriented(orientation)))
            assert pixels.shape == (120, 160) and size == (160, 120), (orientation, kind)
    text = b'Exif\0\0MM\0*\0\0\0\x08\0\1\x01\x12\0\2\0\0\0\x026\0\0\0\0\0\0\0'  # not a number, but text
    assert read(encoded(Image.fromarray(noise(1)), 'JPEG', exif=text))[1] == (160, 120)


def test_sixteen_bits():
    wide = noise(2).astype(np.uint16) * 257
    for kind in 'PNG', 'TIFF', 'PPM':
        content = encoded(Image.fromarray(wide.astype(np.int32) if kind == 'PPM' else wide), kind)
        assert np.array_equal(read(content)[0], noise(2)), kind
    assert np.array_equal(read(encoded(Image.fromarray(wide // 2)))[0], (wide // 2 + 128) // 257)
    for kind, factor, fault in ((np.int32, 2, 'more than 16 bits'), (np.int32, -1, 'negative values'),
                                (np.float32, 1, 'floating-point')):
        with pytest.raises(ValueError, match=f'{fault}.*: --stretch'):
            read(encoded(Image.fromarray(wide.astype(kind) * factor), 'TIFF'))


def test_stretch():
    twelve = Image.fromarray(noise(2).astype(np.uint16) * 16)
    assert read(encoded(twelve))[0].max() < 20
    stretched = read(encoded(twelve), stretch=True)[0].astype(int)
    assert stretched.min() == 0 and stretched.max() == 255 and np.abs(stretched - noise(2)).mean() < 5
    thermal = Image.fromarray(noise(2).astype(np.float32) / 10 - 40)
    assert np.abs(read(encoded(thermal, 'TIFF'), stretch=True)[0] - stretched).max() <= 1
    assert np.array_equal(read(encoded(Image.fromarray(noise(2))), stretch=True)[0], noise(2))


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
    contents = encoded(image), encoded(image, 'JPEG', quality=95)
    for content in contents:
        for max_size, width, height in (None, 640, 480), (640, 640, 480), (639, 639, 479), (100, 100, 75), (1, 1, 1):
            pixels, size = read(content, max_size=max_size)
            assert pixels.shape == (height, width) and size == (640, 480)
    png, jpeg = (read(content, max_size=160)[0].astype(int) for content in contents)
    assert np.abs(png - jpeg).mean() < 3


@pytest.mark.parametrize('width, height, max_size', [(1601, 1201, 200), (1201, 1601, 200), (1600, 1200, 200)])
def test_the_draft_of_a_jpeg_moves_nothing(width, height, max_size):
    rows, columns = np.mgrid[:height, :width]
    spots = [np.exp(-((columns - x)**2 + (rows - y)**2) / 800) for x in (100, width - 100) for y in (100, height - 100)]
    image = Image.fromarray(np.uint8(250 * sum(spots)))
    for kind in 'JPEG', 'PNG':
        pixels, size = read(encoded(image, kind), max_size=max_size)
        assert size == (width, height) and max(pixels.shape) == max_size
        scale = np.divide(size, pixels.shape[::-1])
        for right in 0, 1:  # the centre of the spots at the left, and at the right, in pixels of the large image
            half = pixels[:, :pixels.shape[1] // 2] if not right else pixels[:, pixels.shape[1] // 2:]
            left = right * (pixels.shape[1] // 2)
            centre = (half.sum(0, dtype=float) @ (np.arange(half.shape[1]) + left) / half.sum() + .5) * scale[0] - .5
            assert abs(centre - (width - 100 if right else 100)) < .5, (kind, right, centre)


@pytest.mark.parametrize('kind, ending', [('HEIF', b'ftypheic'), ('AVIF', b'ftypavif')])
def test_heic_and_avif(kind, ending):
    content = bytes(4) + ending + bytes(100)
    try:
        import pillow_heif
        pillow_heif.register_avif_opener()
        content = encoded(Image.fromarray(noise(1)).convert('RGB'), kind, quality=95)
    except (ImportError, AttributeError, OSError, KeyError):
        with pytest.raises(ValueError, match='pip install pillow-heif|no image'):
            read(content)
        return
    pixels, size = read(content)
    assert size == (160, 120) and np.abs(pixels.astype(int) - noise(1)).mean() < 8


@pytest.mark.parametrize('tags', [{254: 1}, {50706: b'\1\4\0\0'}])
def test_a_preview_is_no_photograph(tags):
    with pytest.raises(ValueError, match='a RAW file, whose first picture is a preview'):
        read(encoded(Image.fromarray(noise(1)), 'TIFF', tiffinfo=tags))
    assert read(encoded(Image.fromarray(noise(1)), 'TIFF', tiffinfo={254: 0}))[1] == (160, 120)


def test_a_jpeg_without_its_end():
    content = encoded(Image.fromarray(noise(1, 480, 640)), 'JPEG', quality=95)
    whole = images.read_image(io.BytesIO(content))
    assert whole.note == ''
    for end, rows in (-2, 480), (len(content) // 2, 200):
        picture = images.read_image(io.BytesIO(content[:end]))
        assert picture.note == 'its end is missing'
        assert np.array_equal(picture.pixels[:rows], whole.pixels[:rows])


def test_compressed_tiffs_on_several_threads(tmp_path):
    Image.fromarray(noise(1, 120, 160)).save(tmp_path / 'a.tif', compression='tiff_lzw')

    def read(_):
        with images.open_file(tmp_path / 'a.tif') as file:
            return images.read_image(file).pixels.tobytes()

    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        assert len(set(pool.map(read, range(500)))) == 1


def test_a_png_with_much_text():
    info = PngImagePlugin.PngInfo()
    info.add_text('history', 'x' * 2**21, zip=True)
    content = encoded(Image.fromarray(noise(1)), 'PNG', pnginfo=info, icc_profile=bytes(2**21))
    assert np.array_equal(read(content)[0], noise(1))
    with pytest.raises(ValueError, match='(?i)too large'):  # the rest of the program keeps Pillow's limits
        Image.open(io.BytesIO(content)).load()


def test_images_with_many_pixels():
    content = encoded(Image.new('L', (14000, 13000)), 'JPEG')
    assert read(content, max_size=1000)[0].shape == (929, 1000)  # the draft is small
    with pytest.raises(ValueError, match='14000 x 13000 pixels are more than --max-pixels 178956970'):
        read(content)
    assert read(content, max_pixels=2 * 10**8)[1] == (14000, 13000)
    with pytest.raises(Image.DecompressionBombError):
        Image.open(io.BytesIO(content))


def test_what_exif_says():
    exif = oriented(1)
    exif.update({0x010f: 'Maker', 0x0110: 'Model\0 '})
    exif[0x8769] = {0x920a: 4.25, 0xa405: 28}
    exif[0x8825] = {1: 'S', 2: (47., 30., 0.), 3: 'E', 4: (8., 15., 36.), 5: b'\1', 6: 40.}
    picture = images.read_image(io.BytesIO(encoded(Image.fromarray(noise(1)), 'JPEG', exif=exif)))
    assert picture.camera == {'make': 'Maker', 'model': 'Model', 'focal_length': 4.25, 'focal_length_35mm': 28,
                              'latitude': -47.5, 'longitude': 8.26, 'altitude': -40}
    broken = SimpleNamespace(get={0x010f: 5}.get, get_ifd={0x8769: {0x920a: IFDRational(1, 0), 0xa405: 0}, 0x8825: {
        1: 'N', 2: ('a', 0.), 4: 'text', 6: 'text'}}.get)
    assert images.camera_of(broken) == {}


def test_positions_are_those_of_the_large_image(tmp_path):
    pixels = noise(8, 480, 640)
    save(tmp_path / 'images' / 'a.png', pixels)
    run('extract', tmp_path / 'images', '--out', tmp_path / 'f', '--max-size', 320)
    row = rows(tmp_path / 'f')['a.png']
    half = expected(read(encoded(Image.fromarray(pixels)), max_size=320)[0])
    assert (row['width'], row['height']) == (640, 480) and row['descriptors'] == half['descriptors']
    for name, shift in ('x', .5), ('y', .5), ('size', 0):
        assert np.allclose(row[name], np.float32(half[name]) * 2 + shift)


def test_formats_that_are_not_read(tmp_path, monkeypatch):
    # Pillow hands an EPS to Ghostscript.
    (tmp_path / 'gs').write_text(f'#!/bin/sh\ntouch {tmp_path}/ran\n')
    (tmp_path / 'gs').chmod(0o755)
    monkeypatch.setenv('PATH', f'{tmp_path}:{os.environ["PATH"]}')
    for kind in 'EPS', 'TGA', 'PCX', 'ICO':
        with pytest.raises(ValueError, match='its format is not supported'):
            read(encoded(Image.fromarray(noise(1)).convert('RGB'), kind))
    assert not (tmp_path / 'ran').exists()


@pytest.mark.parametrize('kind', ['PNG', 'JPEG', 'TIFF', 'WEBP', 'BMP', 'PPM', 'GIF', 'JPEG2000'])
def test_formats_that_are_read(kind):
    assert np.abs(read(encoded(Image.fromarray(noise(1)), kind))[0].astype(int) - noise(1)).mean() < 8
