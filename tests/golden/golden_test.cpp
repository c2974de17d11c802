// SPDX-License-Identifier: Apache-2.0
// The committed clip must give the committed bytes, on every machine and with every instruction set (README.md).
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "core/file.h"
#include "tests/body/body_pack.h"
#include "tests/golden/golden_run.h"

namespace im2fit::golden {
namespace {

const std::string kDirectory = IM2FIT_GOLDEN_DATA;

std::string text_of(const std::string& path) {
  const auto bytes = read_file(path);
  EXPECT_TRUE(bytes) << bytes.error().message;
  if (!bytes) return "";
  return {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
}

// Data is read once: reading pictures under emulation costs more than the stages.
const Data& clip() {
  static const Result<Data> data = Data::load(kDirectory);
  if (!data) throw std::runtime_error(data.error().message);
  return *data;
}

TEST(GoldenClip, EveryStageGivesTheSameBits) {
  const auto found = stages(clip());
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(first_difference(text_of(kDirectory + "/stages.txt"), *found), "");
}

TEST(GoldenClip, ResultIsTheSameBytesOnOneThreadAndTwo) {
  const std::string expected = text_of(kDirectory + "/result.json");
  for (const bool single_thread : {true, false}) {
    const auto found = result(clip(), kDirectory, single_thread);
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_EQ(first_difference(expected, *found), "") << (single_thread ? "one thread" : "two threads");
  }
}

// .ci/run, where the body file is: there a test that does not run is a failure.
bool may_skip() {
  return std::getenv("IM2FIT_NO_SKIPS") == nullptr;
}

TEST(GoldenBodies, FitsGiveTheSameBits) {
  const std::string path = body::body_pack_path();
  if (!std::filesystem::exists(path)) {
    ASSERT_TRUE(may_skip()) << "no body file at " << path;
    GTEST_SKIP() << "no body file at " << path << ": run im2fit-lab fetch --source npm";
  }
  const auto found = bodies(path);
  ASSERT_TRUE(found) << found.error().message;
  const std::string expected = text_of(kDirectory + "/bodies.txt");
  if (expected.substr(0, expected.find('\n')) != found->substr(0, found->find('\n'))) {
    // Even where nothing may be skipped: the shape space is learned with Eigen, whose sums depend on the processor.
    GTEST_SKIP() << path << " was not made from the data of im2fit-lab fetch --source npm";
  }
  EXPECT_EQ(first_difference(expected, *found), "");
}

// That the comparison can fail, and names the stage: one pixel of the person 1 mm nearer in one frame is found.
TEST(GoldenClip, OneMillimetreInOnePixelIsNoticed) {
  auto changed = Data::load(kDirectory);
  ASSERT_TRUE(changed) << changed.error().message;
  constexpr std::size_t kFrame = 3;
  const Intrinsics& k = changed->intrinsics();
  auto& pixels = changed->frames()[kFrame];
  auto& middle = pixels[static_cast<std::size_t>(k.height / 2) * static_cast<std::size_t>(k.width) +
                        static_cast<std::size_t>(k.width / 2)];
  ASSERT_NE(middle, 0);
  --middle;
  const auto found = stages(*changed);
  ASSERT_TRUE(found) << found.error().message;
  const std::string difference = first_difference(text_of(kDirectory + "/stages.txt"), *found);
  // In the frame's own lines where the change has an effect there, else in the lines of the fused frame.
  EXPECT_TRUE(difference.find("expected \"frame 3 ") != std::string::npos ||
              difference.find("expected \"fused depth") != std::string::npos)
      << difference;
}

TEST(GoldenClip, DifferencesNameTheLine) {
  EXPECT_EQ(first_difference("a\nb\n", "a\nb\n"), "");
  EXPECT_EQ(first_difference("a\nb\n", "a\nc\n"), "line 2: expected \"b\", found \"c\"");
  EXPECT_EQ(first_difference("a\n", "a\nb\n"), "line 2: expected \"\", found \"b\"");
  EXPECT_EQ(first_difference("a\nb\n", "a\n"), "line 2: expected \"b\", found \"\"");
  EXPECT_EQ(first_difference("a\n\n", "a\n"), "line 2: expected \"\", found \"\"");
  EXPECT_NE(first_difference("a\n", "a"), "");
}

}  // namespace
}  // namespace im2fit::golden
