# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of the tables of matchers and of pairs of images."""

import matching


def write(folder, name, lines):
    (folder / name).write_text('\n'.join(lines) + '\n')


def test_matchers(tmp_path):
    for cpu, file, factor in (('slow', 'matchers-baseline.csv', 4), ('fast', 'matchers-best.csv', 1)):
        lines = ['cpu,n,bytes,task,contender,repeat,ms']
        for n in (1000, 2000):
            for repeat, noise in enumerate((0, 0, 99)):
                for task in ('cross check', 'knn 2'):
                    lines.append(f'{cpu},{n},32,{task},cv::BFMatcher,{repeat},{40 + noise}')
                    lines.append(f'{cpu},{n},32,{task},HammingMatcher,{repeat},{factor * n / 1000 + noise}')
                for contender, ms in (('matchArrays', 3), ('matchByPosition', 2)):
                    lines.append(f'{cpu},{n},32,cross check,{contender},{repeat},{ms}')
        write(tmp_path, file, lines)
    write(tmp_path, 'frequency.csv', ['ghz', '2.0'])
    write(tmp_path, 'scaling.csv', ['cpu,n,task,threads,repeat,ms', 'fast,2000,knn 2,1,0,3', 'fast,2000,knn 2,2,0,2'])
    for name, ms in (('program', 30), ('preloaded', 2)):
        write(tmp_path, name + '-best-1.csv', ['cpu,n,task,repeat,ms', f'fast,1000,match,0,{ms}'])
    tables = matching.matching_tables(str(tmp_path))
    rows = tables['Matchers'].values.tolist()
    assert rows[0] == ['cross check', 'fast', '1000', '40.00', '1.000', '40.0', '2.00']
    assert rows[3] == ['cross check', 'slow', '2000', '40.00', '8.000', '5.0', '4.00']
    assert tables['Matchers: gain'].values.tolist()[0] == ['cross check', 'fast', '28.3']
    assert tables['Matchers: positions'].values.tolist()[1] == ['2000', '2.000', '3.000', '2.000']
    assert tables['Matchers: preloaded'].values.tolist() == [['match', 'fast', '1000', '30.00', '2.000', '15.0']]
    assert tables['Matchers: threads'].values.tolist() == [['knn 2', '2000', '3.000', '2.000', '1.50']]


def test_pairs(tmp_path):
    lines = ['cpu,set,n,contender,repeat,ms']
    for name, factor in (('bikes', 1), ('bark', 4)):
        for contender, ms in (('cv::ORB, cv::BFMatcher', 30), ('aqorb, cv::BFMatcher', 20),
                              ('aqorb, HammingMatcher', 3 * factor)):
            lines.append(f'fast,{name},1000,"{contender}",0,{ms}')
    write(tmp_path, 'pairs-best.csv', lines)
    rows = matching.pair_tables(str(tmp_path))['Pairs of images'].values.tolist()
    assert rows == [['fast', '1000', 'bikes', '30.00', '20.00', '3.00', '1.5', '10.0'],
                    ['fast', '1000', 'bark', '30.00', '20.00', '12.00', '1.5', '2.5'],
                    ['fast', '1000', 'geometric mean', '30.00', '20.00', '6.00', '1.5', '5.0']]
