#!/usr/bin/env python3
"""Measures the engine against others and writes what came out into docs/benchmarks.md and docs/pictures/age.svg.
The beat beside load needs stress-ng (apt-get install stress-ng); without it that half is left out.

usage: measure.py [--build DIR] [--source SOURCE] [--seconds S] [--rounds N] [--only PART...] [--print]

--build    where the programs are (default: build/release beside this repository's CMakeLists.txt)
--source   what the real stages run on (default: synthetic; a folder of rectified frames that pavo knows)
--only     handoff, empty, 50us, real, alone, trace, age, beat: measure just these parts, keep what the page says of the others
--print    print the parts instead of writing them

Run it on a machine that does nothing else: it takes three quarters of an hour, and each part is written when it is
done. Where others work on it, call it with a higher priority (`nice -n -20`, as root), which is what the note under each
table says then. Python 3's own library only.
"""
import argparse
import datetime
import json
import os
import platform
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PAGE = os.path.join(ROOT, "docs", "benchmarks.md")
PICTURE = os.path.join(ROOT, "docs", "pictures", "age.svg")
PARTS = ["handoff", "empty", "50us", "real", "alone", "trace", "age", "beat"]
LOAD = 200  # percent, of the plot of the age


def output(*command):
    print("+", " ".join(command), file=sys.stderr, flush=True)
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout.strip()


def machine():
    cpu = "unknown processor"
    with open("/proc/cpuinfo", encoding="utf-8") as info:
        for line in info:
            if line.startswith("model name"):
                cpu = line.split(":", 1)[1].strip()
                break
    try:
        with open("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", encoding="utf-8") as governor:
            governor = governor.read().strip()
    except OSError:
        governor = "none"
    load = "; ".join(f"{x:.1f}" for x in os.getloadavg())
    nice = os.getpriority(os.PRIO_PROCESS, 0)
    return (f"*{datetime.date.today()}, {cpu}, {os.cpu_count()} cores, governor {governor}, Linux "
            f"{platform.release()}, load average before: {load}{f', nice {nice}' if nice else ''}.*")


def write_part(page, name, text):
    """What stands between the two marks of a part."""
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    pattern = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.S)
    if not pattern.search(page):
        raise SystemExit(f"{PAGE}: there is no {begin} ... {end}")
    return pattern.sub(lambda _: f"{begin}\n\n{text.strip()}\n\n{end}", page)


# --- the picture: the age of data over time, dropped and queued

WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 640, 300, 62, 16, 40, 46


def step_for(span, ticks):
    at_least = span / ticks
    power = 10.0
    while power > at_least:
        power /= 10
    while power * 10 <= at_least:
        power *= 10
    return next(power * f for f in (1, 2, 5, 10) if power * f >= at_least)


def age_picture(live, queued, seconds):
    highest = max(a for s in (queued, live) for t, a in zip(s["t_s"], s["age_ms"]) if t <= seconds) / 1000
    x = lambda t: LEFT + t / seconds * (WIDTH - LEFT - RIGHT)
    y = lambda s: TOP + (1 - s / (highest * 1.04)) * (HEIGHT - TOP - BOTTOM)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" '
           f'viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="13">',
           "<title>Age of data at twice the sustainable rate: live and queued</title>",
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>']
    step = step_for(highest, 5)
    for i in range(int(highest * 1.04 / step) + 1):
        out.append(f'<path d="M{LEFT} {y(i * step):.1f}H{WIDTH - RIGHT}" stroke="#dddddd"/>'
                   f'<text x="{LEFT - 7}" y="{y(i * step) + 4:.1f}" text-anchor="end">{i * step:g} s</text>')
    step = step_for(seconds, 6)
    for i in range(int(seconds / step) + 1):
        out.append(f'<text x="{x(i * step):.1f}" y="{HEIGHT - BOTTOM + 19}" text-anchor="middle">{i * step:g}</text>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 8}" text-anchor="middle">seconds</text>')
    for series, color in ((queued, "#d55e00"), (live, "#0072b2")):
        points = [(t, a / 1000) for t, a in zip(series["t_s"], series["age_ms"]) if t <= seconds]
        out.append(f'<path d="M{" L".join(f"{x(t):.1f} {y(a):.1f}" for t, a in points)}" fill="none" '
                   f'stroke="{color}" stroke-width="2.2"/>')
    out.append(f'<text x="{LEFT}" y="24" font-size="13" font-weight="bold">How old a pose is when it is there, '
               "at twice the rate that can be kept up</text>")
    out.append(f'<text x="{x(seconds * 0.40):.0f}" y="{y(highest * 0.62):.0f}" text-anchor="end" fill="#d55e00">'
               "a plain queue</text>")
    out.append(f'<text x="{x(seconds * 0.62):.0f}" y="{y(0) - 12:.0f}" fill="#0072b2">pavo, live</text>')
    return "\n".join(out) + "\n</svg>\n"


