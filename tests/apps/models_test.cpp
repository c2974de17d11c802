// SPDX-License-Identifier: Apache-2.0
// im2fit-lab pack and im2fit models: made twice the same, installed, found, and refused when damaged, older or newer.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/common/pack/model_pack.h"
#include "body/model_data.h"
#include "core/file.h"
#include "data_paths.h"
#include "index/format.h"
#include "measure_run.h"
#include "perception/joints/model_data.h"
#include "run_program.h"

namespace im2fit {
namespace {

using apps::PackManifest;
namespace fs = std::filesystem;

constexpr std::uintmax_t kPackBytesMax = 10'000'000;

class Models : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = testing::TempDir() + "/models_test";
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  // Only files below the test's folder are read.
  test::RunOptions alone() const {
    test::RunOptions options;
    options.environment = {{"IM2FIT_BODY", ""},
                           {"IM2FIT_TRACKER", ""},
                           {"IM2FIT_INDEX", ""},
                           {"XDG_DATA_HOME", folder_ + "/data"},
                           {"XDG_CACHE_HOME", folder_ + "/cache"},
                           {"XDG_DATA_DIRS", folder_ + "/shared"}};
    return options;
  }
  test::Run models(std::vector<std::string> words) const {
    words.insert(words.begin(), {test::kProgram, "models"});
    return test::run_program(words, alone());
  }
  // A pack of three files that only begin like ours, so that it is made in no time.
  std::string small_pack(std::uint32_t index_format, std::uint32_t pack_format = apps::kPackVersion) const {
    PackManifest manifest;
    manifest.version = "9.9";
    manifest.made_by = "a test";
    manifest.licence = "CC0-1.0";
    manifest.people = 3;
    std::vector<std::vector<std::byte>> contents;
    const auto add = [&](const std::string& name, const char* magic, std::uint32_t format) {
      std::vector<std::byte> bytes(500, std::byte{7});
      std::memcpy(bytes.data(), magic, 4);
      std::memcpy(bytes.data() + 4, &format, sizeof format);
      manifest.files.push_back(apps::describe_file(name, bytes));
      contents.push_back(std::move(bytes));
    };
    add("body.i2b", "I2BD", body::kBodyVersion);
    add("tracker.i2t", "I2TR", joints::kTrackerVersion);
    add("index.i2f", "I2FX", index_format);
    auto pack = apps::make_pack(manifest, contents);
    EXPECT_TRUE(pack);
    std::memcpy(pack->data() + 4, &pack_format, sizeof pack_format);
    const std::string path = folder_ + "/small.i2p";
    EXPECT_TRUE(write_file_atomically(path, *pack));
    return path;
  }
  static constexpr std::uint32_t kIndexFormat = index::kVersion;

  std::string folder_;
};

TEST_F(Models, ArePackedInstalledAndMeasureAsBefore) {
  IM2FIT_NEED_DATA();
  const std::string first = folder_ + "/a.i2p", second = folder_ + "/b.i2p";
  for (const std::string& out : {first, second}) {
    const test::Run run =
        test::run_program({IM2FIT_LAB_PROGRAM, "pack", "--source", "npm", "--out", out, "--body", test::body_path(),
                           "--tracker", test::tracker_path(), "--index", test::index_path()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  const auto a = read_file(first), b = read_file(second);
  ASSERT_TRUE(a && b);
  EXPECT_TRUE(*a == *b) << "the same files give the same pack";
  EXPECT_LT(fs::file_size(first), kPackBytesMax);

  EXPECT_EQ(models({"list"}).exit_code, 1);
  const test::Run installed = models({"install", first});
  ASSERT_EQ(installed.exit_code, 0) << installed.err;
  EXPECT_NE(installed.out.find("AGPL-3.0-only"), std::string::npos) << installed.out;
  for (const auto& [name, path] :
       {std::pair{"body.i2b", test::body_path()}, std::pair{"tracker.i2t", test::tracker_path()},
        std::pair{"index.i2f", test::index_path()}}) {
    const auto was = read_file(path), is = read_file(folder_ + "/data/im2fit/" + name);
    ASSERT_TRUE(was && is) << name;
    EXPECT_TRUE(*was == *is) << name;
  }
  EXPECT_TRUE(fs::exists(folder_ + "/data/im2fit/size-charts/en13402-3-men.csv"));
  EXPECT_TRUE(fs::exists(folder_ + "/data/im2fit/LICENCE.txt"));
  for (const char* text : {"tape/lengths.yaml", "garments/t_shirt.yaml", "fabrics/fabrics.yaml"}) {
    const auto ours = read_file(std::string(IM2FIT_DATA "/") + text);
    const auto packed = read_file(folder_ + "/data/im2fit/" + text);
    ASSERT_TRUE(ours && packed) << text;
    EXPECT_TRUE(*ours == *packed) << text;
  }
  EXPECT_EQ(models({"verify"}).exit_code, 0);
  const auto list = nlohmann::json::parse(models({"list", "--json"}).out, nullptr, false);
  ASSERT_TRUE(list.is_array() && list.size() == 1) << list;
  EXPECT_EQ(list[0]["directory"], folder_ + "/data/im2fit");
  EXPECT_EQ(list[0]["used"], true);
  EXPECT_GT(list[0]["pack"]["people"], 100);

  // Found without a word about where they are.
  const test::Run seen =
      test::run_program({test::kProgram, "tape", "show", "waist_girth", "--out", folder_ + "/w.svg"}, alone());
  EXPECT_EQ(seen.exit_code, 0) << seen.err;
}

TEST_F(Models, OfOneDirectoryAreNeverMixedWithAnothers) {
  const std::string pack = small_pack(kIndexFormat);
  ASSERT_EQ(models({"install", pack, "--to", folder_ + "/shared/im2fit"}).exit_code, 0);
  // A body alone in a place that comes first is not taken.
  fs::create_directories(folder_ + "/data/im2fit");
  std::ofstream(folder_ + "/data/im2fit/body.i2b") << "not these";
  auto list = nlohmann::json::parse(models({"list", "--json"}).out, nullptr, false);
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0]["directory"], folder_ + "/shared/im2fit");
  ASSERT_EQ(models({"install", pack}).exit_code, 0);
  list = nlohmann::json::parse(models({"list", "--json"}).out, nullptr, false);
  ASSERT_EQ(list.size(), 2U);
  EXPECT_EQ(list[0]["directory"], folder_ + "/data/im2fit");
  EXPECT_EQ(list[1]["used"], false);
}

TEST_F(Models, OlderAndNewerAreRefusedByName) {
  test::Run run = models({"install", small_pack(kIndexFormat - 1)});
  EXPECT_EQ(run.exit_code, 1);
  const std::string read = " than the " + std::to_string(kIndexFormat) + " this im2fit reads; get a newer ";
  EXPECT_NE(run.err.find("its index (index.i2f) is of format " + std::to_string(kIndexFormat - 1) + ", older" + read +
                         "pack"),
            std::string::npos)
      << run.err;
  run = models({"install", small_pack(kIndexFormat + 1)});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("newer" + read + "im2fit"), std::string::npos) << run.err;
  run = models({"install", small_pack(kIndexFormat, 2)});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("is a model pack of format 2, newer than the 1"), std::string::npos) << run.err;
  EXPECT_FALSE(fs::exists(folder_ + "/data/im2fit")) << "nothing is written of a pack that is refused";
}

