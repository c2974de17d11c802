// SPDX-License-Identifier: Apache-2.0
// im2fitd's configuration and socket, each alone.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <filesystem>

#include "apps/im2fitd/config.h"
#include "apps/im2fitd/log.h"
#include "apps/im2fitd/publisher.h"
#include "daemon_run.h"
#include "data_paths.h"
#include "depth_folder.h"

namespace im2fit::daemon {
namespace {

using test::Client;

class DaemonConfig : public testing::Test {
 protected:
  Result<Config> load(const std::string& text) {
    test::write_text(folder_.path("c.yaml"), text);
    return load_config(folder_.path("c.yaml"));
  }
  test::TestFolder folder_;
};

TEST_F(DaemonConfig, TheFileThatIsInstalledSaysTheDefaults) {
  const auto shipped = load_config(IM2FIT_DAEMON_YAML);
  ASSERT_TRUE(shipped) << shipped.error().message;
  const Config d;
  EXPECT_EQ(shipped->source, d.source);
  EXPECT_EQ(shipped->rotate_deg, d.rotate_deg);
  EXPECT_EQ(shipped->camera_yaml, d.camera_yaml);
  EXPECT_EQ(shipped->body, d.body);
  EXPECT_EQ(shipped->measuring.frames, d.measuring.frames);
  EXPECT_EQ(shipped->measuring.calibration, d.measuring.calibration);
  EXPECT_EQ(shipped->measuring.turn, d.measuring.turn);
  EXPECT_EQ(shipped->measuring.clothing, d.measuring.clothing);
  EXPECT_EQ(shipped->measuring.sensor, d.measuring.sensor);
  EXPECT_EQ(shipped->measuring.threads, d.measuring.threads);
  EXPECT_EQ(shipped->measuring.size_charts, d.measuring.size_charts);
  EXPECT_EQ(shipped->measuring.site, d.measuring.site);
  EXPECT_EQ(shipped->consent_ask, d.consent_ask);
  EXPECT_EQ(shipped->consent_absent_s, d.consent_absent_s);
  EXPECT_EQ(shipped->socket_path, d.socket_path);
  EXPECT_EQ(shipped->socket_mode, d.socket_mode);
  EXPECT_EQ(shipped->socket_group, d.socket_group);
  EXPECT_EQ(shipped->clients_max, d.clients_max);
  EXPECT_EQ(shipped->client_buffer_bytes, d.client_buffer_bytes);
  EXPECT_EQ(shipped->state_directory, d.state_directory);
  EXPECT_TRUE(shipped->measuring.live);
}

TEST_F(DaemonConfig, EveryKeyIsTaken) {
  const auto c = load(
      "source: v4l2:/dev/video0\nrotate: 270\ncamera: c.yaml\nbody: b\ntracker: t\nindex: i\n"
      "measure: {frames: 7, calibration: psi, turn: true, clothing: dressed, sensor: time-of-flight,\n"
      " threads: 1, size_charts: [a.csv, b.csv], calibration_site: shop.i2c}\n"
      "consent: {ask: true, absent_s: 45}\n"
      "socket:\n  path: /x\n  mode: \"0666\"\n  group: video\n  clients: 3\n  client_buffer_kib: 17\n"
      "state_directory: /s\n");
  ASSERT_TRUE(c) << c.error().message;
  EXPECT_EQ(c->source, "v4l2:/dev/video0");
  EXPECT_EQ(c->rotate_deg, 270);
  EXPECT_EQ(c->camera_yaml, "c.yaml");
  EXPECT_EQ(c->body + c->measuring.tracker + c->measuring.index, "bti");
  EXPECT_EQ(c->measuring.frames, 7);
  EXPECT_EQ(c->measuring.calibration, "psi");
  EXPECT_EQ(c->measuring.turn, "back") << "as older files say it";
  EXPECT_EQ(c->measuring.clothing, "dressed");
  EXPECT_EQ(c->measuring.sensor, "time-of-flight");
  EXPECT_EQ(c->measuring.threads, 1);
  EXPECT_EQ(c->measuring.size_charts, (std::vector<std::string>{"a.csv", "b.csv"}));
  EXPECT_EQ(c->measuring.site, "shop.i2c");
  EXPECT_TRUE(c->consent_ask);
  EXPECT_EQ(c->consent_absent_s, 45);
  EXPECT_EQ(c->socket_path, "/x");
  EXPECT_EQ(c->socket_mode, 0666U);
  EXPECT_EQ(c->socket_group, "video");
  EXPECT_EQ(c->clients_max, 3);
  EXPECT_EQ(c->client_buffer_bytes, 17U * 1024);
  EXPECT_EQ(c->state_directory, "/s");
}

TEST_F(DaemonConfig, WhatIsWrongIsOneLineWithItsNumber) {
  const std::pair<const char*, const char*> kWrong[] = {
      {"source: a\ncolour: red\n", "line 2: unknown key \"colour\""},
      {"measure:\n  frames: 5\n  fames: 6\n", "line 3: unknown key \"measure.fames\""},
      {"source: a\nsource: b\n", "line 2: \"source\" appears twice"},
      {"measure: {frames: 0}\n", "line 1: measure.frames is \"0\", expected a whole number from 1 to 1000"},
      {"measure:\n  frames: many\n", "line 2: measure.frames is \"many\""},
      {"measure:\n  frames: 5.5\n", "line 2: measure.frames"},
      {"\n\nrotate: 45\n", "line 3: rotate is \"45\", expected 0, 90, 180 or 270"},
      {"rotate: [0]\n", "line 1: rotate"},
      {"measure: {turn: perhaps}\n", "measure.turn is \"perhaps\", expected none, back, around or walk"},
      {"measure: {sensor: lidar}\n", "expected one of auto, structured-light, time-of-flight, stereo"},
      {"measure: {calibration: tpose}\n", "expected one of none, psi"},
      {"measure: 5\n", "line 1: measure holds no"},
      {"measure: {size_charts: a.csv}\n", "measure.size_charts is not a list"},
      {"consent: {ask: perhaps}\n", "consent.ask is \"perhaps\", expected true or false"},
      {"consent:\n  absent_s: 0\n", "line 2: consent.absent_s is \"0\", expected a whole number from 1 to 3600"},
      {"socket: {mode: 999}\n", "socket.mode is \"999\", expected three octal digits"},
      {"socket: {path: ''}\n", "socket.path is empty, expected a text"},
      {"source:\n", "line 1: source is empty"},
      {"source: [\n", "line 2"},
      {"- a\n- b\n", "line 1: the file holds no"},
      {"", "line 1: the file holds no"},
      {"just text", "line 1: the file holds no"},
      {"source: {a: b}\n", "line 1: source is not a single value, expected a text"},
      {"? [a]\n: b\n", "unknown key"},
      {"measure:\n  turn: 5\n  frames: 0\n", "line 2: measure.turn is \"5\", expected none, back, around or walk"},
  };
  for (const auto& [text, expected] : kWrong) {
    const auto c = load(text);
    ASSERT_FALSE(c) << text;
    EXPECT_THAT(c.error().message, testing::HasSubstr(expected)) << text;
    EXPECT_THAT(c.error().message, testing::HasSubstr("c.yaml")) << text;
    EXPECT_EQ(c.error().message.find('\n'), std::string::npos);
  }
  EXPECT_EQ(load_config(folder_.path("absent.yaml")).error().code, ErrorCode::not_found);
}

TEST_F(DaemonConfig, TheProgramChecksIt) {
  test::write_text(folder_.path("bad.yaml"), "source: openni2\nx: 1\n");
  const auto bad = test::run_program({IM2FIT_DAEMON_PROGRAM, "--check", "--config", folder_.path("bad.yaml")});
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_EQ(bad.err.rfind("<3>", 0), 0U) << bad.err;
  EXPECT_EQ(bad.err.find('\n'), bad.err.size() - 1);
  EXPECT_EQ(test::run_program({IM2FIT_DAEMON_PROGRAM, "--nonsense"}).exit_code, 2);
  EXPECT_EQ(test::run_program({IM2FIT_DAEMON_PROGRAM, "--help"}).exit_code, 0);
}

// --check refuses the same settings as the start.
TEST_F(DaemonConfig, TheCheckRefusesWhatAStartWould) {
  if (!test::have_data()) GTEST_SKIP() << "no body, tracker or index file";
  const std::string good = "source: openni2\nbody: " + test::body_path() + "\ntracker: " + test::tracker_path() +
                           "\nindex: " + test::index_path() + "\n";
  const auto check = [&](const std::string& more) {
    test::write_text(folder_.path("c.yaml"), good + more);
    return test::run_program({IM2FIT_DAEMON_PROGRAM, "--check", "--config", folder_.path("c.yaml")});
  };
  EXPECT_EQ(check("").exit_code, 0);
  test::write_text(folder_.path("file"), "x");
  const std::pair<std::string, const char*> kWrong[] = {
      {"socket: {path: /" + std::string(156, 'x') + "}\n", "has 157 bytes"},
      {"socket: {group: no-such-group}\n", "no-such-group"},
      {"socket: {path: " + folder_.path("file") + "}\n", "not a socket"},
      {"measure: {size_charts: [" + folder_.path("absent.csv") + "]}\n", "absent.csv"},
      {"camera: " + folder_.path("file") + "\n", "file"},
      {"state_directory: " + folder_.path("file") + "\n", "not a directory"},
  };
  for (const auto& [more, expected] : kWrong) {
    const auto run = check(more);
    EXPECT_EQ(run.exit_code, 1) << more;
    EXPECT_THAT(run.err, testing::HasSubstr(expected)) << more;
  }
  test::write_text(folder_.path("c.yaml"), "source: openni2\nbody: " + folder_.path("absent.i2b") + "\n");
  EXPECT_EQ(test::run_program({IM2FIT_DAEMON_PROGRAM, "--check", "--config", folder_.path("c.yaml")}).exit_code, 1);
}

TEST(DaemonLog, AFloodIsCountedInsteadOfWritten) {
  LogLimit limit;
  std::uint64_t left_out = 0;
  int written = 0;
  for (int i = 0; i < 1000; ++i) written += limit.admit(Level::warning, 1'000'000'000 + i, left_out) ? 1 : 0;
  EXPECT_EQ(written, LogLimit::kLinesMax);
  EXPECT_TRUE(limit.admit(Level::error, 1'000'000'000, left_out)) << "each level has its own";
  EXPECT_TRUE(limit.admit(Level::warning, 1'000'000'000 + LogLimit::kPeriodNs, left_out));
  EXPECT_EQ(left_out, 1000U - LogLimit::kLinesMax);
  EXPECT_TRUE(limit.admit(Level::warning, 1'000'000'001 + LogLimit::kPeriodNs, left_out));
  EXPECT_EQ(left_out, 0U);
}

// Exposure by systemd's own measure: 0 to 10, in tenths on its command line. The unit has 1.0.
TEST_F(DaemonConfig, SystemdAcceptsTheUnitAndFindsLittleExposed) {
  const std::string analyze = "/usr/bin/systemd-analyze";
  if (!std::filesystem::exists(analyze)) GTEST_SKIP() << "no systemd-analyze here: apt-get install systemd";
  // The unit names the program where it will be installed.
  std::string unit = test::read_text(IM2FIT_DAEMON_UNIT);
  const auto at = unit.find("ExecStart=") + 10;
  unit.replace(at, unit.find(' ', at) - at, IM2FIT_DAEMON_PROGRAM);
  const std::string path = folder_.path("im2fitd.service");
  test::write_text(path, unit);
  const auto verified = test::run_program({analyze, "--man=no", "verify", path});
  EXPECT_EQ(verified.exit_code, 0) << verified.err;
  EXPECT_EQ(verified.err, "");
  const auto rated = test::run_program({analyze, "--no-pager", "--offline=true", "--threshold=10", "security", path});
  EXPECT_EQ(rated.exit_code, 0) << rated.out;
  // Both find the fault.
  std::string open = unit;
  for (const std::string line : {"PrivateNetwork=yes\n", "CapabilityBoundingSet=\n"})
    open.erase(open.find(line), line.size());
  test::write_text(path, open);
  EXPECT_NE(
      test::run_program({analyze, "--no-pager", "--offline=true", "--threshold=10", "security", path}).exit_code, 0);
  test::write_text(path, unit + "[Service]\nWatchdogSec=soon\n");
  EXPECT_NE(test::run_program({analyze, "--man=no", "verify", path}).err, "");
}

class DaemonSocket : public testing::Test {
 protected:
  void open(PublisherOptions options = {}) {
    options.path = folder_.path("s");
    auto made = Publisher::open(options);
    ASSERT_TRUE(made) << made.error().message;
    publisher_ = std::move(*made);
  }
  static constexpr const char* kHello = "{\"event\":\"hello\"}\n";
  test::TestFolder folder_;
  std::unique_ptr<Publisher> publisher_;
};

TEST_F(DaemonSocket, AClientThatDoesNotReadIsDroppedAndTheOthersAreServed) {
  open({.client_buffer_bytes = 32 * 1024});
  Client slow(folder_.path("s"));
  Client quick(folder_.path("s"));
  publisher_->serve(kHello);
  EXPECT_EQ(publisher_->clients(), 2U);
  const std::string line = "{\"n\":\"" + std::string(4000, 'x') + "\"}\n";
  int sent = 0;
  EXPECT_EQ(quick.next()["event"], "hello");
  for (; sent < 2000 && publisher_->clients() == 2; ++sent) {
    publisher_->publish(line);
    ASSERT_EQ(quick.next()["n"].get<std::string>().size(), 4000U);
  }
  EXPECT_EQ(publisher_->clients(), 1U);
  EXPECT_EQ(publisher_->dropped(), 1U);
  publisher_->publish(line);
  EXPECT_EQ(quick.next()["n"].get<std::string>().size(), 4000U);
  // What the slow one received is whole lines up to where it was cut off.
  EXPECT_EQ(slow.next()["event"], "hello");
}

TEST_F(DaemonSocket, ClientsComeAndGoAndAreCounted) {
  open({.clients_max = 2});
  {
    Client a(folder_.path("s"));
    Client b(folder_.path("s"));
    Client c(folder_.path("s"));
    publisher_->serve(kHello);
    EXPECT_EQ(publisher_->clients(), 2U);
    EXPECT_EQ(a.next()["event"], "hello");
    EXPECT_TRUE(c.next().is_null()) << "one too many";
    // One that has closed its sending side may still read.
    ASSERT_EQ(::write(a.fd(), "GET / HTTP/1.1\n", 15), 15);
    ::shutdown(a.fd(), SHUT_WR);
    publisher_->serve(kHello);
    publisher_->publish("{\"event\":\"x\"}\n");
    EXPECT_EQ(a.next()["event"], "x");
    EXPECT_EQ(publisher_->clients(), 2U);
  }
  publisher_->serve(kHello);
  EXPECT_EQ(publisher_->clients(), 0U);
  Client d(folder_.path("s"));
  publisher_->serve(kHello);
  EXPECT_EQ(d.next()["event"], "hello");
}

TEST_F(DaemonSocket, LinesOfClientsAreTakenWhole) {
  open({});
  Client a(folder_.path("s"));
  Client b(folder_.path("s"));
  publisher_->serve(kHello);
  const auto write_all = [](const Client& client, const std::string& text) {
    ASSERT_EQ(::write(client.fd(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
  };
  write_all(a, "one\ntw");
  publisher_->serve(kHello);
  write_all(a, "o\n");
  write_all(b, std::string(kClientLineMax, 'x') + "\n");
  publisher_->serve(kHello);
  write_all(b, std::string(kClientLineMax + 1, 'y') + "\nthree\n");
  publisher_->serve(kHello);
  const auto lines = publisher_->take_lines();
  ASSERT_EQ(lines.size(), 5U);
  EXPECT_EQ(lines[0].text, "one");
  EXPECT_EQ(lines[1].text, "two");
  EXPECT_EQ(lines[0].client, lines[1].client);
  EXPECT_EQ(lines[2].text, std::string(kClientLineMax, 'x'));
  EXPECT_NE(lines[2].client, lines[0].client);
  EXPECT_TRUE(lines[3].too_long);
  EXPECT_EQ(lines[3].text, "");
  EXPECT_EQ(lines[4].text, "three");
  EXPECT_FALSE(lines[4].too_long);
  EXPECT_TRUE(publisher_->take_lines().empty());
  // An answer is for one.
  publisher_->answer(lines[2].client, "{\"event\":\"refused\"}\n");
  publisher_->answer(77, "{\"event\":\"nobody\"}\n");
  publisher_->publish("{\"event\":\"x\"}\n");
  EXPECT_EQ(a.next()["event"], "hello");
  EXPECT_EQ(a.next()["event"], "x");
  EXPECT_EQ(b.next()["event"], "hello");
  EXPECT_EQ(b.next()["event"], "refused");
  EXPECT_EQ(b.next()["event"], "x");
}

TEST_F(DaemonSocket, LinesThatNobodyTakesAreBounded) {
  open({});
  Client a(folder_.path("s"));
  publisher_->serve(kHello);
  const std::string many(40 * kClientLinesMax, '\n');
  ASSERT_EQ(::write(a.fd(), many.data(), many.size()), static_cast<ssize_t>(many.size()));
  publisher_->serve(kHello);
  EXPECT_EQ(publisher_->take_lines().size(), kClientLinesMax);
  ASSERT_EQ(::write(a.fd(), "x\n", 2), 2);
  publisher_->serve(kHello);
  EXPECT_EQ(publisher_->take_lines().size(), 1U);
}

TEST_F(DaemonSocket, AClientThatSendsAndLeavesIsHeard) {
  open({});
  {
    Client a(folder_.path("s"));
    ASSERT_EQ(::write(a.fd(), "early\n", 6), 6);
  }
  publisher_->serve(kHello);
  ASSERT_EQ(publisher_->take_lines().size(), 1U);
  {
    Client b(folder_.path("s"));
    publisher_->serve(kHello);
    ASSERT_EQ(::write(b.fd(), "late\n", 5), 5);
  }
  publisher_->publish("{\"event\":\"x\"}\n");
  publisher_->publish("{\"event\":\"x\"}\n");
  publisher_->serve(kHello);
  const auto lines = publisher_->take_lines();
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].text, "late");
}

TEST_F(DaemonSocket, WhoHasGoneTakesNoPlace) {
  open({.clients_max = 2});
  {
    Client a(folder_.path("s"));
    Client b(folder_.path("s"));
    publisher_->serve(kHello);
  }
  Client c(folder_.path("s"));
  Client d(folder_.path("s"));
  publisher_->serve(kHello);
  EXPECT_EQ(c.next()["event"], "hello");
  EXPECT_EQ(d.next()["event"], "hello");
}

TEST_F(DaemonSocket, ModeAndPlaceAreChecked) {
  open({.mode = 0640});
  struct stat about {};
  ASSERT_EQ(::stat(folder_.path("s").c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0640U);
  publisher_.reset();
  EXPECT_FALSE(std::filesystem::exists(folder_.path("s")));
  const auto refused = [](PublisherOptions options, const std::string& why) {
    const auto made = Publisher::open(options);
    ASSERT_FALSE(made);
    EXPECT_THAT(made.error().message, testing::HasSubstr(why));
  };
  refused({.path = folder_.path("no/such/folder")}, "No such file");
  refused({.path = folder_.path(std::string(108, 'a'))}, "expected 1 to 107");
  refused({.path = folder_.path("s"), .group = "no-such-group"}, "no group \"no-such-group\"");
  EXPECT_FALSE(std::filesystem::exists(folder_.path("s")));
  test::write_text(folder_.path("file"), "mine");
  refused({.path = folder_.path("file")}, "not a socket");
  EXPECT_EQ(test::read_text(folder_.path("file")), "mine");
}

}  // namespace
}  // namespace im2fit::daemon
