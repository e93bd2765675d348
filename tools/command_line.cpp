// SPDX-License-Identifier: MIT
#include "tools/command_line.h"

#include <algorithm>
#include <charconv>
#include <ostream>
#include <sstream>

#include "pipeline/error.h"
#include "tools/suggest.h"

namespace skinlod {
namespace {

constexpr size_t kTextColumn = 28, kPageWidth = 100;

}  // namespace

void print_item(std::ostream& out, const std::string& left, const std::string& text) {
  size_t column = left.size() + 2;
  out << "  " << left;
  if (column + 2 > kTextColumn) out << '\n', column = 0;
  out << std::string(kTextColumn - column, ' '), column = kTextColumn;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (column > kTextColumn && column + 1 + word.size() > kPageWidth) {
      out << '\n' << std::string(kTextColumn, ' '), column = kTextColumn;
    }
    if (column > kTextColumn) out << ' ', ++column;
    out << word, column += word.size();
  }
  out << '\n';
}

std::optional<std::string> slip(const std::string& word) {
  if (word.find_first_not_of("0123456789.,%") == std::string::npos)
    return "lists are written without spaces, 50%,25%";
  if (word.ends_with(".slod")) return "did you mean -o " + word + "?";
  return std::nullopt;
}

std::int64_t whole_number(const std::string& option, const std::string& value, std::int64_t least,
                          std::int64_t most) {
  std::int64_t number = 0;
  const auto [end, fault] = std::from_chars(value.data(), value.data() + value.size(), number);
  const bool whole = fault == std::errc{} && end == value.data() + value.size();
  if (whole && number >= least && number <= most) return number;
  throw Error{Fault::Usage, option + ": '" + value + "' is " +
                                (whole ? "out of range" : "not a whole number in range") + ": give " +
                                std::to_string(least) + " to " + std::to_string(most)};
}

std::vector<std::string> items(const std::string& list) {
  std::vector<std::string> all(1);
  for (const char c : list) {
    if (c == ',') {
      all.emplace_back();
    } else if (c != ' ') {
      all.back() += c;
    }
  }
  return all;
}

CommandLine::CommandLine(const std::string& name, std::string usage, std::string summary,
                         const std::string& program)
    : app_(std::move(summary)), name_(program + " " + name), usage_(std::move(usage)) {
  app_.allow_extras();  // Left over words are refused in our own words, and before anything else is.
  app_.set_help_flag("-h,--help", "this page");
}

CLI::Option* CommandLine::add(const std::string& names, const std::string& unit, const std::string& text,
                              const std::string& value, Take take, bool many) {
  const std::string shown = names.substr(0, names.find(','));
  const auto take_all = [shown, many, take = std::move(take)](const CLI::results_t& given) {
    if (given.size() > 1 && !many) throw Error{Fault::Usage, shown + ": given twice: give it once"};
    for (const std::string& one : given) {
      if (one.starts_with("--")) {
        throw Error{Fault::Usage, shown + ": needs a value: '" + one + "' is an option"};
      }
      take(shown, one);
    }
    return true;
  };
  return app_.add_option(names, take_all, text)
      ->type_name(unit)
      ->default_str(value)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->allow_extra_args(false)
      ->group(group_);
}

void CommandLine::input(const std::string& name, std::string& value, const std::string& text) {
  inputs_.push_back(add(name, "", text, "", [&value](auto&, auto& given) { value = given; }));
}

void CommandLine::inputs(const std::string& name, std::vector<std::string>& values, const std::string& text) {
  const auto take = [&values](auto&, auto& given) { values.push_back(given); };
  inputs_.push_back(add(name, "", text, "", take, true)->expected(1, 100000)->allow_extra_args());
}

void CommandLine::flag(const std::string& names, bool& value, const std::string& text) {
  app_.add_flag(names, value, text)->group(group_);
}

