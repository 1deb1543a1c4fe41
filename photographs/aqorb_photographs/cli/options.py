# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What several sub-commands share."""

import argparse
import os
import sys

import aqorb
from aqorb_photographs import Refused, images


def at_least(least):
    def number(text):
        if not least <= int(text) < 2**31:
            raise argparse.ArgumentTypeError(f'{text} is not from {least} to {2**31 - 1}')
        return int(text)
    return number


positive = at_least(1)


def add_command(commands, name, run, text, more=''):
    """A sub-command's parser."""
    parser = commands.add_parser(name, help=text, description=f'{text[0].upper()}{text[1:]}. {more}'.strip())
    parser.add_argument('--quiet', action='store_true', help='print what failed, and nothing else')
    parser.set_defaults(run=run)
    return parser


def add_reading(parser):
    """How images are read, and how many features are detected."""
    parser.add_argument('--num-features', type=positive, default=1000, metavar='N',
                        help='features of an image, at most (%(default)s)')
    parser.add_argument('--set', action='append', default=[], metavar='NAME=VALUE',
                        help='set a property of the detector, such as StrengthWeight=4; may be repeated')
    parser.add_argument('--max-size', type=positive, metavar='PIXELS', help='reduce images whose longer side is longer')
    parser.add_argument('--max-pixels', type=positive, default=images.Reading().max_pixels, metavar='N',
                        help='leave out images with more, after --max-size of a JPEG (%(default)s)')
    parser.add_argument('--stretch', action='store_true',
                        help='of more than 8 bits take those that are used: 12 bits, thermal images')
    parser.add_argument('--ignore-orientation', action='store_true', help='do not turn images as their EXIF data say')


def reading_of(given):
    return images.Reading(given.max_size, not given.ignore_orientation, given.stretch, given.max_pixels)


def detector_of(given):
    """A detector with the properties that the command sets."""
    detector = aqorb.AdaptiveQuadtreeORB_create(given.num_features)
    names = [name[3:] for name in dir(detector) if name.startswith('set')]
    for name, _, value in (text.partition('=') for text in given.set):
        if name not in names:
            raise Refused(f'--set {name}: the detector has {", ".join(names)}')
        kind = type(getattr(detector, 'get' + name)())
        try:
            number = kind(float(value) if kind is float else int(value))
        except ValueError:
            raise Refused(f'--set {name}: must be a number, got {value!r}') from None
        getattr(detector, 'set' + name)(number)
    return detector


def add_threads(parser):
    count = len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else os.cpu_count()
    parser.add_argument('--threads', type=positive, default=count, metavar='N', help='as many as processors by default')


def add_words(parser):
    parser.add_argument('--words', type=positive, metavar='N',
                        help='words, at most (65536); there are at most a quarter as many as features')
    parser.add_argument('--seed', type=at_least(0), metavar='N', help='of the words (0)')
    add_threads(parser)


def index_of(features, given):
    """The index of features, for the options of add_words."""
    from aqorb_photographs import places
    aqorb.setNumThreads(1)  # the images are what is divided among threads
    index = places.Index(features, given.words, given.seed, given.threads,
                         lambda label, total: progress(given, total, 'image', label).update)
    if not index.is_kept:
        print(f'aqorb: {index.folder} cannot be written: the next search takes as long', file=sys.stderr)
    return index


def new_file(path, overwrite, suffixes=()):
    """Refuses a file that exists, or whose suffix is none of those."""
    if suffixes and os.path.splitext(path)[1].lower() not in suffixes:
        raise Refused(f'{path} must end with {" or ".join(suffixes)}')
    if os.path.exists(path) and not overwrite:
        raise Refused(f'{path} exists; --overwrite replaces it')


def store_at(path):
    """The name of a folder of parts."""
    try:
        path.encode()
    except UnicodeEncodeError:  # the parts could not be read by their names
        raise Refused(f'{path!r} must be a name in UTF-8') from None
    if os.path.exists(path) and not os.path.isdir(path):
        raise Refused(f'{path} must be a folder, for parts; features of aqorb 0.4 are to be extracted anew')
    return path


def progress(given, total, unit, label=None):
    """A progress bar, on a terminal."""
    from tqdm import tqdm
    return tqdm(total=total, unit=unit, desc=label, smoothing=.05, disable=given.quiet or not sys.stderr.isatty())


def say(given, text):
    if not given.quiet:
        print(text)


def list_failures(failures, what):
    """Lists files, each with the reason."""
    if failures:
        print(f'{what}:', file=sys.stderr)
    for name, reason in failures:
        print(f'  {shown(name)}: {reason}', file=sys.stderr)


def count_of(number, noun, plural='s'):
    return f'{number} {noun}{"" if number == 1 else plural}'


def shown(name):
    """A name on one line and in one column, without what would control a terminal."""
    return ''.join(character if character.isprintable() or '\udc80' <= character <= '\udcff' else repr(character)[1:-1]
                   for character in os.fsdecode(name))
