// SPDX-License-Identifier: Apache-2.0
#include "formats/yaml_fields.h"

namespace im2fit::yaml {
namespace {

constexpr std::size_t kTextMax = 400;  // characters of a text

// Errors may quote the file, which may hold anything.
std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  return text;
}

}  // namespace

void refuse(const YAML::Node& node, const std::string& field, const std::string& problem) {
  throw Wrong{node.Mark().line + 1, field + " " + problem};
}

std::string shown(const YAML::Node& node) {
  if (!node.IsDefined() || node.IsNull()) return "empty";
  return node.IsScalar() ? "\"" + node.Scalar().substr(0, 60) + "\"" : "not a single value";
}

void expect_keys(const YAML::Node& map, const std::string& what, const std::set<std::string>& known) {
  if (!map.IsMap()) refuse(map, what, "is " + shown(map) + ", expected fields");
  std::set<std::string> seen;
  for (const auto& item : map) {
    const std::string key = item.first.IsScalar() ? item.first.Scalar() : "?";
    if (!seen.insert(key).second) refuse(item.first, what + "." + key, "appears twice");
    if (known.count(key) != 0) continue;
    std::string all;
    for (const std::string& word : known) all += (all.empty() ? "" : ", ") + word;
    refuse(item.first, what + "." + key, "is not known, expected " + all);
  }
}

std::string text_of(const YAML::Node& node, const std::string& field) {
  if (!node.IsScalar() || node.Scalar().empty()) refuse(node, field, "is " + shown(node) + ", expected a text");
  if (node.Scalar().size() > kTextMax) refuse(node, field, "is too long, expected at most 400 characters");
  return node.Scalar();
}

float number_of(const YAML::Node& node, const std::string& field, float low, float high) {
  float value = 0;
  if (!node.IsScalar() || !YAML::convert<float>::decode(node, value) || !(value >= low) || !(value <= high)) {
    const auto shown_limit = [](float v) { return std::to_string(static_cast<int>(v)); };
    refuse(node, field,
           "is " + shown(node) + ", expected a number from " + shown_limit(low) + " to " + shown_limit(high));
  }
  return value;
}

std::string id_of(const YAML::Node& node, const std::string& field) {
  std::string id = text_of(node, field);
  bool good = id.size() <= 48 && id[0] >= 'a' && id[0] <= 'z';
  for (const char c : id) good = good && ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_');
  if (!good) refuse(node, field, "is " + shown(node) + ", expected small letters, digits and _, at most 48");
  return id;
}

void expect_schema(const YAML::Node& root, const std::string& schema) {
  const YAML::Node node = root["schema"];
  if (!node.IsDefined()) refuse(root, "schema", "is missing, expected " + schema);
  if (!node.IsScalar() || node.Scalar() != schema)
    refuse(node, "schema", "is " + shown(node) + ", expected " + schema);
}

YAML::Node needed(const YAML::Node& map, const std::string& key, const std::string& what,
                  const std::string& expected) {
  YAML::Node node = map[key];
  if (!node.IsDefined()) refuse(map, what, "is missing, expected " + expected);
  return node;
}

Error fault(const std::string& what, const Wrong& wrong) {
  return {ErrorCode::corrupt,
          what + " line " + std::to_string(wrong.line > 0 ? wrong.line : 1) + ": " + one_line(wrong.what)};
}
Error fault(const std::string& what, const YAML::Exception& e, const std::string& kind) {
  return {ErrorCode::corrupt,
          what + " line " + std::to_string(e.mark.line + 1) + ": " + one_line(e.msg) + "; expected " + kind};
}

}  // namespace im2fit::yaml
