# SPDX-License-Identifier: Apache-2.0
"""Two filters on the same data: what the velocity of a GNSS receiver adds to its position."""

import copy

import binnacle as bn
import matplotlib.pyplot as plt
import numpy as np
from picture import CONFIGS, draw_error, finish, options

given = options(__doc__, seed=1)

# A config is a dict: the second filter is a copy of the first without the model of the velocity.
config = bn.load(CONFIGS / "quickstart.json").config
config["filters"]["position_only"] = copy.deepcopy(config["filters"]["ins"])
del config["filters"]["position_only"]["measurements"]["fix"]["stack"]["velocity"]
blocks = config["reference"][0]["blocks"]
blocks.update({name.replace("ins/", "position_only/"): outputs for name, outputs in list(blocks.items())})

# Both see the same samples in one run, so that what differs is the filters'.
result = bn.parse(config, name=CONFIGS / "two_filters.json").run(seed=given.seed)

shown = {"position.north": ("m", 1), "velocity.north": ("m/s", 1), "attitude.yaw": ("deg", np.degrees(1))}
figure, axes = plt.subplots(len(shown), 1, figsize=(9, 9), sharex=True)
print("RMS of the error, and of what the filter takes for its sigma")
for axis, (name, (unit, scale)) in zip(axes, shown.items()):
    for color, (filter_name, of_filter) in zip(("C1", "C0"), result.errors.items()):
        error = of_filter[name]
        rms, sigma = (scale * np.sqrt(np.mean(x**2)) for x in (error, error.sigma))
        print(f"  {name:15} {filter_name:14} {rms:8.4f} {sigma:8.4f} {unit}")
        draw_error(axis, error, filter_name, scale, color)
    axis.set(ylabel=f"{name} error [{unit}]")
axes[0].legend()
axes[-1].set(xlabel="t [s]")
finish(figure, given)
