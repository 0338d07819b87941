#!/usr/bin/env python3
"""How wrong is a step of the camera, against the share of the image that people cover? With removal and without.

usage: plot_coverage.py WORK OUT.svg [--scenes TEXT]

WORK  what measure.py left: the scenes (people.csv, poses.txt) and the runs (out-*)
Every frame of every scene whose name begins with TEXT is a case: the share of the image under the true boxes, and the
error of the translation since the frame before. Drawn are the quartiles over bins of equal share; blue with removal,
green without. Python 3's own library only.
"""
import argparse
import csv
import glob
import math
import os
import statistics
import struct
from collections import defaultdict

CELL = 4  # px: the union of the boxes is counted in cells
WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 720, 420, 70, 50, 20, 20
COLOURS = {"pavo": "#1f5fd0", "plain geometry": "#2a9d3a"}


def size_of_jpeg(path):
    with open(path, "rb") as f:
        data = f.read()
    at = 2
    while at < len(data):
        marker, length = data[at + 1], struct.unpack(">H", data[at + 2:at + 4])[0]
        if 0xC0 <= marker <= 0xC2:
            height, width = struct.unpack(">HH", data[at + 5:at + 9])
            return width, height
        at += 2 + length
    raise SystemExit(f"{path}: expected a JPEG")


def coverage(scene):
    """share of the image under people, by frame"""
    width, height = size_of_jpeg(sorted(glob.glob(scene + "/image_*/*.jpg"))[0])
    across, down = width // CELL, height // CELL
    cells = defaultdict(set)
    with open(scene + "/people.csv") as f:
        for row in csv.DictReader(f):
            frame = cells[int(row["image"].split(".")[0])]
            if not row["width"]:
                continue
            x, y, w, h = (float(row[k]) / CELL for k in ("x", "y", "width", "height"))
            for v in range(max(0, round(y)), min(down, round(y + h))):
                frame.update(range(v * across + max(0, round(x)), v * across + min(across, round(x + w))))
    return {frame: len(c) / (across * down) for frame, c in cells.items()}


def poses(path):
    with open(path) as f:
        return [[float(v) for v in line.split()] for line in f if line.strip()]


def step(a, b):
    """translation of b as seen from a: R_a^T (t_b - t_a)"""
    d = [b[3] - a[3], b[7] - a[7], b[11] - a[11]]
    return [sum(a[4 * r + c] * d[r] for r in range(3)) for c in range(3)]


def errors(estimate, truth):
    """metres, by frame"""
    return {k: math.dist(step(estimate[k - 1], estimate[k]), step(truth[k - 1], truth[k]))
            for k in range(1, min(len(estimate), len(truth)))}


def cases(work, text):
    found = {name: [] for name in COLOURS}
    for run in sorted(glob.glob(work + "/out-*")):
        scene = os.path.join(work, os.path.basename(run)[4:])
        if not os.path.basename(scene).startswith(text) or not os.path.exists(scene + "/people.csv"):
            continue
        shares, truth = coverage(scene), poses(scene + "/poses.txt")
        for name, file in zip(COLOURS, ("trajectory.kitti", "trajectory.geometric.kitti")):
            for k, error in errors(poses(f"{run}/{file}"), truth).items():
                found[name].append((shares[k], error))
    return found


def binned(points, width=0.04, least=20):
    bins = defaultdict(list)
    for share, error in points:
        bins[int(share / width)].append(error)
    for b, values in sorted(bins.items()):
        if len(values) >= least:
            yield ((b + 0.5) * width, *statistics.quantiles(values, n=4))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work")
    parser.add_argument("out")
    parser.add_argument("--scenes", default="")
    args = parser.parse_args()
    curves = {name: list(binned(points)) for name, points in cases(args.work, args.scenes).items()}
    if not any(curves.values()):
        raise SystemExit(f"{args.work}: expected runs of measure.py (out-*) and their scenes")
    most = max(c[-1][0] for c in curves.values() if c) + 0.02
    low, high = 1e-3, 10.0

    def at(share, error):
        x = LEFT + share / most * (WIDTH - LEFT - RIGHT)
        y = math.log(min(max(error, low), high) / low) / math.log(high / low)
        return f"{x:.1f},{HEIGHT - BOTTOM - y * (HEIGHT - BOTTOM - TOP):.1f}"

    def place(share, error):
        return (float(v) for v in at(share, error).split(","))

    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="13">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']
    for k in range(5):
        x, y = place(0, low * 10 ** k)
        svg.append(f'<path d="M{x} {y}H{WIDTH - RIGHT}" stroke="#ddd"/>'
                   f'<text x="{x - 8}" y="{y + 4}" text-anchor="end">{low * 10 ** k:g}</text>')
    for k in range(int(most * 10) + 1):
        x, y = place(k / 10, low)
        svg.append(f'<path d="M{x} {y}V{TOP}" stroke="#ddd"/><text x="{x}" y="{y + 18}" text-anchor="middle">{10 * k} %</text>')
    for name, curve in curves.items():
        if not curve:
            continue
        band = [at(c[0], c[3]) for c in curve] + [at(c[0], c[1]) for c in reversed(curve)]
        svg.append(f'<polygon points="{" ".join(band)}" fill="{COLOURS[name]}" fill-opacity="0.15"/>')
        svg.append(f'<polyline points="{" ".join(at(c[0], c[2]) for c in curve)}" fill="none" stroke="{COLOURS[name]}" '
                   'stroke-width="2.5"/>')
    for k, name in enumerate(COLOURS):
        svg.append(f'<path d="M{LEFT + 15} {TOP + 15 + 20 * k}h24" stroke="{COLOURS[name]}" stroke-width="2.5"/>'
                   f'<text x="{LEFT + 46}" y="{TOP + 19 + 20 * k}">{name}: median and quartiles</text>')
    svg.append(f'<text x="{(LEFT + WIDTH) / 2}" y="{HEIGHT - 10}" text-anchor="middle">share of the image that people cover'
               '</text>')
    svg.append(f'<text transform="translate(16 {HEIGHT / 2}) rotate(-90)" text-anchor="middle">error of a step (m)</text>')
    with open(args.out, "w") as f:
        f.write("\n".join(svg) + "\n</svg>\n")
    for name, curve in curves.items():
        for share, _, median, _ in curve:
            print(f"{name}: {100 * share:.0f} % covered, median error {1000 * median:.1f} mm")


if __name__ == "__main__":
    main()
