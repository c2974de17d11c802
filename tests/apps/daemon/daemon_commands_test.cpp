// SPDX-License-Identifier: Apache-2.0
// What clients may ask im2fitd for: the lines alone, then the program before a synthetic person, by a client in C++
// and by the example in Python.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>

#include "apps/im2fitd/commands.h"
#include "apps/im2fitd/publisher.h"
#include "daemon_run.h"
#include "data_paths.h"
#include "depth_folder.h"
#include "private_files.h"

namespace im2fit::daemon {
namespace {

using nlohmann::json;
using test::Client;

TEST(DaemonCommand, IsOneOnALineWithOrWithoutAnId) {
  apps::Json id;
  for (std::size_t i = 0; i < kCommands.size(); ++i) {
    const auto wish = static_cast<Wish>(i);
    const std::string value = wish == Wish::select_user ? "3" : "{}";
    const auto command = parse_command("{\"" + std::string(kCommands[i]) + "\": " + value + "}", id);
    ASSERT_TRUE(command) << kCommands[i] << ": " << command.error().message;
    EXPECT_EQ(command->wish, wish);
    EXPECT_TRUE(command->client.is_null());
  }
  const auto avatar = parse_command(R"({"id": "a-1", "avatar": {"format": "bvh"}})", id);
  ASSERT_TRUE(avatar);
  EXPECT_EQ(avatar->value, "bvh");
  EXPECT_EQ(avatar->client, "a-1");
  EXPECT_EQ(parse_command(R"({"avatar": {}, "id": 7})", id)->value, "glb");
  id = nullptr;
  EXPECT_FALSE(parse_command(R"({"shoe": {}, "id": 7})", id));
  EXPECT_EQ(id, 7) << "a refusal has the id, wherever it stands";
  EXPECT_EQ(id, 7);
}

TEST(DaemonCommand, WhatIsWrongIsSaidWithoutAFact) {
  const std::map<std::string, std::string> wrong = {
      {"GET / HTTP/1.1", "on one line"},
      {"[]", "on one line"},
      {"{}", "on one line"},
      {R"({"id": 4})", "beside the id"},
      {R"({"reset": {}, "mask": {}})", "one command"},
      {R"({"shoe": 4711})", "commands of `hello`"},
      {R"({"reset": 4711})", "reset: expected"},
      {R"({"mask": {"size": 4711}})", "mask: takes no fields"},
      {R"({"known": [4711]})", "known: expected"},
      {R"({"select_user": -1})", "select_user: expected"},
      {R"({"select_user": "4711"})", "select_user: expected"},
      {R"({"select_user": 47.11})", "select_user: expected"},
      {R"({"avatar": {"format": "fbx"}})", "avatar: expected"},
      {R"({"avatar": {"format": "glb", "size": 1}})", "avatar: expected"},
      {R"({"id": [1], "reset": {}})", "id: expected"},
      {R"({"reset": {}, "id": ")" + std::string(65, 'x') + "\"}", "id: expected"},
  };
  for (const auto& [line, said] : wrong) {
    apps::Json id;
    const auto command = parse_command(line, id);
    ASSERT_FALSE(command) << line;
    EXPECT_EQ(command.error().code, ErrorCode::invalid_argument);
    EXPECT_THAT(command.error().message, testing::HasSubstr(said)) << line;
    EXPECT_THAT(command.error().message, testing::Not(testing::HasSubstr("4711"))) << line;
  }
}

std::string base64(const std::string& text) {
  return base64_of(std::as_bytes(std::span(text)));
}

TEST(DaemonCommand, BytesAreBase64) {
  // RFC 4648, section 10.
  const std::map<std::string, std::string> vectors = {{"", ""},
                                                      {"f", "Zg=="},
                                                      {"fo", "Zm8="},
                                                      {"foo", "Zm9v"},
                                                      {"foob", "Zm9vYg=="},
                                                      {"fooba", "Zm9vYmE="},
                                                      {"foobar", "Zm9vYmFy"},
                                                      {"\xFB\xFF\xBF", "+/+/"}};
  for (const auto& [plain, coded] : vectors) EXPECT_EQ(base64(plain), coded);
}

std::string decoded(const std::string& text) {
  static const std::string kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6U | static_cast<unsigned>(kDigits.find(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> static_cast<unsigned>(count) & 255U);
  }
  return bytes;
}

struct Grey {
  unsigned width = 0, height = 0;
  std::vector<std::uint8_t> pixels;
};

Grey read_png(const std::string& bytes) {
  Grey grey;
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0) << image.message;
  EXPECT_EQ(image.format, static_cast<png_uint_32>(PNG_FORMAT_GRAY));
  grey.width = image.width;
  grey.height = image.height;
  grey.pixels.resize(PNG_IMAGE_SIZE(image));
  EXPECT_NE(png_image_finish_read(&image, nullptr, grey.pixels.data(), 0, nullptr), 0) << image.message;
  return grey;
}

