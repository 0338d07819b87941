#!/usr/bin/env bash
# clang-tidy, with the settings of .clang-tidy, on the sources of the release build.
#   tools/tidy.sh [--changed]   --changed: only the files that the last commit touched
set -euo pipefail
cd "$(dirname "$0")/.."
[ -f build/release/compile_commands.json ] || cmake --preset release >/dev/null

if [ "${1:-}" = --changed ]; then
  mapfile -t files < <(git diff --name-only --diff-filter=d HEAD~1 -- '*.cpp' 2>/dev/null | grep -E '^(engine|stages|drivers|pavo|tools)/' || true)
else
  mapfile -t files < <(git ls-files 'engine/*.cpp' 'stages/*.cpp' 'drivers/*.cpp' 'pavo/*.cpp' 'tools/*.cpp')
fi
[ ${#files[@]} -eq 0 ] && { echo "nothing to check"; exit 0; }
printf '%s\n' "${files[@]}" | xargs -P "$(nproc)" -n 1 clang-tidy -p build/release --quiet --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-unused-command-line-argument 2>/dev/null
echo "${#files[@]} files are clean"
