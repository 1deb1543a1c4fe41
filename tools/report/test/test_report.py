# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""How the documents' numbers come from what was measured, on small tables that are worked out by hand."""

import document
import evaluation
import pandas
import profiling
import program
import pytest
import speed

LEUVEN = 'cv/detectors_descriptors_evaluation/images_datasets/leuven/img1.png'
TABLE = pandas.DataFrame([['a', '500', '1.00'], ['a', '1000', '2.00']], columns=['image', 'n', 'value'])
DOCUMENT = '<!-- table: One -->\n\nold\n\n<!-- end -->\n\nWords.\n\n<!-- table: Two, n = 1000 -->\n<!-- end -->\n'


def rows(table):
    return table.values.tolist()


@pytest.mark.parametrize('value, digits, text', [
    (4.765, 2, '4.76'),  # the binary number next to 4.765 is below it
    (4.7651, 2, '4.77'), (0.999, 1, '1.0'), (-0.4, 0, '0'), (-0.6, 0, '-1'), (None, 2, ''), (float('nan'), 1, '')])
def test_number_rounds_to_the_nearest(value, digits, text):
    assert document.number(value, digits) == text


def test_replace_puts_tables_between_their_markers_only():
    new = document.replace(DOCUMENT, {'One': TABLE, 'Two': TABLE})
    assert new == DOCUMENT.replace('\nold\n', '\n' + document.markdown(TABLE)).replace(
        '1000 -->\n', '1000 -->\n\n| image | n | value |\n|---|---:|---:|\n| a | 1000 | 2.00 |\n\n')
    assert document.replace(new, {'One': TABLE, 'Two': TABLE, 'Three': TABLE}) == new
    with pytest.raises(ValueError, match='"Two" has no row with n = 1000'):
        document.replace(DOCUMENT, {'Two': TABLE[TABLE['n'] == '500']})
    with pytest.raises(ValueError, match='<!-- end -->'):
        document.replace(DOCUMENT.replace('<!-- end -->', '', 1), {'One': TABLE})


def case(image, n, detector, ms, fixture='Features', size='900x600', found=None):
    """A test case as opencv_perf_aqorb writes it."""
    properties = {'image_size': size, 'keypoints': n if found is None else found, 'median': round(ms * 1e6),
                  'frequency': 1000000000, 'samples': 11}
    return ('<testcase name="detectAndCompute/0" value_param="(&quot;{}&quot;, {}, {})" classname="{}_x"><properties>'
            '{}</properties></testcase>'.format(image, n, detector, fixture, ''.join(
                '<property name="{}" value="{}"/>'.format(*p) for p in properties.items())))


def write(folder, name, *cases):
    """cases: image, n, ms of cv::ORB and of AdaptiveQuadtreeORB, and options of case."""
    (folder / (name + '.xml')).write_text(
        '<testsuites cv_num_threads="1" cv_version="4.6.0" cv_cpu_features="SSE *AVX2">{}</testsuites>'.format(''.join(
            case(image, n, detector, ms, **options) for image, n, orbs, ours, options in cases
            for detector, ms in (('CV_ORB', orbs), ('AQORB', ours)))))


def test_speed_is_the_median_over_the_passes_of_ratios_within_a_pass(tmp_path):
    for name, orbs, ours in ('1-1', 6, 2), ('2-1', 12, 3), ('3-1', 50, 5):  # 3, 4, 10; of the medians 12 / 3
        write(tmp_path, name, (LEUVEN, 500, orbs, ours, {}))
    results = speed.Results(tmp_path, 'Features')
    assert results.ratios().tolist() == [pytest.approx(4)]
    assert results.spread() == pytest.approx(7 / 2 / 4)


def test_means_are_geometric_and_of_ratios_that_are_not_rounded(tmp_path):
    assert speed.geometric_mean([2, 8]) == pytest.approx(4)
    # The mean of these ratios is 4.762; that of the ratios as the table shows them would be 4.766.
    ratios = {'bikes': 4.726, 'leuven': 4.806, 'bark': 4.746, 'trees': 4.786, 'ubc': 4.766, '640x512': 4.756,
              '1920x1080': 4.75}
    images = {name: 'perf/{}.png'.format(name) if 'x' in name else name + '/img1.png' for name in ratios}
    write(tmp_path, '1-1', *((images[name], 500, 1000 * ratio, 1000, {}) for name, ratio in ratios.items()))
    tables = speed.speed_tables(tmp_path)
    assert [row[3] for row in rows(tables['Against cv::ORB']) if row[1] == 'reference set'] == ['4.76']
    assert rows(tables['Aims'])[0] == ['detectAndCompute, 1 thread', 'at least 4.0', '4.76', 'yes']
    write(tmp_path, '1-1', *((image, 500, 3999, 1000, {}) for image in images.values()))
    assert rows(speed.speed_tables(tmp_path)['Aims'])[0][2:] == ['4.00', 'no']


def test_growth_is_relative_to_one_case(tmp_path):
    # Both detectors take a time for each pixel and for each keypoint.
    write(tmp_path, '1-1', *(
        ('scene_' + size, n, 20 * pixels + found * 0.004, 5 * pixels + found * 0.001,
         {'fixture': 'Scaling', 'size': size, 'found': found})
        for size, pixels in (('320x240', 0.0768), ('640x480', 0.3072))
        for n, found in ((500, 500), (1000, 1000), (8000, 8000 if size == '640x480' else 4000))))
    tables = speed.scaling_tables(tmp_path)
    assert rows(tables['Speed by size and n'])[0] == ['320x240', '4.00', '4.00', '4.00*']
    assert rows(tables['Growth'])[1] == ['640x480', '0.80 (0.80)', '1.00 (1.00)', '3.76 (3.76)']


