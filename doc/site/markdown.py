#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0

"""Prints a Markdown file of the repository as doxygen reads it, for its FILTER_PATTERNS.

On the site each document is a page with a name, and its headings have the anchors that hosts of repositories give them.
Links between documents become references, of which doxygen says so if they lead nowhere. A link to a sample leads to
the copy that doc.sh makes, and a link to any other file becomes the file's name.
"""

import os
import re
import sys

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
FENCE = re.compile(r'(^ *```.*?^ *```$)', re.MULTILINE | re.DOTALL)
LINK = re.compile(r'(!?)\[((?:[^\]`]|`[^`]*`)*)\]\(([^)\s]+)\)')
PAGES = {'README.md': 'mainpage', 'python/README.md': 'python', 'preload/README.md': 'preload',
         'photographs/README.md': 'photographs', 'modules/aqorb/include/opencv2/aqorb.hpp': 'aqorb'}


def slug(heading):
    """The anchor that hosts of repositories give to a heading."""
    return re.sub(r'[^\w\- ]', '', re.sub(r'\]\([^)]*\)', '', heading).strip().lower()).replace(' ', '-')


def page(path):
    """The name of a document's page, by the document's path in the repository; None if it has none."""
    if path.endswith('.markdown'):
        with open(os.path.join(ROOT, path), encoding='utf-8') as file:
            return re.search(r'{#(\w+)}', file.readline())[1]
    name = os.path.basename(path)[:-len('.md')].lower()
    return PAGES.get(path, name if re.fullmatch(r'(doc/|photographs/)?\w+\.md', path) else None)


def link(match, path):
    image, text, target = match.groups()
    if re.match(r'\w+:|@ref', target):
        return match[0]
    if image:
        return f'![{text}]({os.path.basename(target)})'  # doxygen looks for it in IMAGE_PATH
    target, _, anchor = target.partition('#')
    target = os.path.normpath(os.path.join(os.path.dirname(path), target)) if target else path
    name = page(target)
    if name:
        return f'[{text.replace("`", "")}](@ref {name}{anchor and "-" + anchor})'
    if target.startswith(('samples/', 'photographs/samples/')) and os.path.isfile(os.path.join(ROOT, target)):
        return f'<a href="{target}.txt">{text}</a>'
    return f'`{target}`' if text.strip('`') in (target, os.path.basename(target)) else f'{text} (`{target}`)'


def prose(text, path):
    if path.endswith('.md'):
        text = re.sub(r'^(##+) (.*)$', lambda m: f'{m[1]} {m[2]} {{#{page(path)}-{slug(m[2])}}}', text,
                      flags=re.MULTILINE)
    text = LINK.sub(lambda match: link(match, path), text)
    text = re.sub(r'<!--!(.*?)-->', r'\1', text, flags=re.DOTALL)  # commands that only newer versions of doxygen read
    # An apostrophe would end the code for doxygen, which takes two more marks as a sign that it does not.
    return re.sub(r'`+[^`]+`+', lambda code: f'`{code[0]}`' if "'" in code[0] else code[0], text)


if __name__ == '__main__':
    document = os.path.relpath(sys.argv[1], ROOT)
    with open(sys.argv[1], encoding='utf-8') as file:
        source = file.read()
    if document.endswith('.md'):
        contents = '' if document == 'README.md' else '\n@tableofcontents\n'
        source = re.sub(r'\A# (.*)\n', lambda title: f'# {title[1]} {{#{page(document)}}}\n{contents}', source)
    print(''.join(part if FENCE.match(part) else prose(part, document) for part in FENCE.split(source)), end='')
