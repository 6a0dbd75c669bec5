# SPDX-License-Identifier: Apache-2.0
"""A measurement model of your own, in Python: a walker in the plane sees its distances to three beacons.

The model is a class; a config names it like any other. Data are arrays, so no file is needed.
"""

import binnacle as bn
import matplotlib.pyplot as plt
import numpy as np
from picture import finish, options


@bn.register
class BeaconRange(bn.MeasurementModel):
    """z = |x - p| + v."""

    spec = bn.Spec(
        "The distance from a point in the plane to a beacon.",
        parameters=[
            bn.vector("beacon", "m", 2).required().about("where the beacon stands"),
            bn.number("sigma", "m").above(0).defaults("0.5 m").about("of the white noise"),
        ],
        ports=[bn.reads("position", "vector:2:m").about("of the receiver")],
        fields=[bn.field("range", "m").about("the measured distance")],
        example={"channel": "range", "blocks": {"position": "position"}, "beacon": ["0 m", "100 m"]},
    )

    def __init__(self, binding):
        binding.reads("position")
        binding.group("range", rows=1, unit="m")
        self.beacon = binding.parameters["beacon"]
        self.variance = binding.parameters["sigma"] ** 2

    def linearize(self, sample, x):
        difference = x["position"] - self.beacon
        distance = np.linalg.norm(difference)
        if distance < 1:
            return bn.unsupported("closer than 1 m to the beacon")
        return sample["range"] - distance, {"position": difference[np.newaxis] / distance}, [self.variance]


given = options(__doc__.splitlines()[0], seed=1, steps=120)
print("conformance:", bn.conform(BeaconRange) or "nothing found")

# A random walk of 0.7 m/sqrt(s), and what a receiver with 0.5 m of noise measures once a second.
random = np.random.default_rng(given.seed)
t = np.arange(given.steps, dtype=float)
track = np.cumsum(random.normal(0, 0.7, (given.steps, 2)), axis=0)
beacons = {"north": (60, 0), "east": (0, 60), "south": (-40, -30)}
measured = {
    name: (t, {"range": ("m", np.linalg.norm(track - beacon, axis=1) + random.normal(0, 0.5, given.steps))})
    for name, beacon in beacons.items()
}

config = {
    "binnacle": 1,
    "filters": {
        "walker": {
            "blocks": {"position": {"type": "vector", "size": 2, "unit": "m", "sigma": "5 m"}},
            "process": {"walk": {"type": "random_walk", "blocks": {"x": "position"}, "q": "0.7 m/sqrt(s)"}},
            "measurements": {
                name: {"type": "beacon_range", "channel": name, "blocks": {"position": "position"},
                       "beacon": [f"{beacon[0]} m", f"{beacon[1]} m"], "gate": 0.999}
                for name, beacon in beacons.items()
            },
        }
    },
    "reference": [{"channel": "truth", "blocks": {"walker/position": ["north", "east"]}}],
    "evaluate": {"after": 0},
}  # fmt: skip
truth = (t, {"north": ("m", track[:, 0]), "east": ("m", track[:, 1])})
result = bn.parse(config, data={**measured, "truth": truth}).run()
print(result.summary)

position = result["walker"]["position"]
figure, (plane, error) = plt.subplots(1, 2, figsize=(11, 5))
plane.plot(track[:, 1], track[:, 0], color="black", linewidth=0.8, label="truth")
plane.plot(position[:, 1], position[:, 0], ".", color="C0", label="filter")
plane.plot([beacon[1] for beacon in beacons.values()], [beacon[0] for beacon in beacons.values()], "^", color="C3", label="beacons")
plane.set(aspect="equal", xlabel="east [m]", ylabel="north [m]")
plane.legend()
for i, color in enumerate(("C0", "C1")):
    of_axis = np.interp(position.t, t, track[:, i]) - position[:, i]
    error.plot(position.t, of_axis, color=color, label=("north", "east")[i])
    error.fill_between(position.t, -3 * position.sigma[:, i], 3 * position.sigma[:, i], color=color, alpha=0.2)
error.set(title="error inside ±3σ", xlabel="t [s]", ylabel="m")
error.legend()
finish(figure, given)
