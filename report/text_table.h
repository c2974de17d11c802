// SPDX-License-Identifier: Apache-2.0
// Plain tables for people: the first column left, the others right aligned.
#pragma once

#include <string>
#include <vector>

namespace im2fit {

class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header);
  void add(std::vector<std::string> row);  // shorter rows are filled with blanks
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;
};

// "1012", "71.3"; "-" for NaN. `decimals` after the point.
std::string number(double value, int decimals = 0);

}  // namespace im2fit
