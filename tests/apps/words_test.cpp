// SPDX-License-Identifier: Apache-2.0
// The command line: wrong words, --help, --json, and data files that are not there.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <sstream>
#include <tuple>

#include "core/guidance.h"
#include "measure_run.h"

namespace im2fit {
namespace {

using Words = std::vector<std::string>;

test::Run start(const char* program, const Words& words, const test::RunOptions& options = {}) {
  Words command = {program};
  command.insert(command.end(), words.begin(), words.end());
  return test::run_program(command, options);
}

std::string name_of(const char* program) {
  return std::filesystem::path(program).filename();
}

std::string joined(const char* program, const Words& words) {
  std::string text = name_of(program);
  for (const std::string& word : words) text += " " + word;
  return text;
}

TEST(Words, WrongOnesExitWithTwoAndOneLine) {
  const std::pair<const char*, Words> table[] = {
      {test::kProgram, {}},
      {test::kProgram, {"mesure", "x"}},
      {test::kProgram, {"--such"}},
      {test::kProgram, {"measure"}},
      {test::kProgram, {"measure", "a", "b"}},
      {test::kProgram, {"measure", "x", "--such"}},
      {test::kProgram, {"measure", "x", "--out"}},
      {test::kProgram, {"measure", "x", "--rotate", "45"}},
      {test::kProgram, {"measure", "x", "--rotate", "north"}},
      {test::kProgram, {"measure", "x", "--frames", "0"}},
      {test::kProgram, {"measure", "x", "--frames", "-3"}},
      {test::kProgram, {"measure", "x", "--frames", "many"}},
      {test::kProgram, {"measure", "x", "--frames", "99999999999999999999"}},
      {test::kProgram, {"measure", "x", "--calibration", "phi"}},
      {test::kProgram, {"measure", "x", "--sensor", "lidar"}},
      {test::kProgram, {"measure", "x", "--threads", "3"}},
      {test::kProgram, {"measure", "x", "--only", "result"}},
      {test::kProgram, {"measure", "x", "--out", "y", "--only", ""}},
      {test::kProgram, {"measure", "x", "--out", "y", "--only", "result,,bvh"}},
      {test::kProgram, {"measure", "x", "--out", "y", "--only", "result,"}},
      {test::kProgram, {"live", "x", "--out", "y", "--only", "picture"}},
      {test::kProgram, {"live"}},
      {test::kProgram, {"live", "x", "--rotate", "91"}},
      {test::kProgram, {"record", "x"}},
      {test::kProgram, {"record", "x", "--out", "y", "--frames", "-1"}},
      {test::kProgram, {"devices", "x"}},
      {test::kLab, {}},
      {test::kLab, {"rendr"}},
      {test::kLab, {"render"}},
      {test::kLab, {"render", "--out", "x", "--frames", "0"}},
      {test::kLab, {"render", "--out", "x", "--size", "1x1"}},
      {test::kLab, {"render", "--out", "x", "--pose", "handstand"}},
      {test::kLab, {"render", "--out", "x", "--distance", "nan"}},
      {test::kLab, {"population", "--subjects", "0"}},
      {test::kLab, {"population", "--preset", "giants"}},
      {test::kLab, {"dataset"}},
      {test::kLab, {"import-raw", "--out", "x"}},
      {test::kLab, {"import-raw", "x", "--out", "y", "--width", "0"}},
      {test::kLab, {"import-raw", "x", "--out", "y", "--focal", "0"}},
      {test::kLab, {"index", "--dimensions", "-1"}},
      {test::kLab, {"index", "inspect"}},
      {test::kLab, {"eval", "--condition", "foggy"}},
      {test::kLab, {"eval", "--subjects", "0"}},
      {test::kLab, {"train", "--images", "none"}},
      {test::kLab, {"fetch", "--such"}},
  };
  for (const auto& [program, words] : table) {
    SCOPED_TRACE(joined(program, words));
    const test::Run run = start(program, words);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.out, "");
    EXPECT_TRUE(test::is_one_line_of(run.err, name_of(program))) << run.err;
  }
}

TEST(Words, ATypoIsNamedWithWhatWasMeantAndWhoseHelpToRead) {
  const std::tuple<const char*, Words, const char*> table[] = {
      {test::kProgram, {"mesure", "x"}, "im2fit: im2fit has no mesure; did you mean measure? (see im2fit --help)\n"},
      {test::kProgram, {"xyzzy"}, "im2fit: im2fit has no xyzzy (see im2fit --help)\n"},
      {test::kProgram,
       {"measure", "x", "--rotat", "90"},
       "im2fit: im2fit measure has no --rotat; did you mean --rotate? (see im2fit measure --help)\n"},
      {test::kProgram,
       {"measure", "x", "--siez-chart=a"},
       "im2fit: im2fit measure has no --siez-chart; did you mean --size-chart? (see im2fit measure --help)\n"},
      {test::kProgram,
       {"models", "instal", "x"},
       "im2fit: im2fit models has no instal; did you mean install? (see im2fit models --help)\n"},
      {test::kProgram, {"measure"}, "im2fit: SOURCE is required (see im2fit measure --help)\n"},
      {test::kProgram,
       {"measure", "x", "--out", "y", "--only", "result,picture"},
       "im2fit: --only: 'picture' is not known; words are result, avatar, overlay, clothes, obj, bvh (see im2fit "
       "measure --help)\n"},
      {test::kLab, {"rendr"}, "im2fit-lab: im2fit-lab has no rendr; did you mean render? (see im2fit-lab --help)\n"},
  };
  for (const auto& [program, words, message] : table) EXPECT_EQ(start(program, words).err, message);
}

TEST(Words, TheVersionIsTheProjects) {
  for (const char* program : {test::kProgram, test::kLab}) {
    const test::Run run = start(program, {"--version"});
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_THAT(run.out, testing::MatchesRegex(name_of(program) + " [0-9]+\\.[0-9]+\\.[0-9]+\n"));
  }
}

// Libraries of the page cost every start more than the program itself: `im2fit serve` alone loads them.
TEST(Words, OnlyServeLoadsTheLibrariesOfThePage) {
  test::RunOptions traced;
  traced.environment = {{"LD_TRACE_LOADED_OBJECTS", "1"}};
  const test::Run run = start(test::kProgram, {"--version"}, traced);
  EXPECT_THAT(run.out, testing::HasSubstr("libc.so"));
  for (const char* library : {"libmicrohttpd", "libgnutls"})
    EXPECT_THAT(run.out, testing::Not(testing::HasSubstr(library)));
}

// Of a rendered person and of a synthetic one with a known truth.
TEST(Words, ATruthThatIsAskedForMustBeThere) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const test::Run run = test::measure("synthetic:1", folder.path("out"), {"--truth", folder.path("no.json")});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, testing::HasSubstr("no.json"));
}