TEST(DaemonCommand, AMaskIsAGreyPicture) {
  const std::vector<std::uint8_t> pixels = {0, 255, 255, 0, 0, 255};
  const auto png = mask_png({pixels.data(), 3, 2});
  ASSERT_TRUE(png);
  const Grey grey = read_png(*png);
  EXPECT_EQ(grey.width, 3U);
  EXPECT_EQ(grey.height, 2U);
  EXPECT_EQ(grey.pixels, pixels);
}

// An avatar has more bytes than an unread client may have otherwise.
TEST(DaemonLongAnswer, IsNoReasonToDropAClientAndEventsBehindItStillAre) {
  const test::TestFolder folder;
  PublisherOptions options;
  options.path = folder.path("s");
  options.client_buffer_bytes = 4096;
  auto publisher = Publisher::open(options);
  ASSERT_TRUE(publisher) << publisher.error().message;
  Client client(folder.path("s"));
  ASSERT_TRUE(client.connected());
  (*publisher)->serve("");
  ASSERT_EQ((*publisher)->clients(), 1U);
  const std::string line = json{{"event", "avatar"}, {"base64", std::string(3'000'000, 'A')}}.dump() + "\n";
  const std::string small = json{{"event", "state"}}.dump() + "\n";
  EXPECT_FALSE((*publisher)->owes(1));
  (*publisher)->answer_long(1, line);
  EXPECT_TRUE((*publisher)->owes(1));
  (*publisher)->publish(small);
  ASSERT_EQ((*publisher)->clients(), 1U);
  std::thread reader([&] {
    EXPECT_EQ(client.next()["base64"].get_ref<const std::string&>().size(), 3'000'000U);
    EXPECT_EQ(client.next()["event"], "state");
  });
  (*publisher)->flush(10'000);
  reader.join();
  EXPECT_FALSE((*publisher)->owes(1));
  // It reads no more: what follows a long answer counts as ever.
  (*publisher)->answer_long(1, line);
  for (int i = 0; i < 300 && (*publisher)->clients() == 1; ++i) (*publisher)->publish(small);
  EXPECT_EQ((*publisher)->clients(), 0U);
}

class DaemonCommands : public testing::Test {
 protected:
  void SetUp() override {
    IM2FIT_NEED_DATA();
    std::filesystem::create_directories(folder_.path("state"));
  }
  std::string config(const std::string& more) const {
    test::write_text(folder_.path("c.yaml"), "source: 'synthetic:5'\nrotate: 90\nbody: " + test::body_path() +
                                                 "\ntracker: " + test::tracker_path() +
                                                 "\nindex: " + test::index_path() +
                                                 "\nmeasure: {frames: 5}\nsocket: {path: " + socket() +
                                                 "}\nstate_directory: " + folder_.path("state") + "\n" + more);
    return folder_.path("c.yaml");
  }
  std::string socket() const { return folder_.path("s"); }
  std::string kept() const { return folder_.path("state") + "/last-result.json"; }
  std::string err() const { return folder_.path("err"); }

  // The answer with this command's id, or its refusal.
  json ask(Client& client, const std::string& command, const json& value = json::object()) {
    const std::string id = "test-" + std::to_string(++asked_);
    const std::string line = json{{command, value}, {"id", id}}.dump() + "\n";
    EXPECT_EQ(::write(client.fd(), line.data(), line.size()), static_cast<ssize_t>(line.size()));
    for (;;) {
      json event = client.next();
      if (event.is_null() || event.value("id", json()) == id) return event;
    }
  }

  static bool is_measured(const json& event) { return event.is_object() && event["event"] == "measured"; }

  test::TestFolder folder_;
  int asked_ = 0;
};

TEST_F(DaemonCommands, NobodyIsLookedAtWithoutConsent) {
  test::DaemonRun daemon(config("consent: {ask: true}\n"), {}, err());
  Client client(socket());
  ASSERT_TRUE(client.connected()) << daemon.messages();
  const json hello = client.next();
  EXPECT_EQ(hello["protocol"], "im2fitd/1");
  EXPECT_EQ(hello["commands"], json(kCommands));
  EXPECT_EQ(client.next("visit")["state"], "ASKING");
  ASSERT_FALSE(client.next("camera", "PRESENT").is_null()) << daemon.messages();
  EXPECT_TRUE(client.next(std::chrono::milliseconds(700)).is_null()) << "not even a state";
  for (const std::string command : {"mask", "users", "reset", "known"})
    EXPECT_THAT(ask(client, command)["reason"].get<std::string>(), testing::HasSubstr("nobody has consented"))
        << command;
  EXPECT_EQ(ask(client, "select_user", 1)["event"], "refused");
  EXPECT_THAT(ask(client, "avatar")["reason"].get<std::string>(), testing::HasSubstr("nobody is measured"));

  EXPECT_EQ(ask(client, "consent")["state"], "MEASURING");
  EXPECT_THAT(ask(client, "consent")["reason"].get<std::string>(), testing::HasSubstr("consented already"));
  ASSERT_EQ(client.next("measured")["person"], 1) << daemon.messages();
  EXPECT_EQ(ask(client, "avatar")["person"], 1);
  EXPECT_TRUE(std::filesystem::exists(kept()));

  // What cannot be deleted is not called deleted.
  std::filesystem::remove(kept());
  std::filesystem::create_directories(kept() + "/in");
  const json refused = ask(client, "delete");
  EXPECT_EQ(refused["event"], "refused");
  EXPECT_THAT(refused["reason"].get<std::string>(), testing::HasSubstr("was not deleted"));
  std::filesystem::remove_all(kept());
  std::ofstream(kept() + ".a1b2c3") << "left by a program that was killed";

  // The visit is over, and nothing is left of it.
  EXPECT_EQ(ask(client, "delete")["person"], 1);
  EXPECT_THAT(test::all_files_in(folder_.path("state")), testing::IsEmpty());
  EXPECT_EQ(ask(client, "avatar")["event"], "refused");
  EXPECT_EQ(ask(client, "mask")["event"], "refused");
  Client late(socket());
  EXPECT_EQ(late.next()["persons"], 1);
  EXPECT_EQ(late.next("visit")["state"], "ASKING");
  EXPECT_EQ(late.next()["event"], "camera");
  EXPECT_TRUE(late.next(std::chrono::milliseconds(300)).is_null()) << "no state of the person before";

  EXPECT_EQ(ask(client, "consent")["state"], "MEASURING");
  EXPECT_EQ(client.next("measured")["person"], 2) << daemon.messages();
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
}

TEST_F(DaemonCommands, AvatarMaskUsersAndTheirRefusals) {
  test::DaemonRun daemon(config(""), {}, err());
  Client client(socket());
  ASSERT_EQ(client.next("measured")["person"], 1) << daemon.messages();
  EXPECT_THAT(ask(client, "consent")["reason"].get<std::string>(), testing::HasSubstr("measures whoever comes"));

  const std::map<std::string, std::string> begin = {{"glb", "glTF"}, {"obj", "#"}, {"bvh", "HIERARCHY"}};
  for (const auto& [format, first] : begin) {
    const json avatar = ask(client, "avatar", {{"format", format}});
    ASSERT_EQ(avatar["event"], "avatar") << avatar;
    EXPECT_EQ(avatar["person"], 1);
    const std::string bytes = decoded(avatar["base64"]);
    EXPECT_EQ(bytes.size(), avatar["bytes"]);
    EXPECT_EQ(bytes.compare(0, first.size(), first), 0) << format << " begins with " << bytes.substr(0, 20);
  }

  const json mask = ask(client, "mask");
  ASSERT_EQ(mask["event"], "mask") << mask;
  const Grey grey = read_png(decoded(mask["png"]));
  EXPECT_EQ(grey.width, 480U);
  EXPECT_EQ(grey.height, 640U);
  EXPECT_EQ(mask["width"], 480);
  const auto person = std::count(grey.pixels.begin(), grey.pixels.end(), 255);
  EXPECT_EQ(person + std::count(grey.pixels.begin(), grey.pixels.end(), 0), 480 * 640);
  EXPECT_GT(person, 10'000);
  EXPECT_LT(person, 100'000);

  const json users = ask(client, "users")["users"];
  ASSERT_EQ(users.size(), 1U) << users;
  EXPECT_EQ(users[0]["user"], mask["user"]);
  EXPECT_NEAR(users[0]["distance_mm"].get<int>(), 2400, 300);
  EXPECT_THAT(ask(client, "select_user", 1)["reason"].get<std::string>(), testing::HasSubstr("reset begins anew"));
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
}

TEST_F(DaemonCommands, ResetMeasuresThePersonAnewAndSelectAnother) {
  test::DaemonRun daemon(config(""), {}, err());
  Client client(socket()), other(socket());
  ASSERT_EQ(client.next("measured")["person"], 1) << daemon.messages();
  const json reset = ask(client, "reset");
  ASSERT_EQ(reset["event"], "reset");
  EXPECT_EQ(other.next("reset"), reset) << "every client hears of it";
  ASSERT_EQ(client.next("measured")["person"], 2) << daemon.messages();

  // Of an id that nobody has, so nobody is measured; 0 is everybody again.
  json selected;
  for (int i = 0; i < 20 && selected["event"] != "selected"; ++i) {  // unless the person was measured meanwhile
    ASSERT_EQ(ask(client, "reset")["event"], "reset");
    selected = ask(client, "select_user", 77);
  }
  ASSERT_EQ(selected["event"], "selected");
  EXPECT_EQ(selected["user"], 77);
  for (const auto end = test::Clock::now() + std::chrono::seconds(1); test::Clock::now() < end;)
    EXPECT_FALSE(is_measured(client.next(std::chrono::milliseconds(100))));
  EXPECT_EQ(ask(client, "select_user", 0)["user"], 0);
  EXPECT_FALSE(client.next("measured").is_null()) << daemon.messages();
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
}

// Who is still in view is not measured again, and facts do not bring the numbers back.
TEST_F(DaemonCommands, DeletedIsDeletedWhileThePersonStays) {
  test::DaemonRun daemon(config(""), {}, err());
  Client client(socket());
  ASSERT_EQ(client.next("measured")["person"], 1) << daemon.messages();
  EXPECT_EQ(ask(client, "delete")["person"], 1);
  EXPECT_FALSE(std::filesystem::exists(kept()));
  EXPECT_THAT(ask(client, "known", {{"weight_kg", 70}})["reason"].get<std::string>(), testing::HasSubstr("deleted"));
  EXPECT_EQ(ask(client, "avatar")["event"], "refused");
  for (const auto end = test::Clock::now() + std::chrono::seconds(1); test::Clock::now() < end;)
    EXPECT_FALSE(is_measured(client.next(std::chrono::milliseconds(100))));
  EXPECT_FALSE(std::filesystem::exists(kept()));
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
}

// A room without a person: who consented has gone away.
TEST_F(DaemonCommands, ConsentEndsWithoutAPerson) {
  std::vector<test::Picture> pictures(200, test::Picture(320, 240, 0));
  test::CameraText camera;
  test::write_depth_folder(folder_.path("empty"), pictures, camera);
  config("consent: {ask: true, absent_s: 1}\n");
  std::string text = test::read_text(folder_.path("c.yaml"));
  text.replace(text.find("synthetic:5"), 11, folder_.path("empty"));
  test::write_text(folder_.path("c.yaml"), text);
  test::DaemonRun daemon(folder_.path("c.yaml"), {}, err());
  Client client(socket());
  ASSERT_FALSE(client.next("camera", "PRESENT").is_null()) << daemon.messages();
  EXPECT_EQ(ask(client, "consent")["state"], "MEASURING");
  EXPECT_EQ(client.next("visit")["state"], "ASKING") << daemon.messages();
  // The recording waits: there are frames for another visit.
  EXPECT_EQ(ask(client, "consent")["state"], "MEASURING");
  EXPECT_EQ(client.next("visit")["state"], "ASKING");
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
}

TEST_F(DaemonCommands, TheExampleInPythonDoesAll) {
  const std::string python = "/usr/bin/python3";
  if (!std::filesystem::exists(python)) GTEST_SKIP() << "no python3";
  test::DaemonRun daemon(config("consent: {ask: true}\n"), {}, err());
  const auto example = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {python, IM2FIT_DAEMON_CLIENT});
    test::RunOptions options;
    options.environment = {{"IM2FITD_SOCKET", socket()}, {"PYTHONDONTWRITEBYTECODE", "1"}};
    return test::run_program(words, options);
  };
  {
    const Client wait(socket());
    ASSERT_TRUE(wait.connected()) << daemon.messages();
  }
  const auto early = example({"mask", folder_.path("m.png")});
  EXPECT_EQ(early.exit_code, 1);
  EXPECT_EQ(early.err, "daemon_client: nobody has consented: nobody is looked at\n");
  const auto measured = example({"consent"});
  ASSERT_EQ(measured.exit_code, 0) << measured.err;
  EXPECT_THAT(measured.out, testing::ContainsRegex("stature [0-9]+ mm, chest_girth [0-9]+ mm"));
  EXPECT_EQ(example({"avatar", folder_.path("a.glb")}).exit_code, 0);
  EXPECT_EQ(test::read_text(folder_.path("a.glb")).substr(0, 4), "glTF");
  EXPECT_EQ(example({"mask", folder_.path("m.png")}).exit_code, 0);
  EXPECT_EQ(test::read_text(folder_.path("m.png")).substr(1, 3), "PNG");
  EXPECT_THAT(example({"users"}).out, testing::HasSubstr("\"user\": "));
  EXPECT_EQ(example({"known", "weight_kg=70", "weight_from=scale"}).exit_code, 0);
  EXPECT_EQ(example({"reset"}).exit_code, 0);
  EXPECT_EQ(example({"delete"}).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(kept()));
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
}

}  // namespace
}  // namespace im2fit::daemon
