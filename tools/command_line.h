// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <concepts>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skinlod {

/// The whole number that `value` spells, or Error{Usage} in the name of `option`.
std::int64_t whole_number(const std::string& option, const std::string& value, std::int64_t least,
                          std::int64_t most);

/// What stands between the commas of a list; blanks are passed over.
std::vector<std::string> items(const std::string& list);

/// `left`, and `text` beside it in a column of its own, as wide as the page.
void print_item(std::ostream& out, const std::string& left, const std::string& text);

/// What somebody meant who gave one word too many, where that can be told.
std::optional<std::string> slip(const std::string& word);

/// One command's options, in the order in which --help shows them, over CLI11. Each is bound to a variable
/// that holds its default, so that a default is typed in one place: where the variable is declared.
/// Names are written as CLI11 has them: "-o,--output". Errors read "option: fact: remedy".
class CommandLine {
 public:
  /// `name` is that of the command, `usage` what follows it, `summary` one paragraph.
  CommandLine(const std::string& name, std::string usage, std::string summary,
              const std::string& program = "skinlod");

  /// The options that follow stand under this title.
  void group(std::string title) { group_ = std::move(title); }

  /// The one argument without a name, which must be there.
  void input(const std::string& name, std::string& value, const std::string& text);
  /// All further arguments without a name, of which there must be one.
  void inputs(const std::string& name, std::vector<std::string>& values, const std::string& text);
  void flag(const std::string& names, bool& value, const std::string& text);
  void word(const std::string& names, const std::string& unit, std::string& value, const std::string& text);
  /// May be given more than once, one value each time.
  void words(const std::string& names, const std::string& unit, std::vector<std::string>& values,
             const std::string& text);

  template <std::integral T>
  void number(const std::string& names, const std::string& unit, T& value, std::int64_t least,
              std::int64_t most, const std::string& text) {
    add(names, unit, text, std::to_string(value), [&value, least, most](auto& option, auto& given) {
      value = T(whole_number(option, given, least, most));
    });
  }

  /// One of `names_of`, whose order is that of the enumerators.
  template <class E>
  void choice(const std::string& names, E& value, const std::vector<std::string>& names_of,
              const std::string& text) {
    add(names, joined(names_of), text, names_of[size_t(value)],
        [&value, names_of](auto& option, auto& given) { value = E(index_in(names_of, option, given)); });
  }

  /// Some of `names_of`, with commas between them.
  template <class E>
  void choices(const std::string& names, std::vector<E>& values, const std::vector<std::string>& names_of,
               const std::string& text) {
    std::string shown;
    for (const E value : values) shown += (shown.empty() ? "" : ",") + names_of[size_t(value)];
    add(names, "LIST", text, shown, [&values, names_of](auto& option, auto& given) {
      values.clear();
      for (const std::string& item : items(given)) {
        values.push_back(E(index_in(names_of, option, item)));
        refuse_twice(option, item, std::count(values.begin(), values.end(), values.back()) > 1);
      }
    });
  }

  /// The names as a help page lists them: a|b|c.
  static std::string joined(const std::vector<std::string>& names);

  /// The last lines of the help page.
  void footer(std::string text) { footer_ = std::move(text); }

  /// Reads the command line into the variables. False: help was asked for, and stands on `out`.
  /// Throws Error{Usage}.
  bool parse(std::span<const std::string> args, std::ostream& out);

  /// After `parse`: whether the option stands on the command line.
  bool given(const std::string& name) const { return app_.count(name) > 0; }

 private:
  using Take = std::function<void(const std::string& option, const std::string& value)>;
  CLI::Option* add(const std::string& names, const std::string& unit, const std::string& text,
                   const std::string& value, Take take, bool many = false);
  void print_help(std::ostream& out) const;
  void refuse_leftovers() const;
  static void refuse_twice(const std::string& option, const std::string& item, bool twice);
  static size_t index_in(const std::vector<std::string>& names, const std::string& option,
                         const std::string& value);

  CLI::App app_;
  std::string name_, usage_, footer_, group_ = "Options";
  std::vector<CLI::Option*> inputs_;
};

}  // namespace skinlod
