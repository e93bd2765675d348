// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

namespace skinlod {

/// User CPU seconds of one call of `work`, on one thread, the median of `runs`. What takes less than 50 ms is
/// called again and again for as long, since the clock does not tell less.
double user_seconds(int runs, const std::function<void()>& work);

}  // namespace skinlod
