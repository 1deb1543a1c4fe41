#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0

"""Puts the signatures of the Python package, as its stub __init__.pyi has them, into the site.

signatures.py page TAGS PAGE    writes the page on Python from python.markdown; TAGS is OpenCV's tag file
signatures.py insert FOLDER     puts Python's signature beside C++'s on the pages of FOLDER
"""

import ast
import glob
import html
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, '..', '..')
STUB = os.path.join(ROOT, 'bindings/python/stub.cmake')
HEADERS = [os.path.join(ROOT, 'modules/aqorb/include/opencv2', name) for name in ('aqorb.hpp', 'aqorb/matching.hpp')]
# The classes, and those of OpenCV that they are derived from.
CLASSES = {'AdaptiveQuadtreeORB': ('cv::ORB', 'cv::Feature2D', 'cv::Algorithm'),
           'HammingMatcher': ('cv::BFMatcher', 'cv::DescriptorMatcher', 'cv::Algorithm')}


def read(path):
    with open(path, encoding='utf-8') as file:
        return file.read()


def plain(node):
    """A type as it is shown: without the names of modules that add nothing, and without the mark of private names."""
    text = ast.unparse(node)
    return re.sub(r'\b(numpy\.|cv2\.(?=KeyPoint|DMatch|File))|\b_(?=[A-Z])', '', text)


def declarations():
    """The functions of the public headers that are wrapped: {name: {parameter: default in Python's notation}}."""
    text = re.sub(r'/\*.*?\*/|//[^\n]*', '', '\n'.join(map(read, HEADERS)), flags=re.DOTALL)
    found = {}
    declaration = r'CV_(?:WRAP|EXPORTS_W)\b[^;{(]*?(\w+)\((.*?)\)\s*(?:const\b[^;]*|=\s*0|CV_OVERRIDE)?;'
    for match in re.finditer(declaration, text, re.DOTALL):
        defaults = {}
        for parameter, value in re.findall(r'(\w+) = ([\w:.]+(?:\([^)]*\))?)', match.group(2)):
            value = {'noArray()': 'None', 'true': 'True', 'false': 'False'}.get(value, value)
            value = re.sub(r'^Size\((.*)\)$', r'(\1)', value)
            value = re.sub(r'^(\d[\d.]*)f$', r'\1', value)
            value = re.sub(r'^NORM_', 'cv2.NORM_', value)
            defaults[parameter] = 'cv2.' + value.replace('::', '_') if '::' in value else value
        found.setdefault(match.group(1), {}).update(defaults)
    return found


def signature(function, defaults, method):
    """Call and result of a function of the stub."""
    arguments = function.args
    names = arguments.args
    given = [None] * (len(names) - len(arguments.defaults)) + arguments.defaults
    shown = []
    for argument, default in list(zip(names, given))[1 if method else 0:]:
        text = f'{argument.arg}: {plain(argument.annotation)}'
        if default is not None:
            default = ast.unparse(default)
            if default == '...':
                optional = re.search(r'\b(Optional|None|Mask)\b', ast.unparse(argument.annotation).replace('_', ''))
                default = 'None' if optional else defaults.get(argument.arg, '...')
            text += f' = {default}'
        shown.append(text)
    return f'{function.name}({", ".join(shown)})', plain(function.returns)


def stub():
    """What the stub declares: the methods of each class and the functions as {name: [(call, result)]}, and types as
    {name: definition}."""
    cpp = declarations()
    methods, functions, types = {name: {} for name in CLASSES}, {}, {}
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, '__init__.pyi')
        subprocess.run(['cmake', '-DAQORB_STUB=' + path, '-P', STUB], check=True)
        text = read(path)
    for node in ast.parse(text).body:
        if isinstance(node, ast.ClassDef) and node.name in CLASSES:
            for method in (member for member in node.body if isinstance(member, ast.FunctionDef)):
                static = any(ast.unparse(d) == 'staticmethod' for d in method.decorator_list)
                name = node.name if method.name == '__init__' else method.name
                method.name = name
                methods[node.name].setdefault(name, []).append(signature(method, cpp.get(name, {}), not static))
        elif isinstance(node, ast.FunctionDef):
            defaults = cpp.get('create' if node.name.endswith('_create') else node.name, {})
            functions.setdefault(node.name, []).append(signature(node, defaults, False))
        elif isinstance(node, ast.Assign) and node.targets[0].id.startswith('_') and node.targets[0].id[1].isupper():
            types[node.targets[0].id[1:]] = plain(node.value)
    return methods, functions, types


