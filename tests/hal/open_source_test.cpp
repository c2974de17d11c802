// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "hal/open/open.h"
#include "made_folder.h"

namespace im2fit::hal {
namespace {

TEST(OpenSource, WordsThatAreNoSourceAreRefusedClearly) {
  const TestFolder folder;
  put(folder.path("notes.txt"), "hello");
  const struct {
    std::string uri;
    ErrorCode code;
    const char* names;
  } cases[] = {{"synthetic:7", ErrorCode::unsupported, "no synthetic camera"},
               {folder.path("absent.oni"), ErrorCode::not_found, "does not exist"},
               {"", ErrorCode::not_found, "does not exist"},
               {folder.path("notes.txt"), ErrorCode::unsupported, "neither a folder nor a recording"}};
  for (const auto& bad : cases) {
    const auto source = open_source(bad.uri);
    ASSERT_FALSE(source) << bad.uri;
    EXPECT_EQ(source.error().code, bad.code) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, bad.names)) << source.error().message;
  }
}

TEST(OpenSource, TheSyntheticFactoryGetsTheSeedAndTheOptions) {
  std::string seed;
  int rotate_deg = -1;
  OpenOptions options;
  options.rotate_deg = 270;
  options.synthetic = [&](const std::string& word, const OpenOptions& given) -> Result<std::unique_ptr<Source>> {
    seed = word;
    rotate_deg = given.rotate_deg.value_or(-1);
    return Error{ErrorCode::not_found, "called"};
  };
  EXPECT_FALSE(open_source("synthetic:42", options));
  EXPECT_EQ(seed, "42");
  EXPECT_EQ(rotate_deg, 270);
  EXPECT_FALSE(open_source("synthetic", options));
  EXPECT_EQ(seed, "");
}

}  // namespace
}  // namespace im2fit::hal
