// SPDX-License-Identifier: MIT
#include "pipeline/metrics/limit_influences.h"

#include "pipeline/influences.h"
#include "pipeline/parallel.h"

namespace skinlod {

History limit_influences(const Mesh& mesh, std::vector<Influences>& influences, int cap,
                         const std::function<Influences(int)>& refit) {
  std::vector<int> over;
  for (int v = 0; cap > 0 && v < mesh.vertex_count(); ++v) {
    if (mesh.alive(v) && int(influences[v].size()) > cap) over.push_back(v);
  }
  parallel_for(int(over.size()), [&](int i) {
    const int v = over[i];
    influences[v] = mesh.kind(v) == Kind::Locked ? largest(influences[v], cap) : refit(v);
  });
  History history;
  for (const int v : over) history.push_back({{v, -1}, 0, mesh.position[v], influences[v]});
  return history;
}

History limit_influences(const Mesh& mesh, std::vector<Influences>& influences, int cap) {
  return limit_influences(mesh, influences, cap, [&](int v) { return largest(influences[v], cap); });
}

}  // namespace skinlod
