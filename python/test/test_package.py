# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of what the package aqorb has beyond cv2.aqorb, whose tests in modules/aqorb/misc/python/test hold for it, too."""

import ast
import inspect
import os
import pathlib
import re

import cv2 as cv
import numpy as np
import pytest

import aqorb
from conftest import FOLDER, copies_of, noise, python

# cv2 4.6 has no stubs, nor have other packages that the documents' programs use.
MYPY = '[mypy]\n[mypy-cv2.*,pyarrow.*,PIL.*,pycolmap.*,aqorb_photographs.*]\nignore_missing_imports = True\n'
FIELDS = ('pt', 'size', 'angle', 'response', 'octave', 'class_id')


def same(keypoints, array):
    return [(*k.pt, *(getattr(k, name) for name in FIELDS[1:])) for k in keypoints] == [
        (*row['pt'], *row.tolist()[1:]) for row in array]


def test_arrays_equal_objects(orb, image):
    keypoints, descriptors = orb.detectAndCompute(image, None)
    array, rows = orb.detectAndComputeArrays(image)
    assert array.dtype == aqorb.keypoint_dtype
    assert array.dtype.names == FIELDS
    assert array['pt'].shape == (300, 2) and array['pt'].dtype == np.float32
    assert same(keypoints, array)
    assert rows.shape == (300, 32) and np.array_equal(rows, descriptors)
    assert array.flags.writeable and rows.flags.writeable


def test_conversion_of_keypoints():
    keypoints = [cv.KeyPoint(1.5, 2.25, 3, 4, 5, 6, 7), cv.KeyPoint(-1, 1e6, 0)]
    array = aqorb.keypointsToArray(keypoints)
    assert same(keypoints, array)
    assert same(aqorb.keypointsFromArray(array), array)
    assert same(aqorb.keypointsFromArray(array[::-1]), array[::-1])
    assert aqorb.keypointsFromArray(array[:0]) == ()
    assert aqorb.keypointsToArray(()).shape == (0,)


class Other:
    """A keypoint that does not hold its fields as cv2's does."""
    def __init__(self, x, y, *rest):
        self.pt = (x, y)
        self.size, self.angle, self.response, self.octave, self.class_id = rest


@pytest.mark.parametrize('kind', [cv.KeyPoint, Other])
def test_keypoints_are_as_their_class_makes_them(monkeypatch, image, kind):
    array = aqorb.AdaptiveQuadtreeORB_create(100).detectAndComputeArrays(image)[0]
    monkeypatch.setattr(cv, 'KeyPoint', kind)
    keypoints = aqorb.AdaptiveQuadtreeORB_create(100).detect(image)
    constructed = [kind(float(item['pt'][0]), float(item['pt'][1]), *item.tolist()[1:]) for item in array]
    assert {type(keypoint) for keypoint in keypoints} == {kind}
    for field in FIELDS:
        assert [getattr(each, field) for each in keypoints] == [getattr(each, field) for each in constructed]
    keypoints[0].pt = 5, 6
    assert keypoints[0].pt == (5, 6) and keypoints[1].pt == constructed[1].pt
    if kind is not Other:
        pictures = [cv.drawKeypoints(image, each[1:], None, (0, 0, 255)) for each in (keypoints, constructed)]
        assert np.array_equal(*pictures)


def test_functions_take_arrays(orb, image):
    keypoints, size = orb.detect(image), (640, 480)
    array = aqorb.keypointsToArray(keypoints)
    for measure in aqorb.distributionUniformity, aqorb.distributionOccupancy:
        assert measure(array, size) == measure(keypoints, size)
    kept = aqorb.retainUniform(array, size, 50)
    assert kept.dtype == aqorb.keypoint_dtype and same(aqorb.retainUniform(keypoints, size, 50), kept)


