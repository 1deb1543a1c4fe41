#!/usr/bin/env python3
# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0

"""Makes the site's search find words of headings, properties and parameters. Doxygen's own index has the beginnings of
names and of titles alone, and OpenCV's names.

search.py SITE
"""

import glob
import html
import json
import os
import re
import sys

COMMON = set('''
a about after all an and are as at be beside between by can do does each for from get has have how i if in into is
it its me more most my of on one or other same should so some than that the their them then there they this to up
use used was what when where which who why will with without you your
'''.split())


def read(path):
    with open(path, encoding='utf-8') as file:
        return file.read()


def plain(markup):
    return ' '.join(html.unescape(re.sub('<[^>]*>', '', markup)).split())


def words(text):
    """The words of a heading or a name, each also by the parts of a name in camel case."""
    for word in re.findall(r'\w+', text):
        parts = re.findall(r'[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+', word)
        for part in {word, *parts}:
            if len(part) > 2 and part.lower() not in COMMON:
                yield part.lower()


def own_entries(site):
    """What doxygen lists, without the names of OpenCV: (key, label, address, place)."""
    for path in sorted(glob.glob(os.path.join(site, 'search', 'all_*.js'))):
        for key, label, targets in re.findall(r"^  \['(\w+)',\['(.*?)',(\[.*\])\]\],?$", read(path), re.MULTILINE):
            for address, place in re.findall(r"\['([^']*)',\d+,'((?:[^'\\]|\\.)*)'\]", targets):
                if address.startswith('../') and not address.startswith('../http'):
                    yield re.sub(r'_\d+$', '', key), label, address, place


def headings(site):
    """The titles and headings of the pages: (words, label, address, place)."""
    for path in sorted(glob.glob(os.path.join(site, '*.html'))):
        name, text = os.path.basename(path), read(path)
        title = re.search(r'<div class="title">(.*?)</div>', text, re.DOTALL)
        if not title:
            continue
        title = plain(title[1])
        yield set(words(title)), title, '../' + name, ''
        for anchor, heading in re.findall(r'<h[1-4]><a class="anchor" id="([^"]+)"></a>\s*(.*?)</h[1-4]>', text,
                                          re.DOTALL):
            heading = plain(heading)
            yield set(words(heading)), heading, f'../{name}#{anchor}', title


def members(site):
    """Properties, functions and their parameters, by their parts: (words, label, address, place)."""
    for path in sorted(glob.glob(os.path.join(site, '*.html'))):
        name, text = os.path.basename(path), read(path)
        for chunk in re.split(r'(?=<a id="\w+" name="\w+"></a>\s*<h2 class="memtitle">)', text)[1:]:
            anchor = re.match(r'<a id="(\w+)"', chunk)[1]
            member = plain(re.search(r'<h2 class="memtitle">.*?</span>(.*?)(?:<span|</h2>)', chunk, re.DOTALL)[1])
            yield set(words(member)), member, f'../{name}#{anchor}', ''
            for parameter in dict.fromkeys(re.findall(r'<td class="paramname">(\w+)', chunk)):
                yield set(words(parameter)), parameter, f'../{name}#{anchor}', member


def write(site, entries):
    """entries: {key: [(label, address, place)]}. One file for each first letter, as doxygen's script reads them."""
    folder = os.path.join(site, 'search')
    template = read(os.path.join(folder, 'all_0.html'))
    for path in glob.glob(os.path.join(folder, 'all_*')):
        os.remove(path)
    letters = ''.join(sorted({key[0] for key in entries}))
    for i, letter in enumerate(letters):
        lines, number = [], 0
        for key in sorted(key for key in entries if key[0] == letter):
            for label, address, place in entries[key]:
                lines.append(json.dumps([f'{key}_{number}', [html.escape(label), [address, 1, html.escape(place)]]]))
                number += 1
        with open(os.path.join(folder, f'all_{i:x}.js'), 'w', encoding='utf-8') as file:
            file.write('var searchData=\n[\n  ' + ',\n  '.join(lines) + '\n];\n')
        with open(os.path.join(folder, f'all_{i:x}.html'), 'w', encoding='utf-8') as file:
            file.write(template.replace('all_0.js', f'all_{i:x}.js'))
    path = os.path.join(folder, 'searchdata.js')
    index = re.sub(r'(  0: )"[^"]*"', lambda match: match[1] + json.dumps(letters), read(path), count=1)
    with open(path, 'w', encoding='utf-8') as file:
        file.write(index)


def main(site):
    entries = {}

    def add(key, label, address, place):
        found = entries.setdefault(key, [])
        if all(address != other[1] for other in found):
            found.append((label, address, place))

    for key, label, address, place in own_entries(site):
        add(key, html.unescape(label), address, html.unescape(place))
    for source in (members, headings):
        for keys, label, address, place in source(site):
            for key in keys:
                add(key, label, address, place)
    write(site, entries)
    for word in ('nfeatures', 'stitcher', 'thread', 'strength', 'sample', 'mask'):
        if not any(key.startswith(word) for key in entries):
            sys.exit(f'search.py: the search finds nothing for {word}')
    print(f'{len(entries)} words in the search')


if __name__ == '__main__':
    main(sys.argv[1])