def measure_age(pavo, source, seconds):
    results = []
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "bench.json")
        # A rate for both, so that both are offered the same; one at a time, so that there is one for the latency.
        output(pavo, "bench", source, "--load", "5", "--repeat", "3", "--seconds", "5", "--json", path)
        with open(path, encoding="utf-8") as file:
            alone = json.load(file)
        rate = f"{alone['capacity_fps'] * LOAD / 100:.2f}"
        for mode in ([], ["--every-frame"]):
            output(pavo, "bench", source, "--rate", rate, "--repeat", "1", "--seconds", str(seconds), "--json", path,
                   *mode)
            with open(path, encoding="utf-8") as file:
                results.append(json.load(file))
    live, queued = results
    run, queue = live["runs"][0], queued["runs"][0]
    single = alone["runs"][0]["end_to_end_ms"]
    seen = [a for t, a in zip(queued["over_time"][0]["t_s"], queued["over_time"][0]["age_ms"]) if t <= seconds]
    text = f"""| {rate} frames a second offered, {LOAD} % of the capacity, for {seconds} s | done a second | dropped | age p50, ms | age p99, ms | age max, ms |
| --- | --- | --- | --- | --- | --- |
| pavo, live | {run['done_fps']:.1f} | {run['dropped']} | {run['age_ms']['p50']:.1f} | {run['age_ms']['p99']:.1f} | {run['age_ms']['max']:.1f} |
| a queue (`--every-frame`) | {queue['done_fps']:.1f} | {queue['dropped']} | {queue['age_ms']['p50']:.0f} | {queue['age_ms']['p99']:.0f} | {queue['age_ms']['max']:.0f} |

A frame that has the machine for itself (5 % load) takes {single['p50']:.2f} ms (p50); the age's p99, live, is
{run['age_ms']['p99'] / single['p50']:.2f} times that. Behind the queue a pose is {seen[-1] / 1000:.1f} s old after {seconds} s, when the plot
ends; the queue is empty, and the table's largest age reached, as much later again."""
    picture = age_picture(live["over_time"][0], queued["over_time"][0], seconds)
    return text, picture


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build", "release"))
    parser.add_argument("--source", default="synthetic")
    parser.add_argument("--seconds", type=float, default=3)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--age-seconds", type=int, default=60)
    parser.add_argument("--only", nargs="+", choices=PARTS)
    parser.add_argument("--print", action="store_true")
    call = parser.parse_args()
    wanted = call.only or PARTS
    pipeline = os.path.join(call.build, "bench", "pipeline", "bench_pipeline")
    for part in wanted:
        where, picture = machine(), None
        if part == "handoff":
            text = output(os.path.join(call.build, "bench", "handoff", "bench_handoff"))
        elif part == "alone":
            text = output(pipeline, "alone", call.source, str(call.rounds))
        elif part == "trace":
            text = output(os.path.join(call.build, "bench", "trace", "bench_trace"), call.source)
        elif part == "beat":
            text = output(os.path.join(ROOT, "bench", "realtime", "run.sh"), call.build)
        elif part == "age":
            text, picture = measure_age(os.path.join(call.build, "tools", "pavo"), call.source, call.age_seconds)
        else:
            text = output(pipeline, call.source if part == "real" else part, str(call.seconds), str(call.rounds))
        text += "\n\n" + where
        if call.print:
            print(text + "\n", flush=True)
            continue
        with open(PAGE, encoding="utf-8") as file:
            page = write_part(file.read(), part, text)
        with open(PAGE, "w", encoding="utf-8") as file:
            file.write(page)
        if picture:
            with open(PICTURE, "w", encoding="utf-8") as file:
                file.write(picture)


if __name__ == "__main__":
    main()
