#!/usr/bin/env python3
"""How far the truth is from the camera itself: what of r_rel no estimate that looks through this camera can be without.

usage: mounting.py DATA [--pavo PAVO]

DATA   the folder with sequences/

The truth of KITTI's drives is of another sensor; how the camera sits beside it is known to some milliradians. For each drive:
r_rel as it is; the pitch of the camera in the truth's axes with which it is least, and what it is then; and the side slip, the
angle in the ground between where the camera looks and where it goes. On a straight road, a car's has to stay what it is: told
is its standard deviation over seconds in which the car turns by less than 2 mrad a metre, of the truth and of the estimate. Last,
a line through what both say of the heading, over stretches of six frames: what the estimate turns when the truth turns by 1, and
when it does not turn. A focal length that is off shows in the first of the two only, and in all drives of a camera.
Every run: --scale groundtruth, so that lengths are the truth's. Python 3's own library only.
"""
import argparse
import json
import math
import os
import statistics
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# every how many frames a segment begins: as docs/results.md has it
DRIVES = {"kitti05-300": 10, "kitti-street-108": 1, "kitti-city-134": 1, "kitti01-51": 1}


def times(A, B):
    return [[sum(A[i][k] * B[k][j] for k in range(3)) for j in range(3)] for i in range(3)]


def transposed(A):
    return [list(row) for row in zip(*A)]


def pitched(R, pitch):
    c, s = math.cos(pitch), math.sin(pitch)
    M = [[1, 0, 0], [0, c, -s], [0, s, c]]
    return times(transposed(M), times(R, M))


def poses(file):
    with open(file, encoding="utf-8") as text:
        rows = [[float(x) for x in line.split()] for line in text]
    return [([r[0:3], r[4:7], r[8:11]], (r[3], r[7], r[11])) for r in rows]


def r_rel(args, name, estimate, pitch, work):
    """deg/100 m, as `pavo eval` has it; positions do not count in it"""
    turned, result = os.path.join(work, "turned.kitti"), os.path.join(work, "eval.json")
    with open(turned, "w", encoding="utf-8") as file:
        for R, t in estimate:
            file.write(" ".join(repr(x) for row, p in zip(pitched(R, pitch), t) for x in (*row, p)) + "\n")
    subprocess.run([args.pavo, "eval", turned, os.path.join(args.data, "sequences", name, "poses.txt"), "--step",
                    str(DRIVES[name]), "--json", result], check=True, stdout=subprocess.DEVNULL)
    with open(result, encoding="utf-8") as text:
        return json.load(text)["estimates"][0]["raw"]["segments"]["r_rel_deg_per_100m"]


def side_slips(path):
    """rad, of each second of straight road"""
    slips, turns = [], []
    for (Ra, a), (Rb, b) in zip(path, path[1:]):
        step = [sum(Ra[k][i] * (b[k] - a[k]) for k in range(3)) for i in range(3)]
        R = times(transposed(Ra), Rb)
        yaw = math.atan2(R[0][2], R[2][2])
        slips.append(math.atan2(step[0], step[2]) - yaw / 2)
        turns.append((yaw, math.hypot(*step)))
    seconds = []
    for i in range(0, len(slips) - 9, 10):
        yaw, metres = (sum(part) for part in zip(*turns[i:i + 10]))
        if abs(yaw) < 2e-3 * metres:
            seconds.append(statistics.mean(slips[i:i + 10]))
    return seconds


def slip_text(path):
    slips = side_slips(path)
    return f"{1e3 * statistics.stdev(slips):.1f}" if len(slips) > 2 else "-"


def heading_text(truth, estimate):
    """the line through (truth's turn, estimate's turn) of each stretch"""
    stretch = 6
    turns = []
    for path in (truth, estimate):
        yaws = [times(transposed(a[0]), b[0]) for a, b in zip(path, path[1:])]
        yaws = [math.atan2(R[0][2], R[2][2]) for R in yaws]
        turns.append([sum(yaws[i:i + stretch]) for i in range(0, len(yaws) - stretch + 1, stretch)])
    x, y = turns
    mean_x, mean_y = statistics.mean(x), statistics.mean(y)
    spread = sum((a - mean_x) ** 2 for a in x)
    slope = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y)) / spread
    rest = mean_y - slope * mean_x
    noise = sum((b - rest - slope * a) ** 2 for a, b in zip(x, y)) / (len(x) - 2)
    return f"{slope:.3f} ± {math.sqrt(noise / spread):.3f} | {1e3 * rest / stretch:.2f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data")
    parser.add_argument("--pavo", default=os.path.join(ROOT, "build", "release", "tools", "pavo"))
    args = parser.parse_args()
    print("| drive | r_rel deg/100 m | camera's pitch mrad | r_rel with it | side slip's deviation, truth / pavo mrad | "
          "turns by, a turn of 1 | mrad a frame, none |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as work:
        for name in DRIVES:
            folder = os.path.join(args.data, "sequences", name)
            subprocess.run([args.pavo, "run", folder, "--scale", "groundtruth", "--out", os.path.join(work, name)],
                           check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            truth = poses(os.path.join(folder, "poses.txt"))
            estimate = poses(os.path.join(work, name, "trajectory.kitti"))
            by_pitch = {0.5 * step: r_rel(args, name, estimate, 0.5e-3 * step, work) for step in range(-36, 37)}  # mrad
            best = min(by_pitch, key=by_pitch.get)
            # at the end of what was tried: there is no least one
            turned = "- | -" if abs(best) == 18 else f"{best:.1f} | {by_pitch[best]:.2f}"
            print(f"| {name} | {by_pitch[0]:.2f} | {turned} | {slip_text(truth)} / {slip_text(estimate)} | "
                  f"{heading_text(truth, estimate)} |")


if __name__ == "__main__":
    main()
