// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <exception>
#include <iostream>

#include "pipeline/error.h"
#include "tests/bench/bench.h"

namespace skinlod {
namespace {

struct Command {
  std::string name, summary;
  int (*run)(Args args, const Streams& streams);
};

int run(Args args, const Streams& streams) {
  static const std::array kCommands = {
      Command{"quality", "posed errors of all methods as multiples of per_frame's", quality_command},
      Command{"speed", "times of all methods as multiples of meshopt_simplify's", speed_command},
      Command{"evaluate", "what the evaluation costs per pose and sample", evaluate_command},
      Command{"compare", "what moved between two runs", compare_command},
      Command{"papers", "the measurements behind the papers' tables", papers_command},
  };
  const std::string word = args.empty() ? "--help" : args.front();
  for (const Command& c : kCommands) {
    if (word == c.name) return c.run(args.subspan(1), streams);
  }
  if (word != "--help" && word != "-h") {
    throw Error{Fault::Usage, word + ": no such command: see skinlod_bench --help"};
  }
  streams.out << "Usage: skinlod_bench COMMAND [options]\n\nCommands:\n";
  for (const Command& c : kCommands)
    streams.out << "  " << c.name << std::string(10 - c.name.size(), ' ') << c.summary << '\n';
  return args.empty() ? int(Fault::Usage) : 0;
}

}  // namespace

double geometric_mean(std::span<const double> values) {
  double sum = 0;
  for (const double x : values) sum += std::log(x);
  return values.empty() ? 0 : std::exp(sum / double(values.size()));
}

}  // namespace skinlod

int main(int argc, char** argv) {
  using namespace skinlod;
  try {
    const std::vector<std::string> args(argv + (argc > 0), argv + argc);
    return run(args, {std::cout, std::cerr});
  } catch (const Error& e) {
    std::cerr << "skinlod_bench: " << e.what() << '\n';
    return int(e.fault);
  } catch (const std::exception& e) {
    std::cerr << "skinlod_bench: " << e.what() << '\n';
    return int(Fault::Ours);
  }
}
