# SPDX-License-Identifier: Apache-2.0
"""Many runs of one filter: is its covariance true? The mean NEES over the runs lies within its band if it is."""

from concurrent.futures import ThreadPoolExecutor

import binnacle as bn
import matplotlib.pyplot as plt
import numpy as np
from picture import CONFIGS, finish, options


def chi2_quantile(share, dof):
    """By Wilson and Hilferty (1931), within a percent for dof of 30 and more; share 0.025 or 0.975."""
    normal = {0.025: -1.959964, 0.975: 1.959964}[share]
    return dof * (1 - 2 / (9 * dof) + normal * np.sqrt(2 / (9 * dof))) ** 3


given = options(__doc__, runs=100, jobs=2)

BLOCKS = ("position", "velocity", "attitude")
config = bn.load(CONFIGS / "quickstart.json")


def nees_of(run):
    """The NEES of each block in one run, (n,) each. Of the rest nothing is kept."""
    errors = config.run(seed=1, run=run, innovations=False).errors["ins"]
    return {block: errors[f"{block}.nees"] for block in BLOCKS}


# One composition runs in several threads at once: a run holds no lock of Python.
with ThreadPoolExecutor(given.jobs) as threads:
    runs = list(threads.map(nees_of, range(given.runs)))

figure, axes = plt.subplots(3, 1, figsize=(9, 9), sharex=True)
for axis, block in zip(axes, BLOCKS):
    nees = np.mean([run[block] for run in runs], axis=0)
    t, dof = runs[0][block].t, 3
    low, high = (chi2_quantile(share, given.runs * dof) / given.runs for share in (0.025, 0.975))
    inside = np.mean((low < nees) & (nees < high))
    print(f"{block:9} mean NEES {nees.mean():.3f} of {dof}; within the 95 % band of {given.runs} runs at {inside:.0%} of the times")
    axis.plot(t, nees, linewidth=0.8)
    axis.axhspan(low, high, color="C2", alpha=0.3)
    axis.set(ylabel=f"NEES of {block}")
axes[0].set(title=f"mean of {given.runs} runs, and the band in which 95 % of it lie if the covariance is true")
axes[-1].set(xlabel="t [s]")
finish(figure, given)
