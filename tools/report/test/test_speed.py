# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
import pytest
import speed

LEUVEN = 'cv/detectors_descriptors_evaluation/images_datasets/leuven/img1.png'


def case(image, n, detector, ms, fixture='Features', operation='detectAndCompute', size='900x600', found=None,
         body=None):
    """A test case as opencv_perf_aqorb writes it."""
    properties = {'image_size': size, 'keypoints': n if found is None else found, 'median': round(ms * 1e6),
                  'frequency': 1000000000, 'samples': 11}
    if body is None:
        body = '<properties>{}</properties>'.format(''.join(
            '<property name="{}" value="{}"/>'.format(*p) for p in properties.items()))
    return ('<testcase name="{o}/0" value_param="(&quot;{}&quot;, {}, {})" classname="{}_{o}">{}</testcase>'.format(
        image, n, detector, fixture, body, o=operation))


def both(image, n, orbs, ours, **others):
    return case(image, n, 'CV_ORB', orbs, **others) + case(image, n, 'AQORB', ours, **others)


def write(folder, name, cases, threads=1):
    (folder / (name + '.xml')).write_text(
        '<testsuites cv_num_threads="{}" cv_version="4.6.0" cv_parallel_framework="tbb" cv_cpu_features="SSE *AVX2">'
        '<testsuite name="Features_detectAndCompute">{}</testsuite></testsuites>'.format(threads, ''.join(cases)))


def rows(table):
    return table.values.tolist()


def test_geometric_mean():
    assert speed.geometric_mean([2, 8]) == pytest.approx(4)
    assert speed.geometric_mean([5]) == pytest.approx(5)
    # A ratio and its inverse are equally far from 1, which no other mean respects.
    assert speed.geometric_mean([3, 1 / 3]) == pytest.approx(1)


@pytest.mark.parametrize('ratios', [[], [1, 0], [-1]])
def test_geometric_mean_refuses_what_has_none(ratios):
    with pytest.raises(ValueError, match='at least one'):
        speed.geometric_mean(ratios)


@pytest.mark.parametrize('path, name', [(LEUVEN, 'leuven'), ('stitching/a3.png', 'a3'), ('scene_640x480', 'scene'),
                                        ('perf/640x512.png', '640x512')])
def test_short_name(path, name):
    assert speed.short_name(path) == name


def test_ratio_is_the_median_over_the_passes_of_ratios_within_a_pass(tmp_path):
    write(tmp_path, '1-1', [both(LEUVEN, 500, 6, 2)])    # 3
    write(tmp_path, '2-1', [both(LEUVEN, 500, 12, 3)])   # 4
    write(tmp_path, '3-1', [both(LEUVEN, 500, 50, 5)])   # 10; of the medians it would be 12 / 3
    write(tmp_path, '1-2', [both(LEUVEN, 500, 6, 1)], threads=2)
    results = speed.Results(tmp_path, 'Features')
    key = ('detectAndCompute', 'leuven', '900x600', 500)
    assert results.ratios().to_dict() == {key + (1,): pytest.approx(4), key + (2,): pytest.approx(6)}
    assert results.by_case('ms').loc[key + (1,)].to_dict() == {'CV_ORB': 12, 'AQORB': 3}
    assert results.spread() == pytest.approx(7 / 2 / 4)


def test_one_pass_has_no_spread(tmp_path):
    write(tmp_path, '1-1', [both(LEUVEN, 500, 6, 2)])
    assert speed.Results(tmp_path, 'Features').spread() is None


def test_cases_that_lack_one_detector_or_are_of_another_fixture_are_left_out(tmp_path):
    write(tmp_path, '1-1', [both(LEUVEN, 500, 6, 2), case(LEUVEN, 1000, 'AQORB', 2),
                            both('scene_640x480', 500, 8, 2, fixture='Scaling')])
    assert len(speed.Results(tmp_path, 'Features').ratios()) == 1
    assert speed.Results(tmp_path, 'Scaling').ratios().tolist() == [pytest.approx(4)]


