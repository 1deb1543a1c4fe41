# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Folders of photographs, for the command aqorb, pipelines on clusters, and programs.

images finds and decodes files, store keeps features and matches in folders of Parquet parts, places finds images of the
same place, tracks refines positions, and colmap writes a COLMAP database."""

import collections
import os
import traceback

import aqorb


class InputError(ValueError):
    """An invalid input; the message is a sentence for the user."""


def sentence_of(error):
    """Returns the message of an error. An error that is neither raised for an input nor by a decoder is a fault: the message
    says so, and how to report it. If the environment has AQORB_TRACEBACK, prints the traceback."""
    if os.environ.get('AQORB_TRACEBACK'):
        traceback.print_exception(type(error), error, error.__traceback__)
    text = getattr(error, 'strerror', None) or str(error) or type(error).__name__
    modules = [frame.f_globals['__name__'].partition('.')[0] for frame, _ in traceback.walk_tb(error.__traceback__)]
    # Decoders raise errors of any kind for damaged files.
    is_of_decoder = 'PIL' in modules or 'pillow_heif' in modules
    if is_of_decoder or isinstance(error, (InputError, aqorb.error, ImportError, MemoryError, OSError)):
        return text
    return (f'unforeseen {type(error).__name__}: {text}. Please report this fault of aqorb, with the traceback that the '
            'command prints if the environment has AQORB_TRACEBACK=1')


def map_ahead(pool, function, items, count):
    """Yields each item with the function's value. The pool works on `count` items ahead of the consumer."""
    ahead = collections.deque()
    try:
        for item in items:
            ahead.append((item, pool.submit(function, item)))
            if len(ahead) > count:
                item, future = ahead.popleft()
                yield item, future.result()
        while ahead:
            item, future = ahead.popleft()
            yield item, future.result()
    finally:  # a stopped consumer does not wait for the others
        for _, future in ahead:
            future.cancel()
