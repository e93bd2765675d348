// SPDX-License-Identifier: MIT
#include "tools/suggest.h"

#include <algorithm>
#include <vector>

namespace skinlod {
namespace {

// The optimal string alignment distance: Levenshtein's with swaps of neighbours.
size_t slips(std::string_view a, std::string_view b) {
  std::vector<std::vector<size_t>> d(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) {
    for (size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::optional<std::string> closest(std::string_view word, std::span<const std::string> candidates) {
  std::optional<std::string> best;
  size_t fewest = std::max<size_t>(1, std::min<size_t>(word.size() / 3, 3)) + 1;
  for (const std::string& candidate : candidates) {
    if (candidate.size() > word.size() + 3 || word.size() > candidate.size() + 3) continue;
    if (const size_t n = slips(word, candidate); n < fewest) fewest = n, best = candidate;
  }
  if (best) return best;
  // Half a name is a guess too: --influences for --max-influences.
  const std::string_view bare = word.substr(std::min(word.find_first_not_of('-'), word.size()));
  for (const std::string& candidate : candidates) {
    if (bare.size() >= 3 && candidate.find(bare) != std::string::npos) return candidate;
  }
  return std::nullopt;
}

}  // namespace skinlod