def test_skipped_images_are_named(tmp_path):
    absent = ''.join(case(LEUVEN, 500, detector, 0, body='') for detector in speed.DETECTORS)
    write(tmp_path, '1-1', [both('scene_640x480', 500, 6, 2), absent])
    assert 'OPENCV_TEST_DATA_PATH: leuven.' in speed.speed_tables(tmp_path)['Against cv::ORB: notes']
    write(tmp_path, '1-1', [absent])
    with pytest.raises(ValueError, match='no case .* OPENCV_TEST_DATA_PATH: leuven'):
        speed.speed_tables(tmp_path)


def test_failed_cases_are_errors(tmp_path):
    write(tmp_path, '1-1', [both('scene_640x480', 500, 6, 2), case(LEUVEN, 500, 'AQORB', 1, body='<failure/>')])
    with pytest.raises(ValueError, match='failed .*\n.*leuven'):
        speed.speed_tables(tmp_path)


def test_empty_folder_is_an_error(tmp_path):
    with pytest.raises(ValueError, match='no case'):
        speed.speed_tables(tmp_path)


def test_case_table(tmp_path):
    write(tmp_path, '1-1', [both(LEUVEN, 500, 3, 2, operation='detect', found=490),
                            both(LEUVEN, 500, 6, 2), both(LEUVEN, 2000, 24, 2),
                            both('scene_640x480', 500, 27, 1, size='640x480')])
    table = speed.speed_tables(tmp_path)['Against cv::ORB']
    assert list(table.columns) == ['image', 'size', 'n', 'detect 1T', 'detectAndCompute 1T', 'ms 1T', 'keypoints']
    assert rows(table) == [
        ['leuven', '900x600', '500', '1.50', '3.00', '6.00 / 2.00', '500 / 500'],
        ['leuven', '900x600', '2000', '', '12.00', '24.00 / 2.00', '2000 / 2000'],
        ['scene', '640x480', '500', '', '27.00', '27.00 / 1.00', '500 / 500'],
        ['lowest', '', '', '1.50', '3.00', '', ''],
        ['geometric mean', 'all', '500', '1.50', '9.00', '', ''],
        ['geometric mean', 'all', '2000', '', '12.00', '', ''],
        ['geometric mean', 'scenes', '', '', '27.00', '', ''],
        ['geometric mean', 'all', '', '1.50', '{:.2f}'.format((3 * 12 * 27) ** (1 / 3)), '', '']]


def test_a_mean_reads_the_same_in_every_table(tmp_path):
    # The mean of these ratios is 4.762; that of the ratios as the table shows them would be 4.766.
    ratios = {'bikes': 4.726, 'leuven': 4.806, 'bark': 4.746, 'trees': 4.786, 'ubc': 4.766, '640x512': 4.756,
              '1920x1080': 4.75}
    assert '{:.2f}'.format(speed.geometric_mean([round(ratio, 2) for ratio in ratios.values()])) == '4.77'
    images = {name: 'perf/{}.png'.format(name) if 'x' in name else name + '/img1.png' for name in ratios}
    write(tmp_path, '1-1', [both(images[name], 500, 1000 * ratio, 1000, size='9x9')
                            for name, ratio in ratios.items()])
    tables = speed.speed_tables(tmp_path)
    means = [row[3] for row in rows(tables['Against cv::ORB']) if row[1] == 'reference set']
    assert means == ['4.76']
    assert rows(tables['Aims'])[0] == ['detectAndCompute, 1 thread', 'at least 4.0', '4.76', 'yes']
    assert rows(tables['Aims'])[1][2] == '4.73'
    assert rows(tables['Speed in short']) == [
        ['`detectAndCompute`, geometric mean over 7 images and n = 500', '4.76'],
        ['`detectAndCompute`, the lowest: bikes 9x9, n = 500', '4.73']]


def test_aims_are_compared_before_they_are_rounded(tmp_path):
    images = [image + '/img1.png' for image in ('bikes', 'leuven', 'bark', 'trees', 'ubc')]
    images += ['perf/640x512.png', 'perf/1920x1080.png']
    write(tmp_path, '1-1', [both(image, 500, 3999, 1000) for image in images])
    assert rows(speed.speed_tables(tmp_path)['Aims'])[0][2:] == ['4.00', 'no']


