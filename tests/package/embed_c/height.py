#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The program in C, in Python: height.py LIBRARY CONFIG"""
import ctypes
import sys

library, config = sys.argv[1:]
binnacle = ctypes.CDLL(library)
binnacle.binnacle_last_error.restype = ctypes.c_char_p


def call(function, *arguments):
    if getattr(binnacle, function)(*arguments) != 0:
        sys.exit(binnacle.binnacle_last_error().decode())


composition, session = ctypes.c_void_p(), ctypes.c_void_p()
altimeter, height = ctypes.c_uint64(), ctypes.c_uint64()
call("binnacle_load", config.encode(), None, ctypes.byref(composition))
call("binnacle_open", composition, ctypes.c_uint64(0), ctypes.c_int32(0), ctypes.byref(session))
call("binnacle_find_channel", session, b"altimeter", ctypes.byref(altimeter))
call("binnacle_find_block", session, b"walk/height", ctypes.byref(height))

no_time = ctypes.c_int64(-(2**63))
for second in range(11):
    z = (ctypes.c_double * 1)(50.0 if second == 5 else 2.0)
    call("binnacle_push", session, altimeter, no_time, ctypes.c_int64(second * 10**9), z, ctypes.c_uint64(1))

estimate, sigma = (ctypes.c_double * 1)(), (ctypes.c_double * 1)()
call("binnacle_read", session, height, estimate, ctypes.c_uint64(1))
call("binnacle_read_sigma", session, height, sigma, ctypes.c_uint64(1))
print(f"height {estimate[0]:.2f} m, sigma {sigma[0]:.3f} m")
