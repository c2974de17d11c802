// SPDX-License-Identifier: Apache-2.0
// --only: the folder holds the files that were named, the same bytes as among all, and the others are not computed.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <cstring>
#include <filesystem>
#include <map>

#include "measured_clip.h"

namespace im2fit {
namespace {

using Files = std::map<std::string, std::string>;  // name: bytes

class WantedFiles : public test::MeasuredClip {
 protected:
  static void SetUpTestSuite() { render({"--frames", "12"}); }

  // Seconds of processor time that ended children have spent in their own code.
  static double seconds_spent() {
    rusage usage{};
    ::getrusage(RUSAGE_CHILDREN, &usage);
    return static_cast<double>(usage.ru_utime.tv_sec) + 1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
  }

  Files files_of(const std::vector<std::string>& words) {
    const test::TestFolder folder;
    std::vector<std::string> more = {"--frames", "12"};
    more.insert(more.end(), words.begin(), words.end());
    const double before = seconds_spent();
    const test::Run run = test::measure(clip(), folder.path("out"), more);
    seconds_ = seconds_spent() - before;
    EXPECT_EQ(run.exit_code, 0) << run.err;
    Files files;
    for (const std::string& name : test::files_in(folder.path("out")))
      files[name] = test::read_text(folder.path("out") + "/" + name);
    return files;
  }

  static std::size_t garments_in(const std::string& glb) {
    std::uint32_t length = 0;  // of the first chunk
    std::memcpy(&length, glb.data() + 12, sizeof length);
    const auto document = nlohmann::json::parse(glb.substr(20, length), nullptr, false);
    std::size_t count = 0;
    for (const auto& material : document["materials"]) {
      const std::string name = material["name"];
      count += name != "skin" && name != "eyes" && name != "hair" ? 1 : 0;
    }
    return count;
  }

  double seconds_ = 0;  // of the last run
};

TEST_F(WantedFiles, AreAllThereIsAndTheSameBytes) {
  const Files all = files_of({});
  const double seconds_of_all = seconds_;
  const std::vector<std::string> every = {"result.json", "avatar.glb", "overlay.png",    "avatar.obj",
                                          "avatar.mtl",  "avatar.bvh", "avatar_skin.png"};
  const auto names = [](const Files& files) {
    std::vector<std::string> of;
    for (const auto& file : files) of.push_back(file.first);
    return of;
  };
  EXPECT_THAT(names(all), testing::UnorderedElementsAreArray(every));
  ASSERT_EQ(all.count("avatar.glb"), 1U);
  EXPECT_GE(garments_in(all.at("avatar.glb")), 2U);
  const std::pair<const char*, std::vector<std::string>> table[] = {
      {"result", {"result.json"}},
      {"overlay", {"overlay.png"}},
      {"obj", {"avatar.obj", "avatar.mtl", "avatar_skin.png"}},
      {"bvh", {"avatar.bvh"}},
      {"clothes", {"avatar.glb"}},
      {"bvh,result,overlay", {"result.json", "avatar.bvh", "overlay.png"}},
      {"result,avatar,overlay,clothes,obj,bvh", every},
  };
  for (const auto& [words, expected] : table) {
    SCOPED_TRACE(words);
    const Files some = files_of({"--only", words});
    EXPECT_THAT(names(some), testing::UnorderedElementsAreArray(expected));
    for (const auto& [name, bytes] : some) EXPECT_TRUE(all.count(name) == 1 && bytes == all.at(name)) << name;
  }

  // The result with an undressed avatar: dressing takes most of the time of all files.
  const Files bare = files_of({"--only", "result,avatar"});
  EXPECT_THAT(names(bare), testing::UnorderedElementsAre("result.json", "avatar.glb"));
  EXPECT_EQ(bare.at("result.json"), all.at("result.json"));
  EXPECT_EQ(garments_in(bare.at("avatar.glb")), 0U);
  EXPECT_LT(seconds_, 0.7 * seconds_of_all);
}

TEST_F(WantedFiles, WithoutAMeasurementAreWrittenAsFarAsTheyExist) {
  const test::TestFolder folder;
  std::filesystem::copy(clip(), folder.path("short"));
  for (int frame = 3; frame < 12; ++frame) {
    const std::string number = std::to_string(frame);
    std::filesystem::remove(folder.path("short") + "/" + std::string(6 - number.size(), '0') + number + ".png");
  }
  const test::Run run = test::measure(folder.path("short"), folder.path("out"), {"--only", "overlay,obj"});
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_THAT(test::files_in(folder.path("out")), testing::ElementsAre("overlay.png"));
}

}  // namespace
}  // namespace im2fit
