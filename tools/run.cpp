// SPDX-License-Identifier: MIT
#include "tools/run.h"

#include <array>
#include <ostream>
#include <string_view>
#include <vector>

#include "pipeline/error.h"
#include "tools/commands.h"
#include "tools/outputs.h"
#include "tools/suggest.h"

namespace skinlod {
namespace {

struct Command {
  std::string_view name;
  std::string_view summary;
  int (*run)(std::span<const std::string> args, const Console& console);
};

constexpr std::array kCommands = {
    Command{"cook", "a rigged character in, a chain of levels of detail out", cook_command},
    Command{"evaluate", "how far levels lie from their original when both move", evaluate_command},
    Command{"inspect", "what a .slod or a source character holds", inspect_command},
    Command{"explain", "what a warning means and how to mend its cause", explain_command},
    Command{"formats", "the file formats that can be read and written", formats_command},
};

void print_help(std::ostream& out) {
  out << "skinlod " SKINLOD_VERSION
         ": levels of detail for rigged characters that hold in motion\n\n"
         "Usage: skinlod COMMAND [options]\n\nCommands:\n";
  for (const Command& c : kCommands) {
    out << "  " << c.name << std::string(10 - c.name.size(), ' ') << c.summary << '\n';
  }
  out << "\n  skinlod COMMAND --help shows a command's options; skinlod --version the version.\n\n"
         "Exit codes:\n"
         "  0   done\n"
         "  1   ran, and the answer is no: a target was not reached\n"
         "  2   the command line is wrong\n"
         "  3   an input is broken or not supported, or --strict found a warning\n"
         "  4   a file cannot be read or written\n"
         "  5   a fault of skinlod itself\n"
         "  75  a passing fault: the disk is full, or memory ran out; try again\n";
}

[[noreturn]] void refuse(const std::string& word) {
  std::vector<std::string> names;
  for (const Command& c : kCommands) names.emplace_back(c.name);
  if (const auto name = closest(word, names)) {
    throw Error{Fault::Usage, word + ": no such command: did you mean skinlod " + *name + "?"};
  }
  if (word.starts_with("-")) {
    throw Error{Fault::Usage, word + ": options follow a command: see skinlod --help"};
  }
  if (word.find('.') != std::string::npos) {  // Dropping a file on a program is what one tries first.
    throw Error{Fault::Usage, word + ": not a command: to cook it, skinlod cook " + word + " -o OUT.slod"};
  }
  throw Error{Fault::Usage, word + ": no such command: see skinlod --help"};
}

int dispatch(std::span<const std::string> args, const Console& console) {
  if (args.empty()) {
    throw Error{Fault::Usage, "no command: skinlod cook HERO.glb -o HERO.slod, or see skinlod --help"};
  }
  const std::string& word = args.front();
  if (word == "help" && args.size() > 1) {
    const std::vector<std::string> help = {args[1], "--help"};
    return dispatch(help, console);
  }
  if (word == "--help" || word == "-h" || word == "help") {
    print_help(console.out);
    return 0;
  }
  if (word == "--version") {
    console.out << "skinlod " SKINLOD_VERSION "\n";
    return 0;
  }
  for (const Command& c : kCommands) {
    if (word == c.name) return c.run(args.subspan(1), console);
  }
  refuse(word);
}

}  // namespace

int run(std::span<const std::string> args, std::ostream& out, std::ostream& err, const Readers& readers) {
  const int result = dispatch(args, {out, err, readers});
  flush(out);
  return result;
}

}  // namespace skinlod
