// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "formats/import.h"

namespace skinlod {

/// An Imported as bytes, to come back from the process that read it. Both ends are the same program, so there
/// is no version and no byte order. The glTF document is not carried.
std::vector<std::byte> to_bytes(const Imported& imported);

/// Throws Error{Input} where the bytes are no whole archive.
Imported from_bytes(std::span<const std::byte> bytes);

}  // namespace skinlod
