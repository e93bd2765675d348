// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace skinlod {

/// What in `value` is not as `schema` says, one line a finding; none: it is valid. Knows as much of JSON
/// Schema as report.schema.json uses, and calls a word it does not know a finding.
std::vector<std::string> schema_violations(const nlohmann::json& value, const nlohmann::json& schema,
                                           const nlohmann::json& root, const std::string& where = "$");

}  // namespace skinlod
