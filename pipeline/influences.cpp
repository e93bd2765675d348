// SPDX-License-Identifier: MIT
#include "pipeline/influences.h"

#include <algorithm>
#include <cmath>

#include "pipeline/side_by_side.h"

namespace skinlod {

Influences blend(const Influences& a, const Influences& b, double t) {
  Influences sum;
  sum.reserve(a.size() + b.size());
  const auto joint = [](const Influence& i) { return i.joint; };
  side_by_side(a, b, joint, [&](const Influence* i, const Influence* j) {
    sum.push_back({i ? i->joint : j->joint, (i ? (1 - t) * i->weight : 0) + (j ? t * j->weight : 0)});
  });
  erase_if(sum, [](const Influence& influence) { return influence.weight == 0; });
  return sum;
}

ToSumOne::ToSumOne(double sum, double magnitude, int count) {
  constexpr double kCancelled = 0.1;
  if (sum > kCancelled * magnitude) {
    divisor = sum;
  } else {
    shift = (1 - sum) / count;
  }
}

Influences largest(Influences influences, int count) {
  if (count > 0 && int(influences.size()) > count) {
    std::stable_sort(influences.begin(), influences.end(), [](const Influence& a, const Influence& b) {
      return std::abs(a.weight) > std::abs(b.weight);
    });
    influences.resize(size_t(count));
    std::sort(influences.begin(), influences.end(),
              [](const Influence& a, const Influence& b) { return a.joint < b.joint; });
    double sum = 0, magnitude = 0;
    for (const auto& [joint, weight] : influences) sum += weight, magnitude += std::abs(weight);
    const ToSumOne to_sum_one(sum, magnitude, count);
    for (Influence& influence : influences) influence.weight = to_sum_one(influence.weight);
  }
  return influences;
}

}  // namespace skinlod
