#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds the targets named, or everything, in build/ or $SKINLOD_BUILD; configures it as Release where that is
# not done yet.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${SKINLOD_BUILD:-$root/build}

if [ ! -f "$build/CMakeCache.txt" ]; then
  if command -v ninja > /dev/null; then export CMAKE_GENERATOR=Ninja; fi
  cmake -S "$root" -B "$build" -D CMAKE_BUILD_TYPE=Release
fi
cmake --build "$build" --parallel "$(nproc)" ${1:+--target "$@"}
