# SPDX-License-Identifier: Apache-2.0
"""Many runs: is the covariance of a filter true? If so, the mean NEES over the runs lies within its band at 95 % of the times.

The quickstart takes the biases of its sensors for Gauss-Markov processes of 300 s. Those that are simulated are constant.
"""

from concurrent.futures import ThreadPoolExecutor

import binnacle as bn
import matplotlib.pyplot as plt
import numpy as np
from picture import CONFIGS, finish, options

BLOCKS = {"position": 3, "velocity": 3, "attitude": 3, "state": 9}  # degrees of freedom
CONSTANT = {f"/filters/ins/process/{name}/tau": "1e7 s" for name in ("gyro_drift", "accel_drift")}


def chi2_quantile(normal, dof):
    """Of the share that a standard normal variable has below `normal`; Wilson and Hilferty (1931), good for dof of 30 and more."""
    return dof * (1 - 2 / (9 * dof) + normal * np.sqrt(2 / (9 * dof))) ** 3


def mean_nees(config, runs, jobs):
    """{block: (t, mean over the runs)}, (n,) each. One composition runs in several threads at once: a run holds no lock of Python."""

    def nees_of(run):
        errors = config.run(seed=1, run=run, innovations=False).errors["ins"]
        return {block: errors[f"{block}.nees"] for block in BLOCKS}

    with ThreadPoolExecutor(jobs) as threads:
        each = list(threads.map(nees_of, range(runs)))
    return {block: (each[0][block].t, np.mean([nees[block] for nees in each], axis=0)) for block in BLOCKS}


given = options(__doc__.splitlines()[0], runs=100, jobs=2)
filters = {"biases drift": {}, "biases are constant": CONSTANT}
found = {
    name: mean_nees(bn.load(CONFIGS / "quickstart.json", set=settings), given.runs, given.jobs) for name, settings in filters.items()
}

figure, axes = plt.subplots(len(BLOCKS), 1, figsize=(9, 11), sharex=True)
for axis, (block, dof) in zip(axes, BLOCKS.items()):
    low, high = (chi2_quantile(normal, given.runs * dof) / given.runs for normal in (-1.959964, 1.959964))
    for name, nees_of in found.items():
        t, nees = nees_of[block]
        inside = np.mean((low < nees) & (nees < high))
        print(f"{block:8} of {dof}: mean NEES {nees.mean():6.3f}, within the band at {inside:4.0%} of the times, if {name}")
        axis.plot(t, nees, linewidth=0.8, label=name)
    axis.axhspan(low, high, color="C2", alpha=0.3)
    axis.set(ylabel=f"NEES of {block}")
axes[0].set(title=f"mean of {given.runs} runs, and the band in which 95 % of it lie if the covariance is true")
axes[0].legend()
axes[-1].set(xlabel="t [s]")
finish(figure, given)
