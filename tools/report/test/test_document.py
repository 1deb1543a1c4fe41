# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
import os
import subprocess
import sys

import document
import pandas
import pytest

TABLE = pandas.DataFrame([['a', '500', '1.00'], ['a', '1000', '2.00']], columns=['image', 'n', 'value'])
DOCUMENT = '''# Title

<!-- table: One -->

old

<!-- end -->

Words between.

<!-- table: Two, n = 1000 -->
<!-- end -->
'''


@pytest.mark.parametrize('value, digits, text', [
    (4.765, 2, '4.76'),  # the binary number next to 4.765 is below it
    (4.7651, 2, '4.77'), (0.999, 1, '1.0'), (10.8723, 0, '11'), (-0.4, 0, '0'), (-0.6, 0, '-1'), (12, 2, '12.00')])
def test_number_rounds_to_the_nearest(value, digits, text):
    assert document.number(value, digits) == text


def test_number_is_empty_where_nothing_was_measured():
    assert document.number(None) == ''
    assert document.number(float('nan'), 1, ' %') == ''
    assert document.number(33.6, 0, ' %') == '34 %'


def test_markdown_aligns_numbers_to_the_right():
    assert document.markdown(TABLE) == ('| image | n | value |\n|---|---:|---:|\n'
                                        '| a | 500 | 1.00 |\n| a | 1000 | 2.00 |\n')


def test_markdown_of_a_text_is_the_text():
    assert document.markdown('A sentence.\nAnother.') == 'A sentence.\nAnother.\n'


def test_terminal_aligns_columns():
    assert document.terminal({'T': TABLE}) == 'T\n-\nimage     n  value\na       500   1.00\na      1000   2.00\n'


def test_replace_puts_tables_between_their_markers_only():
    new = document.replace(DOCUMENT, {'One': TABLE, 'Two': TABLE})
    assert new == DOCUMENT.replace('\nold\n', '\n' + document.markdown(TABLE)).replace(
        '1000 -->\n', '1000 -->\n\n| image | n | value |\n|---|---:|---:|\n| a | 1000 | 2.00 |\n\n')
    assert document.replace(new, {'One': TABLE, 'Two': TABLE}) == new


def test_replace_keeps_tables_that_were_not_made():
    assert document.replace(DOCUMENT, {'Three': TABLE}) == DOCUMENT
    new = document.replace(DOCUMENT, {'Two': TABLE})
    assert 'old' in new and '2.00' in new and '500' not in new


def test_replace_takes_backslashes_as_they_are():
    assert r'\1 \g<0>' in document.replace(DOCUMENT, {'One': r'\1 \g<0>'})


def test_replace_refuses_a_choice_of_rows_that_is_empty():
    with pytest.raises(ValueError, match='"Two" has no row with n = 1000'):
        document.replace(DOCUMENT, {'Two': TABLE[TABLE['n'] == '500']})


@pytest.mark.parametrize('end', [0, 1])
def test_replace_refuses_a_marker_without_its_end(end):
    parts = DOCUMENT.split('<!-- end -->')
    broken = parts[0] + ('' if end == 0 else '<!-- end -->') + parts[1] + ('<!-- end -->' if end == 0 else '')
    with pytest.raises(ValueError, match='<!-- end -->'):
        document.replace(broken, {'One': TABLE})


def test_update_says_which_tables_the_document_shows(tmp_path):
    path = tmp_path / 'document.md'
    path.write_text(DOCUMENT)
    assert document.update(path, {'Two': TABLE, 'Three': TABLE}) == ['Two']
    assert path.read_text() == document.replace(DOCUMENT, {'Two': TABLE})


def test_command_prints_tables_or_puts_them_into_documents(tmp_path):
    report = os.path.join(os.path.dirname(document.__file__), 'report.py')
    (tmp_path / 'setting.csv').write_text('name,value\nOpenCV,4.6.0\ncompiler,"GNU 12, Release"\n')
    path = tmp_path / 'document.md'
    path.write_text('<!-- table: Setting -->\n<!-- end -->\n')

    def run(*arguments):
        return subprocess.run([sys.executable, report, *map(str, arguments)], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True)

    assert 'GNU 12, Release' in run('setting', tmp_path).stdout
    assert run('setting', tmp_path, '--doc', path).returncode == 0
    assert path.read_text() == ('<!-- table: Setting -->\n\n|  |  |\n|---|---:|\n| OpenCV | 4.6.0 |\n'
                                '| compiler | GNU 12, Release |\n\n<!-- end -->\n')
    absent = run('memory', tmp_path)
    assert absent.returncode == 1 and 'memory.csv' in absent.stderr and 'Traceback' not in absent.stderr
