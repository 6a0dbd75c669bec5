# SPDX-License-Identifier: Apache-2.0
"""Tuning: the noise of the quickstart's fixes, from starts that are five times off, by the likelihood of the innovations."""

import binnacle as bn
import matplotlib.pyplot as plt
import numpy as np
from picture import CONFIGS, finish, options

given = options(__doc__, seed=1, jobs=2)
SCALES = {"position": 5, "velocity": 0.2}
stack = "/filters/ins/measurements/fix/stack"

config = {
    "extends": "quickstart.json",
    "filters": {"ins": {"measurements": {"fix": {"stack": {name: {"scale": scale} for name, scale in SCALES.items()}}}}},
    "tune": {"parameters": {f"{stack}/{name}/scale": {} for name in SCALES}, "until": "start+180 s"},
}
before = bn.parse(config, name=CONFIGS / "tuning.json")
tuning = before.tune(seed=given.seed, jobs=given.jobs)
print(tuning)

# What it found is a merge patch, which a config extended by it takes.
after = bn.parse({"extends": "quickstart.json", **tuning.patch}, name=CONFIGS / "tuned.json")

figure, (values, nis) = plt.subplots(1, 2, figsize=(11, 5), width_ratios=(1, 2))
names = [parameter["name"].split("/")[-2] for parameter in tuning["parameters"]]
ends = np.array([parameter["end"] for parameter in tuning["parameters"]])
errors = np.array([parameter["standard_error"] for parameter in tuning["parameters"]])
values.plot(names, [SCALES[name] for name in names], "v", color="C1", label="start")
values.errorbar(names, ends, 2 * errors * ends, fmt="o", color="C0", capsize=5, label="end, ±2 standard errors")
values.axhline(1, color="black", linewidth=0.8, label="as simulated")
values.set(yscale="log", title="scale of sigma")
values.margins(x=0.5)
values.legend()
for label, tuned, color in (("start", before, "C1"), ("end", after, "C0")):
    fix = tuned.run(seed=given.seed, records=False)["ins"].innovations["fix"]
    nis.plot(fix.t[fix.accepted], fix.nis[fix.accepted], ".", color=color, label=f"{label}: {np.mean(fix.accepted):.0%} accepted")
nis.axhline(6, color="black", linewidth=0.8, label="degrees of freedom")
nis.set(yscale="log", title="NIS of the fixes", xlabel="t [s]")
nis.legend()
finish(figure, given)
