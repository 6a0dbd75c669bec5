# SPDX-License-Identifier: Apache-2.0
"""What the examples share: where configs are, and a picture that is shown or written."""

import argparse
import pathlib

CONFIGS = pathlib.Path(__file__).resolve().parents[3] / "configs"


def options(description, **numbers):
    """--picture FILE, and --NAME N for each of numbers, with what it is by default."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--picture", metavar="FILE", help="write the picture there (.png, .svg, .pdf) instead of showing it")
    for name, number in numbers.items():
        parser.add_argument(f"--{name}", type=type(number), default=number, metavar="N", help=f"by default {number}")
    given = parser.parse_args()
    if given.picture:
        import matplotlib

        matplotlib.use("Agg")  # needs no screen
    return given


def finish(figure, given):
    figure.tight_layout()
    if given.picture:
        figure.savefig(given.picture, dpi=100)
        print(f"{given.picture} is written")
    else:
        import matplotlib.pyplot

        matplotlib.pyplot.show()


def draw_error(axis, error, label, scale=1.0, color="C0"):
    """An error over time inside the filter's own ±3 sigma."""
    axis.plot(error.t, scale * error, color=color, linewidth=0.8, label=label)
    if error.sigma is not None:
        axis.fill_between(error.t, -3 * scale * error.sigma, 3 * scale * error.sigma, color=color, alpha=0.2, linewidth=0)
