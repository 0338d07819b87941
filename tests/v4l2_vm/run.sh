#!/usr/bin/env bash
# The camera driver, and `pavo run` with it, on the real kernel: boots Debian's own in a virtual machine (emulated, so
# that it works everywhere), with the kernel's virtual camera and a simulated USB webcam, and runs the tests there.
#   tests/v4l2_vm/run.sh [BUILD FOLDER] [GTEST FILTER]        default: build/release, all
#   PAVO=FILE: the command, where it is not that of this build
set -euo pipefail
cd "$(dirname "$0")/../.."
build=$(realpath "${1:-build/release}")
filter=${2:-*}
pavo=$(realpath "${PAVO:-$build/tools/pavo}")
tests=$build/tests/v4l2_vm/camera_vm_tests
uvcsim=$build/tests/v4l2_vm/uvcsim
for program in "$pavo" "$tests" "$uvcsim"; do
  [ -x "$program" ] || { echo "$0: no $program; build it first: cmake --build $build" >&2; exit 1; }
done
export VIVID_VM_CACHE=${VIVID_VM_CACHE:-$PWD/build/vm-cache}
# Sanitizers need memory for their shadow; TCG has no clock to spare, hence the time.
exec tests/v4l2_vm/run-in-vm.sh --times --timeout 1800 --mem 2500 --modules 'vivid uvcvideo vhci_hcd' \
  --copy "$pavo" --copy "$uvcsim" --env "PAVO=$pavo" --env "UVCSIM=$uvcsim" \
  --env 'ASAN_OPTIONS=detect_stack_use_after_return=0' --env 'UBSAN_OPTIONS=print_stacktrace=1' \
  -- "$tests" --gtest_filter="$filter" --gtest_brief=0
