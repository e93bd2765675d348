// SPDX-License-Identifier: MIT
#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>

#include "pipeline/error.h"
#include "tests/bench/bench.h"
#include "tools/command_line.h"
#include "tools/table.h"

namespace skinlod {
namespace {

// What is compared, by the case's name; all of it is worse when it is larger. Seconds and metres are not:
// other machines and other poses have others.
using Ratios = std::map<std::string, double>;

void add_ratios(Ratios& ratios, const std::string& name, const Json& line) {
  for (const auto& [key, value] : line.items()) {
    if (value.is_object()) {
      add_ratios(ratios, name + " " + key, value);
    } else if (value.is_number() && key.ends_with("ratio")) {
      ratios[name + " " + key] = value;
    }
  }
}

Ratios read(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error{Fault::Access, path + ": cannot be read"};
  Ratios ratios;
  int number = 0;
  for (std::string text; std::getline(file, text);) {
    ++number;
    if (text.empty()) continue;
    const Json line = Json::parse(text, nullptr, false);
    if (!line.is_object()) {
      throw Error{Fault::Input, path + ": line " + std::to_string(number) + ": is no JSON object"};
    }
    std::string name;
    for (const auto& [key, value] : line.items()) {
      if (value.is_string()) name += (name.empty() ? "" : " ") + value.get<std::string>();
    }
    add_ratios(ratios, name, line);
  }
  return ratios;
}

double share(const std::string& option, const std::string& text) {
  double percent = 0;
  const char* const last = text.data() + text.size() - text.ends_with('%');
  const auto [end, fault] = std::from_chars(text.data(), last, percent);
  if (fault == std::errc{} && end == last && percent >= 0) return percent / 100;
  throw Error{Fault::Usage, option + ": '" + text + "' is no percentage: write 2%"};
}

struct Move {
  std::string name;
  double from, to;
  double change() const { return from > 0 ? to / from - 1 : (to > 0 ? 1 : 0); }
};

}  // namespace

int compare_command(Args args, const Streams& streams) {
  std::string old_path, new_path, threshold = "1%", allow = "2%";
  CommandLine line("compare", "OLD.jsonl NEW.jsonl [options]",
                   "Prints what moved between two runs. Exits with 1 if anything got worse by too much.",
                   "skinlod_bench");
  line.input("OLD.jsonl", old_path, "an earlier run");
  line.input("NEW.jsonl", new_path, "this run");
  line.word("--threshold", "PERCENT", threshold, "a smaller change is not printed");
  line.word("--allow", "PERCENT", allow, "how much worse a case may be");
  if (!line.parse(args, streams.out)) return 0;
  const double least = share("--threshold", threshold), most = share("--allow", allow);
  const Ratios before = read(old_path), after = read(new_path);

  std::vector<Move> moves;
  size_t shared = 0;
  bool worse = false;
  for (const auto& [name, to] : after) {
    const auto from = before.find(name);
    if (from == before.end()) continue;
    ++shared;
    const Move move{name, from->second, to};
    worse = worse || move.change() > most;
    if (std::abs(move.change()) > least) moves.push_back(move);
  }
  if (shared == 0) throw Error{Fault::Input, new_path + ": shares no case with " + old_path};
  std::stable_sort(moves.begin(), moves.end(),
                   [](const Move& a, const Move& b) { return a.change() > b.change(); });
  std::vector<std::vector<std::string>> rows = {{"case", "old", "new", "change"}};
  for (const Move& move : moves) {
    rows.push_back({move.name, rounded(move.from), rounded(move.to),
                    (move.change() > 0 ? "+" : "-") + rounded(100 * std::abs(move.change())) + " %"});
  }
  if (!moves.empty()) print_table(streams.out, rows);
  streams.out << shared << " compared, " << moves.size() << " moved by more than " << threshold << ", "
              << before.size() - shared << " gone, " << after.size() - shared << " new\n";
  return worse ? 1 : 0;
}

}  // namespace skinlod
