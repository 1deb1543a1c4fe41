#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Writes the module as opencv_contrib would have it into the folder modules of a copy of opencv_contrib, and a row into
the README.md there if there is one. Links become files, the licence's header that of OpenCV, and what only this project
has is left out. Fails if a file then still names something outside of the module, or if an edit below no longer applies."""

import argparse
import re
import shutil
import sys
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

ROW = '- **aqorb**: Uniformly distributed ORB features -- An ORB detector whose keypoints cover the whole image, functions ' \
      'that thin out the keypoints of any detector uniformly or measure how they lie, and a fast matcher of binary ' \
      'descriptors.\n'

# What the standalone build, the Python package and the project's tests of its samples need.
LEFT_OUT = ['*/CMakeLists.txt', 'test/exports.cmake', 'src/exports.*', 'tutorials/aqorb_many_images',
            'samples/collection', 'samples/colmap', 'samples/notebook', 'samples/test']

# For every file: a regular expression, and what takes its place.
EVERYWHERE = [
    (r'\$\(scripts/demo\.sh --images\)', '<opencv>/samples/data'),
    (r'build/release/test/aqorb_test', 'bin/opencv_test_aqorb'),
    (r'build/release/samples/(\w+)', r'bin/example_aqorb_\1'),
    (r'try:\n    import aqorb\nexcept ImportError:.*\n    (from cv2 import aqorb)\n', r'\1\n'),
    (r'(?m)^import aqorb$', 'from cv2 import aqorb'),
    (r'(?m)^\| Compatibility \|', '| Original author | The aqorb developers |\n| Compatibility |'),  # as in other tutorials
]

# For one file: a text, in which white space stands for any, a comment's slashes included, and "[...]" for anything; and
# what takes its place.
EDITS = {
    'README.md': [
        ('\n\nThe `CMakeLists.txt` files in [...]OpenCV\'s build does not read them.', '')],
    'src/parameter_table.hpp': [
        (', and so are the Python package, the preloaded library\'s variables, what the page sets, and tests. Each row is',
         ', and so are tests. Each row is')],
    'src/precomp.hpp': [
        ('as cmake/AqorbTarget.cmake asks other compilers for', 'as CMakeLists.txt asks other compilers for')],
    'perf/perf_features.cpp': [
        ('the machine; tools/report/speed.py takes the ratio of each such pair.', 'the machine.')],
    'test/backends.hpp': [
        ('  // see tools/tsan', '')],
    'test/matches.hpp': [
        ('neither test framework, so that tools/evaluate uses it, too.', 'not the test framework.')],
    'test/start_matches.hpp': [
        (' tools/evaluate uses it, too.', '')],
    'test/test_fuzz_finds.cpp': [
        ('that fuzzing has found; see doc/reliability.md.', 'that fuzzing has found.')],
    'test/test_memory.cpp': [
        ('//! Those for which doc/performance.md sets aims.', '//! Those whose times are compared.')],
    'test/test_soak.cpp': [
        ('AQORB_SOAK_FRAMES makes it as long as doc/reliability.md tells.', 'AQORB_SOAK_FRAMES makes it longer.')],
    'misc/python/test/test_aqorb.py': [
        ('"""Tests of both Python bindings: [...] where there is one."""\n\nimport os', '\nimport os'),
        ('try:\n    from tests_common import NewOpenCVTests\nexcept ImportError: [...]staticmethod(unittest.main)\n',
         'from tests_common import NewOpenCVTests\n\n'),
        ('import unittest\n\n', '\n'),
        ('if os.environ.get(\'AQORB_BINDING\'[...]\nelse:\n    import aqorb\n\n\n', 'aqorb = cv.aqorb\n\n\n')],
    'tutorials/aqorb_slam/aqorb_slam.markdown': [
        ('@prev_tutorial{tutorial_aqorb_many_images}', '@prev_tutorial{tutorial_aqorb_recipes}'),
        (' The project itself does not build these systems; @ref tutorial_aqorb_slam_orbslam2 was measured outside of it.',
         '\nThey do not build these systems; @ref tutorial_aqorb_slam_orbslam2 was measured with them.'),
        ('Add `find_package(aqorb CONFIG REQUIRED)` there, and link `aqorb::aqorb`.',
         'There, `find_package(OpenCV)` finds the module with the others, unless it names components. Then add `aqorb`.'),
        ('tests of matches, and `doc/performance.md` has the times.', 'tests of matches.'),
        ('**The figures of this section were measured outside this project**, and no command of it prints them.',
         '**No program of this module prints the figures of this section.**')],
}

# Names of what only this project has; paths are found by looking whether there is such a file.
FOREIGN = re.compile(r'aqorb_test --|aqorb_(?:claims|evaluate|fingerprint)|(?<!cv2 )import aqorb|aqorb\[|[Pp]reload|'
                     r'Python package|package `aqorb`|detectAndComputeArrays|CHANGELOG|[Ss]tandalone|AQORB_BINDING|build/|'
                     r'this project|part of aqorb|SPDX')
PATH = re.compile(r'(?<![\w/.<>-])[\w.-]+(?:/[\w.-]+)+')


def pattern(text):
    """What a text of EDITS stands for, as a regular expression."""
    parts = [r'(?:\s|//(?=\s))+'.join(re.escape(word) for word in re.split(r'\s+', part)) for part in text.split('[...]')]
    return re.compile('.*?'.join(parts), re.DOTALL)


def with_header_of_opencv(text):
    return re.sub(r'This file is part of aqorb\. .*\n(.*)\n(.*) of this distribution\.\n.*SPDX-License-Identifier: .*\n',
                  r'This file is part of OpenCV project.\n\1\n\2 of this distribution and at http://opencv.org/license.html.\n',
                  text, count=1)


def cmake_lists(text):
    """The part of CMakeLists.txt that OpenCV's build reads."""
    head, inside = re.match(r'(.*?)^if\(DEFINED OPENCV_INITIAL_PASS\)\n(.*?)^  return\(\)\nendif\(\)\n', text,
                            re.DOTALL | re.MULTILINE).groups()
    for pattern_, new in ((r'\A(?:#.*\n)+', ''), (r' OR OpenCV_VERSION_MAJOR GREATER_EQUAL 5', ''),
                          (r'\n *set\(aqorb_standard \d+\)', ''), (r', and is for a newer C\+\+', ''),
                          (r'has renamed features2d, has split', 'has renamed features2d and split')):
        head, count = re.subn(pattern_, new, head)
        if not count:
            sys.exit(f'CMakeLists.txt has nothing like {pattern_}')
    inside, count = re.subn(r"  # In the project's repository these folders are links.*?\n  endforeach\(\)\n\n", '', inside,
                            count=1, flags=re.DOTALL)
    if not count:
        sys.exit('CMakeLists.txt has no check of the links')
    return head + textwrap.dedent(inside)


