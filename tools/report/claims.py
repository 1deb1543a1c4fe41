# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""The tables of what is claimed of the selection, from the claims.csv that aqorb_claims wrote."""

import os

import pandas as pd

COLUMNS = {'claim': '', 'n': 'n', 'here': 'default', 'orb': 'cv::ORB', 'paper': "the paper's", 'asked': 'asked',
           'aim': 'aim', 'holds': 'holds'}
TITLE = 'What is claimed of the selection'


def claims_tables(folder):
    """One table with what is asked for, one with what is only told, and one of the times; of the first method.

    What stands there for one gap between frames is left to claims.csv."""
    rows = pd.read_csv(os.path.join(folder, 'claims.csv'), dtype=str, keep_default_na=False)
    rows = rows[rows['method'] == rows['method'].iloc[0]]
    rows = rows[~rows['claim'].str.contains(', gap ')]
    is_time = rows['claim'].str.startswith('CPU time')
    is_asked = rows['holds'] != ''
    return {title: rows.loc[which, list(COLUMNS)].rename(columns=COLUMNS)
            for title, which in ((TITLE, is_asked & ~is_time), (TITLE + ', more', ~is_asked & ~is_time),
                                 (TITLE + ', times', is_time))}
