# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
import profiling


def rows(table):
    return table.values.tolist()


def write_stages(folder, frames, paths=((1000, 100, 400, 500, 600),)):
    """frames: (FAST, selection); paths: (frame by one thread, serial, longest path, least and queue's time)."""
    lines = ['image,frame,kind,name,ns']
    for i, (fast, selection) in enumerate(frames):
        lines += ['"scene 9x9",{},stage,"FAST, cells",{}'.format(i, fast),
                  '"scene 9x9",{},stage,selection,{}'.format(i, selection)]
    for i, (frame, *others) in enumerate(paths):
        lines.append('"scene 9x9",{},path,frame 1,{}'.format(i, frame))
        for threads in 2, 4, 8:
            for name, ns in zip(('serial', 'longest', 'least', 'queue'), others):
                # With more threads the least time falls, the queue's does not.
                least = ns * 2 // threads if name == 'least' else ns
                lines.append('"scene 9x9",{},path,{} {},{}'.format(i, name, threads, least))
    (folder / 'stages.csv').write_text('\n'.join(lines) + '\n')


def test_stages_are_medians_of_frames(tmp_path):
    # The medians of the stages, 900 and 100, are of different frames; no frame has them both.
    write_stages(tmp_path, [(900, 1100), (700, 100), (9000, 90)])
    tables = profiling.stage_tables(tmp_path)
    assert list(tables['Stages'].columns) == ['% of a frame', 'scene 9x9']
    assert rows(tables['Stages']) == [['FAST, cells', '90.0'], ['selection', '10.0']]


def test_critical_path_is_of_ratios_within_a_frame(tmp_path):
    # serial: 10, 12.5 and 10 %; least time of two threads: 50, 62.5 and 50 %; of the queue 60, 75 and 60 %
    write_stages(tmp_path, [(900, 100)],
                 [(2000, 200, 800, 1000, 1200), (800, 100, 400, 500, 600), (9090, 909, 3636, 4545, 5454)])
    assert rows(profiling.stage_tables(tmp_path)['Critical path']) == [
        ['scene 9x9', '10.0', '10.0', '40.0', '2.00', '4.00', '8.00', '1.67', '1.67', '1.67']]


def test_memory_is_in_multiples_of_the_image(tmp_path):
    (tmp_path / 'memory.csv').write_text('image,pixels,threads,detector,first,later,kept\n'
                                         '"scene 10x10",100,1,CV_ORB,600,655,0\n'
                                         '"scene 10x10",100,1,AQORB,1000,1100,900\n'
                                         '"scene 10x10",100,2,CV_ORB,600,655,0\n'
                                         '"scene 10x10",100,2,AQORB,1200,1300,905\n'
                                         'leuven 20x10,200,1,CV_ORB,1200,1310,0\n'
                                         'leuven 20x10,200,1,AQORB,2200,1100,900\n'
                                         'bark 10x10,100,1,CV_ORB,500,700,0\n'
                                         'bark 10x10,100,1,AQORB,500,600,400\n')
    table = profiling.memory_tables(tmp_path)['Memory']
    assert list(table.columns) == ['image', 'threads', 'first frame', 'later frames', 'kept', 'cv::ORB, first frame',
                                   'cv::ORB, later frames', 'cv::ORB, kept']
    assert rows(table) == [
        ['scene 10x10', '1', '10.00', '11.00', '9.00', '6.00', '6.55', '0.00'],
        ['scene 10x10', '2', '12.00', '13.00', '9.05', '6.00', '6.55', '0.00'],
        ['leuven 20x10', '1', '11.00', '5.50', '4.50', '6.00', '6.55', '0.00'],
        ['bark 10x10', '1', '5.00', '6.00', '4.00', '5.00', '7.00', '0.00'],
        ['largest of the photographs', '1', '11.00', '6.00', '4.50', '6.00', '7.00', '0.00']]


def test_memory_of_another_build(tmp_path):
    (tmp_path / 'memory.csv').write_text('image,pixels,threads,detector,first,later,kept\n'
                                         '"scene 10x10",100,1,CV_ORB,600,655,0\n'
                                         '"scene 10x10",100,1,AQORB,1000,1100,900\n'
                                         '"scene 10x10",100,1,BESIDE libaqorb.so.0.1.0,1500,1600,1400\n')
    table = profiling.memory_tables(tmp_path)['Memory']
    assert list(table.columns[5:8]) == ['version 0.1.0, first frame', 'version 0.1.0, later frames',
                                        'version 0.1.0, kept']
    assert rows(table)[0][2:8] == ['10.00', '11.00', '9.00', '15.00', '16.00', '14.00']


def test_instructions(tmp_path):
    (tmp_path / 'instructions.csv').write_text(
        'image,detector,kind,name,instructions\n'
        'leuven,CV_ORB,frame,frame,80000000.0\nleuven,AQORB,frame,frame,20000000.0\n'
        'leuven,AQORB,stage,"FAST, suppression",10000000.0\nleuven,AQORB,stage,blur,5000000.0\n'
        'leuven,AQORB,function,cv::aqorb::stages::opt_AVX2::fetch,1000000.0\n'
        'leuven,AQORB,function,int cv::aqorb::stages::scoreRow<cv::aqorb::stages::Wide>,2000000.0\n'
        'bark,CV_ORB,frame,frame,60000000.0\nbark,AQORB,frame,frame,40000000.0\n'
        'bark,AQORB,stage,"FAST, suppression",10000000.0\nbark,AQORB,stage,blur,5000000.0\n'
        'bark,AQORB,function,int cv::aqorb::stages::scoreRow<cv::aqorb::stages::Wide>,4000000.0\n')
    tables = profiling.instruction_tables(tmp_path)
    assert rows(tables['Instructions']) == [['leuven', '80.00', '20.00', '4.00'], ['bark', '60.00', '40.00', '1.50']]
    assert rows(tables['Instructions by stage']) == [['FAST, suppression', '50.0', '25.0'], ['blur', '25.0', '12.5'],
                                                     ['rest', '25.0', '62.5']]
    # The most of the first image come first.
    assert rows(tables['Instructions by function']) == [['scoreRow<Wide>', '10.0', '10.0'],
                                                        ['opt_AVX2::fetch', '5.0', '0.0']]


def test_emulated_instructions(tmp_path):
    (tmp_path / 'instructions.csv').write_text('image,detector,instructions\n'
                                               'leuven,CV_ORB,80000000.0\nleuven,AQORB,40000000.0\n'
                                               'bark,CV_ORB,60000000.0\nbark,AQORB,24000000.0\n')
    assert rows(profiling.emulated_tables(tmp_path)['Instructions on AArch64']) == [
        ['leuven', '80.00', '40.00', '2.00'], ['bark', '60.00', '24.00', '2.50']]


def test_setting(tmp_path):
    (tmp_path / 'setting.csv').write_text('name,value\nOpenCV,4.10\nframes,31\n')
    assert rows(profiling.setting_tables(tmp_path)['Setting']) == [['OpenCV', '4.10'], ['frames', '31']]
