// SPDX-License-Identifier: Apache-2.0
// The comparison with ANSUR II, against soldiers made of the program's own people: alike, and with one girth changed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "data_paths.h"
#include "depth_folder.h"
#include "measure_run.h"
#include "run_program.h"
#include "written_files.h"

namespace im2fit {
namespace {

using Words = std::vector<std::string>;

// A row a person, by the names of people.csv.
std::vector<std::map<std::string, std::string>> rows_of(const std::string& csv) {
  std::vector<std::map<std::string, std::string>> rows;
  std::vector<std::string> names;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    if (names.empty()) {
      names = cells;
      continue;
    }
    auto& values = rows.emplace_back();
    for (std::size_t i = 0; i < names.size() && i < cells.size(); ++i) values[names[i]] = cells[i];
  }
  return rows;
}

void write_soldiers(const test::TestFolder& folder, const std::string& people, double waist_factor) {
  std::ofstream files[2] = {std::ofstream(folder.path("ANSUR_II_MALE_Public.csv")),
                            std::ofstream(folder.path("ANSUR_II_FEMALE_Public.csv"))};
  const auto rows = rows_of(people);
  std::vector<std::string> columns;  // those of ANSUR II
  for (const auto& [name, value] : rows.front())
    if (name.starts_with("ansur_")) columns.push_back(name);
  for (auto& file : files) {
    file << "subjectid,Weightkg,stature,Age";
    for (const std::string& column : columns) file << ',' << column.substr(6);
    file << ",Branch\r\n";
  }
  for (const auto& row : rows) {
    auto& file = files[row.at("woman") == "1" ? 1 : 0];
    file << row.at("subject") << ',' << 10 * std::stod(row.at("weight_kg")) << ',' << row.at("stature_mm") << ','
         << row.at("age_years");
    for (const std::string& column : columns)
      file << ',' << std::stod(row.at(column)) * (column == "ansur_waistcircumference" ? waist_factor : 1);
    file << ",x\r\n";
  }
}

TEST(Population, IsComparedWithRealPeople) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const Words draw = {test::kLab, "population", "--subjects", "600", "--body", test::body_path()};
  const auto with = [&](const Words& more) {
    Words words = draw;
    words.insert(words.end(), more.begin(), more.end());
    return test::run_program(words);
  };
  ASSERT_EQ(with({"--out", folder.path("people.csv")}).exit_code, 0);
  const std::string people = test::read_text(folder.path("people.csv"));

  write_soldiers(folder, people, 1);
  const test::Run alike = with({"--ansur", folder.path(), "--plot", folder.path("plot.png")});
  EXPECT_EQ(alike.exit_code, 0) << alike.err;
  EXPECT_THAT(alike.out, testing::AllOf(testing::HasSubstr("all within tolerance"),
                                        testing::HasSubstr("all dimensions within tolerance")));
  EXPECT_TRUE(test::is_whole_png(folder.path("plot.png")));

  write_soldiers(folder, people, 1.06);
  const test::Run wide = with({"--ansur", folder.path()});
  EXPECT_EQ(wide.exit_code, 1);
  EXPECT_THAT(wide.out, testing::HasSubstr("women's waistcircumference, mean at equal stature"));

  std::ofstream(folder.path("ANSUR_II_FEMALE_Public.csv")) << "subjectid,stature\n1,1600\n";
  const test::Run damaged = with({"--ansur", folder.path()});
  EXPECT_EQ(damaged.exit_code, 1);
  EXPECT_THAT(damaged.err, testing::HasSubstr("no column 'weightkg'"));
}

}  // namespace
}  // namespace im2fit
