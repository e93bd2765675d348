// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <ostream>
#include <span>
#include <string>
#include <vector>

/// The bench: a JSON line per case on standard output and a table for people on standard error. Errors are
/// multiples of per_frame's and times are multiples of meshopt_simplify's, all found in one run.
namespace skinlod {

using Json = nlohmann::ordered_json;
using Args = std::span<const std::string>;

/// What a command talks to.
struct Streams {
  std::ostream& out;  // results
  std::ostream& err;  // tables, progress
};

/// The commands, each in a file of its own. They return 0, or 1 for "the answer is no".
int quality_command(Args args, const Streams& streams);
int speed_command(Args args, const Streams& streams);
int evaluate_command(Args args, const Streams& streams);
int compare_command(Args args, const Streams& streams);
int papers_command(Args args, const Streams& streams);

/// A case, on a line of its own.
inline void print_line(std::ostream& out, const Json& line) {
  out << line.dump(-1, ' ', false, Json::error_handler_t::replace) << std::endl;
}

/// Of the positive numbers; 0 where there is none.
double geometric_mean(std::span<const double> values);

}  // namespace skinlod
