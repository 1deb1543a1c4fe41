# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of the package where cv2 is not installed or does not work, and that cv2 is imported no sooner than it is needed."""

import os
import re

import pytest

import aqorb
from conftest import python

# cv2 cannot be imported here.
BEGIN = '''
import sys
sys.modules['cv2'] = None
import numpy as np
import aqorb
image = np.repeat(np.repeat(np.random.RandomState(3).randint(0, 256, (60, 80), np.uint8), 8, 0), 8, 1)
orb = aqorb.AdaptiveQuadtreeORB_create(300)

def raised(kind, call):
    try:
        call()
    except kind as error:
        return error
    raise AssertionError('no error')
'''


def run(program):
    run = python('-c', program)
    assert run.returncode == 0, run.stdout
    return run.stdout


@pytest.mark.parametrize('body', [
    # keypoints as objects
    '''
for call in (lambda: orb.detect(image), lambda: orb.detect([image]), lambda: orb.detectAndCompute(image, None),
             lambda: aqorb.keypointsFromArray(orb.detectAndComputeArrays(image)[0])):
    error = raised(ImportError, call)
    assert str(error).startswith('cv2 does not work: ') and 'opencv-python-headless' in str(error)
    assert 'detectAndComputeArrays' in str(error) and isinstance(error.__cause__, ImportError)
for wrong in [5], [image]:
    assert 'keypoints[0] must be a cv2.KeyPoint, got' in str(raised(TypeError, lambda: orb.compute(image, wrong)))
''',
    # errors
    '''
import pickle
error = raised(ValueError, lambda: orb.setPatchSize(1))
assert type(error) is aqorb.error and 'patchSize' in error.err and error.code == -211
assert type(pickle.loads(pickle.dumps(error))) is aqorb.error
assert aqorb.error.__bases__ == (ValueError,) and 'error' in dir(aqorb)
''',
    # files
    '''
import copy, os, pathlib, tempfile
with tempfile.TemporaryDirectory() as folder:
    path = pathlib.Path(folder) / 'orb.yml'
    orb.write(path)
    other = aqorb.AdaptiveQuadtreeORB_create()
    other.read(path)
    assert other.getMaxFeatures() == copy.copy(orb).getMaxFeatures() == 300
for call in orb.write, orb.read:
    assert 'got 5' in str(raised(TypeError, lambda: call(5)))
'''], ids=['keypoints', 'errors', 'files'])
def test_without_cv2(body):
    run(BEGIN + body)


def test_arrays_without_cv2():
    program = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'without_cv2.py')
    run(f"import sys, runpy; sys.modules['cv2'] = None; runpy.run_path({program!r})")


@pytest.mark.parametrize('cv2, cause', [
    ('', "module 'cv2' has no attribute 'KeyPoint'"),
    ('raise ImportError("libGL.so.1: cannot open shared object file")', 'libGL.so.1: cannot open shared object file')])
def test_cv2_does_not_work(tmp_path, cv2, cause):
    (tmp_path / 'cv2').mkdir()
    (tmp_path / 'cv2' / '__init__.py').write_text(cv2)
    run('import sys\nsys.path.insert(0, {!r})\n'.format(str(tmp_path)) + BEGIN.replace("sys.modules['cv2'] = None", """
try:
    import cv2
    assert not hasattr(cv2, 'KeyPoint')
except ImportError:
    pass
""") + """
keypoints, descriptors = orb.detectAndComputeArrays(image)
assert np.array_equal(orb.compute(image, keypoints)[1], descriptors)
assert aqorb.error.__bases__ == (ValueError,)
assert str(raised(ImportError, lambda: orb.detect(image))).startswith('cv2 does not work: ' + cause)
for call, kind in ((lambda: orb.compute(image, [5]), TypeError), (lambda: orb.write(5), TypeError),
                   (lambda: orb.setPatchSize(1), ValueError)):
    raised(kind, call)
""".replace('+ cause', f'+ {cause!r}'))


@pytest.mark.parametrize('needs', ["orb.detect(image)", "aqorb.error", "from aqorb import error",
                                   "aqorb.keypointsFromArray(np.zeros(1, aqorb.keypoint_dtype))"])
def test_cv2_is_imported_when_it_is_needed(needs):
    pytest.importorskip('cv2')
    run(BEGIN.replace("sys.modules['cv2'] = None", '') + '''
orb.detectAndComputeArrays(image)
orb.compute(image, orb.detectAndComputeArrays(image)[0])
assert 'cv2' not in sys.modules
{}
assert 'cv2' in sys.modules
import cv2
assert issubclass(aqorb.error, cv2.error) and issubclass(aqorb.error, ValueError)
'''.format(needs))


def test_the_command_is_another_package():
    asked = python('-m', 'aqorb', 'extract')
    assert asked.returncode == 1 and 'pip install . ./photographs' in asked.stdout


def test_version():
    output = run("import sys, runpy; sys.modules['cv2'] = None; sys.argv = ['aqorb', '--version']; "
                 "runpy.run_module('aqorb', run_name='__main__')")
    assert re.search(r'^aqorb {}, OpenCV \d[\w.-]+, kernels for (plain C\+\+|[A-Z0-9-]+), \d+ threads?$'.format(
        re.escape(aqorb.__version__)), output, re.MULTILINE), output
