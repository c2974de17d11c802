// SPDX-License-Identifier: Apache-2.0
// im2fit-lab pack and im2fit models: made twice the same, installed, found, and refused when damaged, older or newer.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "apps/common/pack/packs.h"
#include "body/model_data.h"
#include "capi/include/im2fit/im2fit.h"
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
  // Three files that only begin like ours, so that a pack of them is made in no time.
  struct Small {
    PackManifest manifest;
    std::vector<std::vector<std::byte>> contents;
    void add(const std::string& name, std::vector<std::byte> bytes) {
      manifest.files.push_back(apps::describe_file(name, bytes));
      contents.push_back(std::move(bytes));
    }
    void add(const std::string& name, const char* magic, std::uint32_t format, std::byte fill) {
      std::vector<std::byte> bytes(500, fill);
      std::memcpy(bytes.data(), magic, 4);
      std::memcpy(bytes.data() + 4, &format, sizeof format);
      add(name, std::move(bytes));
    }
  };
  static Small small(std::uint32_t index_format = kIndexFormat, std::byte fill = std::byte{7}) {
    Small all;
    all.manifest.version = "9.9";
    all.manifest.made_by = "a test";
    all.manifest.licence = "CC0-1.0";
    all.manifest.people = 3;
    all.add("body.i2b", "I2BD", body::kBodyVersion, fill);
    all.add("tracker.i2t", "I2TR", joints::kTrackerVersion, fill);
    all.add("index.i2f", "I2FX", index_format, fill);
    return all;
  }
  std::string packed(const Small& all, std::uint32_t pack_format = kPackVersion) const {
    auto pack = apps::make_pack(all.manifest, all.contents);
    EXPECT_TRUE(pack);
    std::memcpy(pack->data() + 4, &pack_format, sizeof pack_format);
    const std::string path = folder_ + "/small.i2p";
    EXPECT_TRUE(write_file_atomically(path, *pack));
    return path;
  }
  std::string small_pack(std::uint32_t index_format, std::uint32_t pack_format = kPackVersion) const {
    return packed(small(index_format), pack_format);
  }
  void expect_refused(const std::string& pack, const std::string& why) const {
    for (const char* command : {"verify", "install"}) {
      const test::Run run = models({command, pack});
      EXPECT_EQ(run.exit_code, 1) << why;
      EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
      EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
      EXPECT_LT(run.err.size(), 400U) << "of a size to be read";
    }
  }
  std::string installed(const std::string& name) const {
    std::ifstream file(folder_ + "/data/im2fit/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
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

// One file in place of three, compressed or stored: the same answer to the bit, and nothing unpacked.
TEST_F(Models, OfAPackMeasureWithoutBeingUnpacked) {
  IM2FIT_NEED_DATA();
  const auto measured = [&](std::vector<std::string> words, const std::string& models = "") {
    words.insert(words.begin(), {test::kProgram, "measure", "synthetic:7", "--json"});
    test::RunOptions options = alone();
    options.environment.emplace_back("IM2FIT_MODELS", models);
    const test::Run run = test::run_program(words, options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    auto json = nlohmann::json::parse(run.out, nullptr, false);
    json.erase("created");
    return json;
  };
  const auto apart =
      measured({"--body", test::body_path(), "--tracker", test::tracker_path(), "--index", test::index_path()});
  ASSERT_TRUE(apart.contains("measurements")) << apart;
  for (const bool stored : {false, true}) {
    const std::string pack = folder_ + (stored ? "/stored.i2p" : "/small.i2p");
    std::vector<std::string> words = {
        IM2FIT_LAB_PROGRAM, "pack",      "--source",           "npm",     "--out",           pack, "--body",
        test::body_path(),  "--tracker", test::tracker_path(), "--index", test::index_path()};
    if (stored) words.emplace_back("--stored");
    const test::Run made = test::run_program(words);
    ASSERT_EQ(made.exit_code, 0) << made.err;
    EXPECT_EQ(measured({"--models", pack}), apart) << pack;
    EXPECT_EQ(measured({}, pack), apart) << pack;
    EXPECT_EQ(measured({"--models", pack, "--index", test::index_path()}), apart) << "one file of its own";
  }
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder_)) files += entry.is_regular_file() ? 1 : 0;
  EXPECT_EQ(files, 2U) << "the packs alone";
  const std::string cut = folder_ + "/small.i2p";
  fs::resize_file(cut, fs::file_size(cut) / 2);
  const test::Run refused = test::run_program({test::kProgram, "measure", "synthetic:7", "--models", cut}, alone());
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(refused.err, "im2fit")) << refused.err;
  EXPECT_NE(refused.err.find("small.i2p"), std::string::npos) << refused.err;
}

