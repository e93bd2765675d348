// SPDX-License-Identifier: MIT
#include "pipeline/byte_weights.h"

#include <algorithm>

namespace skinlod {

std::vector<ByteInfluence> round_weights(const Influences& influences) {
  struct Rounding {
    int joint, whole;
    double rest;
  };
  double sum = 0;
  for (const Influence& i : influences) sum += i.weight;
  std::vector<Rounding> shares;
  int left = 255;
  for (const Influence& i : influences) {
    const double exact = i.weight / sum * 255;
    const int whole = int(exact);
    shares.push_back({i.joint, whole, exact - whole});
    left -= whole;
  }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const Rounding& a, const Rounding& b) { return a.rest > b.rest; });
  for (int i = 0; i < left; ++i) ++shares[size_t(i) % shares.size()].whole;

  std::vector<ByteInfluence> rounded;
  for (const Rounding& s : shares) {
    if (s.whole > 0) rounded.push_back({s.joint, std::uint8_t(s.whole)});
  }
  std::sort(rounded.begin(), rounded.end(), [](const ByteInfluence& a, const ByteInfluence& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.joint < b.joint;
  });
  return rounded;
}

Influences rounded(const Influences& influences) {
  Influences result;
  for (const ByteInfluence& i : round_weights(influences)) result.push_back({i.joint, i.weight / 255.0});
  std::ranges::sort(result, {}, &Influence::joint);
  return result;
}

}  // namespace skinlod