def write_page(tags, path):
    methods, functions, types = stub()
    own = declarations()
    members = {}
    for compound in xml.etree.ElementTree.parse(tags).iterfind('compound[@kind="class"]'):
        members[compound.findtext('name')] = {member.findtext('name') for member in compound.iterfind('member')}

    def counterpart(name, owner):
        if name.endswith('_create'):
            name, owner = 'create', name[:-len('_create')]
        scope = f'{owner}::' if owner else ''
        if name in own and not (owner == 'HammingMatcher' and name.endswith('Arrays')):
            return f'@ref cv::aqorb::{scope}{name} "{scope}{name}"'
        base = next((base for base in CLASSES.get(owner, ()) if name in members.get(base, ())), None)
        return f'@ref {base}::{name} "{base[len("cv::"):]}::{name}"' if base else "Python's own"

    def table(declared, owner):
        rows = ['| call | result | in C++ |', '|---|---|---|']
        for name, overloads in declared.items():
            for call, result in overloads:
                # The mark keeps doxygen from taking the name for that of a function of OpenCV.
                rows.append(f'| <code>%{call}</code> | `{result}` | {counterpart(name, owner)} |')
        return '\n'.join(rows)

    rows = ['| name | type |', '|---|---|'] + [f'| `{name}` | `{value}` |' for name, value in types.items()]
    text = read(os.path.join(HERE, 'python.markdown'))
    for owner in CLASSES:
        text = text.replace(f'<!-- methods of {owner} -->', table(methods[owner], owner))
    text = text.replace('<!-- functions -->', table(functions, ''))
    text = text.replace('<!-- types -->', '\n'.join(rows))
    with open(path, 'w', encoding='utf-8') as file:
        file.write(text)


def insert(folder):
    methods, functions, _ = stub()
    wanted = {f'cv::aqorb::{name}': [f'aqorb.{call} -> {result}' for call, result in overloads]
              for name, overloads in functions.items() if name in declarations()}
    for owner in CLASSES:
        for name, overloads in methods[owner].items():
            if name in declarations() and not (owner == 'HammingMatcher' and name in functions):
                wanted[f'cv::aqorb::{owner}::{name}'] = [f'aqorb.{owner}.{call} -> {result}'
                                                         for call, result in overloads]
        wanted[f'cv::aqorb::{owner}::create'] += [f'aqorb.{call} -> {result}'
                                                  for call, result in functions[f'{owner}_create']]
    missing = set(wanted)

    def add(match):
        name = re.sub(r'<[^>]*>', '', match.group(1)).split()[-1]
        if name not in wanted:
            return match.group(0)
        missing.discard(name)
        lines = '\n'.join(html.escape(line) for line in wanted[name])
        return f'{match.group(0)}\n<div class="python"><a href="python.html">Python</a>\n<pre>{lines}</pre></div>'

    member = re.compile(r'<div class="memproto">.*?<td class="memname">(.*?)</td>.*?<div class="memdoc">', re.DOTALL)
    for path in glob.glob(os.path.join(folder, '*.html')):
        text = read(path)
        changed = member.sub(add, text)
        if changed != text:
            with open(path, 'w', encoding='utf-8') as file:
                file.write(changed)
    if missing:
        sys.exit(f'No place in the site for the Python signatures of: {", ".join(sorted(missing))}')


if __name__ == '__main__':
    if sys.argv[1:2] == ['page'] and len(sys.argv) == 4:
        write_page(*sys.argv[2:])
    elif sys.argv[1:2] == ['insert'] and len(sys.argv) == 3:
        insert(sys.argv[2])
    else:
        sys.exit(__doc__)