def test_error_is_what_users_catch(orb):
    assert issubclass(aqorb.error, cv.error) and issubclass(aqorb.error, ValueError)
    with pytest.raises(aqorb.error, match=r'patchSize must be from 2 to 16384, got 1') as raised:
        orb.setPatchSize(1)
    assert raised.value.code == cv.Error.StsOutOfRange
    assert str(raised.value) == raised.value.err == 'patchSize must be from 2 to 16384, got 1'


def test_a_detector_has_no_constructor():
    detector = aqorb.AdaptiveQuadtreeORB
    for kind in detector, type('Derived', (detector,), {}):
        for call in (kind, lambda: kind(500), lambda: kind.__new__(kind), lambda: object.__new__(kind)):
            with pytest.raises(TypeError, match=r'call aqorb\.AdaptiveQuadtreeORB\.create or|object.__new__'):
                call()
    assert type('Mine', (aqorb.HammingMatcher,), {})().match(None, None) == ()


def test_memoryviews(orb, image):
    expected, mask = orb.detectAndComputeArrays(image, image > 99), image > 99
    for found in (orb.detectAndComputeArrays(memoryview(image), memoryview(mask)),
                  orb.detectAndComputeArrays(memoryview(image.tobytes()).cast('B', image.shape), mask),
                  orb.compute(memoryview(image), expected[0]),
                  [values[0] for values in orb.compute([memoryview(image)], [expected[0]])]):
        assert np.array_equal(found[0], expected[0]) and np.array_equal(found[1], expected[1])
    assert len(orb.detect(memoryview(image))) == 300
    rows = memoryview(expected[1])
    assert np.array_equal(aqorb.matchArrays(rows, rows)[0], aqorb.matchArrays(expected[1], expected[1])[0])
    with pytest.raises(aqorb.error, match=r'image must be uint8 .*, got an array of dtype uint8 and shape \(5,\)'):
        orb.detect(memoryview(b'black'))


@pytest.mark.parametrize('shape, strides', [((480, 640), (0, 1)), ((480, 640), (640, 0)), ((480, 640), (-640, 1))])
def test_strides_that_no_mat_has(orb, image, shape, strides):
    start = image[::-1] if strides[0] < 0 else image
    view = np.lib.stride_tricks.as_strided(start, shape, strides, writeable=False)
    assert np.array_equal(orb.detectAndComputeArrays(view)[1], orb.detectAndComputeArrays(view.copy())[1])


def words(text):
    return ' '.join((text or '').split())


def test_stub_has_the_parameters_and_docstrings():
    # Editors show those of the stub, because they do not load a compiled module.
    stub = ast.parse((pathlib.Path(aqorb.__file__).parent / '__init__.pyi').read_text())
    for node in ast.walk(stub):
        owner = getattr(aqorb, node.name) if isinstance(node, ast.ClassDef) else aqorb
        assert owner is aqorb or words(ast.get_docstring(node)) == words(owner.__doc__)
        for function in [each for each in getattr(node, 'body', ()) if isinstance(each, ast.FunctionDef)]:
            member = inspect.unwrap(getattr(owner, function.name))
            given = words(member.__doc__)
            assert words(ast.get_docstring(function)) in given, function.name
            names = [argument.arg for argument in function.args.args]
            if inspect.isfunction(member):
                assert names == list(inspect.signature(member).parameters)
            elif names[1:]:
                parts = [rf'\b{name}: ' for name in names if name != 'self']
                assert re.search(r'\(.*?' + '.*?'.join(parts), given), function.name


@pytest.fixture
def mypy(tmp_path, monkeypatch):
    """Runs one of its modules, with its option for the configuration and others."""
    pytest.importorskip('mypy')
    if 'site-packages' not in FOLDER:
        monkeypatch.setenv('MYPYPATH', FOLDER)
    (tmp_path / 'mypy.ini').write_text(MYPY)

    def run(module, config, *options):
        return python('-m', module, config, 'mypy.ini', *options, cwd=tmp_path)
    return run


