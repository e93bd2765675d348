// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

namespace skinlod {

/// Calls `body(i)` once for each i in 0 .. count - 1, on all threads the process may use. Calls must not
/// touch each other's results; nothing may depend on their order.
void parallel_for(int count, const std::function<void(int)>& body);

}  // namespace skinlod
