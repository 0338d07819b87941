#!/usr/bin/env python3
"""The thesis's experiment: what do hard examples do for a classifier of people?

usage: thesis.py DATA OUT [--pavo PAVO] [--workers N]

DATA   a folder with train/positive and train/negative (INRIA Person), and fudan, ethz and kitti17, each with images and
       truth.csv
OUT    gets the three models, their detections, table.md, and the pictures before/ and after/

Three trainings by `pavo train`, from the same 1200 people and their mirror images, and the same 12000 windows at random
of pictures without people:
  1. these 14400 alone;
  2. and the 400 worst of the false alarms that a scan of all pictures finds with 1.;
  3. and all of them, round by round until a scan finds none any more (50 a picture and round).
The table has the log-average miss rate (bench/people/lamr.py) on people nobody trained on. The pictures show what each
classifier reports at its own border, a margin of 0. Models that exist in OUT are used again. Python 3's own library only.
"""
import argparse
import math
import os
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import lamr  # noqa: E402

SETS = [("fudan", 0), ("ethz", 90), ("kitti17", 90)]
COLUMNS = [
    ("random", "12000 negatives at random", ["--rounds", "0"]),
    ("hard400", "+ 400 hard examples", ["--rounds", "1", "--hard", "400", "--hard-per-image", "400"]),
    ("mined", "all hard examples, round by round", []),
]


def images_of(folder):
    return folder + "/images" if os.path.isdir(folder + "/images") else folder


def train(args, name, options):
    """The model, and what the training said of its last round."""
    model, log = f"{args.out}/{name}.txt", f"{args.out}/{name}.log"
    if not os.path.exists(model):
        # 8 people and 8 pictures are kept out: 1200 are left, mirrored 2400.
        call = [args.pavo, "train", f"{args.data}/train/positive", f"{args.data}/train/negative", "--out", model,
                "--hold-out", "8", "--workers", str(args.workers)] + options
        with open(log, "w") as f:
            subprocess.run(call, check=True, stdout=f)
    with open(log) as f:
        last = [line for line in f if line.startswith("round ")][-1]
    words = last.replace(":", "").replace(",", "").split()
    return model, int(words[2]), int(words[4])


def probability_of_margin_0(model):
    with open(model) as f:
        for line in f:
            if line.startswith("calibration "):
                return 1 / (1 + math.exp(-float(line.split()[2])))
    sys.exit(f"{model}: expected a line `calibration SLOPE OFFSET`")


def detect(args, model, name, pictures, threshold, draw=None):
    csv = f"{args.out}/{name}.csv"
    call = [args.pavo, "detect", pictures, "--model", model, "--threshold", f"{threshold:.6g}", "--workers",
            str(args.workers)]
    with open(csv, "w") as f:
        subprocess.run(call + (["--draw", draw] if draw else []), check=True, stdout=f)
    return csv


def miss_at(images, rate):
    rows = sorted((row for judged, _ in images for row in judged), reverse=True)
    people, hits, misses = sum(n for _, n in images), 0, 1.0
    for k, (_, hit) in enumerate(rows):
        hits += hit
        if (k + 1 - hits) / len(images) > rate:
            break
        misses = 1 - hits / people
    return misses


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data")
    parser.add_argument("out")
    here = os.path.dirname(os.path.abspath(__file__))
    parser.add_argument("--pavo", default=os.path.join(here, "../../build/release/tools/pavo"))
    parser.add_argument("--workers", type=int, default=os.cpu_count())
    args = parser.parse_args()
    os.makedirs(args.out, exist_ok=True)

    head = [f"| | {' | '.join(title for _, title, _ in COLUMNS)} |", "| --- |" + " --- |" * len(COLUMNS)]
    rows = {"people, negatives of the last fit": []}
    for name, _, options in COLUMNS:
        model, positives, negatives = train(args, name, options)
        rows["people, negatives of the last fit"].append(f"{positives}, {negatives}")
        pooled = []
        for data, least in SETS:
            pictures = images_of(f"{args.data}/{data}")
            found = detect(args, model, f"{name}.{data}", pictures, 1e-6)
            images = lamr.read_set(found, f"{args.data}/{data}/truth.csv", least)
            pooled += images
            rows.setdefault(f"LAMR {data}" + (f", {least} px and more" if least else ""), []).append(
                f"{lamr.lamr(images):.3f}")
        rows.setdefault("LAMR, all three pooled", []).append(f"{lamr.lamr(pooled):.3f}")
        rows.setdefault("missed at 1 false alarm a picture, pooled", []).append(f"{miss_at(pooled, 1):.3f}")
        if name != "hard400":
            folder = f"{args.out}/{'before' if name == 'random' else 'after'}"
            for data, _ in SETS:
                detect(args, model, f"{name}.{data}.drawn", images_of(f"{args.data}/{data}"),
                       probability_of_margin_0(model), f"{folder}/{data}")
    table = "\n".join(head + [f"| {name} | {' | '.join(cells)} |" for name, cells in rows.items()]) + "\n"
    with open(f"{args.out}/table.md", "w") as f:
        f.write(table)
    print(table, end="")


if __name__ == "__main__":
    main()