def test_stub_is_a_stub_of_the_package(tmp_path, mypy):
    allowlist = tmp_path / 'allowlist'  # pybind11's metaclass, and its __init__ that raises
    allowlist.write_text('aqorb.AdaptiveQuadtreeORB\naqorb.AdaptiveQuadtreeORB.__init__\naqorb.HammingMatcher\n')
    run = mypy('mypy.stubtest', '--mypy-config-file', 'aqorb', '--allowlist', 'allowlist')
    assert run.returncode == 0, run.stdout


def test_stub_accepts_the_programs_of_the_documents(tmp_path, mypy):
    root = pathlib.Path(__file__).resolve().parents[2]
    if not (pathlib.Path(cv.__file__).parent / '__init__.pyi').exists() or not (root / 'README.md').exists():
        pytest.skip('cv2 has no annotations, or there are no documents')
    text = '\n'.join(path.read_text() for path in [*root.glob('*.md'), *root.glob('p*/*.md'),
                                                   *root.glob('modules/aqorb/tutorials/*/*.markdown')])
    programs = [program for program in re.findall(r'^```python\n(.*?)^```', text, re.MULTILINE | re.DOTALL)
                if re.search('^(import|from) aqorb', program, re.MULTILINE)]
    assert programs
    for i, program in enumerate(programs):
        (tmp_path / f'program{i}.py').write_text(program)
    run = mypy('mypy', '--config-file', '--check-untyped-defs', *[f'program{i}.py' for i in range(len(programs))])
    # cv2's own annotations lack a function and refuse None for a picture. Spark has its variable in its programs.
    errors = [line for line in run.stdout.splitlines()
              if ': error: ' in line and not re.search('"(ORB_create|drawMatches|spark)"', line)]
    assert not errors and 'checked' in run.stdout, run.stdout


def program_of(page, folder, shape=(480, 640)):
    """Returns a function that runs the program of a document, in a folder with two images."""
    path = pathlib.Path(__file__).resolve().parents[2] / page
    if not path.exists():
        pytest.skip(f'there is no {page}')
    program = re.search(r'^```python\n(import sys\n.*?)^```', path.read_text(), re.MULTILINE | re.DOTALL).group(1)
    cv.imwrite(str(folder / 'black.png'), np.zeros(shape, np.uint8))
    cv.imwrite(str(folder / 'noise.png'), noise(1))
    return lambda *names: python('-c', program, *names, cwd=folder)


@pytest.mark.parametrize('shape', [(480, 640), (1, 1), (20, 30)])
def test_program_of_readme_on_black_images(tmp_path, shape):
    program = program_of('README.md', tmp_path, shape)
    run = program('black.png', 'missing.png')
    assert run.returncode == 1 and 'missing.png: cannot be read as an image\n' in run.stdout
    for other in 'black.png', 'noise.png':
        run = program('black.png', other)
        assert (run.returncode, run.stdout) == (0, '0 of 0 matches agree\n')


def test_program_of_the_tutorial_finds_the_box(tmp_path):
    program = program_of('modules/aqorb/tutorials/aqorb_find/aqorb_find.markdown', tmp_path)
    pictures = os.path.join(os.environ.get('OPENCV_TEST_DATA_PATH', ''), 'cv/shared')
    box, scene = (os.path.join(pictures, name) for name in ('box.png', 'box_in_scene.png'))
    for names, code, output in ((('black.png', 'noise.png'), 1, 'not found: 0 places\n'),
                                ((box, scene), 0, r'found: [1-9]\d places\n'), ((box, 'noise.png'), 1, 'not found: ')):
        if os.path.exists(names[0]) or names[0] == 'black.png':
            run = program(*names)
            assert run.returncode == code and re.match(output, run.stdout), run.stdout


