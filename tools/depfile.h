// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>

namespace skinlod {

/// The Makefile rule "target: inputs", as make and ninja read it, with the paths as they were given.
/// Throws Error{Usage} where a path holds a line break, which no Makefile can name.
std::string depfile(const std::string& target, std::span<const std::string> inputs);

}  // namespace skinlod
