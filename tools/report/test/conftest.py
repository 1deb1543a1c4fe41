# This file is part of the aqorb project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
