#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# From a fresh clone to a cooked character: installs what is missing, builds skinlod in build/, cooks
# content/humanoid.glb and prints its levels of detail. Run it again at any time, from any folder.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

"$root/tools/install.sh" build
"$root/tools/build.sh" skinlod
"$root/build/skinlod" cook "$root/content/humanoid.glb" -o "$root/build/humanoid.slod"
