// SPDX-License-Identifier: MIT
#include "pipeline/parallel.h"

#include <tbb/parallel_for.h>

namespace skinlod {

void parallel_for(int count, const std::function<void(int)>& body) {
  tbb::parallel_for(0, count, [&](int i) { body(i); });
}

}  // namespace skinlod
