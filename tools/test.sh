#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds and runs all tests; what is missing is installed. Arguments go to ctest, e.g. -R collapse.
# Fails where a test fails, is skipped or cannot run, and where there is none.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${SKINLOD_BUILD:-$root/build}

"$root/tools/install.sh" build
"$root/tools/build.sh"
ctest --test-dir "$build" --output-on-failure --no-tests=error --parallel "$(nproc)" "$@" | tee "$build/test.log"
# ctest calls a run good in which tests were disabled or skipped.
if grep -E '\*\*\*(Skipped|Not Run)|\((Disabled|Skipped)\)' "$build/test.log"; then
  echo "FAILED: the tests above were not run" >&2
  exit 1
fi
