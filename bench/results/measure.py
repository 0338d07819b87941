#!/usr/bin/env python3
"""The keyframe estimator beside others: the table of docs/results.md and its plots of paths and of scale over distance.

usage: measure.py MAKE_CROWD DATA [--pavo PAVO] [--seeds 1-5] [--work DIR] [--print]

MAKE_CROWD  the script that puts people into a recorded sequence (SEQUENCE CUTOUTS OUT --people N --companions N --seed N)
DATA        the folder with sequences/, peers/ and people/cutouts/
--work      where crowds and rendered streets are kept and used again (default: a temporary folder)
--print     print the table, write no page (the plots go to --work)

Every run: --estimator keyframe --scale camera-height=1.65, people removed, nothing else told. Some ten minutes on an idle
machine. Python 3's own library only (MAKE_CROWD needs more).
"""
import argparse
import json
import math
import os
import re
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGE = os.path.join(ROOT, "docs", "results.md")
RED, BLUE, GRAY = "#c00", "#06c", "#999"


def run(args, folder, name, *more):
    out = os.path.join(args.work, "run-" + name)
    subprocess.run([args.pavo, "run", folder, "--estimator", "keyframe", "--scale", "camera-height=1.65", "--out", out,
                    *more],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return os.path.join(out, "trajectory.kitti")


def judge(args, estimate, folder, step):
    file = os.path.join(args.work, "eval.json")
    subprocess.run([args.pavo, "eval", estimate, os.path.join(folder, "poses.txt"), "--step", str(step), "--json", file],
                   check=True, stdout=subprocess.DEVNULL)
    with open(file, encoding="utf-8") as text:
        said = json.load(text)["estimates"][0]
    raw = said["raw"]["segments"]
    return raw["t_rel_percent"], raw["r_rel_deg_per_100m"], said["ate_m"]["sim3"]["rmse"]


def medians(rows):
    return tuple(statistics.median(column) for column in zip(*rows))


def crowd(args, seed):
    folder = os.path.join(args.work, f"crowd-{seed}")
    if not os.path.exists(os.path.join(folder, "people.csv")):
        subprocess.run(["/usr/bin/python3", args.make_crowd, os.path.join(args.data, "sequences", "kitti05-300"),
                        os.path.join(args.data, "people", "cutouts"), folder, "--people", "100", "--companions", "20",
                        "--seed", str(seed)], check=True, stdout=subprocess.DEVNULL)
    return folder


def street(args, seed):
    folder = os.path.join(args.work, f"street-{seed}")
    if not os.path.exists(folder):
        subprocess.run([args.pavo, "synth", "--out", folder, "--seed", str(seed)], check=True, stdout=subprocess.DEVNULL)
    return folder


def positions(file):
    with open(file, encoding="utf-8") as lines:
        return [(float(p[3]), float(p[7]), float(p[11])) for p in (line.split() for line in lines) if len(p) >= 12]


def travelled(path):
    way = [0.0]
    for a, b in zip(path, path[1:]):
        way.append(way[-1] + math.dist(a, b))
    return way


def drift_of_scale(estimate, truth, window_m=10.0):
    """(distance, length of the estimate over the true length) of the last window_m metres, all along the way."""
    estimated, true = travelled(estimate), travelled(truth)
    points, first = [], 0
    for k in range(len(true)):
        while true[k] - true[first + 1] > window_m if first + 1 < k else False:
            first += 1
        if true[k] - true[first] >= window_m:
            points.append((true[k], (estimated[k] - estimated[first]) / (true[k] - true[first])))
    return points


def polyline(points, colour, width=1.5):
    text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{text}" fill="none" stroke="{colour}" stroke-width="{width}"/>'


def label(x, y, text, colour="#333", anchor="start"):
    return f'<text x="{x}" y="{y}" font-family="sans-serif" font-size="12" fill="{colour}" text-anchor="{anchor}">{text}</text>'


def svg(width, height, parts):
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">'
            f'<rect width="{width}" height="{height}" fill="#fff"/>' + "\n".join(parts) + "</svg>\n")


def plot_paths(drives):
    """From above, x to the right, z up; no alignment: all begin at the same pose."""
    size, gap, parts = 260, 20, []
    for i, (name, truth, estimate, peer) in enumerate(drives):
        paths = [(peer, GRAY)] * (peer is not None) + [(truth, RED), (estimate, BLUE)]
        everything = [p for path, _ in paths for p in path]
        low_x, high_x = min(p[0] for p in everything), max(p[0] for p in everything)
        low_z, high_z = min(p[2] for p in everything), max(p[2] for p in everything)
        scale = (size - 50) / max(high_x - low_x, high_z - low_z, 1e-9)
        left, bottom = gap + i * (size + gap), size + 20
        for path, colour in paths:
            parts.append(polyline([(left + (p[0] - low_x) * scale, bottom - (p[2] - low_z) * scale) for p in path], colour))
        parts.append(label(left, 18, f"{name} ({travelled(truth)[-1]:.0f} m)"))
    parts.append(label(gap, size + 44, "ground truth", RED))
    parts.append(label(gap + 100, size + 44, "pavo, as published", BLUE))
    parts.append(label(gap + 240, size + 44, "VISO2-M", GRAY))
    return svg(gap + len(drives) * (size + gap), size + 56, parts)


