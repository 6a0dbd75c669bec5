# SPDX-License-Identifier: Apache-2.0
"""Configs that run by themselves, of any length, and one that is fed."""

import math


def drive(duration_s=2000, rate="1 Hz"):
    """A target tracked by its bearing from a ship, which turns once halfway; filter `track`, a record for each sample."""
    half = f"{duration_s / 2:.0f} s"
    return {
        "binnacle": 1,
        "sources": {"ship": {"type": "target_simulator", "duration": f"{duration_s:.0f} s", "rate": rate, "sigma": "0.1 deg",
                             "target": {"position": ["5 km", 0], "velocity": 0, "position_sigma": ["1.5 km", "10 m"],
                                        "velocity_sigma": "1 m/s", "q": 0.02},
                             "legs": [{"duration": half, "velocity": [0, 10]}, {"duration": half, "velocity": [0, -10]}]}},
        "filters": {"track": {
            "trust": False,
            "blocks": {"position": {"type": "vector", "size": 2, "unit": "m", "components": ["north", "east"], "init": ["5 km", 0],
                                    "sigma": ["1.5 km", "10 m"]},
                       "velocity": {"type": "vector", "size": 2, "unit": "m/s", "components": ["vn", "ve"], "init": 0, "sigma": "1 m/s"}},
            "process": {"move": {"type": "integrated", "blocks": {"x": "position", "rate": "velocity"}},
                        "wander": {"type": "random_walk", "blocks": {"x": "velocity"}, "q": 0.02}},
            "measurements": {"sonar": {"type": "bearing", "channel": "ship.bearing", "blocks": {"target": "position"}, "sigma": "0.1 deg"}}}},
        "reference": [{"channel": "ship.truth", "blocks": {"track/position": ["north", "east"]}}],
    }


def live_drive():
    """The drive's filter, live: its bearings come by standard input, a line of JSON each."""
    config = drive()
    fields = {"azimuth": {"unit": "rad"}, "observer_north": {"unit": "m"}, "observer_east": {"unit": "m"}}
    config["sources"] = {"ship": {"type": "stream/json", "from": "stdin:", "channels": {"bearing": {"fields": fields}}}}
    del config["reference"]
    return config


def bearing(t):
    """The line of the live drive at t seconds: a target 5 km ahead, seen from a ship that goes to and fro."""
    east = 500 * math.sin(t / 100)
    azimuth = math.atan2(-east, 5000) + 0.0017 * math.sin(12.9898 * t * t)
    return f'{{"channel": "bearing", "t": {t}, "azimuth": {azimuth:.9f}, "observer_north": 0, "observer_east": {east:.6f}}}\n'


def study(runs, duration_s=2000, seed=3):
    """The drive, many times."""
    return drive(duration_s) | {"study": {"runs": runs, "seed": seed, "metrics": ["track/position.norm/final"]}}


def copied(path, rows="x.csv"):
    """A drive whose sink copies samples of a table, `t,b` in turns a second, to a file."""
    config = drive()
    config["sources"]["gyro"] = {"type": "csv", "path": rows, "columns": {"wx": {"column": "b", "unit": "rad/s", "kind": "rate"}}}
    config["sinks"] = {"copy": {"type": "csv_writer", "input": "gyro", "path": str(path), "columns": {"wx": {"unit": "rad/s"}}}}
    return config
