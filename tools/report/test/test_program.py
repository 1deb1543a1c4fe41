# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
import program

AVX512, AVX2 = 'SSE *AVX2 *AVX512-SKX', 'SSE *AVX2 *AVX512-SKX?'


def rows(table):
    return table.values.tolist()


def write(folder, *cases):
    """cases: cpu, case, threads, image, n, pass, ms of cv::ORB, of AdaptiveQuadtreeORB and of another build."""
    lines = ['cpu,case,threads,image,n,pass,detector,keypoints,ms']
    for *case, orbs, ours, others in cases:
        for detector, ms in ('CV_ORB', orbs), ('AQORB', ours), ('BESIDE libaqorb.so.0.1.0', others):
            if ms:
                lines.append(','.join(map(str, case + [detector, 100, ms])))
    (folder / 'program.csv').write_text('\n'.join(lines) + '\n')


def test_ratio_is_the_median_over_the_passes_of_ratios_within_a_pass(tmp_path):
    write(tmp_path, (AVX512, 'turns', 1, 'leuven 9x9', 500, 0, 6, 2, 0),   # 3
          (AVX512, 'turns', 1, 'leuven 9x9', 500, 1, 12, 3, 0),            # 4
          (AVX512, 'turns', 1, 'leuven 9x9', 500, 2, 50, 5, 0))            # 10; of the medians it would be 12 / 3
    tables = program.program_tables(tmp_path)
    assert rows(tables['In a program']) == [['in turns', '4.00', '4.00']]
    assert rows(tables['In a program: cases']) == [['leuven 9x9', '500', '4.00', '12.00 / 3.00']]
    assert 'over 3 passes' in tables['In a program: notes']


def test_summary_has_means_and_the_lowest_by_case_and_threads(tmp_path):
    write(tmp_path, (AVX512, 'turns', 1, 'leuven 9x9', 500, 0, 8, 4, 0), (AVX512, 'turns', 1, 'bark 9x9', 500, 0, 8, 1, 0),
          (AVX512, 'turns', 2, 'leuven 9x9', 500, 0, 8, 2, 0), (AVX512, 'turns', 2, 'bark 9x9', 500, 0, 9, 1, 0),
          (AVX512, 'cold', 1, 'leuven 9x9', 500, 0, 6, 2, 0), (AVX2, 'turns', 1, 'leuven 9x9', 500, 0, 5, 2, 0))
    tables = program.program_tables(tmp_path)
    assert list(tables['In a program'].columns)[1:] == ['1 thread', '2 threads', 'lowest, 1 thread', 'lowest, 2 threads']
    assert rows(tables['In a program']) == [['in turns', '4.00', '6.00', '2.00', '4.00'], ['cold', '3.00', '', '3.00', ''],
                                            ['in turns, AVX2 only', '2.50', '', '2.50', '']]
    assert list(tables['In a program: cases'].columns) == [
        'image', 'n', 'in turns, 1T', 'in turns, 2T', 'cold, 1T', 'in turns, AVX2 only, 1T', 'ms in turns, 1T',
        'ms in turns, 2T']
    assert rows(tables['In a program: cases'])[1] == ['bark 9x9', '500', '8.00', '9.00', '', '', '8.00 / 1.00',
                                                      '9.00 / 1.00']


def test_a_machine_without_avx512_has_one_set_of_features(tmp_path):
    write(tmp_path, ('SSE *AVX2', 'turns', 1, 'leuven 9x9', 500, 0, 8, 4, 0))
    assert rows(program.program_tables(tmp_path)['In a program']) == [['in turns', '2.00', '2.00']]


def test_another_build_has_rows_of_its_own(tmp_path):
    write(tmp_path, (AVX512, 'cold', 1, 'leuven 9x9', 500, 0, 8, 2, 4))
    assert rows(program.program_tables(tmp_path)['In a program']) == [['cold', '4.00', '4.00'],
                                                                      ['cold, version 0.1.0', '2.00', '2.00']]
