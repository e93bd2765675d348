// SPDX-License-Identifier: MIT
#pragma once

#include <iosfwd>
#include <string>
#include <string_view>

namespace skinlod {

/// True where `stream` is standard error and that is a terminal.
bool is_terminal(const std::ostream& stream);

/// One line that is drawn over and over: a bar, the percentage of the stage, the stage. Gone when the object
/// goes, so that whatever is said next stands on a clean line. Draws nothing unless `shown`.
class ProgressBar {
 public:
  ProgressBar(std::ostream& out, bool shown) : out_(out), shown_(shown) {}
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `fraction` of `stage` is done, 0 to 1.
  void operator()(std::string_view stage, double fraction);
  void clear();

 private:
  std::ostream& out_;
  bool shown_;
  std::string line_;  // as it stands on the terminal
};

}  // namespace skinlod
