#!/usr/bin/env bash
# clang-tidy, with the settings of .clang-tidy, on each source for itself (the builds compile several as one).
#   tools/tidy.sh [--changed]   --changed: only the files that the last commit touched
set -euo pipefail
cd "$(dirname "$0")/.."
cmake --preset release -B build/tidy -DCMAKE_UNITY_BUILD=OFF -DPAVO_BUILD_TESTS=OFF >/dev/null

if [ "${1:-}" = --changed ]; then
  mapfile -t files < <(git diff --name-only --diff-filter=d HEAD~1 -- '*.cpp' 2>/dev/null | grep -E '^(engine|stages|drivers|pavo|tools)/' || true)
else
  mapfile -t files < <(git ls-files 'engine/*.cpp' 'stages/*.cpp' 'drivers/*.cpp' 'pavo/*.cpp' 'tools/*.cpp')
fi
[ ${#files[@]} -eq 0 ] && { echo "nothing to check"; exit 0; }
printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -n 1 clang-tidy -p build/tidy --quiet --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-unused-command-line-argument 2>/dev/null
echo "${#files[@]} files are clean"