TEST(Words, TheTableFitsATerminalOfEightyColumns) {
  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  const test::Run run =
      test::measure("synthetic:7", folder.path("out"), {"--frames", "5", "--rotate", "90", "--paper"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, testing::HasSubstr("paper's error"));
  std::istringstream lines(run.out.substr(0, run.out.find("written to")));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
}

TEST(Words, HelpIsEverywhere) {
  const std::pair<const char*, std::vector<Words>> table[] = {
      {test::kProgram,
       {{},
        {"devices"},
        {"measure"},
        {"live"},
        {"record"},
        {"convert"},
        {"tape"},
        {"tape", "list"},
        {"tape", "show"}}},
      {test::kLab,
       {{},
        {"fetch"},
        {"population"},
        {"train"},
        {"dataset"},
        {"index"},
        {"index", "inspect"},
        {"render"},
        {"import-raw"},
        {"eval"}}},
  };
  for (const auto& [program, commands] : table) {
    for (Words words : commands) {
      words.push_back("--help");
      SCOPED_TRACE(joined(program, words));
      const test::Run run = start(program, words);
      EXPECT_EQ(run.exit_code, 0);
      EXPECT_EQ(run.err, "");
      EXPECT_THAT(run.out, testing::HasSubstr("Usage"));
      // Help names the command it is about.
      if (words.size() > 1) {
        EXPECT_THAT(run.out, testing::HasSubstr(words[words.size() - 2]));
      }
    }
  }
}

TEST(Words, SourcesThatDoNotExistFail) {
  IM2FIT_NEED_DATA();
  const std::pair<const char*, const char*> table[] = {
      {"nothing-of-this-name", "nothing-of-this-name does not exist"},
      {"nothing.oni", "nothing.oni does not exist"},
      {"synthetic:seven", "synthetic:seven"},
      {"usb:1", "usb"},
      {"v4l2:/dev/video9", "v4l2"},
      {"/dev/null", "/dev/null"},
  };
  for (const auto& [source, message] : table) {
    SCOPED_TRACE(source);
    const test::TestFolder folder;
    const test::Run run = test::measure(source, folder.path("out"));
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, testing::HasSubstr(message));
    test::expect_honest(run, folder.path("out"));
    EXPECT_THAT(test::files_in(folder.path("out")), testing::IsEmpty());
  }
}

