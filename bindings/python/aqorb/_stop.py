# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""What Ctrl-C does to the command aqorb, from its first moment: the package imports this before what takes time."""

import os
import signal
import sys


def stop(*_):
    """Ends the process at any moment: what it leaves is what the same command goes on with."""
    os.write(2, b'\naqorb: stopped; the same command goes on\n')
    os._exit(130)


def begin():
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, stop)


def finish():
    """From now on Ctrl-C is ignored, as the command ends in a moment."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


if getattr(sys, 'orig_argv', [])[1:3] == ['-m', 'aqorb'] or os.path.basename((sys.argv or [''])[0]) == 'aqorb':
    begin()  # it is the command, and not a program that imports the package
