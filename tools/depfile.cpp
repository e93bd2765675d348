// SPDX-License-Identifier: MIT
#include "tools/depfile.h"

#include "pipeline/error.h"

namespace skinlod {
namespace {

std::string escaped(const std::string& path) {
  std::string out;
  for (size_t i = 0; i < path.size(); ++i) {
    const char c = path[i];
    if (c == '\n' || c == '\r') {
      throw Error{Fault::Usage,
                  "--depfile: a file name with a line break cannot stand in a Makefile: rename it"};
    }
    if (c == ' ' || c == '\t' || c == '#') {
      // make halves the backslashes before an escaped blank, and leaves all others alone.
      for (size_t back = i; back > 0 && path[back - 1] == '\\'; --back) out += '\\';
      out += '\\';
    } else if (c == ':') {
      out += '\\';
    } else if (c == '$') {
      out += '$';
    }
    out += c;
  }
  return out;
}

}  // namespace

std::string depfile(const std::string& target, std::span<const std::string> inputs) {
  std::string rule = escaped(target) + ":";
  for (const std::string& input : inputs) rule += " \\\n  " + escaped(input);
  return rule + "\n";
}

}  // namespace skinlod
