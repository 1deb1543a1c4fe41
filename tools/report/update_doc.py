#!/usr/bin/python3
# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Puts the tables that aqorb_evaluate wrote into a document.

Between the lines `<!-- table: TITLE -->` and `<!-- end -->` of the document goes the table of that title; with
`<!-- table: TITLE, n = 1000 -->` only its rows of that n.
"""

import argparse
import os
import re


def read_tables(path):
    """{title: lines of the table}"""
    tables, title = {}, None
    with open(path) as file:
        for line in file:
            if line.startswith('## '):
                title = line[3:].strip()
                tables[title] = []
            elif title and line.startswith('|'):
                tables[title].append(line)
    return tables


def table(tables, name):
    title, _, n = name.partition(', n = ')
    lines = tables[title]
    if n:
        lines = lines[:2] + [line for line in lines[2:] if line.split('|')[2].strip() == n]
    return ''.join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('folder', help='where aqorb_evaluate wrote')
    parser.add_argument('document')
    parser.add_argument('--keep', action='store_true', help='leave tables as they are that were not written')
    arguments = parser.parse_args()

    tables = read_tables(os.path.join(arguments.folder, 'tables.md'))
    with open(arguments.document) as file:
        text = file.read()

    def replacement(match):
        if arguments.keep and match[2] not in tables:
            return match[0]
        return match[1] + '\n' + table(tables, match[2]) + '\n' + match[3]

    text = re.sub(r'(<!-- table: (.*?) -->\n).*?(<!-- end -->)', replacement, text, flags=re.S)
    with open(arguments.document, 'w') as file:
        file.write(text)


if __name__ == '__main__':
    main()
