#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# One check of the conformance suite in one process, as a debugger wants it.
binnacle-conform build/balloon.so --only 'balloon/bearings:life.calls' --level 5 --seed 1 --in-process
