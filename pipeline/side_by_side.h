// SPDX-License-Identifier: MIT
#pragma once

namespace skinlod {

/// Walks two lists that ascend by `key` side by side: `take` gets pointers to the items of each key that is
/// in either, null where a list has none.
template <class List, class Key, class Take>
void side_by_side(const List& a, const List& b, const Key& key, const Take& take) {
  auto i = a.begin(), j = b.begin();
  while (i != a.end() || j != b.end()) {
    const bool in_a = j == b.end() || (i != a.end() && key(*i) <= key(*j));
    const bool in_b = i == a.end() || (j != b.end() && key(*j) <= key(*i));
    take(in_a ? &*i : nullptr, in_b ? &*j : nullptr);
    i += in_a, j += in_b;
  }
}

}  // namespace skinlod
