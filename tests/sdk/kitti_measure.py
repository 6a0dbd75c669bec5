# SPDX-License-Identifier: Apache-2.0
# KITTI's odometry measure as its devkit has it (evaluate_odometry.cpp: trajectoryDistances, lastFrameFromSegmentLength,
# calcSequenceErrors), of 4x4 poses; poses of a run's CSV and of a CSV of truth, in the axes of the first true position.
#   kitti_measure.py ESTIMATES TRUTH EVERY START_EVERY LENGTH...
import csv
import math
import sys

import numpy

A, F = 6378137.0, 1 / 298.257223563
E2 = F * (2 - F)


def ecef(lat, lon, height):
    n = A / math.sqrt(1 - E2 * math.sin(lat) ** 2)
    return numpy.array([(n + height) * math.cos(lat) * math.cos(lon), (n + height) * math.cos(lat) * math.sin(lon),
                        (n * (1 - E2) + height) * math.sin(lat)])


def north_east_down(lat, lon):
    """Columns: north, east, down in ECEF."""
    sl, cl, so, co = math.sin(lat), math.cos(lat), math.sin(lon), math.cos(lon)
    return numpy.array([[-sl * co, -so, -cl * co], [-sl * so, co, -cl * so], [cl, 0, -sl]])


def turns(roll, pitch, yaw):
    """Body to north, east, down."""
    def about(axis, angle):
        c, s, i, j = math.cos(angle), math.sin(angle), (axis + 1) % 3, (axis + 2) % 3
        R = numpy.eye(3)
        R[i, i] = R[j, j] = c
        R[j, i], R[i, j] = s, -s
        return R
    return about(2, yaw) @ about(1, pitch) @ about(0, roll)


def read(path, prefixes):
    with open(path) as file:
        rows = list(csv.reader(file))
    names = [cell.split("[")[0] for cell in rows[0]]
    columns = [names.index(prefix + name) for prefix, name in
               zip(prefixes, ["", "lat", "lon", "height", "roll", "pitch", "yaw"])]
    poses = {}
    for row in rows[1:]:
        t, lat, lon, height, roll, pitch, yaw = (float(row[c]) for c in columns)
        pose = numpy.eye(4)
        pose[:3, :3] = north_east_down(lat, lon) @ turns(roll, pitch, yaw)
        pose[:3, 3] = ecef(lat, lon, height)
        poses[round(t * 1e6)] = pose
    return poses


def measure(truth, estimate, lengths, start_every):
    distances = [0.0]
    for before, pose in zip(truth, truth[1:]):
        distances.append(distances[-1] + numpy.linalg.norm(pose[:3, 3] - before[:3, 3]))
    errors = []
    for first in range(0, len(truth), start_every):
        for length in lengths:
            last = next((i for i in range(first, len(truth)) if distances[i] > distances[first] + length), None)
            if last is None:
                continue
            inverse = numpy.linalg.inv
            error = inverse(inverse(estimate[first]) @ estimate[last]) @ inverse(truth[first]) @ truth[last]
            cosine = max(-1.0, min(1.0, 0.5 * (numpy.trace(error[:3, :3]) - 1)))
            errors.append((numpy.linalg.norm(error[:3, 3]) / length, math.acos(cosine) / length))
    return len(errors), numpy.mean([e[0] for e in errors]), numpy.mean([e[1] for e in errors])


def main():
    estimates, truths, every, start_every = sys.argv[1:5]
    block = ["position."] * 3 + ["attitude."] * 3
    estimate = read(estimates, ["t"] + block)
    truth = read(truths, ["t_s"] + [""] * 6)
    step = round(float(every) * 1e6)
    times = [t for t in sorted(truth) if t in estimate]
    times = [t for t in times if (t - times[0]) % step == 0]
    count, translation, rotation = measure([truth[t] for t in times], [estimate[t] for t in times],
                                           [float(length) for length in sys.argv[5:]], int(start_every))
    print(count, 100 * translation, math.degrees(rotation))


main()
