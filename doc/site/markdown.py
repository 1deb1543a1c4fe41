#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0

"""Prints a Markdown file of the repository as doxygen reads it, for its FILTER_PATTERNS.

The documents are written for readers of the repository. On the site each of them is a page with a name, links between
documents become references to these pages, a link to a sample leads to a copy of it, and a link to any other file
becomes the file's name.
"""

import os
import re
import sys

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
FENCE = re.compile(r'^( *)```(\w*)\n(.*?)^ *```$', re.MULTILINE | re.DOTALL)
LINK = re.compile(r'(!?)\[((?:[^\]`]|`[^`]*`)*)\]\(([^)\s]+)\)')
PLACES = {'modules/aqorb/include/opencv2/aqorb.hpp': 'aqorb'}  # headers that have a page
LANGUAGES = {'python': 'py', 'sh': 'unparsed', 'cmake': 'unparsed', '': 'unparsed'}


def slug(heading):
    """The anchor that hosts of repositories give to a heading."""
    heading = re.sub(r'\[([^\]]*)\]\([^)]*\)', r'\1', heading).strip().lower()
    return re.sub(r'[^\w\- ]', '', heading).replace(' ', '-')


def page(path):
    """The name of a document's page on the site, by the document's path in the repository; None if it has none."""
    if path in PLACES:
        return PLACES[path]
    full = os.path.join(ROOT, path)
    if path.endswith('.markdown') and os.path.isfile(full):
        with open(full, encoding='utf-8') as file:
            return re.search(r'{#(\w+)}', file.readline()).group(1)
    if path == 'README.md':
        return 'mainpage'
    if re.fullmatch(r'(doc/)?\w+\.md', path) and os.path.isfile(full):
        return os.path.basename(path)[:-len('.md')].lower()
    if path == 'bindings/preload/README.md':
        return 'preload'
    return None


def title(path):
    """A document's first heading."""
    with open(os.path.join(ROOT, path), encoding='utf-8') as file:
        return re.sub(r'^# |\s*{#\w+}', '', file.readline()).strip()


def link(match, path):
    image, text, target = match.groups()
    if re.match(r'\w+:|@ref', target):
        return match.group(0)
    if image:
        return f'![{text}]({os.path.basename(target)})'  # doxygen looks for it in IMAGE_PATH
    target, _, anchor = target.partition('#')
    target = os.path.normpath(os.path.join(os.path.dirname(path), target)) if target else path
    name = page(target)
    if name:
        if text in (target, os.path.basename(target)):
            text = title(target)
        text = text.replace('`', '')  # which doxygen would show
        return f'[{text}](@ref {f"{name}-{anchor}" if anchor else name})'
    if target.startswith('samples/') and os.path.isfile(os.path.join(ROOT, target)):
        return f'<a href="{target}.txt">{text}</a>'  # doc.sh copies them
    if text.strip('`') in (target, os.path.basename(target)):
        return f'`{target}`'
    return f'{text} (`{target}`)'


def prose(text, path, seen):
    name = page(path)

    def labelled(match):
        # A heading that is repeated gets a number, as hosts of repositories do it.
        anchor = slug(match[2])
        seen[anchor] = seen.get(anchor, -1) + 1
        number = f'-{seen[anchor]}' if seen[anchor] else ''
        return f'{match[1]} {match[2]} {{#{name}-{anchor}{number}}}'
    if path.endswith('.md'):
        text = re.sub(r'^(##+) (.*)$', labelled, text, flags=re.MULTILINE)
    text = LINK.sub(lambda m: link(m, path), text)

    def document(match):
        other = page(match.group(1))
        return f'[{title(match.group(1))}](@ref {other})' if other else match.group(0)
    if path.endswith('.markdown'):  # which cannot link to what is not in the module
        text = re.sub(r'`(doc/\w+\.md)`', document, text)
    text = re.sub(r'\*\*(`[^`]+`)\*\*', r'<b>\1</b>', text)
    # An apostrophe would end the code for doxygen, which takes two more marks as a sign that it does not.
    return re.sub(r'`+[^`]+`+', lambda code: f'`{code[0]}`' if "'" in code[0] else code[0], text)


def convert(text, path):
    if path.endswith('.md'):
        contents = '' if path == 'README.md' else '\n@tableofcontents\n'
        text = re.sub(r'\A# (.*)\n', lambda m: f'# {m[1]} {{#{page(path)}}}\n{contents}', text)
    result, end, seen = [], 0, {}
    for fence in FENCE.finditer(text):
        result.append(prose(text[end:fence.start()], path, seen))
        indent, language, code = fence.groups()
        result.append(f'{indent}@code{{.{LANGUAGES.get(language, language)}}}\n{code}{indent}@endcode')
        end = fence.end()
    return ''.join(result) + prose(text[end:], path, seen)


if __name__ == '__main__':
    with open(sys.argv[1], encoding='utf-8') as document:
        source = document.read()
    print(convert(source, os.path.relpath(sys.argv[1], ROOT)), end='')
