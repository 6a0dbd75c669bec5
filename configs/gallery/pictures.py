#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs each config of the gallery and draws NAME.svg: true errors (red) inside the filter's own 3 sigma (blue).

    python3 configs/gallery/pictures.py [--binnacle build/release/bin/binnacle] [NAME…]

It reads the run.nc of each run by h5py, and draws every n-th sample, some 220 of a curve.
"""
import argparse
import math
import pathlib
import subprocess
import tempfile

import h5py

HERE = pathlib.Path(__file__).resolve().parent
POINTS = 220
WIDTH, HEIGHT, LEFT, TOP, GAP = 880, 250, 60, 34, 70  # of the picture, and of its panels
M, DEG = (1, "m"), (math.degrees(1), "deg")
DEG_H = (3600 * math.degrees(1), "deg/h")

# Name of the run: panels (block, component or output, scale and unit), and stretches of time with a grey ground.
PICTURES = {
    "loose-ins-gnss": ([("position", "north", M), ("attitude", "yaw", DEG), ("gyro_bias", "z", DEG_H)], []),
    "tight-ins-gnss": ([("position", "east", M), ("attitude", "yaw", DEG), ("clock", "bias", M)], [(150, 210)]),
    "car-wheels": ([("position", "north", M), ("attitude", "yaw", DEG), ("mounting", "z", DEG)], [(150, 210), (300, 360), (450, 510)]),
    "uwb-indoors": ([("position", "north", M), ("position", "down", M), ("attitude", "yaw", DEG)], []),
    "underwater-dvl": ([("position", "north", M), ("position", "east", M), ("attitude", "yaw", DEG)], [(60, 1630)]),
    "foot-zupt": ([("position", "north", M), ("position", "down", M), ("attitude", "yaw", DEG)], []),
    "transfer-alignment": ([("attitude", "east", DEG), ("attitude", "down", DEG), ("mounting", "z", DEG)], []),
    "ship-motion": ([("pitch", "angle", DEG), ("rate", "rate", (DEG[0], "deg/s")), ("error", "error", DEG)], []),
    "target-tracking": ([("position", "north", M), ("position", "east", M), ("velocity", "north", (1, "m/s"))], []),
    "battery": ([("cell", "charge", (100, "%")), ("cell", "pair", (1000, "mV")), ("cell", "current", (1, "A"))], []),
    "attitude-magnetometer": ([("attitude", "roll", DEG), ("attitude", "yaw", DEG), ("hard_iron", "x", (1e6, "uT"))], []),
}


def run(binnacle, name, folder):
    """The errors that the run left: its only filter's group of run.nc, open."""
    subprocess.run([binnacle, "run", HERE / f"{name}.json", "--out", folder, "--only", "nc", "--quiet"], check=True)
    record = h5py.File(folder / "run.nc", "r")
    return next(group["errors"] for group in record.values() if isinstance(group, h5py.Group) and "errors" in group)


def names_of(errors, block):
    return ["".join(letter.decode() for letter in row).rstrip("\0") for row in errors[f"{block}_component"][:]]


def curve(errors, block, what, scale):
    """Times, errors and sigmas, every n-th of them, without those that are not numbers."""
    series = f"{block}_{what}" if f"{block}_{what}" in errors else block
    values, sigmas, times = errors[series][:], errors[f"{series}_sigma"][:], errors[series].dims[0][0][:]
    if series == block:
        column = names_of(errors, block).index(what)
        values, sigmas = values[:, column], sigmas[:, column]
    rows = [row for row in zip(times, scale * values, scale * sigmas) if all(x == x for x in row)]
    return rows[:: max(1, len(rows) // POINTS)]


def ticks(low, high, count):
    """At most so many round numbers from low to high."""
    power = 10 ** math.floor(math.log10((high - low) / count))
    step = next(step for step in (power, 2 * power, 5 * power, 10 * power) if step * count >= high - low)
    return [i * step for i in range(math.ceil(low / step), math.floor(high / step) + 1)]


def path(points):
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points)


def panel(index, count, rows, title, unit, shades):
    """The lines of SVG of one panel."""
    width = (WIDTH - LEFT - 12 - GAP * (count - 1)) / count
    left, height = LEFT + index * (width + GAP), HEIGHT - TOP - 46
    begin, end = rows[0][0], rows[-1][0]
    settled = [row for row in rows if row[0] >= begin + 0.05 * (end - begin)]
    top = 1.1 * max(max(abs(e), 3 * s) for _, e, s in settled)

    def x_of(t):
        return left + width * (t - begin) / (end - begin)

    def y_of(e):
        return TOP + height * (0.5 - 0.5 * e / top)

    lines = [f'<clipPath id="c{index}"><rect x="{left:.1f}" y="{TOP}" width="{width:.1f}" height="{height}"/></clipPath>',
             f'<text x="{left:.1f}" y="20" font-weight="bold">{title} [{unit}]</text>']
    for first, last in shades:
        lines.append(f'<rect x="{x_of(first):.1f}" y="{TOP}" width="{x_of(last) - x_of(first):.1f}" height="{height}" fill="#eee"/>')
    for t in ticks(begin, end, 4):
        lines.append(f'<text x="{x_of(t):.1f}" y="{TOP + height + 14}" text-anchor="middle">{t:g}</text>')
    for e in ticks(-top, top, 4):
        lines.append(f'<path d="M{left:.1f} {y_of(e):.1f}h{width:.1f}" stroke="#ddd"/>'
                     f'<text x="{left - 4:.1f}" y="{y_of(e) + 4:.1f}" text-anchor="end">{e:g}</text>')
    band = [(x_of(t), y_of(3 * s)) for t, _, s in rows] + [(x_of(t), y_of(-3 * s)) for t, _, s in reversed(rows)]
    lines += [f'<path clip-path="url(#c{index})" fill="#1f6fb2" fill-opacity="0.2" stroke="#1f6fb2" stroke-width="0.8" d="{path(band)}Z"/>',
              f'<path clip-path="url(#c{index})" fill="none" stroke="#c0392b" d="{path([(x_of(t), y_of(e)) for t, e, _ in rows])}"/>',
              f'<rect x="{left:.1f}" y="{TOP}" width="{width:.1f}" height="{height}" fill="none" stroke="#bbb"/>',
              f'<text x="{left + width / 2:.1f}" y="{HEIGHT - 12}" text-anchor="middle">time [s]</text>']
    return lines


def picture(name, errors):
    panels, shades = PICTURES[name]
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="11" fill="#333">',
             f"<title>configs/gallery/{name}.json: true error inside the filter's own 3 sigma</title>",
             f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>']
    for index, (block, what, (scale, unit)) in enumerate(panels):
        title = f"{block} {what}".replace("_", " ") if block != what else block
        lines += panel(index, len(panels), curve(errors, block, what, scale), title, unit, shades)
    return "\n".join([*lines, "</svg>"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--binnacle", default="binnacle", help="the command (default: the one in PATH)")
    parser.add_argument("--to", type=pathlib.Path, default=HERE, metavar="DIR", help="where to write them (default: beside the configs)")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(PICTURES)} (default: all)")
    given = parser.parse_args()
    for name in given.names or PICTURES:
        with tempfile.TemporaryDirectory() as folder:
            (given.to / f"{name}.svg").write_text(picture(name, run(given.binnacle, name, pathlib.Path(folder))))
        print(f"{name}.svg")


if __name__ == "__main__":
    main()
