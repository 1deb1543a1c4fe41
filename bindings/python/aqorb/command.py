# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The command aqorb: features of a folder of images, their matches, and pictures of matches. A sub-command is a module
with a function add, which adds its arguments and says which function runs it."""

import argparse
import os
import sqlite3
import sys
import warnings

import aqorb
from aqorb import _stop

NEEDS = ('the command needs packages that are not installed with aqorb: pip install pillow pyarrow pycolmap scipy '
         'tqdm')


def main(arguments=None):
    _stop.begin()
    for name in 'stdout', 'stderr':
        if getattr(sys, name) is None:  # it was closed
            setattr(sys, name, open(os.devnull, 'w'))
        if hasattr(getattr(sys, name), 'reconfigure'):
            getattr(sys, name).reconfigure(errors='backslashreplace')  # a name that cannot be shown is no failure
    # Arrow's own allocator gives less back, so that memory would grow with the folder.
    os.environ.setdefault('ARROW_DEFAULT_MEMORY_POOL', 'system')
    warnings.simplefilter('ignore')  # what decoders say of images that they can read

    from aqorb import _draw, _extract, _match, _places
    parser = argparse.ArgumentParser(prog='aqorb', description=__doc__.split('. ')[0])
    parser.add_argument('--version', action='version', version=aqorb._build_information())
    commands = parser.add_subparsers(required=True, metavar='COMMAND')
    for module in _extract, _match, _places, _draw:
        module.add(commands)
    try:
        try:
            options = parser.parse_args(arguments)
            options.run(options)
        finally:
            sys.stdout.flush()
    except ImportError as error:
        sys.exit(f'aqorb: {error}; {NEEDS}')
    except OSError as error:
        if isinstance(error.filename, (bytes, str)):
            sys.exit(f'aqorb: {os.fsdecode(error.filename)}: {error.strerror}')
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # the output, if it is what cannot be written, is not tried again
        sys.exit(f'aqorb: {error}')
    except MemoryError:
        sys.exit('aqorb: there is not enough memory')
    except (ValueError, EOFError, RuntimeError, sqlite3.Error) as error:
        sys.exit(f'aqorb: {" ".join(str(error).split())}')


# What several sub-commands share.

def at_least(least):
    def number(text):
        if not least <= int(text) < 2**31:
            raise argparse.ArgumentTypeError(f'{text} is not from {least} to {2**31 - 1}')
        return int(text)
    return number


positive = at_least(1)


def add_image_options(parser):
    """How images are read, and how many features are detected."""
    parser.add_argument('--num-features', type=positive, default=1000, metavar='N',
                        help='features of an image, at most (%(default)s)')
    parser.add_argument('--max-size', type=positive, metavar='PIXELS', help='reduce images whose longer side is longer')
    parser.add_argument('--ignore-orientation', action='store_true',
                        help='do not turn images as their EXIF data say; COLMAP does not')


def add_threads(parser):
    count = len(os.sched_getaffinity(0)) if hasattr(os, 'sched_getaffinity') else os.cpu_count()
    parser.add_argument('--threads', type=positive, default=count, metavar='N', help='as many as processors by default')


def add_overwrite(parser):
    parser.add_argument('--overwrite', action='store_true', help='replace a file that exists')


def count_of(number, noun, plural='s'):
    return f'{number} {noun}{"" if number == 1 else plural}'


def shown(path):
    """A path on one line, and in one column."""
    return os.fsdecode(path).translate({ord(character): repr(character)[1:-1] for character in '\t\n\r'})


def open_file(folder, path):
    path = os.path.join(folder, path)
    if not os.path.isfile(path):
        raise ValueError('it is no regular file' if os.path.exists(path) else 'there is no such file')
    return open(path, 'rb')
