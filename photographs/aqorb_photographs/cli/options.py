# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Options and messages that several sub-commands share."""

import argparse
import os
import sys

import aqorb
from aqorb_photographs import InputError, images


def at_least(least):
    def number(text):
        if not least <= int(text) < 2**31:
            raise argparse.ArgumentTypeError(f'{text} is not from {least} to {2**31 - 1}')
        return int(text)
    return number


positive = at_least(1)


def add_command(commands, name, run, text, more=''):
    """Adds and returns the parser of a sub-command."""
    parser = commands.add_parser(name, help=text, description=f'{text[0].upper()}{text[1:]}. {more}'.strip())
    parser.add_argument('--quiet', action='store_true', help='print only failures')
    parser.set_defaults(run=run)
    return parser


def add_reading(parser):
    """Adds the options of reading images and detecting features."""
    parser.add_argument('--num-features', type=positive, default=1000, metavar='N',
                        help='maximum number of features of an image (%(default)s)')
    parser.add_argument('--set', action='append', default=[], metavar='NAME=VALUE',
                        help='set a property of the detector, such as StrengthWeight=4; may be repeated')
    parser.add_argument('--max-size', type=positive, metavar='PIXELS', help='reduce images with a longer side')
    parser.add_argument('--max-pixels', type=positive, default=images.Reading().max_pixels, metavar='N',
                        help='leave out larger images; JPEGs count as reduced for --max-size (%(default)s)')
    parser.add_argument('--stretch', action='store_true',
                        help='stretch the contrast of images of more than 8 bits: 12 bits, thermal images')


def reading_of(given):
    return images.Reading(given.max_size, given.stretch, given.max_pixels)


def detector_of(given):
    """Returns a detector with the properties that the command sets."""
    detector = aqorb.AdaptiveQuadtreeORB_create(given.num_features)
    names = [name[3:] for name in dir(detector) if name.startswith('set')]
    for name, _, value in (text.partition('=') for text in given.set):
        if name not in names:
            raise InputError(f'--set {name}: the detector has {", ".join(names)}')
        kind = type(getattr(detector, 'get' + name)())
        try:
            number = kind(float(value) if kind is float else int(value))
        except ValueError:
            raise InputError(f'--set {name}: must be a number, got {value!r}') from None
        getattr(detector, 'set' + name)(number)
    return detector


def add_threads(parser):
    count = len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else os.cpu_count()
    parser.add_argument('--threads', type=positive, default=count, metavar='N', help='one per processor by default')


def add_words(parser):
    parser.add_argument('--words', type=positive, metavar='N',
                        help='maximum number of words (65536); at most one for every four features')
    parser.add_argument('--seed', type=at_least(0), metavar='N', help='seed of the draw of words (0)')
    add_threads(parser)


def index_of(features, given):
    """Returns the index of features, by the options of add_words."""
    from aqorb_photographs import places
    aqorb.setNumThreads(1)  # one thread for each image
    index = places.Index(features, given.words, given.seed, given.threads,
                         lambda label, total: progress(given, total, 'image', label).update)
    if not index.is_kept:
        print(f'aqorb: {index.folder} cannot be written, so the next search takes as long', file=sys.stderr)
    return index


def new_file(path, overwrite, suffixes=()):
    """Raises InputError for an existing file, or for another suffix."""
    if suffixes and os.path.splitext(path)[1].lower() not in suffixes:
        raise InputError(f'{path} must end with {" or ".join(suffixes)}')
    if os.path.exists(path) and not overwrite:
        raise InputError(f'{path} exists; --overwrite replaces it')


def content_of(path):
    """Returns the bytes of a list, or of standard input for -."""
    with open(sys.stdin.fileno() if path == '-' else path, 'rb', closefd=path != '-') as file:
        return file.read()


def store_at(path):
    """Checks and returns the path of a folder of parts."""
    try:
        path.encode()
    except UnicodeEncodeError:  # pyarrow could not open the parts
        raise InputError(f'{path!r} must be a name in UTF-8') from None
    if os.path.exists(path) and not os.path.isdir(path):
        raise InputError(f'{path} must be a folder of parts; features of aqorb 0.4 must be extracted anew')
    return path


def progress(given, total, unit, label=None):
    """Returns a progress bar, which shows on a terminal only."""
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
    """Escapes control characters, so that a name stays on one line and in one column."""
    return ''.join(character if character.isprintable() or '\udc80' <= character <= '\udcff' else repr(character)[1:-1]
                   for character in os.fsdecode(name))
