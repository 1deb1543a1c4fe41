# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
import claims

CSV = '''method,claim,n,here,orb,paper,asked,aim,holds
aqorb,distinct,500,1.499,1.000,1.287,at least 1.380,at least 1.550,yes
aqorb,places,1000,81.3,42.7,77.6,,,
aqorb,CPU time of a frame,1000,1.432,2.582,1.000,at most 1.050,,no
aqorb:strength=1,distinct,500,1.2,1.000,1.287,at least 1.380,at least 1.550,no
'''


def test_tables_of_the_first_method(tmp_path):
    (tmp_path / 'claims.csv').write_text(CSV)
    tables = claims.claims_tables(str(tmp_path))
    assert [table.values.tolist() for table in tables.values()] == [
        [['distinct', '500', '1.499', '1.000', '1.287', 'at least 1.380', 'at least 1.550', 'yes']],
        [['places', '1000', '81.3', '42.7', '77.6', '', '', '']],
        [['CPU time of a frame', '1000', '1.432', '2.582', '1.000', 'at most 1.050', '', 'no']]]
