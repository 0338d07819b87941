#!/usr/bin/env bash
# Installs what is needed, builds pavo, and runs its main job on the synthetic street that is built into it.
#   tools/demo.sh [OUT]      OUT: the folder for the results, default out/demo
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-out/demo}

tools/setup.sh
echo "demo: building (some minutes the first time)"
cmake --preset release >/dev/null
cmake --build --preset release --target pavo_executable | tail -n 1

echo "demo: 300 frames through a street with people in it"
build/release/tools/pavo run synthetic --scale groundtruth --compare --draw "$out/frames" --out "$out"
echo "demo: the path is $out/trajectory.svg, the inside of every frame $out/frames/, all figures $out/report.json"
