# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Folders of photographs, for the command aqorb, pipelines on clusters, and programs.

images finds and decodes files, store keeps features and matches in folders of Parquet parts, places finds images of the
same place, tracks refines positions, and colmap writes a COLMAP database."""

import collections


class InputError(ValueError):
    """An invalid input; the message is a sentence for the user."""


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
