// SPDX-License-Identifier: MIT
#include "pipeline/large_pages.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <numeric>

using namespace skinlod;

TEST_CASE("a vector in large pages grows, is copied and shrinks like any other") {
  LargeVector<int> numbers;
  for (int i = 0; i < 3000000; ++i) numbers.push_back(i);  // from a few bytes to 12 MB
  LargeVector<int> copy = numbers;
  const LargeVector<int> moved = std::move(numbers);
  CHECK(copy == moved);
  CHECK(reinterpret_cast<std::uintptr_t>(moved.data()) % (size_t(2) << 20) == 0);
  copy.resize(10);
  copy.shrink_to_fit();
  CHECK(std::accumulate(copy.begin(), copy.end(), 0) == 45);
  CHECK(std::accumulate(moved.begin(), moved.end(), 0LL) == 2999999LL * 3000000 / 2);
}

TEST_CASE("items with a constructor are made by it, wherever they lie") {
  struct Seven {
    int value = 7;
  };
  for (const size_t count : {size_t(3), size_t(5000000)}) {
    const LargeVector<Seven> all(count);
    size_t sevens = 0;
    for (const Seven& item : all) sevens += item.value == 7;
    CHECK(sevens == count);
  }
}
