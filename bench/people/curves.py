#!/usr/bin/env python3
"""Miss rate against false alarms an image, as curves.

usage: curves.py OUT.svg NAME:DETECTIONS.csv:TRUTH.csv[:MIN_HEIGHT] ...

The files and rules are those of lamr.py; both axes are logarithmic, as the Caltech benchmark draws them. Python 3's own
library only.
"""
import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import lamr  # noqa: E402

WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 640, 420, 70, 50, 20, 20
X, Y = (0.005, 10.0), (0.1, 1.0)
COLOURS = ["#1f5fd0", "#2a9d3a", "#d0401f", "#8a3fb0", "#888888"]


def place(rate, miss):
    def share(value, low, high):
        return math.log(min(max(value, low), high) / low) / math.log(high / low)
    return (LEFT + share(rate, *X) * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - share(miss, *Y) * (HEIGHT - BOTTOM - TOP))


def curve(images):
    rows = sorted((row for judged, _ in images for row in judged), reverse=True)
    people, hits = sum(n for _, n in images), 0
    yield place(X[0], 1)
    for k, (_, hit) in enumerate(rows):
        hits += hit
        yield place((k + 1 - hits) / len(images), 1 - hits / people)


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="13">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>']
    for rate in (0.01, 0.1, 1, 10):
        x, y = place(rate, Y[0])
        svg.append(f'<path d="M{x:.1f} {y}V{TOP}" stroke="#ddd"/><text x="{x:.1f}" y="{y + 18}" text-anchor="middle">{rate:g}</text>')
    for miss in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1):
        x, y = place(X[0], miss)
        svg.append(f'<path d="M{x} {y:.1f}H{WIDTH - RIGHT}" stroke="#ddd"/><text x="{x - 8}" y="{y + 4:.1f}" text-anchor="end">{miss:g}</text>')
    for k, text in enumerate(sys.argv[2:]):
        name, detections, truth, *rest = text.split(":")
        images = lamr.read_set(detections, truth, float(rest[0]) if rest else 0)
        colour = COLOURS[k % len(COLOURS)]
        points, last = [], None
        for x, y in curve(images):
            if (round(x, 1), round(y, 1)) != last:
                last = (round(x, 1), round(y, 1))
                points.append(f"{x:.1f},{y:.1f}")
        svg.append(f'<polyline points="{" ".join(points)}" fill="none" stroke="{colour}" stroke-width="2"/>')
        svg.append(f'<path d="M{LEFT + 15} {HEIGHT - BOTTOM - 15 - 20 * k}h24" stroke="{colour}" stroke-width="2"/>'
                   f'<text x="{LEFT + 46}" y="{HEIGHT - BOTTOM - 11 - 20 * k}">{name}: LAMR {lamr.lamr(images):.3f}</text>')
    svg.append(f'<text x="{(LEFT + WIDTH) / 2}" y="{HEIGHT - 10}" text-anchor="middle">false alarms an image</text>')
    svg.append(f'<text transform="translate(18 {HEIGHT / 2}) rotate(-90)" text-anchor="middle">people missed</text>')
    with open(sys.argv[1], "w") as f:
        f.write("\n".join(svg) + "\n</svg>\n")


if __name__ == "__main__":
    main()
