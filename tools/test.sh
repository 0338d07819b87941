#!/usr/bin/env bash
# Installs what is needed, builds everything and passes every test: release, then the same tests under
# AddressSanitizer with UndefinedBehaviorSanitizer, then under ThreadSanitizer.
#   tools/test.sh [--all]    --all: what takes long too (the benchmarks' build, all of the command's tests under the
#                            sanitizers, what has one thread under ThreadSanitizer too, fuzzing, clang-tidy on every file)
set -euo pipefail
cd "$(dirname "$0")/.."
all=${1:-}
long=OFF
[ "$all" = --all ] && long=ON
jobs=$(nproc)

step() { echo; printf '== %s (after %d min %02d s)\n' "$*" $((SECONDS / 60)) $((SECONDS % 60)); }

# Builds quietly; a failure shows what the compiler said, not only that it failed.
build() {
  local log="build/$1.log"
  local options=("-DPAVO_TEST_ALL=$long")
  if [ "$1" = release ]; then
    options+=("-DPAVO_BUILD_BENCHMARKS=$long")
  else
    options+=("-DPAVO_COMMAND_TESTS=$PWD/build/release/tests/command/test_command")
  fi
  cmake --preset "$1" "${options[@]}" >/dev/null
  cmake --build --preset "$1" --parallel "$jobs" >"$log" 2>&1 && { tail -n 1 "$log"; return; }
  grep -E -A 8 'FAILED:|error:|Killed|undefined reference' "$log" | head -n 60 >&2
  tail -n 5 "$log" >&2
  echo "test: the $1 build failed; the whole output is in $log" >&2
  exit 1
}

tools/setup.sh

step "format"
git ls-files '*.cpp' '*.h' | xargs clang-format --dry-run --Werror

for preset in release asan tsan; do
  step "$preset"
  build "$preset"
  ctest --preset "$preset" --parallel "$jobs" --output-on-failure | grep -vE ' Passed |^ +Start '
done

step "cameras on the real kernel, in a virtual machine"
tests/v4l2_vm/run.sh build/asan

step "install, and a program that uses the library"
cmake --install build/release --prefix build/install >/dev/null
cmake -S examples/push_frames -B build/example -DCMAKE_PREFIX_PATH="$PWD/build/install" >/dev/null
cmake --build build/example | tail -n 1
build/example/push_frames | tail -n 1

step "clang-tidy"
if [ "$all" = --all ]; then tools/tidy.sh; else tools/tidy.sh --changed; fi

if [ "$all" = --all ]; then
  step "fuzzing"
  tools/fuzz.sh 60
fi

step "all passed"
