// SPDX-License-Identifier: MIT
#include <ostream>

#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/report.h"
#include "tools/table.h"

namespace skinlod {

int formats_command(std::span<const std::string> args, const Console& console) {
  bool json = false;
  CommandLine line("formats", "[--json]", "Lists the file formats that skinlod reads and writes.");
  line.flag("--json", json, "as JSON");
  if (!line.parse(args, console.out)) return 0;
  if (json) {
    console.out << text(report(formats()));
    return 0;
  }
  std::vector<std::vector<std::string>> rows = {{"format", "reads", "writes", "extensions"}};
  for (const Format& format : formats()) {
    std::string extensions;
    for (const std::string& e : format.extensions) extensions += (extensions.empty() ? "." : " .") + e;
    rows.push_back({format.name, format.reads ? "yes" : "", format.writes ? "yes" : "", extensions});
  }
  print_table(console.out, rows);
  return 0;
}

}  // namespace skinlod
