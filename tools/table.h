// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

/// Text for people: aligned columns and numbers that can be taken in at a glance. Machines read the report.
namespace skinlod {

/// 13832 as "13,832".
std::string grouped(std::int64_t number);

/// Three significant digits without an exponent; "0" for what rounds to nothing.
std::string rounded(double number);

/// Rows of cells, columns padded to their widest cell: the first to the left, the others to the right.
void print_table(std::ostream& out, const std::vector<std::vector<std::string>>& rows);

}  // namespace skinlod
