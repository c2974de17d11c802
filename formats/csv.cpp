// SPDX-License-Identifier: Apache-2.0
#include "formats/csv.h"

#include <algorithm>
#include <charconv>
#include <cstdint>

namespace im2fit {
namespace {

constexpr std::string_view kBlank = " \t\r";

std::string_view trim(std::string_view text, std::string_view what) {
  const std::size_t first = text.find_first_not_of(what);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(what) - first + 1);
}

// Behind the closing quote of a text that begins with one; npos where there is none.
std::size_t end_of_quoted(std::string_view text) {
  for (std::size_t at = 1; at < text.size(); ++at) {
    if (text[at] != '"') continue;
    if (at + 1 == text.size() || text[at + 1] != '"') return at + 1;
    ++at;
  }
  return std::string_view::npos;
}

// `quoted` with both its quotes.
std::string unquoted(std::string_view quoted) {
  std::string out;
  for (std::size_t at = 1; at + 1 < quoted.size(); ++at) {
    out += quoted[at];
    if (quoted[at] == '"') ++at;
  }
  return out;
}

}  // namespace

CsvReader::CsvReader(std::string_view text, const std::string& what, const Limits& limits)
    : rest_(text), what_(what), limits_(limits) {
  if (rest_.substr(0, 3) == "\xEF\xBB\xBF") rest_.remove_prefix(3);
}

Error CsvReader::error(const std::string& problem) const {
  return {ErrorCode::corrupt, what_ + " line " + std::to_string(line_) + ": " + problem};
}

std::string_view CsvReader::take_line() {
  const std::size_t end = rest_.find('\n');
  const std::string_view line = rest_.substr(0, end);
  cut_off_ = end == std::string_view::npos;
  rest_.remove_prefix(cut_off_ ? rest_.size() : end + 1);
  ++line_;
  return line;
}

char CsvReader::separator_of(std::string_view line) const {
  if (line.find(';') != std::string_view::npos) return ';';
  if (line.find(',') == std::string_view::npos && line.find('\t') != std::string_view::npos) return '\t';
  return ',';
}

Result<bool> CsvReader::next(std::vector<std::string>& cells) {
  if (line_ == 0 && (rest_.substr(0, 2) == "\xFF\xFE" || rest_.substr(0, 2) == "\xFE\xFF")) {
    line_ = 1;
    return error("is UTF-16; save it as CSV in UTF-8");
  }
  while (!rest_.empty()) {
    const std::string_view line = take_line();
    if (line.find('\0') != std::string_view::npos) return error("holds bytes that are not text");
    cells.clear();
    const std::string_view bare = trim(line, kBlank);
    if (line_ == 1 && bare.size() == 5 && bare.substr(0, 4) == "sep=") {
      separator_ = bare[4];
      continue;
    }
    const std::string_view inside = trim(bare, "\"");
    if (!inside.empty() && inside.front() == '#') {
      if (auto done = comment(bare, cells); !done) return done.error();
      return true;
    }
    if (trim(bare, " \t\r,;\"").empty()) continue;
    if (separator_ == '\0') separator_ = separator_of(bare);
    // A tab at an end separates an empty cell from nothing.
    if (auto done = split(separator_ == '\t' ? trim(line, "\r") : bare, cells); !done) return done.error();
    while (!cells.empty() && cells.back().empty()) cells.pop_back();
    if (!cells.empty()) return true;
  }
  return false;
}

Status CsvReader::comment(std::string_view line, std::vector<std::string>& cells) const {
  std::string text;
  if (line.front() == '"' && end_of_quoted(line) != std::string_view::npos)
    text = unquoted(line.substr(0, end_of_quoted(line)));
  else
    text = trim(line, " \t\r,;");
  if (text.size() > 4 * limits_.cell_bytes_max) return error("is too long a comment");
  cells.push_back(std::move(text));
  return Ok{};
}

Status CsvReader::split(std::string_view line, std::vector<std::string>& cells) const {
  for (;;) {
    if (cells.size() == limits_.cells_max)
      return error("has more than " + std::to_string(limits_.cells_max) + " cells");
    line = trim(line, " \r");
    std::string cell;
    std::size_t end = 0;
    if (!line.empty() && line.front() == '"') {
      end = end_of_quoted(line);
      if (end == std::string_view::npos) return error("has a quote that is not closed");
      cell = trim(unquoted(line.substr(0, end)), kBlank);
      const std::string_view behind = trim(line.substr(end, line.find(separator_, end) - end), " \r");
      if (!behind.empty()) return error("has text behind a quoted cell");
      end = std::min(line.find(separator_, end), line.size());
    } else {
      end = std::min(line.find(separator_), line.size());
      cell = trim(line.substr(0, end), kBlank);
    }
    if (cell.size() > limits_.cell_bytes_max)
      return error("has a cell of more than " + std::to_string(limits_.cell_bytes_max) + " bytes");
    cells.push_back(std::move(cell));
    if (end >= line.size()) return Ok{};
    line.remove_prefix(end + 1);
  }
}

bool CsvReader::number(const std::string& cell, double& value) const {
  const char* at = cell.data();
  const char* const end = at + cell.size();
  const bool negative = at != end && *at == '-';
  if (at != end && (*at == '-' || *at == '+')) ++at;
  // By hand: from_chars for floats is not in every standard library we build with, strtod asks the locale.
  std::uint64_t whole = 0;
  const auto [stop, fault] = std::from_chars(at, end, whole);
  if (fault != std::errc() || stop == at) return false;
  double result = static_cast<double>(whole), place = 0.1;
  at = stop;
  if (at != end) {
    if (*at != '.' && !(*at == ',' && separator_ != ',')) return false;
    if (++at == end) return false;
    for (; at != end; ++at, place /= 10) {
      if (*at < '0' || *at > '9') return false;
      result += place * (*at - '0');
    }
  }
  value = negative ? -result : result;
  return true;
}

}  // namespace im2fit