def test_two_threads(tmp_path):
    write(tmp_path, '1-1', [both(LEUVEN, 1000, 6, 2), both(LEUVEN, 500, 6, 2)])
    assert 'Two threads' not in speed.speed_tables(tmp_path)
    write(tmp_path, '1-2', [both(LEUVEN, 1000, 5, 1), both(LEUVEN, 500, 5, 1)], threads=2)
    assert rows(speed.speed_tables(tmp_path)['Two threads']) == [['leuven 900x600', '2.00', '1.20']]


def test_scaling(tmp_path):
    def scene(size, n, orbs, ours, found):
        return both('scene_' + size, n, orbs, ours, fixture='Scaling', size=size, found=found)

    # Both detectors take a time for each pixel and for each keypoint; the second pass is twice as slow.
    for name, slow in (('1-1', 1), ('2-1', 2)):
        cases = []
        for size, pixels in (('320x240', 0.0768), ('640x480', 0.3072)):
            for n, found in ((500, 500), (1000, 1000), (8000, 8000 if size == '640x480' else 4000)):
                cases.append(scene(size, n, slow * (20 * pixels + found * 0.004), slow * (5 * pixels + found * 0.001),
                                   found))
        write(tmp_path, name, cases)
    tables = speed.scaling_tables(tmp_path)
    assert rows(tables['Speed by size and n']) == [['320x240', '4.00', '4.00', '4.00*'],
                                                   ['640x480', '4.00', '4.00', '4.00']]
    assert rows(tables['Keypoints found'])[0] == ['320x240', '500 / 500', '1000 / 1000', '4000 / 4000*']
    assert rows(tables['Growth'])[1] == ['640x480', '0.80 (0.80)', '1.00 (1.00)', '3.76 (3.76)']
    assert rows(tables['Cost of a pixel and of a keypoint']) == [
        ['cv::ORB', '1.000', '1.000', '200', '0 %'], ['AdaptiveQuadtreeORB', '0.250', '0.250', '200', '0 %']]


def test_scaling_has_a_row_for_the_dot_grid(tmp_path):
    def scaling(image, n, orbs, ours):
        return both(image, n, orbs, ours, fixture='Scaling', size=image[-7:],
                    operation='dots' if 'dots' in image else 'detectAndCompute')

    write(tmp_path, '1-1', [scaling('scene_320x240', 500, 4, 2), scaling('scene_640x480', 500, 8, 2),
                            scaling('scene_640x480', 1000, 10, 2), scaling('dots_640x480', 100000, 300, 200)])
    tables = speed.scaling_tables(tmp_path)
    assert rows(tables['Speed by size and n']) == [['320x240', '2.00', '', ''], ['640x480', '4.00', '5.00', ''],
                                                   ['dot grid 640x480', '', '', '1.50']]
    assert rows(tables['Growth'])[2] == ['dot grid 640x480', '', '', '100.0 (30.0)']
    # It is not fitted: it has no scene's corners.
    costs = rows(tables['Cost of a pixel and of a keypoint'])
    write(tmp_path, '1-1', [scaling('scene_320x240', 500, 4, 2), scaling('scene_640x480', 500, 8, 2),
                            scaling('scene_640x480', 1000, 10, 2)])
    assert rows(speed.scaling_tables(tmp_path)['Cost of a pixel and of a keypoint']) == costs


def test_scaling_is_of_one_thread(tmp_path):
    write(tmp_path, '1-2', [both('scene_640x480', 500, 6, 2, fixture='Scaling')], threads=2)
    with pytest.raises(ValueError, match='one thread'):
        speed.scaling_tables(tmp_path)


def test_costs_are_fitted_to_relative_errors():
    pixel, keypoint, deviation = speed.fit_costs([1, 100, 1e6], [10, 10, 10], [21, 120, 1000020])
    assert (pixel, keypoint, deviation) == (pytest.approx(1), pytest.approx(2), pytest.approx(0, abs=1e-9))
    # Two times of the same case: the fit is where the relative errors are least, nearer to the smaller time.
    pixel, _, deviation = speed.fit_costs([1, 1], [0, 0], [1, 3])
    assert pixel == pytest.approx((1 + 1 / 3) / (1 + 1 / 9))
    assert deviation == pytest.approx(1 - pixel / 3)
