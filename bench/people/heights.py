#!/usr/bin/env python3
"""Would people's heights tell the scale? How tall the people that pavo sees would be, were they standing.

usage: heights.py DATA [CROWD...] [--pavo PAVO]

DATA    the folder with sequences/
CROWD   sequences with people put into them (make_crowd.py, the seeds 1 to 5, say)

A person of known height H whose box is h pixels high is at the depth f H / h; corners on that person, seen from two
places, give the depth in the unit of the way between them: so each box votes for the length of the way, and H / (the
height by the true way) is the factor by which that vote is wrong. For every box of `pavo run` corners in its middle are
followed over four frames (Lucas and Kanade, there and back), their depth is found with the true motion, and what did not
move enough, or not as anything that stands would, is left out as an estimator would do it: without knowing the truth.

Prints for each sequence: boxes, those that vote, the votes' median and spread (half of the distance between quartiles of
the logarithm, in percent), and the part of windows of 30 frames in which nobody votes. Needs python3-opencv.
"""
import argparse
import csv
import os
import subprocess
import sys
import tempfile

import cv2
import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PERSON_M = 1.70
APART = 4         # frames
PARALLAX_PX = 2   # a corner that moved less by the camera's way says nothing of its depth
WINDOW = 30       # frames


def images(folder):
    for name in ("image_0", "image_2"):
        path = os.path.join(folder, name)
        if os.path.isdir(path):
            return int(name[-1]), [os.path.join(path, f) for f in sorted(os.listdir(path))]
    sys.exit(f"{folder}: no image_0 and no image_2")


def intrinsics(folder, number):
    for line in open(os.path.join(folder, "calib.txt")):
        if line.startswith(f"P{number}:"):
            p = [float(x) for x in line.split()[1:]]
            return np.array([[p[0], 0, p[2]], [0, p[5], p[6]], [0, 0, 1]])
    sys.exit(f"{folder}: calib.txt has no P{number}")


def poses(folder):
    rows = np.loadtxt(os.path.join(folder, "poses.txt")).reshape(-1, 3, 4)
    return [np.vstack([row, [0, 0, 0, 1]]) for row in rows]


def boxes(folder, pavo):
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([pavo, "run", folder, "--scale", "camera-height=1.65", "--out", out], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with open(os.path.join(out, "people.csv")) as f:
            for row in csv.DictReader(f):
                yield int(row["frame"]), *(float(row[k]) for k in ("x", "y", "width", "height"))


def followed(first, second, box):
    """Corners in the middle of the box, and where they are in the second picture."""
    x, y, w, h = box
    mask = np.zeros(first.shape, np.uint8)
    mask[int(max(y + 0.1 * h, 0)):int(max(y + 0.9 * h, 0)), int(max(x + 0.3 * w, 0)):int(max(x + 0.7 * w, 0))] = 255
    a = cv2.goodFeaturesToTrack(first, 30, 0.01, 3, mask=mask)
    if a is None:
        return np.empty((0, 2)), np.empty((0, 2))
    b, there, _ = cv2.calcOpticalFlowPyrLK(first, second, a, None, winSize=(15, 15))
    back, here, _ = cv2.calcOpticalFlowPyrLK(second, first, b, None, winSize=(15, 15))
    good = (there.ravel() == 1) & (here.ravel() == 1) & (np.linalg.norm((back - a).reshape(-1, 2), axis=1) < 0.5)
    return a.reshape(-1, 2)[good], b.reshape(-1, 2)[good]


def vote(a, b, K, T_b_a, height_px):
    """The height in metres that a standing person would have, or None."""
    if len(a) < 5:
        return None
    rays = np.linalg.solve(K, np.vstack([a.T, np.ones(len(a))])).T
    R, t = T_b_a[:3, :3], T_b_a[:3, 3]
    far = (K @ (R @ rays.T)).T
    far = far[:, :2] / far[:, 2:]  # where they would be, were they far away
    inverse_depths = []
    for ray, at, none in zip(rays, b, far):
        # b ~ R ray + t / Z: one unknown, two equations
        p = np.array([(at[0] - K[0, 2]) / K[0, 0], (at[1] - K[1, 2]) / K[1, 1]])
        r = R @ ray
        A, c = p * t[2] - t[:2], r[:2] - p * r[2]
        inverse_depth = (A @ c) / (A @ A)
        off = K[0, 0] * np.linalg.norm(A * inverse_depth - c) / abs(r[2] + t[2] * inverse_depth)
        if np.linalg.norm(at - none) >= PARALLAX_PX and off < 1:  # along its epipolar line, as what stands is
            inverse_depths.append(inverse_depth)
    if len(inverse_depths) < 5:
        return None
    inverse_depth = float(np.median(inverse_depths))
    return height_px / (K[1, 1] * inverse_depth) if inverse_depth > 0 else None


def votes(folder, pavo):
    number, files = images(folder)
    K, truth = intrinsics(folder, number), poses(folder)
    seen, cast = 0, []
    for frame, *box in boxes(folder, pavo):
        seen += 1
        if frame < APART:
            continue
        now, before = (cv2.imread(files[k], cv2.IMREAD_GRAYSCALE) for k in (frame, frame - APART))
        height = vote(*followed(now, before, box), K, np.linalg.inv(truth[frame - APART]) @ truth[frame], box[3])
        if height:
            cast.append((frame, height / PERSON_M))
    windows = range(0, len(files) - WINDOW + 1, WINDOW)
    silent = sum(not any(w <= frame < w + WINDOW for frame, _ in cast) for w in windows)
    return seen, cast, silent / max(len(windows), 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data")
    parser.add_argument("crowds", nargs="*")
    parser.add_argument("--pavo", default=os.path.join(ROOT, "build", "release", "tools", "pavo"))
    args = parser.parse_args()
    print("| sequence | boxes | votes | median of (height / 1.70 m) | spread | windows of 30 frames without a vote |")
    print("| --- | --- | --- | --- | --- | --- |")
    names = ("kitti05-300", "kitti-street-108", "kitti-city-134", "kitti01-51")
    for folder in [os.path.join(args.data, "sequences", n) for n in names] + args.crowds:
        seen, cast, silent = votes(folder, args.pavo)
        ratios = [r for _, r in cast]
        told = "- | -"
        if ratios:
            low, high = np.percentile(np.log(ratios), [25, 75])
            told = f"{np.median(ratios):.2f} | {100 * (high - low) / 2:.0f} %"
        print(f"| {os.path.basename(os.path.normpath(folder))} | {seen} | {len(ratios)} | {told} | {100 * silent:.0f} % |",
              flush=True)


if __name__ == "__main__":
    main()
