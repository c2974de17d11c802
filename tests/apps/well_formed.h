// SPDX-License-Identifier: Apache-2.0
// Is a text well-formed XML? Elements nest and close, attributes are quoted and not doubled, & begins an entity.
#pragma once

#include <cctype>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace im2fit::test {

// What is wrong and where; empty when nothing is. `may_stay_open`: HTML's elements without an end.
inline std::string xml_fault(std::string_view text, const std::set<std::string>& may_stay_open = {}) {
  std::vector<std::string> open;
  std::size_t i = 0;
  const auto fault = [&](const std::string& what) { return what + " before: " + std::string(text.substr(i, 60)); };
  const auto entity_fault = [&](std::string_view part) {
    for (std::size_t k = part.find('&'); k != part.npos; k = part.find('&', k + 1)) {
      const std::string_view name = part.substr(k + 1, part.find(';', k) - k - 1);
      if (name != "amp" && name != "lt" && name != "gt" && name != "quot") return true;
    }
    return false;
  };
  while (i < text.size()) {
    const std::size_t next = text.find('<', i);
    const std::string_view words = text.substr(i, next - i);
    if (entity_fault(words)) return fault("a bare &");
    if (next == text.npos) break;
    i = next;
    if (text.substr(i, 4) == "<!--") {
      const std::size_t end = text.find("-->", i);
      if (end == text.npos) return fault("a comment without end");
      i = end + 3;
      continue;
    }
    std::size_t at = i + 1;
    const auto is_name = [&](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == ':'; };
    const bool closing = at < text.size() && text[at] == '/';
    if (closing) ++at;
    std::size_t end = at;
    while (end < text.size() && is_name(text[end])) ++end;
    const std::string name(text.substr(at, end - at));
    if (name.empty()) return fault("a < that begins no element");
    std::set<std::string> attributes;
    while (end < text.size() && text[end] != '>' && text[end] != '/') {
      if (std::isspace(static_cast<unsigned char>(text[end]))) {
        ++end;
        continue;
      }
      const std::size_t equals = text.find('=', end);
      if (equals == text.npos || equals + 1 >= text.size() || text[equals + 1] != '"')
        return fault("an attribute without quotes");
      if (!attributes.insert(std::string(text.substr(end, equals - end))).second) return fault("an attribute twice");
      const std::size_t quote = text.find('"', equals + 2);
      if (quote == text.npos) return fault("an open quote");
      const std::string_view value = text.substr(equals + 2, quote - equals - 2);
      if (value.find('<') != value.npos || entity_fault(value)) return fault("an attribute with < or &");
      end = quote + 1;
    }
    if (end >= text.size()) return fault("an element without >");
    const bool whole = text[end] == '/';
    if (closing) {
      if (open.empty() || open.back() != name) return fault("</" + name + "> closes nothing");
      open.pop_back();
    } else if (!whole && may_stay_open.count(name) == 0) {
      open.push_back(name);
    }
    i = end + (whole ? 2 : 1);
  }
  return open.empty() ? "" : "<" + open.back() + "> is never closed";
}

}  // namespace im2fit::test
