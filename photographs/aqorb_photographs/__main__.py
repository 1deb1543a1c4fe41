# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The entry point of the command aqorb."""

import argparse
import os
import sys
import warnings

import aqorb
from aqorb_photographs import sentence_of
from aqorb_photographs.cli import colmap, draw, extract, match, options, pairs, search


def main(arguments=None):
    try:
        code = call(arguments)
    except KeyboardInterrupt:
        print('\naqorb: stopped; the same command goes on', file=sys.stderr, flush=True)
        os._exit(130)  # without waiting for threads
    sys.exit(code)


def call(arguments):
    """Runs the command, and returns its exit code or an error message."""
    for name in 'stdout', 'stderr':
        if getattr(sys, name) is None:  # closed
            setattr(sys, name, open(os.devnull, 'w'))
        if hasattr(getattr(sys, name), 'reconfigure'):
            getattr(sys, name).reconfigure(errors='backslashreplace')  # for names that cannot be printed
    # Arrow's own allocator returns less memory, so memory would grow with the folder.
    os.environ.setdefault('ARROW_DEFAULT_MEMORY_POOL', 'system')
    warnings.simplefilter('ignore')  # decoders warn about readable images

    parser = argparse.ArgumentParser(prog='aqorb', description='Features and matches of photographs.')
    parser.add_argument('--version', action='version', version=aqorb._build_information())
    commands = parser.add_subparsers(required=True, metavar='COMMAND')
    for module in extract, match, pairs, search, colmap, draw:
        module.add(commands)
    try:
        try:
            given = parser.parse_args(arguments)
            return given.run(given)
        finally:
            sys.stdout.flush()
    except Exception as error:
        text = options.shown(' '.join(sentence_of(error).split()))
        if isinstance(error, ImportError):
            text += '. To install all packages, in a clone of aqorb: pip install . ./photographs'
        elif isinstance(error, OSError) and isinstance(error.filename, (bytes, str)):
            text = f'{options.shown(os.fsdecode(error.filename))}: {text}'
        elif isinstance(error, OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # keeps the exit from writing to a broken output again
        elif isinstance(error, MemoryError):
            text = 'there is not enough memory'
        return 0 if isinstance(error, BrokenPipeError) else f'aqorb: {text}'  # | head closes the pipe


if __name__ == '__main__':
    main()
