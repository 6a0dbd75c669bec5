# SPDX-License-Identifier: Apache-2.0
"""The quickstart: run a filter on a simulated drive, and look at its track, its errors and its innovations."""

import binnacle as bn
import matplotlib.pyplot as plt
import numpy as np
from picture import CONFIGS, draw_error, finish, options

given = options(__doc__, seed=1)

# A config is checked and composed by load(), and run as often as wanted.
result = bn.load(CONFIGS / "quickstart.json").run(seed=given.seed)
print(result.summary)

# Results are arrays by name; each has its times, and its 1-sigma where the filter knows it.
ins = result["ins"]
errors, fix = ins.errors, ins.innovations["fix"]
lat, lon = ins["position.lat"], ins["position.lon"]
north = (lat - lat[0]) * 6.37e6
east = (lon - lon[0]) * 6.37e6 * np.cos(lat[0])

figure, ((track, position), (yaw, nis)) = plt.subplots(2, 2, figsize=(11, 8))
track.plot(east, north)
track.set(title="track", xlabel="east [m]", ylabel="north [m]", aspect="equal")
for color, name in zip(("C0", "C1"), ("north", "east")):
    draw_error(position, errors[f"position.{name}"], name, color=color)
position.set(title="position error inside ±3σ", xlabel="t [s]", ylabel="m")
position.legend()
draw_error(yaw, errors["attitude.yaw"], "yaw", scale=np.degrees(1))
yaw.set(title="yaw error inside ±3σ", xlabel="t [s]", ylabel="deg")
nis.plot(fix.t[fix.accepted], fix.nis[fix.accepted], ".")
nis.axhline(fix.rows[fix.accepted].mean(), color="black", linewidth=0.8)
nis.set(title="NIS of the fixes, and their degrees of freedom", xlabel="t [s]")
finish(figure, given)
