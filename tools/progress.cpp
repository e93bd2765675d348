// SPDX-License-Identifier: MIT
#include "tools/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iostream>

namespace skinlod {

bool is_terminal(const std::ostream& stream) { return &stream == &std::cerr && isatty(STDERR_FILENO) == 1; }

void ProgressBar::operator()(std::string_view stage, double fraction) {
  if (!shown_) return;
  constexpr int kWidth = 24;
  const double done = std::clamp(fraction, 0.0, 1.0);
  const int full = int(done * kWidth);
  char percent[8];
  std::snprintf(percent, sizeof percent, "%3d %%", int(done * 100));
  const std::string line = "[" + std::string(size_t(full), '#') + std::string(size_t(kWidth - full), '.') +
                           "] " + percent + " " + std::string(stage.substr(0, 40));
  if (line == line_) return;
  out_ << "\r\x1b[K" << line << std::flush;
  line_ = line;
}

void ProgressBar::clear() {
  if (line_.empty()) return;
  out_ << "\r\x1b[K" << std::flush;
  line_.clear();
}

}  // namespace skinlod
