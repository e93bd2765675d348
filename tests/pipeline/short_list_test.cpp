// SPDX-License-Identifier: MIT
#include "pipeline/short_list.h"

#include <doctest/doctest.h>

#include <random>

using namespace skinlod;

namespace {

// What an oracle has, seen through each of the ways to look.
void check_same(const ShortList<int, 3>& list, const std::vector<int>& all) {
  REQUIRE(list.size() == all.size());
  CHECK(list.empty() == all.empty());
  CHECK(std::equal(list.begin(), list.end(), all.begin(), all.end()));
  if (!all.empty()) {
    CHECK(list.front() == all.front());
    CHECK(list.back() == all.back());
    CHECK(list[all.size() / 2] == all[all.size() / 2]);
  }
}

}  // namespace

TEST_CASE("a short list is a vector, on either side of what it holds itself") {
  std::mt19937 random(7);
  const auto below = [&](size_t count) { return size_t(random()) % count; };
  ShortList<int, 3> list;
  std::vector<int> all;
  int longest = 0;
  for (int turn = 0; turn < 20000; ++turn) {
    const int item = int(below(10));
    const auto at = std::ptrdiff_t(below(all.size() + 1));
    switch (below(8)) {
      case 0:
        list.push_back(item), all.push_back(item);
        break;
      case 1:
        CHECK(list.emplace_back(item) == item);
        all.emplace_back(item);
        break;
      case 2:
      case 3:
        CHECK(*list.insert(list.begin() + at, item) == item);
        all.insert(all.begin() + at, item);
        break;
      case 4: {
        const auto size = size_t(below(7));
        list.resize(size), all.resize(size);
        break;
      }
      case 5:
        if (at == std::ptrdiff_t(all.size())) break;
        CHECK(list.erase(list.begin() + at) - list.begin() == at);
        all.erase(all.begin() + at);
        break;
      case 6: {
        const auto is_low = [&](int x) { return x < item / 4; };
        CHECK(erase_if(list, is_low) == std::erase_if(all, is_low));
        break;
      }
      default: {
        ShortList<int, 3> copy = list, moved = std::move(copy);
        CHECK(moved == list);
        CHECK(copy.empty());
        copy = list;
        list = ShortList<int, 3>(all.begin(), all.end());
        CHECK(copy == list);
      }
    }
    check_same(list, all);
    longest = std::max(longest, int(all.size()));
  }
  CHECK(longest > 6);
}

TEST_CASE("a short list takes items of its own, and gives up some in the middle") {
  for (const size_t size : {size_t(2), size_t(3), size_t(6)}) {
    ShortList<int, 3> list;
    std::vector<int> all;
    list.reserve(size + 2);
    for (size_t i = 0; i < size; ++i) list.push_back(int(i)), all.push_back(int(i));
    list.push_back(list[0]), all.push_back(0);
    list.insert(list.begin() + 1, list.back()), all.insert(all.begin() + 1, 0);
    check_same(list, all);
    const auto next = list.erase(list.begin() + 1, list.begin() + 3);
    CHECK(next == list.begin() + 1);
    all.erase(all.begin() + 1, all.begin() + 3);
    check_same(list, all);
    list.erase(list.begin(), list.begin());
    check_same(list, all);
    list.clear();
    check_same(list, {});
  }
  CHECK(ShortList<int, 3>{1, 2, 3, 4} == ShortList<int, 3>{1, 2, 3, 4});
  CHECK_FALSE(ShortList<int, 3>{1, 2} == ShortList<int, 3>{1, 2, 3});
}
