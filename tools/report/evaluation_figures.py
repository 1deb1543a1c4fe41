# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Draws the paper's figures 3 to 8 from what aqorb_evaluate wrote, with the paper's values marked."""

import glob
import os

import matplotlib
matplotlib.use('Agg')
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)

from evaluation import Evaluation, PAPER_SETS, read_paper  # noqa: E402

COLOURS = {'orb': 'tab:gray', 'orb_slam': 'tab:orange', 'paper': 'tab:blue', 'aqorb': 'black',
           'sift': 'tab:green', 'surf': 'tab:olive', 'brisk': 'tab:purple', 'akaze': 'tab:brown',
           'ssc': 'tab:cyan', 'superpoint': 'tab:red'}


def measured(data, quantity):
    """A function that gives the values of a set and a method by image, for the paper's number of features."""
    values = data.by_image(quantity).dropna()
    return lambda name, method: values.xs((name, method)) if (name, method) in values.index else None


def printed(paper, quantity):
    """The same of the paper's tables."""
    values = paper.drop('text', level='table').xs(quantity, level='quantity')
    # Column C of tables 1 and 2 comes first; the row OURS of table 3 repeats it.
    values = values.groupby(level=['set', 'method', 'image']).first()
    values.index = values.index.set_levels(values.index.levels[2].astype(int), level='image')
    return lambda name, method: values.xs((name, method)) if (name, method) in values.index else None


def panels(data, paper, quantity, methods, title, label, path, rows=1, log=False):
    """A panel for each of the paper's sets with a quantity by image, ours and the paper's."""
    figure, axes = plt.subplots(rows, -(-len(PAPER_SETS) // rows), figsize=(16 if rows == 1 else 13, 4 * rows),
                                sharey=True, squeeze=False)
    for axis in axes.flat[len(PAPER_SETS):]:
        axis.axis('off')
    here, there = measured(data, quantity), printed(paper, quantity)
    for axis, name in zip(axes.flat, PAPER_SETS):
        for method in methods:
            for values, style in ((here(name, method), dict(marker='o', linestyle='-', markersize=4)),
                                  (there(name, method), dict(marker='o', linestyle=':', markersize=7,
                                                             markerfacecolor='none', linewidth=0.8))):
                if values is not None:
                    axis.plot(values.index, values.values, color=COLOURS[method], **style)
        axis.set_title(name)
        axis.set_xlabel('image')
        axis.grid(alpha=0.3)
        if log:
            axis.set_yscale('log')
    for row in axes:
        row[0].set_ylabel(label)
    lines = [plt.Line2D([], [], color=COLOURS[m], marker='o', markersize=4, label=data.methods[m]) for m in methods]
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


def pictures(data, folder, figure_number, columns, title):
    """Puts the pictures of keypoints of one of the paper's figures together."""
    files = sorted(glob.glob(os.path.join(folder, 'figure{}[a-z]_*.jpg'.format(figure_number))))
    if not files:
        return
    rows = (len(files) + columns - 1) // columns
    figure, axes = plt.subplots(rows, columns, figsize=(12, 3.2 * rows), squeeze=False)
    for axis, file in zip(axes.flat, files):
        axis.imshow(plt.imread(file))
        letter, method = os.path.basename(file)[len('figure') + 1:-len('.jpg')].split('_', 1)
        axis.set_title('({}) {}'.format(letter, data.methods[method]), fontsize=10)
    for axis in axes.flat:
        axis.axis('off')
    figure.suptitle(title)
    figure.tight_layout()
    figure.savefig(os.path.join(folder, 'figure{}.jpg'.format(figure_number)), dpi=80)
    plt.close(figure)


def draw_figures(folder):
    """Draws what a folder has the measures of, into that folder, and says which figures there are now."""
    data, paper = Evaluation(folder), read_paper()
    present = [method for method in COLOURS if method in data.methods]
    four = [method for method in ('orb', 'orb_slam', 'paper', 'aqorb') if method in present]

    pictures(data, folder, 3, 3, 'Figure 3: 500 keypoints of bikes img1')
    pictures(data, folder, 4, 3, 'Figure 4: cv::ORB on leuven')
    pictures(data, folder, 5, 3, "Figure 5: ours with the paper's settings on leuven")
    panels(data, paper, 'uniformity', four, 'Figure 6: uniformity u by image, less is more uniform', 'u',
           os.path.join(folder, 'figure6.png'))
    panels(data, paper, 'time_ms', four, "Figure 7: CPU time by image; the paper's are of an i5-4258U", 'ms',
           os.path.join(folder, 'figure7.png'), log=True)
    panels(data, paper, 'uniformity', [method for method in present if method not in ('orb', 'orb_slam')],
           'Figure 8: uniformity u by image', 'u', os.path.join(folder, 'figure8.png'), rows=2)
    drawn = sorted(glob.glob(os.path.join(folder, 'figure[0-9].*')))
    return {'Figures': '\n'.join(drawn)}
