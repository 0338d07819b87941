#!/usr/bin/env python3
"""The recorded drives, altered: mirrored, backwards, dark, behind a car ... Does what was tuned on four drives hold there?

usage: altered.py DATA [--pavo PAVO] [--work DIR] [--only NAME] [--print]

DATA    the folder with sequences/
--work  where the altered drives are kept and used again (default: a temporary folder; they take 1.5 GB)
--only  alterations whose name contains this
--print print the table instead of writing it into docs/results.md

Every run as measure.py's. Some eight minutes. Needs numpy and OpenCV for Python 3.
"""
import argparse
import os
import re
import sys
import tempfile

import cv2
import measure
import numpy as np

PAGE = measure.PAGE
DRIVES = ["kitti05-300", "kitti-street-108", "kitti-city-134", "kitti01-51"]


class Drive:
    """Images (read when they are asked for), camera matrix K, poses T of the camera, times t."""

    def __init__(self, folder):
        pictures = next(p for p in ("image_0", "image_2") if os.path.isdir(os.path.join(folder, p)))
        files = sorted(os.listdir(os.path.join(folder, pictures)))
        self.read = [lambda f=f: cv2.imread(os.path.join(folder, pictures, f), cv2.IMREAD_GRAYSCALE) for f in files]
        with open(os.path.join(folder, "calib.txt"), encoding="utf-8") as lines:
            said = dict(line.split(":") for line in lines if ":" in line)
        self.K = np.array([float(v) for v in said["P" + pictures[-1]].split()]).reshape(3, 4)[:, :3]
        poses = np.loadtxt(os.path.join(folder, "poses.txt")).reshape(-1, 3, 4)[:len(files)]
        self.T = [np.vstack([p, [0, 0, 0, 1]]) for p in poses]
        self.t = list(np.loadtxt(os.path.join(folder, "times.txt"))[:len(files)])
        self.quality = 92

    def write(self, folder):
        os.makedirs(os.path.join(folder, "image_0"), exist_ok=True)
        for i, read in enumerate(self.read):
            cv2.imwrite(os.path.join(folder, "image_0", f"{i:06d}.jpg"), read(), [cv2.IMWRITE_JPEG_QUALITY, self.quality])
        P = np.hstack([self.K, np.zeros((3, 1))])
        first = np.linalg.inv(self.T[0])
        np.savetxt(os.path.join(folder, "poses.txt"), [(first @ T)[:3].ravel() for T in self.T])
        np.savetxt(os.path.join(folder, "times.txt"), self.t, fmt="%.6f")
        with open(os.path.join(folder, "calib.txt"), "w", encoding="utf-8") as file:  # the last: it says that all is there
            file.write("P0: " + " ".join(f"{v:.12g}" for v in P.ravel()) + "\n")

    def each(self, change):
        self.read = [lambda read=read: change(read()) for read in self.read]

    def choose(self, frames):
        self.read = [self.read[i] for i in frames]
        self.T = [self.T[i] for i in frames]
        self.t = [self.t[i] for i in frames]

    def size(self):
        return self.read[0]().shape[::-1]

    def middle(self):
        return len(self.read) // 2

    def stand(self, at, frames):
        """Frame `at` again and again, each time with noise of its own; the rest comes later by as much."""
        noise = np.random.default_rng(at)
        read, period = self.read[at], (self.t[-1] - self.t[0]) / (len(self.t) - 1)
        again = [lambda: noisy(read(), noise, 2) for _ in range(frames)]
        self.read[at + 1:at + 1] = again
        self.T[at + 1:at + 1] = [self.T[at]] * frames
        self.t[at + 1:] = [self.t[at] + period * (k + 1) for k in range(frames)] + [
            t + period * frames for t in self.t[at + 1:]]


def grays(values):
    return np.clip(values, 0, 255).astype(np.uint8)


def noisy(image, random, sigma):
    return grays(image + random.normal(0, sigma, image.shape))


def mirrored(d):
    d.each(lambda image: cv2.flip(image, 1))
    d.K[0, 2] = d.size()[0] - 1 - d.K[0, 2]
    M = np.diag([-1, 1, 1, 1.0])
    d.T = [M @ T @ M for T in d.T]


