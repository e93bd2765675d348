// SPDX-License-Identifier: MIT
#include <algorithm>
#include <ostream>

#include "pipeline/error.h"
#include "pipeline/warning.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/suggest.h"

namespace skinlod {

int explain_command(std::span<const std::string> args, const Console& console) {
  std::string given;
  CommandLine line("explain", "[CODE]",
                   "Tells what a warning means, what skinlod did about it, and how to mend the source.");
  line.input("CODE", given, "the warning's code, such as weights-absent; without it all are listed");
  const std::vector<WarningCode> codes = warning_codes();
  if (args.empty()) {
    for (const WarningCode code : codes)
      print_item(console.out, std::string(name(code)), std::string(explain(code).meaning));
    return 0;
  }
  if (!line.parse(args, console.out)) return 0;
  const auto code = std::find_if(codes.begin(), codes.end(), [&](WarningCode c) { return name(c) == given; });
  if (code == codes.end()) {
    std::vector<std::string> names;
    for (const WarningCode c : codes) names.emplace_back(name(c));
    const auto meant = closest(given, names);
    throw Error{Fault::Usage, given + ": no such code: " +
                                  (meant ? "did you mean " + *meant + "?" : "skinlod explain lists all")};
  }
  const Explanation its = explain(*code);
  console.out << its.name << '\n';
  print_item(console.out, "what it means", std::string(its.meaning));
  print_item(console.out, "what skinlod did", std::string(its.done));
  print_item(console.out, "what you can do", std::string(its.remedy));
  return 0;
}

}  // namespace skinlod