// The C library takes a pack by path, from memory and from inside another file.
TEST_F(Models, OfAPackOpenInC) {
  IM2FIT_NEED_DATA();
  const std::string path = folder_ + "/a.i2p";
  const test::Run made =
      test::run_program({IM2FIT_LAB_PROGRAM, "pack", "--source", "npm", "--stored", "--out", path, "--body",
                         test::body_path(), "--tracker", test::tracker_path(), "--index", test::index_path()});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const auto pack = read_file(path);
  ASSERT_TRUE(pack);
  im2fit_settings plain;
  im2fit_settings_init(&plain, sizeof plain);
  plain.width = 480;
  plain.height = 640;
  plain.fx = plain.fy = 575.8F;
  plain.cx = 240;
  plain.cy = 320;
  const auto opened = [](const im2fit_settings& settings) {
    im2fit_handle* handle = nullptr;
    im2fit_models models{};
    EXPECT_EQ(im2fit_open(&settings, &handle), IM2FIT_OK) << im2fit_last_error(nullptr);
    if (handle != nullptr) {
      EXPECT_EQ(im2fit_get_models(handle, &models, sizeof models), IM2FIT_OK);
    }
    im2fit_close(handle);
    models.made_by = nullptr;
    return models;
  };
  const auto same = [](const im2fit_models& a, const im2fit_models& b) {
    return a.people == b.people && a.people > 0 && a.tracker_key == b.tracker_key && a.has_body == 1 &&
           b.has_body == 1 && a.answers_shape == b.answers_shape && a.captures == b.captures;
  };
  im2fit_settings apart = plain;
  const std::string body = test::body_path(), tracker = test::tracker_path(), index = test::index_path();
  apart.body_path = body.c_str();
  apart.tracker_path = tracker.c_str();
  apart.index_path = index.c_str();
  const im2fit_models expected = opened(apart);

  im2fit_settings by_path = plain, in_memory = plain, inside = plain;
  by_path.pack_path = path.c_str();
  EXPECT_TRUE(same(opened(by_path), expected));
  in_memory.pack_data = {IM2FIT_DATA_MEMORY, 0, 0, pack->data(), pack->size()};
  EXPECT_TRUE(same(opened(in_memory), expected));
  std::vector<std::byte> asset(4099, std::byte{9});
  asset.insert(asset.end(), pack->begin(), pack->end());
  const std::string asset_path = folder_ + "/asset";
  ASSERT_TRUE(write_file_atomically(asset_path, asset));
  inside.pack_data = {IM2FIT_DATA_FD, ::open(asset_path.c_str(), O_RDONLY | O_CLOEXEC), 4099, nullptr, pack->size()};
  ASSERT_GE(inside.pack_data.fd, 0);
  EXPECT_TRUE(same(opened(inside), expected));
  ::close(inside.pack_data.fd);

  im2fit_settings with_own = by_path;
  with_own.index_path = "/nonexistent.i2f";
  const auto refused = [](const im2fit_settings& settings, int status) {
    im2fit_handle* handle = nullptr;
    EXPECT_EQ(im2fit_open(&settings, &handle), status);
    return std::string(im2fit_last_error(nullptr));
  };
  EXPECT_NE(refused(with_own, IM2FIT_ERROR_NOT_FOUND).find("/nonexistent.i2f"), std::string::npos)
      << "a file of its own is read in place of the pack's";
  in_memory.pack_data.size = pack->size() / 2;
  EXPECT_NE(refused(in_memory, IM2FIT_ERROR_CORRUPT).find("settings.pack_data"), std::string::npos);
  std::vector<std::byte> older = *pack;
  older[4] = std::byte{1};
  in_memory.pack_data.bytes = older.data();
  in_memory.pack_data.size = older.size();
  EXPECT_NE(refused(in_memory, IM2FIT_ERROR_UNSUPPORTED)
                .find("format 1, older than the 2 this im2fit reads; get a newer pack"),
            std::string::npos);
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
  run = models({"install", small_pack(kIndexFormat, 3)});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("is a model pack of format 3, newer than the 2"), std::string::npos) << run.err;
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
    const auto pack = apps::open_pack(path);
    // Padding between sections has no checksum.
    if (pack && apps::verify_pack(*pack)) {
      EXPECT_EQ(pack->manifest.version, "9.9");
      EXPECT_EQ(pack->manifest.files.size(), 3U);
    }
  }
  for (const std::size_t size : {std::size_t{0}, std::size_t{7}, whole->size() / 2, whole->size() - 1}) {
    ASSERT_TRUE(write_file_atomically(path, std::span(*whole).first(size)));
    EXPECT_FALSE(apps::open_pack(path)) << size;
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
  ASSERT_TRUE(apps::parse_manifest(apps::manifest_json(small().manifest), "test"));
  for (const char* name : {"../escaped", "/tmp/escaped", "a/../../escaped", "models.json", "", "a/", "a//b", "./a",
                           ".models.part/a", "a\\b", "\x1b[2J", "a\nb", "caf\xC3\xA9"}) {
    Small all = small();
    all.add(name, std::vector<std::byte>(4));
    const auto read = apps::parse_manifest(apps::manifest_json(all.manifest), "test");
    ASSERT_FALSE(read) << name;
    EXPECT_NE(read.error().message.find("expected a path below the pack's folder"), std::string::npos) << name;
  }
}

