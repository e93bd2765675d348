// SPDX-License-Identifier: MIT
#include "tools/table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <string_view>

namespace skinlod {

std::string grouped(std::int64_t number) {
  std::string digits = std::to_string(number);
  const int first = number < 0;
  for (int at = int(digits.size()) - 3; at > first; at -= 3) digits.insert(size_t(at), ",");
  return digits;
}

std::string rounded(double number) {
  if (!std::isfinite(number)) return "not finite";
  int decimals = 2;
  for (double size = std::fabs(number); size >= 10 && decimals > 0; size /= 10) --decimals;
  for (double size = std::fabs(number); size < 1 && decimals < 6; size *= 10) ++decimals;
  char text[400];  // DBL_MAX has 309 digits
  std::snprintf(text, sizeof text, "%.*f", decimals, number);
  const bool nothing = std::string_view(text).find_first_of("123456789") == std::string_view::npos;
  return nothing ? "0" : text;
}

void print_table(std::ostream& out, const std::vector<std::vector<std::string>>& rows) {
  std::vector<size_t> width;
  for (const auto& row : rows) {
    width.resize(std::max(width.size(), row.size()));
    for (size_t c = 0; c < row.size(); ++c) width[c] = std::max(width[c], row[c].size());
  }
  for (const auto& row : rows) {
    std::string line;
    for (size_t c = 0; c < row.size(); ++c) {
      const std::string blank(width[c] - row[c].size(), ' ');
      line += c == 0 ? row[c] + blank : "  " + blank + row[c];
    }
    out << line.substr(0, line.find_last_not_of(' ') + 1) << '\n';
  }
}

}  // namespace skinlod
