# SPDX-License-Identifier: Apache-2.0
"""Your own data: CSV files of an IMU and of a GNSS receiver are looked at first, and then filtered with what was found.

The files are those of the tutorial. What one would not know of them is left open: the receiver's clock and how the IMU is mounted.
"""

import binnacle as bn
import matplotlib.pyplot as plt
import numpy as np
from picture import CONFIGS, draw_error, finish, options

given = options(__doc__.splitlines()[0])
folder = CONFIGS / "tutorial"

# 1. Look at the data: units, signs, clocks, axes, each finding with its evidence.
inspection = bn.inspect(folder / "imu.csv", folder / "gnss.csv")
findings = {finding["kind"]: finding for finding in inspection["findings"] if finding["meaning"]}
for kind, finding in findings.items():
    print(f"{kind:10} {finding['text']}")

# 2. Put what was found into the config. A finding's "meaning" is a piece of a config.
offset = findings["delay"]["meaning"]["sources"]["gnss"]["time"]["offset"]
mounting = findings["mounting"]["meaning"]["transforms"]["vehicle"]
config = bn.load(
    folder / "drive.json",
    vars={"data": folder},
    set={"/sources/gnss/time/offset": offset, "/transforms/imu": {**mounting, "input": "raw_imu"}},
)

# 3. Filter. The truth in the tutorial's third file only judges it.
result = config.run()
ins = result["ins"]
print(f"\nverdict: {result.verdict}")
for name, unit, scale in (("position.horizontal", "m", 1), ("attitude.tilt", "deg", np.degrees(1)), ("attitude.yaw", "deg", np.degrees(1))):
    print(f"{name:20} {scale * np.sqrt(np.mean(ins.errors[name] ** 2)):6.3f} {unit} RMS")

gnss = np.genfromtxt(folder / "gnss.csv", delimiter=",", names=True)
figure, ((track, clock), (position, yaw)) = plt.subplots(2, 2, figsize=(11, 8))
track.plot(gnss["lon_deg"], gnss["lat_deg"], ".", label="GNSS")
track.plot(np.degrees(ins["position.lon"]), np.degrees(ins["position.lat"]), label="filter")
track.set(title="track", xlabel="lon [deg]", ylabel="lat [deg]")
track.legend()
speed = np.hypot(gnss["vn_mps"], gnss["ve_mps"])
clock.plot(gnss["utc_s"], speed, ".", label="GNSS, by its own clock")
clock.plot(ins.t, np.hypot(ins["velocity.vn"], ins["velocity.ve"]), label="filter, by the IMU's clock")
clock.set(title=findings["delay"]["text"].split(" (")[0], xlabel="t [s]", ylabel="speed [m/s]")
clock.legend()
for color, name in zip(("C0", "C1"), ("north", "east")):
    draw_error(position, ins.errors[f"position.{name}"], name, color=color)
position.set(title="position error inside ±3σ", xlabel="t [s]", ylabel="m")
position.legend()
draw_error(yaw, ins.errors["attitude.yaw"], "yaw", scale=np.degrees(1))
yaw.set(title="yaw error inside ±3σ", xlabel="t [s]", ylabel="deg")
finish(figure, given)