void CommandLine::word(const std::string& names, const std::string& unit, std::string& value,
                       const std::string& text) {
  add(names, unit, text, value, [&value](const std::string& option, const std::string& given) {
    if (given.empty()) throw Error{Fault::Usage, option + ": its value is empty: give one or leave it out"};
    value = given;
  });
}

void CommandLine::words(const std::string& names, const std::string& unit, std::vector<std::string>& values,
                        const std::string& text) {
  add(
      names, unit, text, "", [&values](auto&, auto& given) { values.push_back(given); }, true);
}

std::string CommandLine::joined(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : "|") + name;
  return all;
}

size_t CommandLine::index_in(const std::vector<std::string>& names, const std::string& option,
                             const std::string& value) {
  const auto at = std::find(names.begin(), names.end(), value);
  if (at != names.end()) return size_t(at - names.begin());
  throw Error{Fault::Usage, option + ": '" + value + "' is not known: give " + joined(names)};
}

void CommandLine::refuse_twice(const std::string& option, const std::string& item, bool twice) {
  if (twice) throw Error{Fault::Usage, option + ": '" + item + "' is listed twice: list it once"};
}

bool CommandLine::parse(std::span<const std::string> args, std::ostream& out) {
  try {
    app_.parse(std::vector<std::string>(args.rbegin(), args.rend()));  // CLI11 takes the last word first.
  } catch (const CLI::CallForHelp&) {
    print_help(out);
    return false;
  } catch (const CLI::ArgumentMismatch& e) {  // "--poses: 1 required COUNT missing"
    const std::string what = e.what();
    throw Error{Fault::Usage, what.substr(0, what.find(':')) + ": needs a value: see " + name_ + " --help"};
  } catch (const CLI::ParseError& e) {
    throw Error{Fault::Usage, std::string(e.what()) + ": see " + name_ + " --help"};
  }
  refuse_leftovers();
  for (const CLI::Option* input : inputs_) {
    if (input->count() > 0) continue;
    throw Error{Fault::Usage, input->get_name() + ": missing: " + name_ + " " + usage_};
  }
  return true;
}

void CommandLine::refuse_leftovers() const {
  const std::vector<std::string> left = app_.remaining();
  if (left.empty()) return;
  const auto option =
      std::find_if(left.begin(), left.end(), [](auto& word) { return word.starts_with("-"); });
  if (option == left.end()) {
    const std::string& word = left.front();
    throw Error{Fault::Usage, word + ": one word too many: " +
                                  slip(word).value_or("one input a run; see " + name_ + " --help")};
  }
  std::vector<std::string> names;
  for (const CLI::Option* o : app_.get_options()) {
    for (const std::string& name : o->get_lnames()) names.push_back("--" + name);
  }
  const std::string typed = option->substr(0, option->find('='));
  const auto meant = closest(typed, names);
  throw Error{Fault::Usage, typed + ": no such option: " +
                                (meant ? "did you mean " + *meant + "?" : "see " + name_ + " --help")};
}

void CommandLine::print_help(std::ostream& out) const {
  out << "Usage: " << name_ << ' ' << usage_ << "\n\n" << app_.get_description() << '\n';
  std::string group;
  for (const CLI::Option* o : app_.get_options()) {
    if (o == app_.get_help_ptr()) continue;
    if (o->get_group() != group) out << '\n' << (group = o->get_group()) << ":\n";
    std::string left = o->get_positional() ? o->get_name(true) : o->get_name(false, true);
    if (const size_t comma = left.find(','); comma != std::string::npos) left.insert(comma + 1, " ");
    if (!o->get_type_name().empty() && !o->get_positional() && o->get_type_size() != 0)
      left += " " + o->get_type_name();
    const std::string value = o->get_default_str();
    print_item(out, left, o->get_description() + (value.empty() ? "" : " (default " + value + ")"));
  }
  print_item(out, "-h, --help", app_.get_help_ptr()->get_description());
  if (!footer_.empty()) out << '\n' << footer_;
}

}  // namespace skinlod
