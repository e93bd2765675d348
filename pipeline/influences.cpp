// SPDX-License-Identifier: MIT
#include "pipeline/influences.h"

#include <algorithm>

namespace skinlod {

Influences blend(const Influences& a, const Influences& b, double t) {
  Influences sum;
  auto i = a.begin();
  auto j = b.begin();
  while (i != a.end() || j != b.end()) {
    if (j == b.end() || (i != a.end() && i->joint < j->joint)) {
      sum.push_back({i->joint, (1 - t) * i->weight}), ++i;
    } else if (i == a.end() || j->joint < i->joint) {
      sum.push_back({j->joint, t * j->weight}), ++j;
    } else {
      sum.push_back({i->joint, (1 - t) * i->weight + t * j->weight}), ++i, ++j;
    }
  }
  std::erase_if(sum, [](const Influence& influence) { return !(influence.weight > 0); });
  return sum;
}

Influences largest(Influences influences, int count) {
  if (count > 0 && int(influences.size()) > count) {
    std::stable_sort(influences.begin(), influences.end(),
                     [](const Influence& a, const Influence& b) { return a.weight > b.weight; });
    influences.resize(size_t(count));
    std::sort(influences.begin(), influences.end(),
              [](const Influence& a, const Influence& b) { return a.joint < b.joint; });
    double sum = 0;
    for (const Influence& influence : influences) sum += influence.weight;
    for (Influence& influence : influences) influence.weight /= sum;
  }
  return influences;
}

}  // namespace skinlod
