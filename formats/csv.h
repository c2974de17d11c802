// SPDX-License-Identifier: Apache-2.0
// The one reader of tables as text: RFC 4180 and the variants of spreadsheets. It accepts a byte order mark, CRLF, a
// line "sep=;", semicolons or tabs between cells, quotes, blanks round cells, empty cells at the end of a row, and
// decimal commas.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/status.h"

namespace im2fit {

class CsvReader {
 public:
  struct Limits {
    std::size_t cells_max = 64;        // a row
    std::size_t cell_bytes_max = 256;  // a comment may have four times as much
  };
  // `what` names the file in errors; both must outlive the reader. The first row determines the cell separator.
  CsvReader(std::string_view text, const std::string& what, const Limits& limits);
  CsvReader(std::string_view text, const std::string& what) : CsvReader(text, what, Limits{}) {}

  // The next row that is not blank; false at the end. Cells come without quotes, blanks around them and empty ones at
  // the end. A line that begins with '#' is one cell, whatever a spreadsheet did to it. Errors: corrupt, with the
  // line: a quote that is not closed on its line, more than Limits allows, UTF-16.
  Result<bool> next(std::vector<std::string>& cells);
  int line() const { return line_; }
  // The last row given was not ended by a line end.
  bool cut_off() const { return cut_off_; }
  // A decimal comma is a comma between digits where cells are separated by something else.
  bool number(const std::string& cell, double& value) const;

 private:
  Error error(const std::string& problem) const;
  Status split(std::string_view line, std::vector<std::string>& cells) const;
  Status comment(std::string_view line, std::vector<std::string>& cells) const;
  std::string_view take_line();
  char separator_of(std::string_view line) const;

  std::string_view rest_;
  const std::string& what_;
  Limits limits_;
  int line_ = 0;
  char separator_ = '\0';  // not known before the first row
  bool cut_off_ = false;
};

}  // namespace im2fit