// Models that cannot be read are not what is reported: what people typed is checked before models are read.
TEST(Words, WhatIsWrongWithThemIsReportedBeforeModelsAreRead) {
  const test::TestFolder folder;
  test::write_text(folder.path("model"), "no model");
  test::write_depth_folder(folder.path("wall"), std::vector<test::Picture>(1, test::Picture(320, 240, 2500)));
  test::write_text(folder.path("file"), "no folder");
  const std::string wall = folder.path("wall");
  const std::pair<Words, const char*> table[] = {
      {{folder.path("nothing")}, "nothing does not exist"},
      {{folder.path("model")}, "neither a folder nor a recording"},
      {{wall, "--camera", folder.path("no.yaml")}, "no.yaml"},
      {{wall, "--truth", folder.path("no.json")}, "no.json"},
      {{wall, "--size-chart", folder.path("no.csv")}, "no.csv"},
      {{wall, "--tape", folder.path("no-tape.yaml")}, "no-tape.yaml"},
      {{wall, "--calibration-site", folder.path("no.i2c")}, "no.i2c"},
      {{wall, "--out", folder.path("file")}, "cannot make the directory"},
      {{wall}, "model"},  // nothing else is wrong
  };
  const std::string model = folder.path("model");
  for (auto [words, message] : table) {
    for (const char* command : {"measure", "live"}) {
      Words all = {command, "--body", model, "--tracker", model, "--index", model};
      all.insert(all.end(), words.begin(), words.end());
      SCOPED_TRACE(joined(test::kProgram, all));
      const test::Run run = start(test::kProgram, all);
      EXPECT_EQ(run.exit_code, 1);
      EXPECT_THAT(run.err, testing::HasSubstr(message));
    }
  }
}

