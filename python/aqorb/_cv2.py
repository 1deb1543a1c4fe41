# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Parts of the package that need cv2. Importing this module imports cv2."""

import importlib

bases: list = [ValueError]
try:
    import cv2
    bases.insert(0, cv2.error)
except Exception:  # cv2 is missing or does not work
    pass

error = type('error', tuple(bases), {'__module__': 'aqorb', '__doc__': """Raised for an invalid argument, which the
message names. It is a ValueError and, with cv2, a cv2.error."""})
memory_error = type('memory_error', (error, MemoryError), {'__module__': 'aqorb._cv2'})


def named(name, instead):
    """Returns a class of cv2."""
    try:
        return getattr(importlib.import_module('cv2'), name)
    except (ImportError, AttributeError) as reason:  # the empty folder cv2 of an old installation has no names
        raise ImportError(f'cv2 does not work: {reason}. The result consists of objects of cv2. Install '
                          f'opencv-python-headless, which needs no libGL, or call {instead}') from reason
