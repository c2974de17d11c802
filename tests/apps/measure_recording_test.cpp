// SPDX-License-Identifier: Apache-2.0
// A measurement from a recording equals that from the recorded source, however it was kept.
#include <sstream>

#include "measure_run.h"

namespace im2fit {
namespace {

#if IM2FIT_TEST_ONI
// The result but for the lines that name the source and its mounting: text, so that every digit counts.
std::string result_of(const std::string& out) {
  std::string kept;
  bool in_source = false;
  std::istringstream lines(test::read_text(out + "/result.json"));
  for (std::string line; std::getline(lines, line);) {
    if (line.find("\"source\": {") != std::string::npos) in_source = true;
    const bool names_it =
        in_source && (line.find("\"uri\":") != std::string::npos || line.find("\"name\":") != std::string::npos ||
                      line.find("\"rotate_deg\":") != std::string::npos);
    if (in_source && line.find('}') != std::string::npos) in_source = false;
    if (!names_it) kept += line + "\n";
  }
  return kept;
}

// 45 frames of 640 x 480 with a sensor's noise.
TEST(MeasureRecording, AnOniAFolderAndTheSourceItselfGiveOneResult) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const std::string synthetic = "synthetic:7";
  const auto record = [&](const std::string& source, const std::string& name) {
    const auto run = test::run_program({test::kProgram, "record", source, "--body", test::body_path(), "--frames",
                                        "45", "--out", folder.path(name)});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return folder.path(name);
  };
  const std::string plain = record(synthetic, "folder"), oni = record(synthetic, "clip.oni"),
                    oni_of_folder = record(plain, "again.oni"), back = record(oni, "back");
  int frames = 0;
  for (const auto& name : test::files_in(plain)) {
    if (name.size() != 10 || name.substr(6) != ".png") continue;
    EXPECT_EQ(test::read_text(plain + "/" + name), test::read_text(back + "/" + name)) << name;
    ++frames;
  }
  EXPECT_EQ(frames, 45);
  std::string expected;
  for (const auto& source : {plain, oni, oni_of_folder, back, synthetic}) {
    const std::string out = folder.path("out");
    std::filesystem::remove_all(out);
    const auto run = test::measure(source, out);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const std::string result = result_of(out);
    EXPECT_NE(result.find("\"stature\""), std::string::npos);
    if (expected.empty()) expected = result;
    EXPECT_EQ(result, expected) << source;
  }
}
#endif

}  // namespace
}  // namespace im2fit