def test_matchers_and_batches_are_pickled_and_copied(orb, image):
    batch, matcher = orb.detectAndComputeBatch([image]), aqorb.HammingMatcher(cv.NORM_HAMMING2, True)
    matcher.add([batch.descriptors])
    for other in copies_of(matcher):
        assert [values.tobytes() for values in other.getTrainDescriptors()] == [batch.descriptors.tobytes()]
        with pytest.raises(cv.error, match='(?i)crossCheck|knn'):
            other.knnMatch(batch.descriptors, batch.descriptors, 2)
        assert [m.distance for m in other.match(~batch.descriptors[:1], batch.descriptors[:1])] == [128]
    for other in copies_of(batch):
        assert type(other) is aqorb.FeatureBatch and all(map(np.array_equal, other, batch))


NO_ROOM = '''
import ctypes
while ctypes.pythonapi.Py_AtExit(ctypes.pythonapi.Py_IsInitialized) == 0:
    pass
for _ in range(2):
    try:
        import aqorb
    except ImportError as error:
        assert 'cannot register' in str(error), error
    else:
        raise AssertionError('imported')
'''


def test_no_room_for_a_function_at_the_exit():
    run = python('-c', NO_ROOM)
    assert run.returncode == 0, run.stdout


SUBINTERPRETER = '''
import _xxsubinterpreters as interpreters
interpreters.run_string(interpreters.create(), 'import aqorb')
'''


def test_a_subinterpreter_is_refused():
    pytest.importorskip('_xxsubinterpreters')  # later Pythons refuse by themselves
    assert "in Python's main interpreter only, and this is a subinterpreter" in python('-c', SUBINTERPRETER).stdout


def test_features_for_the_matchers_of_cv2(orb, image):
    mask = np.zeros(image.shape, np.uint8)
    mask[:, 320:] = 1
    expected = orb.detectAndCompute(image, mask)
    features = aqorb.computeImageFeatures2(orb, image, mask)
    assert features.img_size == (640, 480)
    assert same(features.getKeypoints(), aqorb.keypointsToArray(expected[0]))
    assert np.array_equal(features.descriptors.get(), expected[1])
    other = aqorb.computeImageFeatures2(orb, np.roll(image, 9, 1))
    matches = cv.detail_BestOf2NearestMatcher(False, 0.3).apply2([features, other])
    assert matches[1].num_inliers > 50
    nothing = aqorb.computeImageFeatures2(orb, np.zeros((50, 60), np.uint8))
    assert nothing.img_size == (60, 50) and len(nothing.getKeypoints()) == 0
    for shape in (1, 64), (64, 1), (1, 1), (40, 60, 3):
        assert aqorb.computeImageFeatures2(orb, np.zeros(shape, np.uint8)).img_size == shape[1::-1]
    assert aqorb.computeImageFeatures2(orb, None).img_size == (0, 0)


def test_keywords_of_cv2(orb, image):
    expected = orb.detectAndCompute(image, None)
    for call in (lambda: orb.detectAndCompute(image, None, None, False),
                 lambda: orb.detectAndCompute(image=image, mask=None, descriptors=None, useProvidedKeypoints=False),
                 lambda: orb.compute(image, expected[0], None),
                 lambda: orb.compute(image=image, keypoints=expected[0], descriptors=None)):
        assert np.array_equal(call()[1], expected[1])
    assert np.array_equal(orb.compute([image], [expected[0]], None)[1][0], expected[1])
    for call in (lambda: orb.detectAndCompute(image, None, expected[1]),
                 lambda: orb.compute(image, expected[0], expected[1]),
                 lambda: orb.compute([image], [expected[0]], [expected[1]])):
        with pytest.raises(TypeError, match='descriptors must be None, because the call returns descriptors, got .*array'):
            call()
    with pytest.raises(aqorb.error, match='useProvidedKeypoints must be False, got True'):
        orb.detectAndCompute(image, None, useProvidedKeypoints=True)
    other = aqorb.AdaptiveQuadtreeORB_create(nfeatures=7, scaleFactor=1.5, nlevels=3, edgeThreshold=20, firstLevel=1,
                                             WTA_K=3, scoreType=1, patchSize=25, fastThreshold=9)
    assert (other.getMaxFeatures(), other.getWTA_K(), other.getScoreType()) == (7, 3, cv.ORB_FAST_SCORE)