TEST_F(Models, OfOnePackAreOneOfEachKindAndNoTwoOfAName) {
  Small twice = small();
  twice.add("body.i2b", "I2BD", body::kBodyVersion, std::byte{8});
  expect_refused(packed(twice), "lists body.i2b twice");
  Small folder_of_a_file = small();
  folder_of_a_file.add("body.i2b/chart.csv", std::vector<std::byte>(4));
  expect_refused(packed(folder_of_a_file), "body.i2b is a file and a folder");
  for (std::size_t missing = 0; missing < 3; ++missing) {
    Small two = small();
    two.manifest.files.erase(two.manifest.files.begin() + static_cast<std::ptrdiff_t>(missing));
    two.contents.erase(two.contents.begin() + static_cast<std::ptrdiff_t>(missing));
    expect_refused(packed(two), "it lists no ");
  }
  Small letters = small();
  letters.contents[0] = std::vector<std::byte>(8, std::byte{'x'});
  letters.manifest.files[0] = apps::describe_file("body.i2b", letters.contents[0]);
  expect_refused(packed(letters), "body.i2b begins with '', expected 'I2BD'");
  Small claims = small();
  claims.contents[0] = std::vector<std::byte>(500, std::byte{'x'});  // the manifest claims a body
  expect_refused(packed(claims), "body.i2b differs from the manifest");
  EXPECT_FALSE(fs::exists(folder_ + "/data/im2fit/body.i2b"));
}

TEST_F(Models, NumbersOfAManifestAreWhole) {
  const std::string text = apps::manifest_json(small().manifest);
  for (const auto& [from, to] :
       {std::pair{"\"people\": 3", "\"people\": -1"}, std::pair{"\"people\": 3", "\"people\": 1e300"},
        std::pair{"\"bytes\": 500", "\"bytes\": -1"}, std::pair{"\"bytes\": 500", "\"bytes\": 1e300"},
        std::pair{"\"crc32c\": \"", "\"crc32c\": \"0x"}}) {
    std::string wrong = text;
    ASSERT_NE(wrong.find(from), std::string::npos) << from;
    wrong.replace(wrong.find(from), std::strlen(from), to);
    EXPECT_FALSE(apps::parse_manifest(wrong, "test")) << to;
  }
}

