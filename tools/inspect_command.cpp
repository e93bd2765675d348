// SPDX-License-Identifier: MIT
#include <ostream>

#include "formats/file.h"
#include "pipeline/error.h"
#include "pipeline/repair.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/report.h"
#include "tools/table.h"

namespace skinlod {
namespace {

// The text is written from the report: what people see and what machines get are one.
std::string number(const Json& value) { return grouped(value.get<std::int64_t>()); }

void print_names(std::ostream& out, const std::string& title, const Json& names) {
  out << title << " (" << names.size() << "):";
  for (const Json& name : names) out << ' ' << name.get<std::string>();
  out << '\n';
}

void print_warnings(std::ostream& out, const Warnings& warnings) {
  out << "warnings (" << warnings.size() << ")" << (warnings.empty() ? ": none\n" : ":\n");
  for (const Warning& w : warnings) out << "  " << text(w) << '\n';
}

void print_source(std::ostream& out, const Json& told, const Warnings& warnings) {
  const Json& source = told["source"];
  out << told["input"].get<std::string>() << ": " << number(source["triangles"]) << " triangles, "
      << number(source["vertices"]) << " vertices (" << number(told["imported_vertices"])
      << " before welding), " << number(source["wedges"]) << " wedges, " << number(source["joints"])
      << " joints, diagonal " << rounded(source["diagonal_metres"]) << " m\n\n";

  std::vector<std::vector<std::string>> rows = {{"part", "triangles", "wedges", "material"}};
  for (const Json& part : told["parts"]) {
    rows.push_back({part["name"], number(part["triangles"]), number(part["wedges"]), part["material"]});
  }
  print_table(out, rows);

  rows = {{"\ninfluences", "vertices"}};
  for (size_t n = 0; n < told["influence_histogram"].size(); ++n) {
    const Json& count = told["influence_histogram"][n];
    if (count != 0) rows.push_back({std::to_string(n), number(count)});
  }
  print_table(out, rows);

  if (told["clips"].empty()) {
    out << "\nno clips\n";
  } else {
    rows = {{"clip", "seconds", "channels"}};
    for (const Json& clip : told["clips"]) {
      rows.push_back({clip["name"], rounded(clip["seconds"]), number(clip["channels"])});
    }
    out << '\n';
    print_table(out, rows);
  }
  out << '\n';
  print_names(out, "materials", told["materials"]);
  print_names(out, "morph targets", told["morphs"]);
  print_warnings(out, warnings);
}

void print_slod(std::ostream& out, const Json& told) {
  out << told["input"].get<std::string>() << ": .slod version " << told["format_version"] << ", "
      << number(told["bytes"]) << " bytes, " << number(told["head_bytes"]) << " of them the head, checksum "
      << told["checksum"].get<std::string>() << ", diagonal " << rounded(told["diagonal_metres"]) << " m\n\n";
  std::vector<std::vector<std::string>> rows = {
      {"", "", "", "", "", "infl.", "RMS error", "", "max error", "", ""},
      {"level", "triangles", "vertices", "wedges", "joints", "cap", "mm", "%", "mm", "%", "bytes"}};
  for (const Json& level : told["levels"]) {
    const Json& error = level["error"];
    rows.push_back({std::to_string(rows.size() - 2), number(level["triangles"]), number(level["vertices"]),
                    number(level["wedges"]), number(level["joints"]), number(level["influence_cap"]),
                    rounded(error["rms_metres"].get<double>() * 1000), rounded(error["rms_percent"]),
                    rounded(error["max_metres"].get<double>() * 1000), rounded(error["max_percent"]),
                    number(level["bytes"])});
  }
  print_table(out, rows);
  out << '\n';
  for (const char* list : {"joints", "parts", "materials", "morphs"}) print_names(out, list, told[list]);
}

int inspect_slod(const InputFile& input, bool json, std::ostream& out) {
  const auto bytes = read_file(input.path());
  const Json told = report(SlodStory{input.name(), bytes, read_slod(bytes, input.name())});
  if (json) {
    out << text(told);
  } else {
    print_slod(out, told);
  }
  return 0;
}

int inspect_source(const InputFile& input, const std::vector<std::string>& clips, bool json,
                   const Console& console) {
  Imported source = input.character(console.readers);
  add_clips(source, clips, console.readers);
  SourceStory story{.input = input.name(),
                    .imported_vertices = int(source.character.surface.position.size()),
                    .character = std::move(source.character),
                    .warnings = std::move(source.warnings)};
  for (Warning& w : repair(story.character)) warn(story.warnings, std::move(w));
  for (Warning& w : weld(story.character)) warn(story.warnings, std::move(w));
  const Json told = report(story);
  if (json) {
    console.out << text(told);
  } else {
    print_source(console.out, told, story.warnings);
  }
  return 0;
}

}  // namespace

int inspect_command(std::span<const std::string> args, const Console& console) {
  std::string path;
  std::vector<std::string> clips;
  bool json = false;
  CommandLine line("inspect", "FILE [options]",
                   "Shows what a .slod or a source character holds, and what a cook would warn about.");
  line.input("FILE", path, "a .slod, or a character in any format that is read; - is stdin (.slod or GLB)");
  line.words("--clips", "FILE", clips,
             "of a source: more clips, bound to the joints by name; may be repeated");
  line.flag("--json", json, "as JSON: see report.schema.json");
  if (!line.parse(args, console.out)) return 0;
  const InputFile input(path);
  if (input.is_slod() && !clips.empty()) {
    throw Error{Fault::Usage, "--clips: " + input.name() +
                                  ": is a .slod, which holds no clips: inspect the " +
                                  "source it was cooked from, or leave --clips out"};
  }
  return input.is_slod() ? inspect_slod(input, json, console.out)
                         : inspect_source(input, clips, json, console);
}

}  // namespace skinlod