def test_program_is_the_median_over_the_passes_of_ratios_within_a_pass(tmp_path):
    lines = ['cpu,case,threads,image,n,pass,detector,keypoints,ms']
    lines += ['SSE *AVX2,turns,1,leuven 9x9,500,{},{},100,{}'.format(number, detector, ms)
              for number, times in enumerate([(6, 2, 4), (12, 3, 4), (50, 5, 5)])
              for detector, ms in zip(('CV_ORB', 'AQORB', 'BESIDE libaqorb.so.0.1.0'), times)]
    (tmp_path / 'program.csv').write_text('\n'.join(lines) + '\n')
    tables = program.program_tables(tmp_path)
    assert rows(tables['In a program']) == [['in turns', '4.00', '4.00'],
                                            ['in turns, version 0.1.0', '3.00', '3.00']]
    assert rows(tables['In a program: cases']) == [['leuven 9x9', '500', '4.00', '12.00 / 3.00']]


def test_many_images_are_compared_within_a_turn(tmp_path):
    lines = ['way,repeat,images,seconds']
    for repeat, slowness in enumerate((1, 2, 1)):
        for way, seconds in (('1 thread', 2), ('2 threads', 1), ('2 processes', .96)):
            lines.append('{},{},100,{}'.format(way, repeat, seconds * slowness))
    (tmp_path / 'collection.csv').write_text('\n'.join(lines))
    assert rows(profiling.collection_tables(tmp_path)['Many images']) == [
        ['1 thread', '50', '1.000', '0.480'], ['2 threads', '100', '2.000', '0.960'],
        ['2 processes', '104', '2.083', '1.000']]


def test_memory_is_in_multiples_of_the_image(tmp_path):
    (tmp_path / 'memory.csv').write_text('image,pixels,threads,detector,first,later,kept\n'
                                         'leuven 20x10,200,1,CV_ORB,1200,1310,0\n'
                                         'leuven 20x10,200,1,AQORB,2200,1100,900\n'
                                         'bark 10x10,100,1,CV_ORB,500,700,0\nbark 10x10,100,1,AQORB,500,600,400\n')
    assert rows(profiling.memory_tables(tmp_path)['Memory']) == [
        ['leuven 20x10', '1', '11.00', '5.50', '4.50', '6.00', '6.55', '0.00'],
        ['bark 10x10', '1', '5.00', '6.00', '4.00', '5.00', '7.00', '0.00'],
        ['largest of the photographs', '1', '11.00', '6.00', '4.50', '6.00', '7.00', '0.00']]


def test_evaluation(tmp_path):
    # Six images: 100, 101, ... for cv::ORB, ten less for ours.
    (tmp_path / 'uniformity.csv').write_text('set,image,method,n,keypoints,uniformity,occupancy,time_ms\n' + ''.join(
        'bikes,{0},orb,500,{1},{2},0.5,8.5\nbikes,{0},aqorb,500,500,{3},0.75,2\n'.format(i, 490 + i, 99 + i, 89 + i)
        for i in range(1, 7)))
    for name, text in {
            'setting.csv': 'name,value\nOpenCV,4.6.0\nCPU features,"SSE, AVX2"\n',
            'methods.csv': 'method,role,text\norb,method,cv::ORB (A)\naqorb,method,ours as shipped\n',
            'matching.csv': 'set,pair,method,n,matches,correct,distinct,places,precision,repeatability,corner_error\n'
                            'bikes,1-2,orb,500,20,10,4,3,0.5,0.25,1\nbikes,1-3,orb,500,20,5,7,4,0.25,0.75,1\n',
            'homography.csv': 'set,pair,method,n,seed,corner_error\nbikes,1-2,orb,500,1,0\nbikes,1-2,orb,500,2,2.5\n'
                              'bikes,1-3,orb,500,1,1000000\nbikes,1-3,orb,500,2,5\n',
            'odometry.csv': 'method,n,frame,stereo,matches,inliers,translation_error_m,rotation_error_deg\n'
                            'orb,500,1,100,50,30,0.03,0.3\norb,500,2,100,51,30,0.04,0.4\norb,500,3,100,4,0,,\n'}.items():
        (tmp_path / name).write_text(text)
    data, paper = evaluation.Evaluation(tmp_path), evaluation.read_paper()
    # AUC@5: (1 + 0.5) / 2 for the first pair, 0 for the second.
    assert rows(dict(evaluation.quality_tables(data, 'quality', '', data.methods))['quality']) == [
        ['cv::ORB (A)', '500', '494', '102.5', '0.500', '5.5', '3.5', '0.375', '0.500', '0.292', '0.375', '0.562'],
        ['ours as shipped', '500', '500', '92.5', '0.750'] + [''] * 7]
    table = dict(evaluation.three_methods_tables(data, paper, '1', 'bikes'))['Table 1 (bikes): uniformity']
    assert rows(table)[0] == ['1', '210.06', '100.00', '137.55', '', '140.81', '', '90.00']
    # Errors are of the two frames with a motion: sqrt((3^2 + 4^2) / 2) cm.
    assert rows(dict(evaluation.odometry_tables(data))['Stereo odometry, from frame to frame'])[0] == [
        'cv::ORB (A)', '500', '100', '35', '20', '3.54', '0.3536', '1']
