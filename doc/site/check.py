#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0

"""Reads the repository's Markdown files as cmark-gfm shows them: every link inside of the repository leads somewhere,
and no directive of doxygen is left in the text, but for a tutorial's label and its neighbours and what it cites.

check.py DOCUMENT ...
"""

import html
import os
import re
import subprocess
import sys

from markdown import slug

DIRECTIVE = re.compile(r'(?<!\w)@(?!prev_tutorial|next_tutorial|cite)[a-z]+\b.*|\{#.*')


def read(path):
    return subprocess.run(['cmark-gfm', '-e', 'table', path], capture_output=True, check=True, text=True).stdout


def anchors(path):
    headings = re.findall(r'<h\d>(.*?)</h\d>', read(path), re.DOTALL)
    return {slug(html.unescape(re.sub('<.*?>', '', heading))) for heading in headings}


count, problems = 0, []
for document in sys.argv[1:]:
    text = read(document)
    for target in re.findall(r'<(?:a href|img src)="([^"]*)"', text):
        file, _, anchor = html.unescape(target).partition('#')
        full = os.path.join(os.path.dirname(document), file) if file else document
        if re.match(r'\w+:', target):
            continue
        count += 1
        if not os.path.exists(full) or (anchor and anchor not in anchors(full)):
            problems.append(f'{document}: the link to {target} leads nowhere')
    title, _, rest = re.sub(r'<pre>.*?</pre>|<code>.*?</code>|<!--.*?-->', '', text, flags=re.DOTALL).partition('</h1>')
    problems += [f'{document}: shows {found}' for found in DIRECTIVE.findall(rest)]
print(f'{len(sys.argv) - 1} documents with {count} links inside of the repository')
sys.exit('\n'.join(problems) or None)
