// SPDX-License-Identifier: MIT
#include "tests/tools/schema.h"

#include <algorithm>
#include <set>

namespace skinlod {
namespace {

using nlohmann::json;

bool is(const json& value, const std::string& type) {
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  return type == value.type_name();
}

bool is_any(const json& value, const json& type) {
  if (type.is_string()) return is(value, type);
  return std::any_of(type.begin(), type.end(), [&](const json& t) { return is(value, t); });
}

}  // namespace

std::vector<std::string> schema_violations(const json& value, const json& schema, const json& root,
                                           const std::string& where) {
  static const std::set<std::string> kNotes = {"$schema", "$comment", "title", "description", "$defs"};
  std::vector<std::string> found;
  const auto check = [&](bool fine, const std::string& what) {
    if (!fine) found.push_back(where + ": " + what);
  };
  const auto descend = [&](const json& part, const json& rule, const std::string& place) {
    for (auto& v : schema_violations(part, rule, root, place)) found.push_back(v);
  };

  for (const auto& [word, rule] : schema.items()) {
    if (word == "$ref") {
      descend(value, root.at(json::json_pointer(rule.get<std::string>().substr(1))), where);
    } else if (word == "type") {
      check(is_any(value, rule), "is no " + rule.dump());
    } else if (word == "const") {
      check(value == rule, "is not " + rule.dump());
    } else if (word == "enum") {
      check(std::find(rule.begin(), rule.end(), value) != rule.end(), "is none of " + rule.dump());
    } else if (word == "minimum") {
      check(!value.is_number() || value >= rule, "is below " + rule.dump());
    } else if (word == "required") {
      for (const json& key : rule) check(!value.is_object() || value.contains(key), "lacks " + key.dump());
    } else if (word == "properties") {
      for (const auto& [key, of] : rule.items()) {
        if (value.is_object() && value.contains(key)) descend(value.at(key), of, where + "." + key);
      }
    } else if (word == "additionalProperties" && rule == false) {
      if (!value.is_object()) continue;
      for (const auto& [key, unused] : value.items())
        check(schema.at("properties").contains(key), "has " + key);
    } else if (word == "items") {
      for (size_t i = 0; value.is_array() && i < value.size(); ++i) {
        descend(value[i], rule, where + "[" + std::to_string(i) + "]");
      }
    } else if (word == "oneOf") {
      const auto fits = std::count_if(rule.begin(), rule.end(), [&](const json& one) {
        return schema_violations(value, one, root, where).empty();
      });
      check(fits == 1, "fits " + std::to_string(fits) + " of the forms and not one");
    } else {
      check(kNotes.contains(word), "the schema says '" + word + "', which this check does not know");
    }
  }
  return found;
}

}  // namespace skinlod
