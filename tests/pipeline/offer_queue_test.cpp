// SPDX-License-Identifier: MIT
#include "pipeline/offer_queue.h"

#include <doctest/doctest.h>

#include <set>

#include "tests/random.h"

using namespace skinlod;

TEST_SUITE("offer_queue") {
  TEST_CASE("what is taken are the cheapest of all, however pushes and takes are mixed") {
    std::mt19937 random(11);
    for (const int start : {0, 1, 9, 3000}) {
      CAPTURE(start);
      OfferQueue queue;
      std::set<std::pair<double, int>> plain;
      int edge = 0;
      const auto push = [&](double cost) {
        queue.push({cost, edge}), plain.insert({cost, edge});
        ++edge;
      };
      // Few different costs: many ties.
      for (int i = 0; i < start; ++i) push(double(random() % 50));
      for (int turn = 0; turn < 20000; ++turn) {
        REQUIRE(queue.empty() == plain.empty());
        if (plain.empty() || random() % 3 != 0) {
          push(plain.empty() ? 1 : plain.begin()->first + double(random() % 8) - 2);
        } else {
          std::vector<OfferKey> taken;
          queue.take(random() % 6, taken);
          std::sort(taken.begin(), taken.end(), [](const OfferKey& a, const OfferKey& b) { return b > a; });
          for (const OfferKey& key : taken) {
            REQUIRE(!plain.empty());
            CHECK(key.edge == plain.begin()->second);
            plain.erase(plain.begin());
          }
        }
      }
      std::vector<OfferKey> all;
      queue.take(plain.size() + 1, all);
      CHECK(all.size() == plain.size());
      CHECK(queue.empty());
      push(1);
      queue.clear();
      CHECK(queue.empty());
    }
  }
}
