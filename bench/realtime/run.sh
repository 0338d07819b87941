#!/bin/sh
# bench/realtime/run.sh [BUILD] [SECONDS]: the engine's beat alone, then beside stress-ng on every core.
set -eu
build=${1:-build/release}
seconds=${2:-10}
bench="$build/bench/realtime/bench_realtime"
printf "Alone:\n\n"
"$bench" "$seconds"
if ! command -v stress-ng >/dev/null; then
  echo "stress-ng is not installed (apt-get install stress-ng): the part beside load is left out" >&2
  exit 0
fi
stress-ng --cpu 0 --vm 1 --vm-bytes 64M --timeout 0 >/dev/null 2>&1 &
load=$!
trap 'kill $load' EXIT
sleep 1
printf '\nBeside `stress-ng --cpu 0 --vm 1`:\n\n'
"$bench" "$seconds"
