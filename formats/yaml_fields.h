// SPDX-License-Identifier: Apache-2.0
// Fields of our YAML files, read strictly: a fault is one line that names file, line, field and what is expected.
#pragma once

#include <yaml-cpp/yaml.h>

#include <set>
#include <string>

#include "core/status.h"

namespace im2fit::yaml {

inline constexpr std::size_t kFileBytesMax = 1U << 20;

struct Wrong {
  int line;
  std::string what;
};
[[noreturn]] void refuse(const YAML::Node& node, const std::string& field, const std::string& problem);
std::string shown(const YAML::Node& node);
// A map whose every key is known and comes once.
void expect_keys(const YAML::Node& map, const std::string& what, const std::set<std::string>& known);
std::string text_of(const YAML::Node& node, const std::string& field);  // 1 to 400 characters
float number_of(const YAML::Node& node, const std::string& field, float low, float high);
std::string id_of(const YAML::Node& node, const std::string& field);  // small letters, digits, _
// The field `schema` is this word.
void expect_schema(const YAML::Node& root, const std::string& schema);
// The field, which has to be there.
YAML::Node needed(const YAML::Node& map, const std::string& key, const std::string& what,
                  const std::string& expected);

// The message of a fault: of Wrong and of the parser.
Error fault(const std::string& what, const Wrong& wrong);
Error fault(const std::string& what, const YAML::Exception& e, const std::string& kind);

// `read` of the text's root; it throws Wrong. `kind`: "a tape in YAML (docs/tape.md)".
template <class T, class Read>
Result<T> read_fields(const std::string& text, const std::string& what, const std::string& kind, Read read) {
  if (text.size() > kFileBytesMax) return Error{ErrorCode::corrupt, what + " is larger than 1 MiB; expected " + kind};
  try {
    return read(YAML::Load(text));
  } catch (const Wrong& wrong) {
    return fault(what, wrong);
  } catch (const YAML::Exception& e) {
    return fault(what, e, kind);
  }
}

}  // namespace im2fit::yaml