def halved(d):
    wide, high = d.size()
    d.each(lambda image: cv2.resize(image, (wide // 2, high // 2), interpolation=cv2.INTER_AREA))
    scale = np.diag([wide // 2 / wide, high // 2 / high, 1])
    d.K = scale @ d.K
    d.K[:2, 2] += np.diag(scale)[:2] / 2 - 0.5


def narrowed(d):
    d.each(lambda image: image[:, 300:-300])
    d.K[0, 2] -= 300


def exposed(d):
    random = np.random.default_rng(3)
    d.each(lambda image: grays(image * random.uniform(0.6, 1.4) + random.uniform(-15, 15)))


def held(rotation_vector):
    """The camera turned on its mount; what of the picture would be empty is cut away."""

    def turn(d):
        R = cv2.Rodrigues(np.array(rotation_vector))[0]
        H, (wide, high) = d.K @ R @ np.linalg.inv(d.K), d.size()
        full = cv2.warpPerspective(np.full((high, wide), 255, np.uint8), H, (wide, high)) == 255
        left, top, right, bottom = 0, 0, wide, high
        while not (part := full[top:bottom, left:right]).all():
            worst = np.argmin([part[0].mean(), part[-1].mean(), part[:, 0].mean(), part[:, -1].mean()])
            top, bottom, left, right = (top + (worst == 0), bottom - (worst == 1), left + (worst == 2), right - (worst == 3))
        d.each(lambda image: cv2.warpPerspective(image, H, (wide, high))[top:bottom, left:right])
        d.K[:2, 2] -= [left, top]
        X = np.eye(4)
        X[:3, :3] = R
        d.T = [X @ T @ X.T for T in d.T]

    return turn


def behind_a_car(d):
    """A piece of street, 200 px wide, keeps its place in the picture, but for a little swaying."""
    wide, _ = d.size()
    car = cv2.resize(d.read[0]()[100:300, 100:400], (200, 160))

    def put(image, k):
        x = int(d.K[0, 2] - 100 + 6 * np.sin(k / 11))
        y = int(d.K[1, 2] - 50 + 2 * np.sin(k / 3))
        image[y:y + 160, x:x + 200] = car[:image.shape[0] - y]
        return image

    d.read = [lambda read=read, k=k: put(read(), k) for k, read in enumerate(d.read)]


def lorry_passes(d):
    """The camera stands half way; what passes covers all but 5 % of the picture, and then all of it again."""
    at, frames = d.middle(), 60
    wide, high = d.size()
    long, tall = int(0.95 * wide), int(0.85 * high)
    lorry = grays(0.6 * cv2.resize(d.read[0](), (long, tall)) + 80)
    d.stand(at, frames)

    def put(image, k):
        x = round(-long + (wide + long) * k / frames)
        left, right = max(x, 0), min(x + long, wide)
        image[high // 10:high // 10 + tall, left:right] = lorry[:, left - x:right - x]
        return image

    for k in range(1, frames):
        d.read[at + k] = lambda read=d.read[at + k], k=k: put(read(), k)


ALTERATIONS = [  # name, what is done
    ("as recorded (its JPEG made anew)", lambda d: None),
    ("mirrored", mirrored),
    ("backwards", lambda d: (d.choose(range(len(d.read))[::-1]), d.t.sort())),
    ("every second frame", lambda d: d.choose(range(0, len(d.read), 2))),
    ("three frames of forty missing", lambda d: d.choose([i for i in range(len(d.read)) if i % 40 not in (20, 21, 22)])),
    ("half the size", halved),
    ("half the width", narrowed),
    ("blurred (1.5 px)", lambda d: d.each(lambda image: cv2.GaussianBlur(image, (0, 0), 1.5))),
    ("noise (8 gray values)", lambda d: d.each(lambda image, r=np.random.default_rng(5): noisy(image, r, 8))),
    ("JPEG of quality 30", lambda d: setattr(d, "quality", 30)),
    ("exposure jumps by 40 %", exposed),
    ("a quarter of the light", lambda d: d.each(lambda image: grays(image * 0.25))),
    ("the camera looks down by 4 degrees", held((-0.07, 0, 0))),
    ("up by 3 degrees", held((0.05, 0, 0))),
    ("rolled by 3 degrees", held((0, 0, 0.05))),
    ("stands 3 s at the start", lambda d: d.stand(0, 30)),
    ("a lorry passes while it stands", lorry_passes),
    ("a car ahead, 200 px wide", behind_a_car),
]


def judge(args, name, alter, drive):
    folder = os.path.join(args.work, re.sub(r"\W+", "-", f"{drive}-{name}"))
    if not os.path.exists(os.path.join(folder, "calib.txt")):
        d = Drive(os.path.join(args.data, "sequences", drive))
        alter(d)
        d.write(folder)
    return measure.judge(args, measure.run(args, folder, "altered"), folder, 10 if drive == "kitti05-300" else 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data")
    parser.add_argument("--pavo", default=os.path.join(measure.ROOT, "build", "release", "tools", "pavo"))
    parser.add_argument("--work")
    parser.add_argument("--only", default="")
    parser.add_argument("--print", action="store_true")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        args.work = args.work or temporary
        os.makedirs(args.work, exist_ok=True)
        rows = [f"| | {' | '.join(DRIVES)} |", "| --- |" + " --- |" * len(DRIVES)]
        for name, alter in ALTERATIONS:
            if args.only not in name:
                continue
            figures = [judge(args, name, alter, drive) for drive in DRIVES]
            rows.append(f"| {name} | " + " | ".join("{:.2f} / {:.2f} / {:.2f}".format(*f) for f in figures) + " |")
            print(rows[-1], file=sys.stderr, flush=True)
    table = "\n".join(rows) + "\n"
    if args.print:
        print(table)
        return
    with open(PAGE, encoding="utf-8") as page:
        text = page.read()
    text, found = re.subn(r"(?<=<!-- altered -->\n).*?(?=<!-- /altered -->)", lambda _: f"\n{table}\n", text, flags=re.S)
    if not found:
        sys.exit(f"{PAGE} has no place for the table")
    with open(PAGE, "w", encoding="utf-8") as page:
        page.write(text)


if __name__ == "__main__":
    main()
