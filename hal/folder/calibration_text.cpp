// SPDX-License-Identifier: Apache-2.0
#include "hal/folder/calibration_text.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "core/text.h"
#include "hal/folder/pose_rows.h"

namespace im2fit::hal {
namespace {

constexpr int kXmlDepthMax = 16;            // OpenCV's files have 3
constexpr std::size_t kElementsMax = 1000;  // looking a name up goes through all; a calibration of a rig has 100

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

std::string_view stripped(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

// One word is a scalar, several are a list.
YAML::Node words_of(std::string_view text) {
  YAML::Node list(YAML::NodeType::Sequence);
  for (text = stripped(text); !text.empty(); text = stripped(text)) {
    std::size_t end = 0;
    while (end < text.size() && !is_blank(text[end])) ++end;
    list.push_back(std::string(text.substr(0, end)));
    text.remove_prefix(end);
  }
  if (list.size() == 0) return YAML::Node("");
  return list.size() == 1 ? YAML::Node(list[0].as<std::string>()) : list;
}

// Elements, their text, comments and declarations: what OpenCV's FileStorage writes. Attributes are left alone, and
// entities, which only texts hold, stay as they are.
class XmlReader {
 public:
  XmlReader(std::string_view text, const std::string& path) : text_(text), path_(path) {}

  Result<YAML::Node> read() {
    std::string name;
    if (auto tag = next_tag(); !tag) return tag.error();
    if (closing_ || tag_.empty()) return wrong("expected an element");
    name = tag_;
    auto tree = element(name, 0);
    if (tree && !tree->IsMap()) return wrong("expected elements within " + excerpt(name));
    return tree;
  }

 private:
  Error wrong(const std::string& problem) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    return {ErrorCode::corrupt, path_ + " line " + std::to_string(line) + ": " + problem +
                                    "; expected a camera calibration as OpenCV writes it in XML (docs/cameras)"};
  }

  // Past the next tag; the text before it is in before_. Declarations and comments are skipped.
  Status next_tag() {
    before_.clear();
    for (;;) {
      const std::size_t open = text_.find('<', at_);
      if (open == std::string_view::npos) return wrong("the file ends within an element");
      before_ += text_.substr(at_, open - at_);
      const bool comment = text_.substr(open, 4) == "<!--";
      const std::string_view end_mark = comment ? "-->" : ">";
      const std::size_t end = text_.find(end_mark, open);
      if (end == std::string_view::npos) return wrong("the file ends within <...>");
      std::string_view inside = text_.substr(open + 1, end - open - 1);
      at_ = end + end_mark.size();
      if (comment || inside.empty() || inside.front() == '?' || inside.front() == '!') continue;
      closing_ = inside.front() == '/';
      empty_ = inside.back() == '/';
      if (closing_) inside.remove_prefix(1);
      inside = inside.substr(0, inside.find_first_of(" \t\r\n/"));
      tag_ = std::string(inside);
      return Ok{};
    }
  }

  // The element whose opening tag was read last.
  Result<YAML::Node> element(const std::string& name, int depth) {
    if (depth > kXmlDepthMax) return wrong("elements lie deeper than " + std::to_string(kXmlDepthMax));
    if (++elements_ > kElementsMax) return wrong("there are more than " + std::to_string(kElementsMax) + " elements");
    if (empty_) return YAML::Node("");
    YAML::Node map(YAML::NodeType::Map);
    std::string text;
    for (;;) {
      if (auto tag = next_tag(); !tag) return tag.error();
      text += before_;
      if (closing_ && tag_ != name) return wrong("</" + excerpt(tag_) + "> closes " + excerpt(name));
      if (closing_) return map.size() > 0 ? map : words_of(text);
      const std::string child = tag_;
      auto inner = element(child, depth + 1);
      if (!inner) return inner.error();
      empty_ = false;
      // OpenCV names the elements of a list "_".
      if (child != "_" && map[child].IsDefined()) return wrong("<" + excerpt(child) + "> appears twice");
      map[child] = *inner;
    }
  }

  std::string_view text_;
  const std::string& path_;
  std::size_t at_ = 0, elements_ = 0;
  std::string before_, tag_;
  bool closing_ = false, empty_ = false;
};

//  Intrinsic of "Depth" / 640x480 / {Z16}
//   Width:      	640
//   ...
//   Coeffs:     	0  	0  	0  	0  	0
YAML::Node realsense_sections(std::string_view text) {
  YAML::Node sections(YAML::NodeType::Sequence);
  YAML::Node section;
  bool within = false;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = stripped(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    constexpr std::string_view kHead = "Intrinsic of \"";
    if (line.substr(0, kHead.size()) == kHead && sections.size() < kElementsMax) {
      section.reset(YAML::Node(YAML::NodeType::Map));
      const std::string_view rest = line.substr(kHead.size());
      section["stream"] = std::string(rest.substr(0, rest.find('"')));
      sections.push_back(section);
      within = true;
      continue;
    }
    const std::size_t colon = line.find(':');
    if (line.empty() || colon == std::string_view::npos) {
      within = false;
      continue;
    }
    const std::string key(stripped(line.substr(0, colon)));
    constexpr std::string_view kKeys[] = {"Width", "Height", "PPX", "PPY", "Fx", "Fy", "Coeffs"};
    if (within && key == "Distortion") section[key] = std::string(stripped(line.substr(colon + 1)));
    if (within && std::find(std::begin(kKeys), std::end(kKeys), key) != std::end(kKeys))
      section[key] = words_of(line.substr(colon + 1));
  }
  YAML::Node tree;
  tree[kRealSenseSections] = sections;
  return tree;
}

// OpenCV begins with "%YAML:1.0", which is not the directive YAML knows, and tags matrices with its own type. JSON
// may be indented by tabs, which YAML refuses.
std::string plain_yaml(std::string text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.rfind(kByteOrderMark, 0) == 0) text.erase(0, kByteOrderMark.size());
  if (text.rfind("%YAML", 0) == 0) text.erase(0, text.find('\n'));
  if (const std::string_view body = stripped(text); !body.empty() && body.front() == '{')
    std::replace(text.begin(), text.end(), '\t', ' ');
  return text;
}

}  // namespace

