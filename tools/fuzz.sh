#!/bin/sh
# Fuzzes everything that parses a file: tools/fuzz.sh [SECONDS for each fuzzer, default 60] [FUZZER...]
# New inputs are kept in build/fuzz/found/NAME, crashes in build/fuzz/crashes/; "tools/fuzz.sh 0" merges what was found
# into tests/fuzz/corpus/NAME (only what adds coverage), where it becomes a regression test.
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-60}
[ $# -gt 0 ] && shift

cmake --preset fuzz >/dev/null
cmake --build --preset fuzz --target fuzzers
mkdir -p build/fuzz/crashes
status=0
for fuzzer in ${*:-$(ls tests/fuzz/corpus)}; do
  found=build/fuzz/found/$fuzzer
  corpus=tests/fuzz/corpus/$fuzzer
  mkdir -p "$found"
  limits="-max_len=4096 -timeout=10 -rss_limit_mb=2048 -artifact_prefix=build/fuzz/crashes/$fuzzer-"
  if [ "$seconds" = 0 ]; then
    mode="-set_cover_merge=1 $corpus $found"
  else
    mode="-max_total_time=$seconds -print_final_stats=1 $found $corpus"
  fi
  echo "== $fuzzer"
  # shellcheck disable=SC2086 # the options are words
  nice -n 10 "build/fuzz/tests/fuzz/fuzz_$fuzzer" $limits $mode >"build/fuzz/$fuzzer.log" 2>&1 || status=1
  tail -n 4 "build/fuzz/$fuzzer.log"
done
[ $status = 0 ] || echo "tools/fuzz.sh: something was found: see build/fuzz/crashes/ and build/fuzz/*.log" >&2
exit $status