// 236 kB held 1.6 GB of zeros.
TEST_F(Models, NoPackUnpacksToMoreThanModelsHave) {
  Small claims = small();
  claims.manifest.files[1].size = claims.manifest.files[2].size = 100U << 20U;
  expect_refused(packed(claims), "its files have more than 134217728 bytes");
  claims.manifest.files[1].size = 500;
  expect_refused(packed(claims), "index.i2f unpacks to 500 bytes, expected 104857600 by the manifest");
  Small bomb = small();
  bomb.add("zeros", std::vector<std::byte>(9U << 20U));
  bomb.manifest.files[3].size = 4;
  expect_refused(packed(bomb), "3 unpacks to 9437184 bytes, expected 4 by the manifest");
  EXPECT_FALSE(fs::exists(folder_ + "/data/im2fit/body.i2b"));

  const char* shared = std::getenv("IM2FIT_SHARED");
  const std::string cases = std::string(shared != nullptr ? shared : IM2FIT_SHARED_DEFAULT) + "/cases/";
  if (!fs::exists(cases + "page-pack-bomb"))
    GTEST_SKIP() << "no " << cases << ": set IM2FIT_SHARED to the shared folder";
  for (const char* name : {"page-pack-bomb/bomb6.i2p", "page-pack-escape/esc.i2p", "page-pack-escape/n_ctl.i2p"})
    expect_refused(cases + name, "is a model pack of format 1, older than the 2 this im2fit reads; get a newer pack");
}

TEST_F(Models, WordsOfAPackDoNotReachTheTerminalAsCommands) {
  Small all = small();
  all.manifest.version = "1\x1b[31mRED\nim2fit: fake" + std::string(1000, 'x');
  all.manifest.licence = "\x1b]0;title\a";
  const std::string pack = packed(all);
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"verify", pack}, {"install", pack}, {"verify"}, {"list"}}) {
    const test::Run run = models(words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(std::count_if(run.out.begin(), run.out.end(), [](unsigned char c) { return c < 0x20; }), 1) << run.out;
    EXPECT_EQ(run.out.find('\n'), run.out.size() - 1) << run.out;
    EXPECT_LT(run.out.size(), 400U);
  }
}

// A body of one pack beside a tracker of another measures, and wrongly.
TEST_F(Models, AFullDiskOrADamagedPackLeavesTheOldOnes) {
  ASSERT_EQ(models({"install", small_pack(kIndexFormat)}).exit_code, 0);
  const std::string body = installed("body.i2b"), manifest = installed("models.json");
  const auto expect_the_old_ones = [&] {
    EXPECT_EQ(installed("body.i2b"), body);
    EXPECT_EQ(installed("models.json"), manifest);
    EXPECT_EQ(models({"verify"}).exit_code, 0);
    EXPECT_FALSE(fs::exists(folder_ + "/data/im2fit/.models.part"));
  };
  Small other = small(kIndexFormat, std::byte{9});
  other.add("chart.csv", std::vector<std::byte>(5000, std::byte{'x'}));
  const std::string pack = packed(other);
  test::RunOptions full = alone();
  full.file_bytes_max = 4000;  // the models fit, what comes after them does not
  const test::Run run = test::run_program({test::kProgram, "models", "install", pack}, full);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("cannot write "), std::string::npos) << run.err;
  expect_the_old_ones();

  Small damaged = small(kIndexFormat, std::byte{9});
  damaged.contents[2][100] = std::byte{1};
  EXPECT_EQ(models({"install", packed(damaged)}).exit_code, 1);
  expect_the_old_ones();

  // What a killed install left goes with the next one.
  fs::create_directories(folder_ + "/data/im2fit/.models.part/size-charts");
  EXPECT_EQ(models({"install", packed(small(kIndexFormat, std::byte{9}))}).exit_code, 0);
  EXPECT_NE(installed("body.i2b"), body);
  EXPECT_EQ(models({"verify"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(folder_ + "/data/im2fit/.models.part"));
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