std::optional<PinholeLens> pinhole_lens(const std::array<double, 9>& m) {
  const bool by_columns = m[2] == 0 && m[5] == 0 && (m[6] != 0 || m[7] != 0);
  const auto at = [&](std::size_t row, std::size_t column) {
    return by_columns ? m[3 * column + row] : m[3 * row + column];
  };
  if (at(0, 1) != 0 || at(1, 0) != 0 || at(2, 0) != 0 || at(2, 1) != 0 || at(2, 2) != 1) return std::nullopt;
  return PinholeLens{at(0, 0), at(1, 1), at(0, 2), at(1, 2)};
}

std::optional<std::array<double, 9>> matrix_in(const std::string& text) {
  constexpr std::string_view kSeparators = " \t\r\n,;[]";
  std::array<double, 9> values{};
  std::size_t count = 0;
  NumberReader numbers;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t begin = text.find_first_not_of(kSeparators, at);
    if (begin == std::string::npos) break;
    const std::size_t end = std::min(text.find_first_of(kSeparators, begin), text.size());
    if (count == values.size() || end - begin > 32 || !numbers.read(text.substr(begin, end - begin), values[count]))
      return std::nullopt;
    ++count;
    at = end;
  }
  if (count != values.size()) return std::nullopt;
  return values;
}

Result<YAML::Node> calibration_tree(const std::string& text, const std::string& path) {
  const std::string plain = plain_yaml(text);
  if (const std::string_view body = stripped(plain); !body.empty() && body.front() == '<')
    return XmlReader(body, path).read();
  if (plain.find("Intrinsic of \"") != std::string::npos) return realsense_sections(plain);
  if (const auto matrix = matrix_in(plain)) {
    YAML::Node tree;
    for (const double value : *matrix) tree[kBareMatrix].push_back(value);
    return tree;
  }
  return YAML::Load(plain);
}

}  // namespace im2fit::hal
