#!/usr/bin/python3
# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
"""Draws the paper's figures 3 to 8 from what aqorb_evaluate wrote, with the paper's values marked."""

import argparse
import collections
import csv
import glob
import os

import matplotlib
matplotlib.use('Agg')
import matplotlib.pyplot as plt

SETS = ['bikes', 'leuven', 'bark', 'trees', 'ubc']
LABELS = {'orb': 'A: cv::ORB', 'orb_slam': "B: ORB_SLAM's quadtree", 'paper': "C: ours, paper's settings",
          'aqorb': 'ours as shipped', 'sift': 'SIFT', 'surf': 'SURF (dlib)', 'brisk': 'BRISK',
          'akaze': 'AKAZE', 'ssc': 'FAST + SSC', 'superpoint': 'SuperPoint'}
COLOURS = {'orb': 'tab:gray', 'orb_slam': 'tab:orange', 'paper': 'tab:blue', 'aqorb': 'black',
           'sift': 'tab:green', 'surf': 'tab:olive', 'brisk': 'tab:purple', 'akaze': 'tab:brown',
           'ssc': 'tab:cyan', 'superpoint': 'tab:red'}


def read(path):
    with open(path, newline='') as file:
        return list(csv.DictReader(file))


def measured(rows, quantity):
    """{(set, method): {image: value}} for plain sets and the paper's number of features."""
    n = rows[0]['n']
    values = collections.defaultdict(dict)
    for row in rows:
        if row['set'] in SETS and row['n'] == n and row['method'] in LABELS and row[quantity]:
            values[row['set'], row['method']][int(row['image'])] = float(row[quantity])
    return values


def printed(rows, quantity):
    """The same of the paper's tables."""
    values = collections.defaultdict(dict)
    for row in rows:
        if row['table'] != 'text' and row['quantity'] == quantity:
            # Column C of tables 1 and 2 is read first; the row OURS of table 3 repeats it.
            values[row['set'], row['method']].setdefault(int(row['image']), float(row['value']))
    return values


def panels(ours, paper, methods, title, label, path, rows=1, log=False):
    figure, axes = plt.subplots(rows, -(-len(SETS) // rows), figsize=(16 if rows == 1 else 13, 4 * rows),
                                sharey=True, squeeze=False)
    for axis in axes.flat[len(SETS):]:
        axis.axis('off')
    for axis, name in zip(axes.flat, SETS):
        for method in methods:
            for values, style in ((ours[name, method], dict(marker='o', linestyle='-', markersize=4)),
                                  (paper[name, method], dict(marker='o', linestyle=':', markersize=7,
                                                             markerfacecolor='none', linewidth=0.8))):
                if values:
                    axis.plot(list(values), list(values.values()), color=COLOURS[method], **style)
        axis.set_title(name)
        axis.set_xlabel('image')
        axis.grid(alpha=0.3)
        if log:
            axis.set_yscale('log')
    for row in axes:
        row[0].set_ylabel(label)
    lines = [plt.Line2D([], [], color=COLOURS[m], marker='o', markersize=4, label=LABELS[m]) for m in methods]
    lines.append(plt.Line2D([], [], color='black', marker='o', linestyle=':', markerfacecolor='none',
                            markersize=7, linewidth=0.8, label="the paper's value"))
    figure.suptitle(title)
    if rows == 1:
        figure.legend(handles=lines, loc='lower center', ncol=len(lines), frameon=False)
        figure.tight_layout(rect=(0, 0.06, 1, 1))
    else:  # in place of the last panel
        axes.flat[-1].legend(handles=lines, loc='center', frameon=False)
        figure.tight_layout()
    figure.savefig(path, dpi=80)
    plt.close(figure)


def pictures(folder, figure_number, columns, title):
    files = sorted(glob.glob(os.path.join(folder, 'figure{}[a-z]_*.jpg'.format(figure_number))))
    if not files:
        return
    rows = (len(files) + columns - 1) // columns
    figure, axes = plt.subplots(rows, columns, figsize=(12, 3.2 * rows), squeeze=False)
    for axis, file in zip(axes.flat, files):
        axis.imshow(plt.imread(file))
        letter, method = os.path.basename(file)[len('figure') + 1:-len('.jpg')].split('_', 1)
        axis.set_title('({}) {}'.format(letter, LABELS[method]), fontsize=10)
    for axis in axes.flat:
        axis.axis('off')
    figure.suptitle(title)
    figure.tight_layout()
    figure.savefig(os.path.join(folder, 'figure{}.jpg'.format(figure_number)), dpi=80)
    plt.close(figure)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('folder', help='where aqorb_evaluate wrote, and the figures go')
    folder = parser.parse_args().folder
    rows = read(os.path.join(folder, 'uniformity.csv'))
    paper = read(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'evaluate', 'paper_tables.csv'))
    present = [method for method in LABELS if any(row['method'] == method for row in rows)]
    three = [method for method in ('orb', 'orb_slam', 'paper', 'aqorb') if method in present]

    pictures(folder, 3, 3, 'Figure 3: 500 keypoints of bikes img1')
    pictures(folder, 4, 3, 'Figure 4: cv::ORB on leuven')
    pictures(folder, 5, 3, "Figure 5: ours with the paper's settings on leuven")
    panels(measured(rows, 'uniformity'), printed(paper, 'uniformity'), three,
           'Figure 6: uniformity u by image, less is more uniform', 'u', os.path.join(folder, 'figure6.png'))
    panels(measured(rows, 'time_ms'), printed(paper, 'time_ms'), three,
           "Figure 7: CPU time by image; the paper's are of an i5-4258U", 'ms', os.path.join(folder, 'figure7.png'),
           log=True)
    panels(measured(rows, 'uniformity'), printed(paper, 'uniformity'),
           [method for method in present if method not in ('orb', 'orb_slam')],
           'Figure 8: uniformity u by image', 'u', os.path.join(folder, 'figure8.png'), rows=2)


if __name__ == '__main__':
    main()
