#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Simulates the cell of battery.json and prints battery.csv: python3 configs/gallery/battery.py > configs/gallery/battery.csv

A lithium-ion cell of 2.5 A h: a curved open-circuit voltage, a resistor, one RC pair, a load that wanders. Nothing of it is the
filter's: the curve is not straight, and the differential equations are integrated in steps of 10 ms.
"""
import math
import random

CAPACITY = 2.5 * 3600  # A s
R0, R1, C1 = 0.020, 0.015, 2000.0  # ohm, ohm, farad
MEAN, DEVIATION, CORRELATION = 1.8, 2.0, 10.0  # of the load: A, A, s
CURRENT_NOISE, VOLTAGE_NOISE = 0.05, 0.005  # of the sensors: A, V
STEP, EVERY, DURATION = 0.01, 2.0, 2400.0  # s


def open_circuit_voltage(charge):
    """A made-up curve of the shape that NMC cells have between 20 and 95 %: volts."""
    return 3.25 + 0.95 * charge + 0.012 * math.sin(2 * math.pi * charge / 0.6)


def main():
    draw = random.Random(1)
    charge, pair, current = 0.93, 0.0, MEAN
    decay = math.exp(-STEP / CORRELATION)
    steps = round(EVERY / STEP)
    print("t_s,current_A,voltage_V,true_charge,true_pair_V,true_current_A")
    for sample in range(round(DURATION / EVERY) + 1):
        measured = current + draw.gauss(0, CURRENT_NOISE)
        voltage = open_circuit_voltage(charge) - pair - R0 * current + draw.gauss(0, VOLTAGE_NOISE)
        print(f"{sample * EVERY:.0f},{measured:.3f},{voltage:.4f},{charge:.5f},{pair:.5f},{current:.3f}")
        for _ in range(steps):
            charge -= STEP * current / CAPACITY
            pair += STEP * (current - pair / R1) / C1
            current = MEAN + decay * (current - MEAN) + DEVIATION * math.sqrt(1 - decay * decay) * draw.gauss(0, 1)


if __name__ == "__main__":
    main()
