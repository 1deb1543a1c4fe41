# This file is part of aqorb. Copyright (C) The aqorb developers.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution.
# SPDX-License-Identifier: Apache-2.0
"""Tests of damaged parts and of kills, the short form of hostile.py."""

import random

import hostile
from command_support import LINUX, pq


def test_flipped_bits(features, tmp_path):
    found = hostile.flips(100, random.Random(1), features, tmp_path / 'damaged')
    assert set(found) == {'a sentence', 'the same rows'} and found['a sentence'] > 50


def test_parts_that_no_command_has_made(features, tmp_path):
    assert set(hostile.odd_parts(pq.read_table(str(features)), tmp_path / 'odd')) == {'a sentence'}


@LINUX
def test_kills(folder, tmp_path):
    seed = random.randrange(1 << 32)
    found = hostile.kills(9, random.Random(seed), str(tmp_path), str(folder))
    assert found['the same rows'] == 9, f'seed {seed}: {found}'
