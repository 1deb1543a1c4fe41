# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Prints the versions of the package and of OpenCV, the kernels and the number of threads."""

import sys

from aqorb import _build_information

if __name__ == '__main__':
    if sys.argv[1:] not in ([], ['--version']):
        sys.exit('the command aqorb is a package of its own; in a clone: pip install . ./photographs')
    print(_build_information())
