#!/usr/bin/env python3
"""What does each part of the keyframe estimator buy? Each switched off, on every sequence, into docs/odometry.md.

usage: table.py MAKE_CROWD DATA [--build DIR] [--work DIR] [--print]

MAKE_CROWD  the script that puts people into a recorded sequence (SEQUENCE CUTOUTS OUT --people N --companions N --seed N)
DATA        the folder with sequences/ and people/cutouts/
--build     where the programs are (default: build/release beside this repository's CMakeLists.txt)
--work      where the crowd, the rendered street and the people's boxes are kept and used again (default: a temporary one)
--print     print the table instead of writing it

Some five minutes on an idle machine. Python 3's own library only (MAKE_CROWD needs more).
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGE = os.path.join(ROOT, "docs", "odometry.md")
HEIGHT = "height=1.65"
VARIANTS = [  # name, settings of bench_ablation, with the people's boxes
    ("everything", [HEIGHT], True),
    ("people are not removed", [HEIGHT], False),
    ("keyframes are not adjusted (`iterations=0`)", [HEIGHT, "iterations=0"], True),
    ("a window of 4 keyframes (`window=4`)", [HEIGHT, "window=4"], True),
    ("the camera as it was calibrated (`lens=0`)", [HEIGHT, "lens=0"], True),
    ("patches are never taken anew (`patch_ratio=1000`)", [HEIGHT, "patch_ratio=1000"], True),
    ("half the points (`points=250`)", [HEIGHT, "points=250"], True),
    ("each look at the ground for itself (`gwalk=0.3`)", [HEIGHT, "gwalk=0.3"], True),
    ("the way tells nothing of the mounting (`gtravel=10`)", [HEIGHT, "gtravel=10"], True),
    ("points may be below the ground (`below=1e9`)", [HEIGHT, "below=1e9"], True),
    ("the same, people not removed", [HEIGHT, "below=1e9"], False),
    ("every second frame (`stride=2`)", [HEIGHT, "stride=2"], True),
    ("lengths between keyframes given, no ground", [], True),
]
FIELDS = re.compile(r"ATE\s+(\S+) .*? t_rel\s+(\S+) r_rel\s+(\S+)")
MOVED = re.compile(r" len (\S+) ")
STANDING = ("euroc-standstill-25", "kitti17")  # what counts there is how far the camera is said to have moved


def sequences(args):
    kitti = os.path.join(args.data, "sequences")
    crowd = os.path.join(args.work, "crowd-1")
    if not os.path.exists(os.path.join(crowd, "people.csv")):
        subprocess.run(["/usr/bin/python3", args.make_crowd, os.path.join(kitti, "kitti05-300"),
                        os.path.join(args.data, "people", "cutouts"), crowd, "--people", "100", "--companions", "20",
                        "--seed", "1"], check=True, stdout=subprocess.DEVNULL)
    street = os.path.join(args.work, "street-2")
    if not os.path.exists(street):
        subprocess.run([args.pavo, "synth", "--out", street, "--seed", "2"], check=True, stdout=subprocess.DEVNULL)
    return [("kitti05-300", os.path.join(kitti, "kitti05-300")), ("in a crowd", crowd),
            ("kitti-street-108", os.path.join(kitti, "kitti-street-108")),
            ("kitti-city-134", os.path.join(kitti, "kitti-city-134")),
            ("kitti01-51", os.path.join(kitti, "kitti01-51")), ("rendered street", street),
            ("euroc-standstill-25", os.path.join(kitti, "euroc-standstill-25")),
            ("KITTI tracking 0017", os.path.join(args.data, "people", "kitti17"))]


def boxes(args, folder):
    """The people that pavo finds, where bench_ablation looks for them."""
    people = os.path.join(args.work, "people")
    os.makedirs(people, exist_ok=True)
    file = os.path.join(people, os.path.basename(folder) + ".csv")
    if not os.path.exists(file):
        with tempfile.TemporaryDirectory() as out:
            subprocess.run([args.pavo, "run", folder, "--estimator", "keyframe", "--scale", "camera-height=1.65", "--out",
                            out], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            os.replace(os.path.join(out, "people.csv"), file + ".new")
            os.replace(file + ".new", file)
    return people


def cell(args, folder, settings, with_people):
    people = ["--people", boxes(args, folder)] if with_people else []
    said = subprocess.run([args.ablation, folder, *people, *settings], check=True, stdout=subprocess.PIPE, text=True).stdout
    if os.path.basename(folder) in STANDING:
        return f"{float(MOVED.search(said)[1]):.2f} m"
    match = FIELDS.search(said)
    if not match:
        return "-"
    ate, t_rel, r_rel = (float(x) for x in match.groups())
    return f"{t_rel:.2f} / {r_rel:.2f} / {ate:.2f}"


def table(args):
    columns = sequences(args)
    lines = ["| | " + " | ".join(name for name, _ in columns) + " |", "| --- |" + " --- |" * len(columns)]
    for name, settings, with_people in VARIANTS:
        cells = [cell(args, folder, settings, with_people) for _, folder in columns]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
        print(lines[-1], file=sys.stderr, flush=True)
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("make_crowd")
    parser.add_argument("data")
    parser.add_argument("--build", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("--work", default=None)
    parser.add_argument("--print", action="store_true")
    args = parser.parse_args()
    args.pavo = os.path.join(args.build, "tools", "pavo")
    args.ablation = os.path.join(args.build, "bench", "ablation", "bench_ablation")
    with tempfile.TemporaryDirectory() as temporary:
        args.work = args.work or temporary
        os.makedirs(args.work, exist_ok=True)
        text = table(args)
    if args.print:
        print(text)
        return
    with open(PAGE, encoding="utf-8") as page:
        old = page.read()
    pattern = re.compile("<!-- ablation -->.*?<!-- /ablation -->", re.S)
    if not pattern.search(old):
        raise SystemExit(f"{PAGE}: there is no <!-- ablation --> ... <!-- /ablation -->")
    with open(PAGE, "w", encoding="utf-8") as page:
        page.write(pattern.sub(lambda _: f"<!-- ablation -->\n\n{text}\n\n<!-- /ablation -->", old))


if __name__ == "__main__":
    main()
