// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <vector>

#include "pipeline/history.h"

namespace skinlod {

/// Gives every vertex of `mesh` that has more than `cap` influences new ones, `refit(vertex)`, and returns
/// what has changed. Nothing for `cap` 0, which is no limit. Calls of `refit` may run in parallel. A locked
/// vertex is not asked of: it keeps its largest, whatever lies around it.
History limit_influences(const Mesh& mesh, std::vector<Influences>& influences, int cap,
                         const std::function<Influences(int vertex)>& refit);

/// The same, cutting each to its `cap` largest.
History limit_influences(const Mesh& mesh, std::vector<Influences>& influences, int cap);

}  // namespace skinlod
