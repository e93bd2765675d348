// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "formats/import.h"

namespace skinlod {

/// Reads what is needed of a file in any format; the name of what is nameless is the file's `stem`.
Imported import_any(const std::string& path, Need need);

/// The file's name without folder and ending: "ninja" of "a/ninja.mesh.xml".
std::string stem(const std::string& path);

}  // namespace skinlod
