#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Configures build/ as Release, where that is not done yet, and builds the targets named, or everything.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

if [ ! -f "$root/build/CMakeCache.txt" ]; then
  command -v ninja > /dev/null && export CMAKE_GENERATOR=Ninja
  cmake -S "$root" -B "$root/build" -D CMAKE_BUILD_TYPE=Release
fi
cmake --build "$root/build" --parallel "$(nproc)" ${1:+--target "$@"}
