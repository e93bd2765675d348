// SPDX-License-Identifier: MIT
#include "pipeline/offer_queue.h"

#include <doctest/doctest.h>

#include <queue>

#include "tests/random.h"

using namespace skinlod;

TEST_SUITE("offer_queue") {
  TEST_CASE("offers come in the order of a plain heap, however pushes and pops are mixed") {
    std::mt19937 random(11);
    for (const int start : {0, 1, 9, 3000}) {
      CAPTURE(start);
      OfferQueue queue;
      std::priority_queue<OfferKey, std::vector<OfferKey>, std::greater<>> plain;
      int edge = 0;
      const auto push = [&](double cost) {
        queue.push({cost, edge}), plain.push({cost, edge});
        ++edge;
      };
      // Few different costs: many ties.
      for (int i = 0; i < start; ++i) push(double(random() % 50));
      for (int turn = 0; turn < 20000; ++turn) {
        REQUIRE(queue.empty() == plain.empty());
        if (plain.empty() || random() % 2 == 0) {
          push(plain.empty() ? 1 : plain.top().cost + double(random() % 8) - 2);
        } else {
          CHECK(queue.front().edge == plain.top().edge);
          CHECK(queue.pop().edge == plain.top().edge);
          plain.pop();
        }
      }
      queue.clear();
      CHECK(queue.empty());
    }
  }
}
