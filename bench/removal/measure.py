#!/usr/bin/env python3
"""What is it worth to remove the features on people? The same drive with and without, on scenes with exact ground truth.

usage: measure.py MAKE_CROWD DATA [--pavo PAVO] [--seeds 1-5] [--work DIR] [--scenes TEXT] [--config FILE]

MAKE_CROWD  the script that puts people into a recorded sequence (SEQUENCE CUTOUTS OUT --people N --companions N --seed N)
DATA        the folder with sequences/ and people/cutouts/

For each scene and seed, one `pavo run --compare --scale groundtruth`: the translation's RMSE from frame to frame (the
three translations of the 12 parameters, on relative poses) and the ATE after Sim(3), with removal and without; then the
medians over the seeds of both and of their ratio. Scenes that exist in DIR are used again; the runs stay in DIR/out-*, for
plot_coverage.py. Python 3's own library only.
"""
import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

SCENES = [  # name, sequence, people, companions
    ("20 companions", "kitti05-300", 100, 20),
    ("12 companions", "kitti05-300", 100, 12),
    ("400 passers-by", "kitti05-300", 400, 0),
    ("nobody, kitti05-300", "kitti05-300", 0, 0),
    ("nobody, kitti-street-108", "kitti-street-108", 0, 0),
]


def scene_folder(args, name, sequence, people, companions, seed):
    source = os.path.join(args.data, "sequences", sequence)
    if people == 0 and companions == 0:
        return source
    folder = os.path.join(args.work, f"{sequence}-{people}-{companions}-{seed}")
    if not os.path.exists(os.path.join(folder, "people.csv")):
        subprocess.run(["/usr/bin/python3", args.make_crowd, source, os.path.join(args.data, "people/cutouts"), folder,
                        "--people", str(people), "--companions", str(companions), "--seed", str(seed)], check=True)
    return folder


def figures(args, folder, out):
    config = ["--config", args.config] if args.config else []
    subprocess.run([args.pavo, "run", folder, "--estimator", "frame-to-frame", "--scale", "groundtruth", "--compare",
                    "--out", out] + config, check=True,
                   stdout=subprocess.DEVNULL)
    truth = os.path.join(folder, "poses.txt")
    table = os.path.join(out, "eval.json")
    subprocess.run([args.pavo, "eval", f"{out}/trajectory.kitti", truth, f"{out}/trajectory.geometric.kitti", "--json", table],
                   check=True, stdout=subprocess.DEVNULL)
    with open(table) as f:
        estimates = json.load(f)["estimates"]
    result = []
    for estimate in estimates:
        translation = [row[3] for row in estimate["raw"]["motion_rmse"]]
        result.append((math.sqrt(sum(t * t for t in translation)), estimate["ate_m"]["sim3"]["rmse"]))
    return result  # with removal, without


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("make_crowd")
    parser.add_argument("data")
    here = os.path.dirname(os.path.abspath(__file__))
    parser.add_argument("--pavo", default=os.path.join(here, "../../build/release/tools/pavo"))
    parser.add_argument("--seeds", default="1-5")
    parser.add_argument("--config", default="", help="settings for all runs, such as another mask")
    parser.add_argument("--scenes", default="", help="only those whose name holds this text")
    parser.add_argument("--work", default=os.path.join(tempfile.gettempdir(), "pavo-removal"))
    args = parser.parse_args()
    first, _, last = args.seeds.partition("-")
    seeds = range(int(first), int(last or first) + 1)
    os.makedirs(args.work, exist_ok=True)

    print("| scene | frame-to-frame RMSE with / without (m) | ratio | ATE with / without (m) | ratio |")
    print("| --- | --- | --- | --- | --- |")
    for name, sequence, people, companions in SCENES:
        if args.scenes not in name:
            continue
        rows = []
        for seed in seeds if people else [0]:
            folder = scene_folder(args, name, sequence, people, companions, seed)
            (rmse, ate), (plain_rmse, plain_ate) = figures(args, folder, os.path.join(args.work, "out-" + os.path.basename(folder)))
            rows.append((rmse, plain_rmse, rmse / plain_rmse, ate, plain_ate, ate / plain_ate))
            print(f"{name}, seed {seed}: {rmse:.4f} / {plain_rmse:.4f}, ATE {ate:.3f} / {plain_ate:.3f}", file=sys.stderr)
        m = [statistics.median(column) for column in zip(*rows)]
        print(f"| {name} | {m[0]:.4f} / {m[1]:.4f} | {m[2]:.3f} | {m[3]:.3f} / {m[4]:.3f} | {m[5]:.3f} |", flush=True)


if __name__ == "__main__":
    main()
