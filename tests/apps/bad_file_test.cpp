// SPDX-License-Identifier: Apache-2.0
// Damaged and foreign files, folders that cannot be written, a full disk.
#include "measure_run.h"

namespace im2fit {
namespace {

using test::Picture;
using Words = std::vector<std::string>;

std::string wall_folder(const test::TestFolder& folder) {
  test::write_depth_folder(folder.path("wall"), std::vector<Picture>(4, Picture(320, 240, 2500)));
  return folder.path("wall");
}

// One run of im2fit-lab that must fail with one line holding `expected`.
void expect_lab_fails(const Words& words, const std::string& expected, const test::RunOptions& options = {}) {
  Words command = {test::kLab};
  command.insert(command.end(), words.begin(), words.end());
  SCOPED_TRACE("im2fit-lab " + words[0]);
  const test::Run run = test::run_program(command, options);
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.out, "");
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit-lab")) << run.err;
  EXPECT_THAT(run.err, testing::HasSubstr(expected));
}

// What can happen to a file of ours. `other` is a file of another kind of ours.
struct Damage {
  const char* name;
  std::string (*change)(std::string whole, const std::string& other);
};
const Damage kDamages[] = {
    {"Empty", [](std::string, const std::string&) -> std::string { return ""; }},
    {"Text", [](std::string, const std::string&) -> std::string { return "hello\n"; }},
    {"Zeros", [](std::string, const std::string&) { return std::string(100'000, '\0'); }},
    {"CutInTheHeader", [](std::string whole, const std::string&) { return whole.substr(0, 20); }},
    {"CutInTheMiddle", [](std::string whole, const std::string&) { return whole.substr(0, whole.size() / 2); }},
    {"CutByOneByte", [](std::string whole, const std::string&) { return whole.substr(0, whole.size() - 1); }},
    {"ChangedInTheMiddle",
     [](std::string whole, const std::string&) {
       whole[whole.size() / 2] = static_cast<char>(whole[whole.size() / 2] ^ 0x10);
       return whole;
     }},
    {"OfAnotherKind", [](std::string, const std::string& other) { return other; }},
};

class DamagedDataFile : public testing::TestWithParam<Damage> {};

TEST_P(DamagedDataFile, IsNamedInOneLine) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const std::string wall = wall_folder(folder);
  const struct {
    const char* option;
    const char* name;
    std::string good;
    std::string other;
  } kinds[] = {{"--tracker", "bad.i2t", test::tracker_path(), test::index_path()},
               {"--index", "bad.i2f", test::index_path(), test::tracker_path()},
               {"--body", "bad.i2b", test::body_path(), test::index_path()}};
  for (const auto& kind : kinds) {
    SCOPED_TRACE(kind.name);
    const std::string bad = folder.path(kind.name);
    test::write_text(bad, GetParam().change(test::read_text(kind.good), test::read_text(kind.other)));
    Words command = {test::kProgram, "measure", wall, "--out", folder.path("out"), kind.option, bad};
    for (const auto& good : kinds)
      if (good.option != kind.option) command.insert(command.end(), {good.option, good.good});
    const test::Run run = test::run_program(command);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, testing::HasSubstr(kind.name));
    test::expect_honest(run, folder.path("out"));
    EXPECT_THAT(test::files_in(folder.path("out")), testing::IsEmpty());
  }
  expect_lab_fails({"index", "inspect", folder.path("bad.i2f")}, "bad.i2f");
  expect_lab_fails({"population", "--subjects", "1", "--body", folder.path("bad.i2b")}, "bad.i2b");
  expect_lab_fails({"render", "--out", folder.path("scene"), "--body", folder.path("bad.i2b")}, "bad.i2b");
  expect_lab_fails({"eval", "--subjects", "1", "--body", test::body_path(), "--joint-model", folder.path("bad.i2t"),
                    "--index", test::index_path()},
                   "bad.i2t");
  EXPECT_FALSE(std::filesystem::exists(folder.path("scene")));
}

INSTANTIATE_TEST_SUITE_P(Table, DamagedDataFile, testing::ValuesIn(kDamages),
                         [](const auto& tested) { return std::string(tested.param.name); });

// Both are sound, but what one learned rests on joints the other does not find.
TEST(IndexOfAnotherTracker, IsRefusedByName) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const std::string tracker = folder.path("tiny.i2t");
  const test::Run trained = test::run_program(
      {test::kLab, "train", "--images", "40", "--level-trees", "1", "--body", test::body_path(), "--out", tracker});
  ASSERT_EQ(trained.exit_code, 0) << trained.err;
  const test::Run run =
      test::run_program({test::kProgram, "measure", wall_folder(folder), "--out", folder.path("out"), "--body",
                         test::body_path(), "--tracker", tracker, "--index", test::index_path()});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
  for (const std::string& expected : {tracker, test::index_path(), std::string("another tracker")})
    EXPECT_THAT(run.err, testing::HasSubstr(expected));
  EXPECT_THAT(test::files_in(folder.path("out")), testing::IsEmpty());
}

#if IM2FIT_TEST_ONI
TEST(ForeignRecording, IsRefused) {
  IM2FIT_NEED_DATA();
  const std::pair<const char*, std::string> table[] = {
      {"empty.oni", ""},
      {"text.oni", "hello\n"},
      {"zeros.oni", std::string(100'000, '\0')},
      {"picture.oni", test::png(Picture(320, 240, 2500))},
      {"index.oni", test::read_text(test::index_path()).substr(0, 100'000)},
  };
  for (const auto& [name, bytes] : table) {
    SCOPED_TRACE(name);
    const test::TestFolder folder;
    test::write_text(folder.path(name), bytes);
    const test::Run run = test::measure(folder.path(name), folder.path("out"));
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, testing::HasSubstr(name));
    test::expect_honest(run, folder.path("out"));
    EXPECT_THAT(test::files_in(folder.path("out")), testing::IsEmpty());
  }
  const test::TestFolder folder;
  std::filesystem::create_directory(folder.path("folder.oni"));
  const test::Run run = test::measure(folder.path("folder.oni"), folder.path("out"));
  EXPECT_EQ(run.exit_code, 1);
  test::expect_honest(run, folder.path("out"));
}
#endif

#if IM2FIT_TEST_ONI
// Recorded, then cut: with the checksum beside it the damage is known, without it the structure shows it.
TEST(CutRecording, IsRefused) {
  IM2FIT_NEED_DATA();
  constexpr int kRecorded = 4;
  const test::TestFolder folder;
  const test::Run recorded = test::run_program({test::kProgram, "record", wall_folder(folder), "--out",
                                                folder.path("whole.oni"), "--frames", std::to_string(kRecorded)});
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const test::Run whole = test::measure(folder.path("whole.oni"), folder.path("whole"));
  EXPECT_EQ(whole.exit_code, 3) << whole.err;
  test::expect_honest(whole, folder.path("whole"));
  const auto whole_result = nlohmann::json::parse(test::read_text(folder.path("whole/result.json")), nullptr, false);
  const int frames_whole = whole_result["frames"]["seen"];
  EXPECT_EQ(frames_whole, kRecorded);

  const std::string bytes = test::read_text(folder.path("whole.oni"));
  const std::string beside = test::read_text(folder.path("whole.oni.yaml"));
  EXPECT_NE(beside, "");
  for (const bool with_checksum : {true, false}) {
    for (const std::size_t size : {bytes.size() - 1, bytes.size() / 2, bytes.size() / 10, std::size_t{100}}) {
      SCOPED_TRACE("cut to " + std::to_string(size) + (with_checksum ? " with checksum" : ""));
      test::write_text(folder.path("cut.oni"), bytes.substr(0, size));
      std::filesystem::remove(folder.path("cut.oni.yaml"));
      if (with_checksum) test::write_text(folder.path("cut.oni.yaml"), beside);
      std::filesystem::remove_all(folder.path("out"));
      const test::Run run = test::measure(folder.path("cut.oni"), folder.path("out"));
      test::expect_honest(run, folder.path("out"));
      if (!with_checksum && run.exit_code == 3) {  // the cut may have hit what lies behind the last frame
        const auto result = nlohmann::json::parse(test::read_text(folder.path("out/result.json")), nullptr, false);
        EXPECT_EQ(result["frames"]["seen"], frames_whole);
        continue;
      }
      EXPECT_EQ(run.exit_code, 1);
      EXPECT_THAT(run.err, testing::HasSubstr("cut.oni"));
      EXPECT_THAT(test::files_in(folder.path("out")), testing::IsEmpty());
    }
  }
}
#endif

// Refused to root as well: below a regular file, and in the kernel's own file systems.
TEST(UnwritableOut, IsReportedInOneLine) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const std::string wall = wall_folder(folder);
  test::write_text(folder.path("file"), "mine\n");
  const std::string raw = folder.path("frame.raw");
  test::write_text(raw, std::string(32, 'x'));
  for (const std::string& out : {folder.path("file"), folder.path("file/below"), std::string("/proc/im2fit-out"),
                                 std::string("/sys/im2fit-out"), std::string("/dev/full")}) {
    SCOPED_TRACE(out);
    for (const char* command : {"measure", "live"}) {
      const test::Run run =
          test::run_program({test::kProgram, command, wall, "--out", out, "--body", test::body_path(), "--tracker",
                             test::tracker_path(), "--index", test::index_path()});
      EXPECT_EQ(run.exit_code, 1) << command;
      EXPECT_THAT(run.err, testing::HasSubstr(out));
      EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
    }
    const test::Run run = test::run_program({test::kProgram, "record", wall, "--out", out});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
    EXPECT_THAT(run.err, testing::HasSubstr(out));
    expect_lab_fails({"import-raw", raw, "--width", "4", "--height", "4", "--out", out}, out);
    expect_lab_fails({"render", "--frames", "1", "--size", "320x240", "--body", test::body_path(), "--out", out},
                     out);
    expect_lab_fails({"population", "--subjects", "1", "--body", test::body_path(), "--out",
                      out == "/dev/full" ? out + "/x" : out + "/x.csv"},
                     out);
  }
  EXPECT_EQ(test::read_text(folder.path("file")), "mine\n");
}

// The largest file that can be written stands in for the room left on the disk.
TEST(FullDisk, LeavesNothingHalfWritten) {
  IM2FIT_NEED_DATA();
  for (const rlim_t room : {rlim_t{0}, rlim_t{100}, rlim_t{250}}) {
    SCOPED_TRACE("room for " + std::to_string(room) + " bytes");
    const test::TestFolder folder;
    const std::string wall = wall_folder(folder);
    test::RunOptions full;
    full.file_bytes_max = room;
    const test::Run run = test::measure(wall, folder.path("out"), {}, full);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, testing::HasSubstr(folder.path("out")));
    test::expect_honest(run, folder.path("out"));

    const test::Run record =
        test::run_program({test::kProgram, "record", wall, "--out", folder.path("copy"), "--frames", "3"}, full);
    EXPECT_EQ(record.exit_code, 1);
    EXPECT_TRUE(test::is_one_line_of(record.err, "im2fit")) << record.err;
    EXPECT_THAT(test::partial_files_in(folder.path("copy")), testing::IsEmpty());

    expect_lab_fails(
        {"render", "--frames", "2", "--size", "320x240", "--body", test::body_path(), "--out", folder.path("scene")},
        folder.path("scene"), full);
    EXPECT_THAT(test::partial_files_in(folder.path("scene")), testing::IsEmpty());

    expect_lab_fails(
        {"population", "--subjects", "20", "--body", test::body_path(), "--out", folder.path("people.csv")},
        folder.path("people.csv"), full);
    EXPECT_THAT(test::files_in(folder.path()), testing::Not(testing::Contains(testing::StartsWith("people"))));
  }
}

TEST(FullDisk, BehindStdoutIsReported) {
  IM2FIT_NEED_DATA();
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  const test::TestFolder folder;
  test::RunOptions full;
  full.stdout_path = "/dev/full";
  const Words data = {"--body", test::body_path(), "--tracker", test::tracker_path(), "--index", test::index_path()};
  const std::pair<const char*, Words> table[] = {
      {test::kProgram, {"measure", wall_folder(folder), "--json"}},
      {test::kProgram, {"measure", "synthetic:1", "--frames", "5"}},
      {test::kProgram, {"measure", "synthetic:1", "--frames", "5", "--json"}},
      {test::kLab, {"population", "--subjects", "2", "--json", "--body", test::body_path()}},
  };
  for (const auto& [program, words] : table) {
    Words command = {program};
    command.insert(command.end(), words.begin(), words.end());
    if (words[0] == "measure") command.insert(command.end(), data.begin(), data.end());
    SCOPED_TRACE(testing::PrintToString(words));
    const test::Run run = test::run_program(command, full);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_TRUE(test::is_one_line_of(run.err, std::filesystem::path(program).filename())) << run.err;
  }
}

// The judge of the cases above finds the faults that it must find.
TEST(PartialFiles, AreSeen) {
  const test::TestFolder folder;
  const std::string png = test::png(Picture(320, 240, 2500));
  const std::string glb("glTF\2\0\0\0\x10\0\0\0body", 16);
  const std::pair<const char*, std::string> whole[] = {
      {"a.json", "{\"a\": 1}\n"}, {"a.png", png}, {"a.glb", glb}, {"a.obj", "v 0 0 0\n"}};
  for (const auto& [name, bytes] : whole) test::write_text(folder.path(name), bytes);
  EXPECT_THAT(test::partial_files_in(folder.path()), testing::IsEmpty());
  for (const auto& [name, bytes] : whole)
    test::write_text(folder.path(std::string("cut-") + name), bytes.substr(0, bytes.size() - 3));
  test::write_text(folder.path("result.json.tmp"), "{}\n");
  EXPECT_THAT(test::partial_files_in(folder.path()),
              testing::UnorderedElementsAre("cut-a.json", "cut-a.png", "cut-a.glb", "cut-a.obj", "result.json.tmp"));
}

TEST(RawFrames, OfAnotherSizeLeaveNoFolder) {
  const test::TestFolder folder;
  test::write_text(folder.path("short.raw"), std::string(31, 'x'));
  test::write_text(folder.path("good.raw"), std::string(32, 'x'));
  for (const char* bad : {"short.raw", "absent.raw"}) {
    expect_lab_fails({"import-raw", folder.path("good.raw"), folder.path(bad), "--width", "4", "--height", "4",
                      "--out", folder.path("depth")},
                     bad);
    EXPECT_FALSE(std::filesystem::exists(folder.path("depth")));
  }
}

TEST(Fetch, OfACheckoutThatIsNoneLeavesNoBody) {
  const test::TestFolder folder;
  std::filesystem::create_directory(folder.path("empty"));
  for (const char* checkout : {"absent", "empty"}) {
    expect_lab_fails({"fetch", "--makehuman", folder.path(checkout), "--out", folder.path("body.i2b")}, checkout);
    EXPECT_THAT(test::files_in(folder.path()), testing::ElementsAre("empty"));
  }
}

}  // namespace
}  // namespace im2fit
