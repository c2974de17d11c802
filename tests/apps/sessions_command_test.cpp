// SPDX-License-Identifier: Apache-2.0
// `im2fit sessions` over a session made of a rendered person's recording.
#include <filesystem>

#include "apps/sessions/store.h"
#include "measured_clip.h"
#include "sessions/a_record.h"

namespace im2fit {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;

class SessionsCommand : public test::MeasuredClip {
 protected:
  static void SetUpTestSuite() { render({"--frames", "8"}); }
  static test::Run start(const std::vector<std::string>& words, const std::string& root) {
    std::vector<std::string> command = {test::kProgram, "sessions"};
    command.insert(command.end(), words.begin(), words.end());
    command.insert(command.end(), {"--root", root});
    if (words[0] == "measure" || words[0] == "replay")
      for (const std::string& word : {std::string("--body"), test::body_path(), std::string("--tracker"),
                                      test::tracker_path(), std::string("--index"), test::index_path()})
        command.push_back(word);
    return test::run_program(command);
  }
  // Of the clip; `result` is the answer.
  std::string saved(const Json& result = Json::object()) const {
    auto session = sessions::NewSession::begin(root_);
    if (!session) return session.error().message;
    std::filesystem::copy(clip(), session->path(sessions::kRecordingFolder));
    std::filesystem::remove(session->path("recording/truth.json"));
    EXPECT_TRUE(session->write(sessions::kResultFile, result.dump()));
    sessions::Record record;
    record.started_utc = sessions::utc_now();
    record.person = "P001";
    record.consent = {"operator-en-1", "en", std::string(64, '0'), sessions::utc_now()};
    record.truth.height_mm = 1650;
    record.truth.tape["waist_girth"] = {800, 804};
    record.camera = {"auto", "rendered", 320, 240, 280, 280, 160, 120};
    record.versions.im2fit = "0.0.0";
    record.settings = {5, "none", "none", "auto", "auto"};
    const auto finished = session->finish(record);
    return finished ? session->id() : finished.error().message;
  }
  const test::TestFolder folder_;
  const std::string root_ = folder_.path("sessions");
};

TEST_F(SessionsCommand, MeasuresARecordingAgainWithTheSameAnswer) {
  const std::string id = saved(measured({"--frames", "5"}));
  const test::Run run = start({"measure", id, "--json", "--out", folder_.path("out")}, root_);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json both = Json::parse(run.out);
  EXPECT_EQ(both["then"]["measurements"], both["now"]["measurements"]);
  EXPECT_GT(both["now"]["measurements"].size(), 5U);
  EXPECT_EQ(Json::parse(test::read_text(folder_.path("out/result.json")))["measurements"],
            both["now"]["measurements"]);
  const test::Run table = start({"measure", id}, root_);
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out, testing::ContainsRegex("waist_girth mm +802 +[0-9]+ +[0-9]+ +\\+0 "));
  EXPECT_THAT(table.out, testing::ContainsRegex("stature mm +1650 "));
}

TEST_F(SessionsCommand, ListsShowsReplaysAndDeletes) {
  EXPECT_THAT(start({"list"}, root_).out, HasSubstr("no sessions in "));
  const std::string id = saved();
  const test::Run list = start({"list"}, root_);
  EXPECT_THAT(list.out, testing::ContainsRegex(id + " +P001 +1650 "));
  const Json all = Json::parse(start({"list", "--json"}, root_).out);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0]["truth"]["tape"]["waist_girth"], Json({800, 804}));
  EXPECT_THAT(start({"show", id}, root_).out, HasSubstr("height      1650 mm\n"));
  EXPECT_EQ(Json::parse(start({"show", id, "--json"}, root_).out)["person"], "P001");
  const test::Run replay = start({"replay", id}, root_);
  EXPECT_EQ(replay.exit_code, 0) << replay.err;
  EXPECT_THAT(replay.err, HasSubstr("TRACKING"));
  EXPECT_THAT(start({"delete", id}, root_).out, HasSubstr("deleted " + id));
  const test::Run gone = start({"show", id}, root_);
  EXPECT_EQ(gone.exit_code, 1);
  EXPECT_TRUE(test::is_one_line_of(gone.err, "im2fit")) << gone.err;
  EXPECT_EQ(start({"delete", "../sessions"}, root_).exit_code, 1);
}

// A result that would end the program when it is printed is taken for none.
TEST_F(SessionsCommand, MeasuresAgainBesideAResultThatIsNestedTooDeep) {
  const std::string id = saved();
  test::write_text(root_ + "/" + id + "/result.json",
                   "{\"a\": " + std::string(100'000, '[') + std::string(100'000, ']') + "}");
  const test::Run run = start({"measure", id, "--json"}, root_);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json both = Json::parse(run.out, nullptr, false);
  EXPECT_TRUE(both["then"].is_null());
  EXPECT_GT(both["now"]["measurements"].size(), 5U);
}

// A field from elsewhere with control sequences of one character (U+009B is "escape, bracket").
TEST(SessionsAsJson, ATerminalGetsEscapesInPlaceOfControlCharacters) {
  const test::TestFolder folder;
  sessions::Record record = test::a_record();
  std::string text = sessions::record_json(record);
  text.insert(text.find('{') + 1,
              "\"from_elsewhere\": \"\xC2\x9B"
              "2J\x7F\xC3\xA9\",");
  std::filesystem::create_directory(folder.path(record.id));
  test::write_text(folder.path(record.id + "/session.json"), text);
  for (const char* command : {"show", "list"}) {
    std::vector<std::string> words = {test::kProgram, "sessions", command, "--json", "--root", folder.path("")};
    if (std::string(command) == "show") words.insert(words.begin() + 3, record.id);
    const test::Run run = test::run_program(words);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.out.find("\xC2\x9B"), std::string::npos) << command;
    EXPECT_EQ(run.out.find('\x7F'), std::string::npos) << command;
    const Json json = Json::parse(run.out);
    EXPECT_EQ((json.is_array() ? json[0] : json)["from_elsewhere"],
              "\xC2\x9B"
              "2J\x7F\xC3\xA9")
        << "the same text";
  }
}

TEST_F(SessionsCommand, ADamagedOneIsNamedAndTheOthersAreListed) {
  const std::string id = saved();
  std::filesystem::create_directory(root_ + "/damaged");
  test::write_text(root_ + "/damaged/session.json", "{\x1b[2J");
  const test::Run list = start({"list"}, root_);
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_THAT(list.out, HasSubstr(id));
  EXPECT_THAT(list.err, HasSubstr("damaged/session.json"));
  EXPECT_THAT(Json::parse(start({"list", "--json"}, root_).out)[0]["damage"], HasSubstr("not JSON"));
}

}  // namespace
}  // namespace im2fit
