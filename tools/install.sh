#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Installs the Debian 12 packages that building or checking skinlod needs and that are missing.
# Usage: tools/install.sh [build] [checks] [importers]. Does nothing, and asks for nothing, where all are there.
set -euo pipefail

build='
g++                   compiles skinlod
cmake                 configures the build
ninja-build           runs the build
libeigen3-dev         linear algebra
libtbb-dev            threads
libmeshoptimizer-dev  the codecs of .slod files
libassimp-dev         reads FBX, Collada, X, B3D, MD5 and Ogre
zlib1g-dev            links Assimp, whose package does not ask for it
libtinygltf-dev       reads and writes glTF
libstb-dev            images in glTF files, for tinygltf
nlohmann-json3-dev    JSON, for tinygltf and reports
libcli11-dev          the command line
doctest-dev           the tests
libxxhash-dev         the tests: their oracle of checksums'

checks='
clang                 the second compiler
clang-format          checks how the code is laid out
clang-tidy            checks how the code is named, and for common mistakes
python3               runs the tables and checks in tools/
gnuplot-nox           plots what tools/paper_tables.py measured
nodejs                runs the Khronos glTF validator
npm                   installs the Khronos glTF validator
libopengl-dev         OpenGL, for skinlod_sheet
libegl-dev            OpenGL without a screen
libegl-mesa0          its driver
libgl1-mesa-dri       its software renderer
glslang-tools         compiles runtime/shaders for Vulkan'

importers='
blender               writes characters as FBX and Collada
python3-numpy         its importer of glTF, whose package does not ask for it
assimp-utils          writes them in more formats'

# A command of the package's name, found anywhere, is as good as the package.
present() {
  command -v "$1" > /dev/null || [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2> /dev/null)" = installed ]
}

missing=()
list=''
for group in "${@:-build}"; do
  while read -r package why; do
    if [ -n "$package" ] && ! present "$package"; then
      missing+=("$package")
      list+="$(printf '  %-22s%s' "$package" "$why")"$'\n'
    fi
  done <<< "${!group}"
done
[ ${#missing[@]} -gt 0 ] || exit 0

if ! grep -qsx 'VERSION_CODENAME=bookworm' /etc/os-release || ! command -v apt-get > /dev/null; then
  echo "This is not Debian 12, so nothing is installed. What these packages of Debian 12 hold must be there:"
  printf '%s' "$list"
  exit 0
fi
echo "Installing from Debian, with apt-get, what is missing:"
printf '%s' "$list"
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo > /dev/null; then
    echo "apt-get must run as root and there is no sudo. As root, run: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
  apt-get install -y -qq --no-install-recommends "${missing[@]}"