def is_outside(name, folder, module):
    """Whether a name in a file of a folder is that of a file of this project that the module does not have."""
    name = name.rstrip('.')
    if '..' in name.split('/'):
        return not (folder / name).resolve().is_relative_to(module)
    return (ROOT / name).exists() and not (module / name).exists()


def export(modules):
    module = modules / 'aqorb'
    source = ROOT / 'modules' / 'aqorb'
    shutil.rmtree(module, ignore_errors=True)
    shutil.copytree(source, module, ignore=shutil.ignore_patterns('__pycache__', '.pytest_cache'))  # follows the links
    for name in LEFT_OUT:
        found = list(module.glob(name))
        if not found:
            sys.exit(f'{name}: is left out, but there is none')
        for path in found:
            shutil.rmtree(path) if path.is_dir() else path.unlink()

    errors = []
    for path in sorted(path for path in module.rglob('*') if path.is_file()):
        name = path.relative_to(module).as_posix()
        try:
            text = path.read_text(encoding='utf-8')
        except UnicodeDecodeError:
            continue  # a picture
        if name == 'CMakeLists.txt':
            text = cmake_lists(text)
        text = with_header_of_opencv(text)
        for old, new in EDITS.get(name, []):
            text, count = pattern(old).subn(lambda _, new=new: new, text)
            if count != 1:
                errors.append(f'{name}: an edit applies to {count} places instead of one: {old}')
        for old, new in EVERYWHERE:
            text = re.sub(old, new, text)
        path.write_text(text, encoding='utf-8')
        for number, line in enumerate(text.splitlines(), 1):
            outside = [word for word in PATH.findall(line) if is_outside(word, path.parent, module)]
            for word in outside + FOREIGN.findall(line):
                errors.append(f'{name}:{number}: names {word}, which is not in the module: {line.strip()}')
    errors += [f'{name}: there is no such file to edit' for name in EDITS if not (module / name).exists()]
    if errors:
        sys.exit('\n'.join(errors) + f'\n{Path(__file__).name} has the texts that differ in opencv_contrib.')


def add_row(readme):
    """Adds the module's row to the list of modules, in the order of their names."""
    rows = readme.read_text(encoding='utf-8').splitlines(keepends=True)
    rows = [row for row in rows if not row.startswith('- **aqorb**')]
    index = next(i for i, row in enumerate(rows) if row.startswith('- **') and row[4:].split('*')[0] > 'aqorb')
    readme.write_text(''.join(rows[:index] + [ROW, '\n'] + rows[index:]), encoding='utf-8')


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('modules', type=Path, help='the folder modules of a copy of opencv_contrib')
    modules = parser.parse_args().modules.resolve()
    export(modules)
    if (modules / 'README.md').exists():
        add_row(modules / 'README.md')
    files = [path for path in (modules / 'aqorb').rglob('*') if path.is_file()]
    print(f'{len(files)} files, none of which names anything outside of the module')


if __name__ == '__main__':
    main()
