// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/scan_study.h"

#include <gtest/gtest.h>

#include <limits>

namespace im2fit::lab {
namespace {

TEST(ScanStudyText, CountsScansErrorsAndIntervals) {
  ScanOutcome missed, measured, other;
  missed.file = "/tmp/scans/scan_000.ply";
  missed.unit = "mm";
  missed.up = "z";
  missed.problem = "no person was measured";
  missed.at_true_level_mm.fill(std::numeric_limits<float>::quiet_NaN());
  missed.of_scan_mm = {4, std::numeric_limits<float>::quiet_NaN()};
  measured.measured = measured.around = other.measured = true;
  measured.truth.fill(100);
  measured.values.fill(103);
  measured.low.fill(99);
  measured.high.fill(107);
  measured.at_true_level_mm = {1, 2, -5};
  measured.of_scan_mm = {1, 0.5F};
  other = measured;
  other.around = false;
  other.truth.fill(110);
  const std::string text = text_of({missed, measured, other});
  EXPECT_NE(text.find("scan_000.ply (mm, z up): no person was measured\n"), std::string::npos) << text;
  EXPECT_NE(text.find("3 scans, 2 measured, 1 of them all round\n"), std::string::npos) << text;
  // 3 mm above and 7 mm below; the second truth lies outside of its interval.
  EXPECT_NE(text.find("waist_girth                      2    -2.0     5.0     7.0  1 of 2\n"), std::string::npos)
      << text;
  EXPECT_NE(text.find("hip at true height               2    -5.0     5.0     5.0\n"), std::string::npos) << text;
  EXPECT_NE(text.find("waist of the scan itself         3     2.0     2.0     4.0\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace im2fit::lab
