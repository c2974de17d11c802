// SPDX-License-Identifier: Apache-2.0
// `im2fit measure` over one source, and the promises that hold whatever the input is.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "data_paths.h"
#include "run_program.h"
#include "written_files.h"

namespace im2fit::test {

inline constexpr const char* kProgram = IM2FIT_PROGRAM;
inline constexpr const char* kLab = IM2FIT_LAB_PROGRAM;

// Failed (1): one line, nothing written. No measurement (3): one line, and result.json names the requirement.
inline void expect_honest(const Run& run, const std::string& out) {
  const std::string printed = "stdout: " + run.out + "stderr: " + run.err;
  EXPECT_THAT(partial_files_in(out), testing::IsEmpty()) << printed;
  if (run.exit_code == 0) {
    EXPECT_EQ(run.err, "");
    return;
  }
  EXPECT_TRUE(is_one_line_of(run.err, "im2fit")) << printed;
  if (run.exit_code != 3) {
    EXPECT_EQ(run.exit_code, 1) << printed;
    EXPECT_EQ(run.out, "");
    return;
  }
  const auto result = nlohmann::json::parse(read_text(out + "/result.json"), nullptr, false);
  ASSERT_TRUE(result.is_object()) << printed;
  EXPECT_EQ(result["schema"], "im2fit.result/1");
  EXPECT_NE(result["state"], "MEASURED");
  EXPECT_TRUE(result["measurements"].is_object() && result["measurements"].empty()) << result["measurements"];
  EXPECT_TRUE(result["guidance"].is_array() && !result["guidance"].empty()) << result["guidance"];
}

inline Run measure(const std::string& source, const std::string& out, const std::vector<std::string>& more = {},
                   const RunOptions& options = {}) {
  std::vector<std::string> command = {kProgram,    "measure",   source,         "--out",   out,         "--body",
                                      body_path(), "--tracker", tracker_path(), "--index", index_path()};
  command.insert(command.end(), more.begin(), more.end());
  return run_program(command, options);
}

inline std::vector<std::string> guidance_in(const std::string& out) {
  const auto result = nlohmann::json::parse(read_text(out + "/result.json"), nullptr, false);
  std::vector<std::string> codes;
  if (result.is_object())
    for (const auto& code : result["guidance"]) codes.push_back(code);
  return codes;
}

}  // namespace im2fit::test