def plot_scale(drives):
    width, height, left, top = 820, 300, 50, 30
    longest = max(travelled(truth)[-1] for _, truth, _, _ in drives)
    x_of = lambda metres: left + metres / longest * (width - left - 20)
    y_of = lambda ratio: top + (1.3 - min(max(ratio, 0.7), 1.3)) / 0.6 * (height - top - 40)
    parts = [label(left, 18, "Length of the last 10 m, estimated / true; over the way, m. VISO2-M on kitti05-300 gray.")]
    for ratio in (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3):
        parts.append(polyline([(left, y_of(ratio)), (width - 20, y_of(ratio))], "#ddd" if ratio != 1 else "#888", 1))
        parts.append(label(left - 6, y_of(ratio) + 4, f"{ratio:.1f}", anchor="end"))
    for metres in range(0, int(longest) + 1, 50):
        parts.append(label(x_of(metres), height - 20, str(metres), anchor="middle"))
    colours = [BLUE, "#080", "#b60", "#909", "#0aa"]
    for i, (name, truth, estimate, peer) in enumerate(drives):
        if peer is not None and i == 0:
            parts.append(polyline([(x_of(x), y_of(y)) for x, y in drift_of_scale(peer, truth)], GRAY, 1))
        parts.append(polyline([(x_of(x), y_of(y)) for x, y in drift_of_scale(estimate, truth)], colours[i]))
        parts.append(label(left + 10 + 150 * i, height - 4, name, colours[i]))
    return svg(width, height, parts)


def table(args, drives):
    kitti = os.path.join(args.data, "sequences")
    rows = []

    def row(name, floors, measured):
        values = " | ".join(f"{value:.2f}" for value in measured)
        rows.append(f"| {name} | {values} | {floors} |")
        print(rows[-1], file=sys.stderr, flush=True)

    for name, step, floors in (("kitti05-300", 10, "2.5 / 0.45 / 1.0"), ("kitti-street-108", 1, "3.0 / 0.6 / 0.5"),
                               ("kitti-city-134", 1, "3.0 / 0.6 / 0.5"), ("kitti01-51", 1, "6 / 2 / 0.6")):
        folder = os.path.join(kitti, name)
        estimate = run(args, folder, name)
        peer = os.path.join(args.data, "peers", f"viso2-mono.{name}.txt")
        drives.append((name, positions(os.path.join(folder, "poses.txt")), positions(estimate),
                       positions(peer) if os.path.exists(peer) else None))
        row(name, floors, judge(args, estimate, folder, step))
    for name, folder, more in (("euroc-standstill-25", os.path.join(kitti, "euroc-standstill-25"), ()),
                               ("people/kitti17", os.path.join(args.data, "people", "kitti17"), ("--rate", "10"))):
        path = positions(run(args, folder, os.path.basename(name), *more))
        moved = max(math.dist(p, path[0]) for p in path)
        rows.append(f"| {name}, which stands still | moves {moved:.3f} m | | | 0.01 m |")
        print(rows[-1], file=sys.stderr, flush=True)
    for title, make, floors in (("kitti05-300 in a crowd, median of the seeds", crowd, "3.5 / 0.8 / 1.5"),
                                ("the rendered street, median of the seeds", street, "1.0 / 0.2 / 0.3")):
        each = []
        for seed in args.seeds:
            folder = make(args, seed)
            each.append(judge(args, run(args, folder, os.path.basename(folder)), folder, 10))
        row(title, floors, medians(each))
        row("&nbsp; the worst of each figure", floors, tuple(max(column) for column in zip(*each)))
    return "\n".join(["| sequence | t_rel raw % | r_rel deg/100 m | ATE (Sim3) m | aimed at |", "| --- | --- | --- | --- | --- |",
                      *rows])


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("make_crowd")
    parser.add_argument("data")
    parser.add_argument("--pavo", default=os.path.join(ROOT, "build", "release", "tools", "pavo"))
    parser.add_argument("--seeds", default="1-5")
    parser.add_argument("--work", default=None)
    parser.add_argument("--print", action="store_true")
    args = parser.parse_args()
    first, _, last = args.seeds.partition("-")
    args.seeds = range(int(first), int(last or first) + 1)
    with tempfile.TemporaryDirectory() as temporary:
        args.work = args.work or temporary
        os.makedirs(args.work, exist_ok=True)
        drives = []
        text = table(args, drives)
        pictures = args.work if args.print else os.path.join(ROOT, "docs", "pictures")
        for name, drawn in (("keyframe-paths.svg", plot_paths(drives)), ("keyframe-scale.svg", plot_scale(drives))):
            with open(os.path.join(pictures, name), "w", encoding="utf-8") as file:
                file.write(drawn)
    if args.print:
        print(text)
        return
    with open(PAGE, encoding="utf-8") as page:
        old = page.read()
    pattern = re.compile("<!-- keyframe -->.*?<!-- /keyframe -->", re.S)
    if not pattern.search(old):
        raise SystemExit(f"{PAGE}: there is no <!-- keyframe --> ... <!-- /keyframe -->")
    with open(PAGE, "w", encoding="utf-8") as page:
        page.write(pattern.sub(lambda _: f"<!-- keyframe -->\n\n{text}\n\n<!-- /keyframe -->", old))


if __name__ == "__main__":
    main()
