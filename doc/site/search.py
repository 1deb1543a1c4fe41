#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0

"""Adds the words of headings, properties and parameters to the index of a site's search, in which doxygen puts only the
beginnings of names and titles.

search.py SITE
"""

import html
import re
import sys
from pathlib import Path

HEADING = re.compile(r'<h[1-4]><a class="anchor" id="([^"]+)"></a>\s*(.*?)</h[1-4]>', re.DOTALL)
MEMBER = re.compile(r'<a id="(\w+)" name="\w+"></a>\s*<h2 class="memtitle">.*?</a></span>(.*?)</h2>'
                    r'(.*?)<div class="memdoc">', re.DOTALL)


def plain(markup):
    return ' '.join(html.unescape(re.sub('<[^>]*>', '', markup)).split())


def entries(path):
    """Labels, anchors, and what is shown beside the labels."""
    text = path.read_text(encoding='utf-8')
    title = plain(re.search(r'<div class="title">(.*?)</div>', text, re.DOTALL)[1]) if 'class="title"' in text else ''
    yield from ((plain(heading), anchor, title) for anchor, heading in HEADING.findall(text))
    for anchor, member, declaration in MEMBER.findall(text):
        yield plain(member), anchor, title
        for parameter in re.findall(r'<td class="paramname">(?:<em>)?(\w+)', declaration):
            yield parameter, anchor, plain(member)


site = Path(sys.argv[1])
added = {}
for path in sorted(site.glob('*.html')):
    for label, anchor, place in entries(path):
        # Words, and parts of names.
        for word in re.findall(r'\w{3,}', label) + re.findall(r'[A-Z]?[a-z]{2,}|[A-Z]{3,}', label):
            shown = html.escape(label).replace("'", '&#39;'), f'../{path.name}#{anchor}', html.escape(place)
            added.setdefault(word.lower(), {})[shown] = None
# Doxygen's script finds the file of a word by the place of its first letter in this list.
index = site / 'search/searchdata.js'
listed = index.read_text(encoding='utf-8')
letters = re.search(r'0: "([^"]*)"', listed)[1]
new = ''.join(sorted({word[0] for word in added} - set(letters)))
index.write_text(listed.replace(f'0: "{letters}"', f'0: "{letters}{new}"', 1), encoding='utf-8')
for number, letter in enumerate(letters + new):
    path = site / f'search/all_{number:x}.js'
    if letter in new:
        path.write_text('var searchData=\n[\n];\n', encoding='utf-8')
        for template in site.glob('search/all_0.html'):  # of doxygen before 1.9.5
            frame = template.read_text(encoding='utf-8').replace('all_0.js', path.name)
            path.with_suffix('.html').write_text(frame, encoding='utf-8')
    lines = [f"  ['{word}_{i}a',['{label}',['{address}',1,'{place}']]],\n"
             for word in sorted(added) if word[0] == letter
             for i, (label, address, place) in enumerate(added[word])]
    path.write_text(path.read_text(encoding='utf-8').replace('[\n', '[\n' + ''.join(lines), 1), encoding='utf-8')
for word in ('nfeatures', 'strength', 'rank', 'thread', 'mask', 'scale'):
    if not any(key.startswith(word) for key in added):
        sys.exit(f'search.py: the search finds nothing for {word}')
print(f'{len(added)} words in the search')
