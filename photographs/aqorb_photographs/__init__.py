# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Folders of photographs, for the command aqorb, pipelines on clusters, and programs.

images finds and decodes files, store keeps features and matches in folders of Parquet parts, places finds the images
that show the same place, tracks refines positions, and colmap writes a database of COLMAP."""

import collections


class Refused(ValueError):
    """What is not done, in a sentence for the user."""


def map_ahead(pool, function, items, count):
    """Yields each item with the function's value. So many items are worked on, or done, before they are asked for."""
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
    finally:  # whoever is stopped does not wait for them
        for _, future in ahead:
            future.cancel()
