// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace skinlod {

/// The candidate that somebody who typed `word` most likely meant: the fewest slips of the finger (a letter
/// too many, missing, wrong, or two swapped), the first of equals; nothing where even that is far off.
std::optional<std::string> closest(std::string_view word, std::span<const std::string> candidates);

}  // namespace skinlod
