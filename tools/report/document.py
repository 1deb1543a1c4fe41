# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What all tables of the documents have in common: their numbers as text, their Markdown and their place.

A table is a pandas.DataFrame of texts, and tables are a dictionary from titles to tables. A plain text may stand in
place of a table. A document shows the table TITLE between the lines `<!-- table: TITLE -->` and `<!-- end -->`;
`<!-- table: TITLE, n = 1000 -->` shows only those of its rows that have 1000 in the column n.
"""

import math
import re

MARKER = '<!-- table: '
PLACE = re.compile(re.escape(MARKER) + r'(.*?) -->\n(.*?)<!-- end -->', re.S)


def number(value, digits=2, unit=''):
    """The text of a number with so many decimals; empty where there is no number."""
    if value is None or math.isnan(value):
        return ''
    text = '{:.{}f}'.format(value, digits)
    if float(text) == 0:
        text = text.lstrip('-')
    return text + unit


def build_names(detectors):
    """{detector: how a table names it} of AdaptiveQuadtreeORB here (no name) and of another build, 'BESIDE FILE'."""
    names = {}
    for detector in sorted(set(detectors) - {'CV_ORB'}):
        version = re.fullmatch(r'BESIDE libaqorb\.so\.([0-9.]+)', detector)
        names[detector] = 'version ' + version[1] if version else detector.partition(' ')[2]
    return names


def markdown(table):
    """The Markdown of a table. Its first column is set as text, the others as numbers."""
    if isinstance(table, str):
        return table.strip('\n') + '\n'
    lines = ['| {} |'.format(' | '.join(table.columns)), '|---|' + '---:|' * (len(table.columns) - 1)]
    lines += ['| {} |'.format(' | '.join(row)) for row in table.itertuples(index=False, name=None)]
    return '\n'.join(lines) + '\n'


def terminal(tables):
    """The tables for reading in a terminal, each below its title."""
    blocks = []
    for title, table in tables.items():
        text = table
        if not isinstance(table, str):
            rows = [list(table.columns)] + table.values.tolist()
            widths = [max(map(len, column)) for column in zip(*rows)]
            text = '\n'.join('  '.join([row[0].ljust(widths[0])] + list(map(str.rjust, row[1:], widths[1:]))).rstrip()
                             for row in rows)
        blocks.append('{}\n{}\n{}\n'.format(title, '-' * len(title), text.strip('\n')))
    return '\n'.join(blocks)


def shown(text):
    """The titles of the tables that a document shows, in its order, without the choice of rows."""
    return [name.partition(', n = ')[0] for name, _ in PLACE.findall(text)]


def replace(text, tables):
    """The text of a document with new tables in the places of their titles. Other tables stay as they are."""
    if text.count(MARKER) != text.count('<!-- end -->') or any(MARKER in old for _, old in PLACE.findall(text)):
        raise ValueError('a line "{}TITLE -->" has no "<!-- end -->", or the reverse'.format(MARKER))

    def new(match):
        title, _, n = match[1].partition(', n = ')
        if title not in tables:
            return match[0]
        table = tables[title]
        if n:
            table = table[table['n'] == n]
            if table.empty:
                raise ValueError('the table "{}" has no row with n = {}'.format(title, n))
        return '{}{} -->\n\n{}\n<!-- end -->'.format(MARKER, match[1], markdown(table))

    return PLACE.sub(new, text)


def update(path, tables):
    """Puts tables into a document and returns the titles of those that it shows."""
    with open(path, encoding='utf-8') as file:
        old = file.read()
    new = replace(old, tables)
    if new != old:
        with open(path, 'w', encoding='utf-8') as file:
            file.write(new)
    return [title for title in tables if title in shown(old)]
