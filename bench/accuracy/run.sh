#!/usr/bin/env bash
# How far from the truth is the frame-to-frame chain on recorded drives, and how fast is it?
#   bench/accuracy/run.sh [PAVO [DATA]]    the command (default build/release/tools/pavo), the folder with the sequences
#                                          (default PAVO_DATA). Prints the table of docs/results.md.
set -euo pipefail
pavo=${1:-$(dirname "$0")/../../build/release/tools/pavo}
data=${2:-${PAVO_DATA:?name the folder with the recorded sequences in PAVO_DATA}}
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

field() { python3 -c 'import json,sys
value = json.load(open(sys.argv[1]))
for key in sys.argv[2].split("."): value = value.get(key) if isinstance(value, dict) else None
print("-" if value is None else f"{value:.{sys.argv[3]}f}")' "$@"; }

echo "| sequence | tracker | ATE (Sim3) m | t_rel % | r_rel deg/100 m | length / true | coasting |"
echo "| --- | --- | --- | --- | --- | --- | --- |"
for sequence in kitti05-300 kitti-street-108 kitti-city-134 kitti01-51; do
  for tracker in descriptor klt; do
    "$pavo" run "$data/sequences/$sequence" --estimator frame-to-frame --no-people --scale groundtruth --tracker $tracker --out "$out/$sequence" >/dev/null
    report=$out/$sequence/report.json
    echo "| $sequence | $tracker | $(field "$report" accuracy.ate_sim3_m 3) | $(field "$report" accuracy.t_rel_percent 2) |" \
      "$(field "$report" accuracy.r_rel_deg_per_100m 2) | $(field "$report" accuracy.length_m 1) / $(field "$report" accuracy.truth_length_m 1) m | $(field "$report" poses.coasting 0) |"
  done
done

"$pavo" run "$data/sequences/euroc-standstill-25" --estimator frame-to-frame --no-people --out "$out/standing" >/dev/null
echo
echo "A camera that stands still (euroc-standstill-25, --scale unit): $(cut -d' ' -f4,8,12 "$out/standing/trajectory.kitti" | sort -u | wc -l) position(s) in 25 frames"

echo
echo "| kitti05-300 from its JPEGs, $(nproc) cores, no people | frames a second (median of 7) | trajectory_sha256 |"
echo "| --- | --- | --- |"
for workers in 1 2 4; do
  for _ in 1 2 3 4 5 6 7; do
    "$pavo" run "$data/sequences/kitti05-300" --estimator frame-to-frame --no-people --scale groundtruth --workers $workers --out "$out/speed" >/dev/null
    field "$out/speed/report.json" fps 0
  done | sort -n | sed -n 4p >"$out/fps"
  echo "| --workers $workers | $(cat "$out/fps") | $(sha256sum "$out/speed/trajectory.kitti" | cut -c1-16)... |"
done