TEST(Words, MeasureScanRefusesWhatIsNoScan) {
  const test::TestFolder folder;
  test::write_text(folder.path("person.oni"), "no recording");
  std::filesystem::create_directories(folder.path("scans.ply"));
  for (const std::string& source : {folder.path(), folder.path("scans.ply"), folder.path("person.oni"),
                                    folder.path("nothing"), std::string("synthetic:1"), std::string("openni2")}) {
    const test::Run run = start(test::kProgram, {"measure-scan", source});
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_THAT(run.err, testing::HasSubstr(source + " is no scan; expected a file whose name ends in .ply, .obj"));
    EXPECT_THAT(run.err, testing::HasSubstr("im2fit measure " + source));
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
  test::write_text(folder.path("body.stl"), "solid");
  const test::Run mesh = start(test::kProgram, {"measure-scan", folder.path("body.stl")});
  EXPECT_EQ(mesh.exit_code, 1);
  EXPECT_THAT(mesh.err, testing::HasSubstr("body.stl is a mesh of a kind that is not read; export it as .ply"));
  const test::Run run = start(test::kProgram, {"measure-scan", folder.path("nothing.ply")});
  EXPECT_THAT(run.err, testing::HasSubstr("nothing.ply does not exist"));
}

// A mesh's skin may look like loose clothes, and whoever wears these is measured from the front alone.
TEST(Words, APersonInAScanIsBareUnlessToldOtherwise) {
  const test::Run scan = start(test::kProgram, {"measure-scan", "--help"});
  EXPECT_THAT(scan.out, testing::HasSubstr("--clothing TEXT:{auto,bare,dressed}=bare"));
  const test::Run camera = start(test::kProgram, {"measure", "--help"});
  EXPECT_THAT(camera.out, testing::HasSubstr("--clothing TEXT:{auto,bare,dressed}=auto"));
}

// On a fresh machine every command names what makes the file it lacks.
TEST(Words, AFreshMachineGetsAdvice) {
  const test::TestFolder folder;
  test::RunOptions fresh;
  fresh.environment = {
      {"XDG_CACHE_HOME", folder.path("cache")}, {"IM2FIT_BODY", ""}, {"IM2FIT_TRACKER", ""}, {"IM2FIT_INDEX", ""}};
  const std::pair<const char*, Words> table[] = {
      {test::kProgram, {"measure", folder.path(), "--out", folder.path("out")}},
      {test::kProgram, {"live", folder.path(), "--out", folder.path("out")}},
      {test::kProgram, {"measure", "synthetic:1"}},
      {test::kProgram, {"record", "synthetic:1", "--out", folder.path("out")}},
      {test::kLab, {"render", "--out", folder.path("out")}},
      {test::kLab, {"population", "--out", folder.path("out.csv")}},
      {test::kLab, {"train", "--out", folder.path("out.i2t")}},
      {test::kLab, {"dataset", "--out", folder.path("out")}},
      {test::kLab, {"index", "--out", folder.path("out.i2f")}},
      {test::kLab, {"index", "inspect", folder.path("no.i2f")}},
      {test::kLab, {"eval", "--subjects", "1", "--out", folder.path("out.json")}},
  };
  for (const auto& [program, words] : table) {
    SCOPED_TRACE(joined(program, words));
    const test::Run run = start(program, words, fresh);
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_EQ(run.out, "");
    EXPECT_TRUE(test::is_one_line_of(run.err, name_of(program))) << run.err;
    EXPECT_THAT(run.err, testing::HasSubstr("im2fit-lab "));
    EXPECT_THAT(test::files_in(folder.path()), testing::IsEmpty());
  }
}

// Who chose the file that is not there: a variable, not the program.
TEST(DataFiles, AreNamedByTheVariableThatNamesThemInVain) {
  const test::TestFolder folder;
  for (const auto& [models, words] :
       {std::pair(folder.path("no.i2p"), "which does not exist"), {folder.path(), "a directory without "}})
    for (const Words& command : {Words{"measure", "synthetic:1"},
                                 {"record", "synthetic:1", "--out", folder.path("out")},
                                 {"tape", "show", "waist_girth", "--out", folder.path("w.svg")}}) {
      SCOPED_TRACE(joined(test::kProgram, command));
      test::RunOptions chosen;
      for (const char* variable : {"IM2FIT_BODY", "IM2FIT_TRACKER", "IM2FIT_INDEX"})
        chosen.environment.emplace_back(variable, "");
      chosen.environment.emplace_back("IM2FIT_MODELS", models);
      const test::Run run = start(test::kProgram, command, chosen);
      EXPECT_EQ(run.exit_code, 1);
      EXPECT_TRUE(test::is_one_line_of(run.err, "im2fit")) << run.err;
      EXPECT_THAT(run.err, testing::HasSubstr("IM2FIT_MODELS names " + models + ", " + words));
      EXPECT_THAT(run.err, testing::Not(testing::HasSubstr("im2fit-lab")));
    }
}

// The header, the page: one order in which codes are told.
TEST(Guidance, HasOneOrderInWhichOneOfSeveralIsTold) {
  const auto words_between = [](const std::string& path, const std::string& begin, const std::string& end) {
    const std::string text = test::read_text(path);
    const std::size_t from = text.find(begin), to = text.find(end, from);
    std::vector<std::string> words;
    if (from == std::string::npos || to == std::string::npos) return words;
    std::string word;
    for (const char c : text.substr(from + begin.size(), to - from - begin.size()) + " ") {
      if (std::isupper(static_cast<unsigned char>(c)) != 0 || c == '_') {
        word += c;
      } else if (!word.empty()) {
        words.push_back(std::exchange(word, ""));
      }
    }
    return words;
  };
  const auto header =
      words_between(IM2FIT_DATA "/../capi/include/im2fit/im2fit.h", "show only the first of this list:", "*/");
  EXPECT_EQ(header, words_between(IM2FIT_DATA "/../apps/kiosk/web/words.js", "const kOrder = [", "]"));
  const std::vector<std::string> all(kGuidanceNames.begin(), kGuidanceNames.end());
  EXPECT_THAT(header, testing::UnorderedElementsAreArray(all));
}

TEST(Json, IsAllThatIsOnStdout) {
  const test::Run devices = start(test::kProgram, {"devices", "--json"});
  if (devices.exit_code == 0) {
    EXPECT_TRUE(nlohmann::json::parse(devices.out, nullptr, false).is_array()) << devices.out;
  } else {  // built without OpenNI2, or its runtime is not there
    EXPECT_EQ(devices.out, "");
  }

  IM2FIT_NEED_DATA();
  const test::TestFolder folder;
  test::write_depth_folder(folder.path("wall"), std::vector<test::Picture>(4, test::Picture(320, 240, 2500)));
  const test::Run wall = test::measure(folder.path("wall"), folder.path("out"), {"--json"});
  EXPECT_EQ(wall.exit_code, 3);
  EXPECT_EQ(wall.out, test::read_text(folder.path("out/result.json")));
  EXPECT_TRUE(nlohmann::json::parse(wall.out, nullptr, false).is_object()) << wall.out;

  const test::Run people =
      start(test::kLab, {"population", "--subjects", "3", "--json", "--body", test::body_path()});
  EXPECT_EQ(people.exit_code, 0) << people.err;
  EXPECT_TRUE(nlohmann::json::parse(people.out, nullptr, false).is_structured()) << people.out;
}

}  // namespace
}  // namespace im2fit
