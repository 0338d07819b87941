#!/usr/bin/env python3
"""Log-average miss rate of detections, with bootstrap intervals; and of the difference between two detectors.

usage: lamr.py NAME:DETECTIONS.csv:TRUTH.csv[:MIN_HEIGHT] ... [--against NAME:DETECTIONS.csv ...] [--resamples 2000]

DETECTIONS  `image,x,y,width,height,score`, as `pavo detect --threshold 0.0001` prints it
TRUTH       `image,x,y,width,height,ignore`; an image without a person has one line with empty boxes
--against   the same sets by another detector: the difference is paired, image by image, over all sets pooled

The rules are those of the Caltech benchmark (Dollar et al., PAMI 2012): boxes brought to the aspect 0.41, IoU 0.5, the
geometric mean of the miss rate at 9 rates of false alarms from 0.01 to 1 an image. Images are what is drawn with
replacement. Python 3's own library only.
"""
import argparse
import bisect
import csv
import math
import random
from collections import defaultdict

ASPECT = 0.41
RATES = [10 ** (-2 + k / 4) for k in range(9)]


def standard(row):
    x, y, w, h = (float(row[k]) for k in ("x", "y", "width", "height"))
    return (x + w / 2 - ASPECT * h / 2, y, ASPECT * h, h)


def shared(a, b):
    w = min(a[0] + a[2], b[0] + b[2]) - max(a[0], b[0])
    h = min(a[1] + a[3], b[1] + b[3]) - max(a[1], b[1])
    return w * h if w > 0 and h > 0 else 0.0


def read_truth(path, min_height):
    truth = defaultdict(list)
    with open(path) as f:
        for row in csv.DictReader(f):
            boxes = truth[row["image"]]
            if row["width"]:
                boxes.append((standard(row), row["ignore"] == "1" or float(row["height"]) < min_height))
    return truth


def judged(detections, boxes):
    """[(score, hit)] of one image; what lies on an ignored person is left out"""
    rows, used = [], set()
    for score, d in sorted(detections, reverse=True):
        best, best_iou = None, 0.5
        for k, (g, ignore) in enumerate(boxes):
            both = shared(d, g)
            iou = both / (d[2] * d[3] + g[2] * g[3] - both)
            if not ignore and k not in used and iou >= best_iou:
                best, best_iou = k, iou
        if best is not None:
            used.add(best)
            rows.append((score, True))
        elif not any(ignore and shared(d, g) >= 0.5 * d[2] * d[3] for g, ignore in boxes):
            rows.append((score, False))
    return rows


def read_set(detections_path, truth_path, min_height):
    """[(judged detections, people)], an image each"""
    truth = read_truth(truth_path, min_height)
    detections = defaultdict(list)
    with open(detections_path) as f:
        for row in csv.DictReader(f):
            detections[row["image"].split("/")[-1]].append((float(row["score"]), standard(row)))
    return [(judged(detections[image], truth[image]), sum(not i for _, i in truth[image])) for image in sorted(truth)]


def lamr(images):
    rows = sorted((row for judged_rows, _ in images for row in judged_rows), reverse=True)
    people = sum(n for _, n in images)
    if not people:
        return 1.0
    rates, misses, hits = [], [], 0
    for k, (_, hit) in enumerate(rows):
        hits += hit
        rates.append((k + 1 - hits) / len(images))
        misses.append(1 - hits / people)
    total = 0.0
    for rate in RATES:  # the miss rate falls along the curve: the last point within the rate is the lowest
        k = bisect.bisect_right(rates, rate)
        total += math.log(max(misses[k - 1] if k else 1.0, 1e-10))
    return math.exp(total / len(RATES))


def interval(values):
    values = sorted(values)
    return values[int(0.025 * len(values))], values[int(0.975 * len(values)) - 1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sets", nargs="+", metavar="NAME:DETECTIONS:TRUTH[:MIN_HEIGHT]")
    parser.add_argument("--against", nargs="*", default=[], metavar="NAME:DETECTIONS")
    parser.add_argument("--resamples", type=int, default=2000)
    args = parser.parse_args()
    others = dict(a.split(":", 1) for a in args.against)
    pooled, pooled_other = [], []
    dice = random.Random(1)
    for text in args.sets:
        name, detections, truth, *rest = text.split(":")
        min_height = float(rest[0]) if rest else 0
        images = read_set(detections, truth, min_height)
        low, high = interval([lamr(dice.choices(images, k=len(images))) for _ in range(args.resamples)])
        print(f"{name}: LAMR {lamr(images):.3f}, 95 % {low:.3f} to {high:.3f}")
        if name in others:
            pooled += images
            pooled_other += read_set(others[name], truth, min_height)
    if not others:
        return
    pairs = list(zip(pooled, pooled_other))

    def difference(sample):
        return lamr([a for a, _ in sample]) - lamr([b for _, b in sample])

    drawn = sorted(difference(dice.choices(pairs, k=len(pairs))) for _ in range(args.resamples))
    low, high = interval(drawn)
    print(f"difference over all sets pooled: {difference(pairs):+.4f}, 95 % {low:+.4f} to {high:+.4f}, "
          f"95 % upper bound {drawn[int(0.95 * len(drawn)) - 1]:+.4f}")


if __name__ == "__main__":
    main()