TEST_F(Models, DamageIsNamed) {
  const std::string path = small_pack(kIndexFormat);
  ASSERT_EQ(models({"verify", path}).exit_code, 0);
  const auto whole = read_file(path);
  ASSERT_TRUE(whole);
  for (std::size_t at = 0; at < whole->size(); at += 13) {
    std::vector<std::byte> bytes = *whole;
    bytes[at] ^= std::byte{0x20};
    ASSERT_TRUE(write_file_atomically(path, bytes));
    const auto pack = apps::read_pack(path);
    // Padding between sections has no checksum.
    if (pack) {
      EXPECT_EQ(pack->manifest.version, "9.9");
      EXPECT_EQ(pack->contents.size(), 3U);
    }
  }
  for (const std::size_t size : {std::size_t{0}, std::size_t{7}, whole->size() / 2, whole->size() - 1}) {
    ASSERT_TRUE(write_file_atomically(path, std::span(*whole).first(size)));
    EXPECT_FALSE(apps::read_pack(path)) << size;
  }
  const test::Run foreign = models({"install", std::string(test::kProgram)});
  EXPECT_EQ(foreign.exit_code, 1);
  EXPECT_NE(foreign.err.find("is not a model pack"), std::string::npos) << foreign.err;

  ASSERT_EQ(models({"install", small_pack(kIndexFormat)}).exit_code, 0);
  std::ofstream(folder_ + "/data/im2fit/tracker.i2t", std::ios::app) << "x";
  const test::Run changed = models({"verify"});
  EXPECT_EQ(changed.exit_code, 1);
  EXPECT_NE(changed.err.find("tracker.i2t: 501 bytes"), std::string::npos) << changed.err;
}

// A manifest that names a file elsewhere is refused before anything is written.
TEST_F(Models, WriteNowhereElse) {
  for (const char* name : {"../escaped", "/tmp/escaped", "a/../../escaped", "models.json", "", "a/"}) {
    PackManifest manifest;
    manifest.files.push_back(apps::describe_file(name, std::vector<std::byte>(4)));
    EXPECT_FALSE(apps::parse_manifest(apps::manifest_json(manifest), "test")) << name;
  }
}

TEST_F(Models, ManualAndCompletionAreOfEveryCommand) {
  for (const char* program : {test::kProgram, IM2FIT_LAB_PROGRAM}) {
    const test::Run page = test::run_program({program, "--man-page"}, alone());
    const test::Run completion = test::run_program({program, "--bash-completion"}, alone());
    const test::Run help = test::run_program({program, "--help"}, alone());
    ASSERT_EQ(page.exit_code + completion.exit_code + help.exit_code, 0);
    EXPECT_EQ(page.out.find(folder_ + "/x"), std::string::npos);
    std::istringstream lines(help.out.substr(help.out.find("Subcommands:")));
    int commands = 0;
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line) && line.starts_with("  ")) {
      if (line[2] == ' ') continue;  // a description goes on
      std::string name;
      std::istringstream(line) >> name;
      ++commands;
      std::string escaped;
      for (const char c : name) escaped += c == '-' ? std::string("\\-") : std::string(1, c);
      EXPECT_NE(page.out.find(".SS \"" + escaped + "\""), std::string::npos) << name;
      EXPECT_NE(completion.out.find("' " + name + "')"), std::string::npos) << name;
    }
    EXPECT_GE(commands, 6);
  }
}

}  // namespace
}  // namespace im2fit
