#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Where one machine has its things, and where all have.
scratch=${TMPDIR:-/@tmp}/x
data=../@work/data
cd /@work/main  # bad
out="/@tmp/out.csv"  # bad
rm -r "$HOME/@tmp/x" /@root  # bad
