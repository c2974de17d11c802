// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/ansur.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>

#include "core/file.h"

namespace im2fit::lab {
namespace {

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == line.npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

// Without its end; `text` goes on behind it.
std::string_view next_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view row = text.substr(0, end);
  text.remove_prefix(end == text.npos ? text.size() : end + 1);
  if (!row.empty() && row.back() == '\r') row.remove_suffix(1);
  return row;
}

bool same_name(std::string_view found, std::string_view wanted) {
  return std::equal(found.begin(), found.end(), wanted.begin(), wanted.end(),
                    [](char x, char y) { return (x >= 'A' && x <= 'Z' ? x + 32 : x) == y; });
}

}  // namespace

Result<std::vector<std::vector<double>>> read_ansur_columns(const std::string& folder, bool woman,
                                                            std::span<const std::string_view> columns) {
  const std::string path = folder + (woman ? "/ANSUR_II_FEMALE_Public.csv" : "/ANSUR_II_MALE_Public.csv");
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  std::string_view head = next_line(text);
  if (head.substr(0, 3) == "\xEF\xBB\xBF") head.remove_prefix(3);
  const auto names = cells_of(head);
  std::vector<std::size_t> places;
  for (const std::string_view column : columns) {
    const auto it = std::find_if(names.begin(), names.end(), [&](auto name) { return same_name(name, column); });
    if (it == names.end()) return Error{ErrorCode::corrupt, path + ": no column '" + std::string(column) + "'"};
    places.push_back(static_cast<std::size_t>(it - names.begin()));
  }
  std::vector<std::vector<double>> rows;
  while (!text.empty()) {
    const auto cells = cells_of(next_line(text));
    if (cells.size() < names.size()) continue;
    std::vector<double>& row = rows.emplace_back(columns.size());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const std::string_view cell = cells[places[c]];
      const auto parsed = std::from_chars(cell.data(), cell.data() + cell.size(), row[c]);
      if (parsed.ec != std::errc() || !(row[c] > 0))
        return Error{ErrorCode::corrupt, fmt::format("{}: person {}: {} is '{}', expected a number", path,
                                                     rows.size(), columns[c], cell)};
    }
  }
  if (rows.size() < 100) return Error{ErrorCode::corrupt, fmt::format("{}: only {} people", path, rows.size())};
  return rows;
}

}  // namespace im2fit::lab
