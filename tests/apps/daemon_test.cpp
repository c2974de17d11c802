// SPDX-License-Identifier: Apache-2.0
// im2fitd before the virtual OpenNI2 camera, which shows two people round and round and loses its cable on a signal.
#include <sys/stat.h>

#include "daemon_run.h"
#include "data_paths.h"
#include "measure_run.h"
#include "two_people.h"

namespace im2fit {
namespace {

using test::Client;
using test::DaemonRun;
using test::Manager;

class Daemon : public testing::Test {
 protected:
  static void SetUpTestSuite() {
#if IM2FIT_TEST_VIRTUAL
    if (!test::have_data()) return;
    folder_ = new test::TestFolder;
    test::write_two_people(folder_->path("two"), 20, true);
#endif
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  void SetUp() override {
    if (folder_ == nullptr) GTEST_SKIP() << "no virtual camera, or no body, tracker or index file";
    std::filesystem::create_directories(own_.path("state"));
  }
  std::string socket() const {
    return own_.path("s");
  }
  // The virtual camera, with more keys.
  static std::string camera(const std::string& keys) {
    return "openni2:im2fit-virtual://9?folder=" + folder_->path("two") + keys;
  }
  std::string config(const std::string& source, const std::string& more = "") const {
    const std::string path = own_.path("im2fitd.yaml");
    test::write_text(path, "source: '" + source + "'\nrotate: 90\nbody: " + test::body_path() +
                               "\ntracker: " + test::tracker_path() + "\nindex: " + test::index_path() +
                               "\nmeasure: {frames: 5}\nsocket: {path: " + socket() + ", mode: \"0600\"}\n" +
                               "state_directory: " + own_.path("state") + "\n" + more);
    return path;
  }
  std::string err() const {
    return own_.path("stderr");
  }

  static inline test::TestFolder* folder_ = nullptr;
  test::TestFolder own_;
};

TEST_F(Daemon, TellsEveryClientOfOnePersonAfterTheOther) {
  DaemonRun daemon(config(camera("&fps=15")), {}, err());
  Client first(socket());
  ASSERT_TRUE(first.connected()) << daemon.messages();
  Client second(socket());
  struct stat about {};
  ASSERT_EQ(::stat(socket().c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0600U);
  for (Client* client : {&first, &second}) {
    const auto hello = client->next();
    EXPECT_EQ(hello["event"], "hello");
    EXPECT_EQ(hello["protocol"], "im2fitd/1");
  }
  ASSERT_FALSE(first.next("camera", "PRESENT").is_null()) << daemon.messages();
  nlohmann::json one;
  for (const int person : {1, 2, 3}) {
    const auto event = first.next("measured");
    ASSERT_FALSE(event.is_null()) << daemon.messages();
    EXPECT_EQ(event["person"], person);
    EXPECT_EQ(event["result"]["schema"], "im2fit.result/1");
    EXPECT_EQ(event["result"]["state"], "MEASURED");
    EXPECT_EQ(event["result"]["frames"]["used"], 5);
    EXPECT_TRUE(event["result"]["measurements"].contains("stature")) << event["result"]["measurements"];
    EXPECT_EQ(first.next("left")["person"], person);
    if (person == 1) one = event;
  }
  EXPECT_EQ(second.next("measured"), one) << "the other client got the same";
  const auto kept = nlohmann::json::parse(test::read_text(own_.path("state") + "/last-result.json"), nullptr, false);
  EXPECT_EQ(kept["schema"], "im2fit.result/1");
  EXPECT_EQ(test::files_in(own_.path("state")).size(), 1U) << "nothing else is written";
  daemon.signal(SIGTERM);
  const auto end = first.next("end");
  EXPECT_GE(end["persons"].get<int>(), 3);
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
  EXPECT_FALSE(std::filesystem::exists(socket()));
  // Lines for the journal: a priority each, and no measurements.
  EXPECT_EQ(daemon.messages().rfind("<6>", 0), 0U) << daemon.messages();
  EXPECT_NE(daemon.messages().find("person 1 is measured"), std::string::npos);
  // With its space: the name of the temporary folder, which messages hold, may have "mm" in it.
  EXPECT_EQ(daemon.messages().find(" mm"), std::string::npos) << daemon.messages();
}

// Before the first person is measured, and after: the same person is reported again.
TEST_F(Daemon, FactsOfThePersonAreEvidence) {
  DaemonRun daemon(config(camera("&fps=15")), {}, err());
  Client client(socket()), other(socket());
  ASSERT_TRUE(client.connected()) << daemon.messages();
  const auto send = [&](const std::string& line) {
    ASSERT_EQ(::write(client.fd(), line.data(), line.size()), static_cast<ssize_t>(line.size()));
  };
  ASSERT_FALSE(client.next("measured").is_null()) << daemon.messages();
  send("{\"known\": {\"weight_kg\": 71.5, \"weight_from\": \"scale\"}}\n");
  const auto known = client.next("known");
  ASSERT_FALSE(known.is_null()) << daemon.messages();
  EXPECT_FALSE(known.contains("weight_kg")) << known;
  // It may have come when the next person stood there already.
  auto again = client.next("measured");
  while (!again.is_null() && again["person"] != known["person"]) again = client.next("measured");
  ASSERT_FALSE(again.is_null()) << daemon.messages();
  EXPECT_EQ(again["result"]["known"]["given"]["weight"]["value"], 71.5) << again["result"]["known"];
  for (const std::string bad : {"GET / HTTP/1.1\n", "{\"known\": {\"weight_kg\": 7150}}\n", "{\"facts\": 1}\n",
                                "{\"known\": {\"shoe\": 4711}}\n"}) {
    send(bad);
    const auto refused = client.next("refused");
    ASSERT_FALSE(refused.is_null()) << bad;
    EXPECT_EQ(refused["reason"].get<std::string>().find("4711"), std::string::npos) << refused;
  }
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
  EXPECT_EQ(daemon.messages().find("71.5"), std::string::npos) << daemon.messages();
  for (auto event = other.next(); !event.is_null(); event = other.next())
    EXPECT_NE(event["event"], "refused") << "another client's";
}

TEST_F(Daemon, SurvivesTheLossOfItsCameraAgainAndAgain) {
  Manager manager(own_.path("notify"));
  DaemonRun daemon(config(camera("&fps=15&unplug_ms=900&replug_ms=300")),
                   {{"NOTIFY_SOCKET", manager.path()}, {"WATCHDOG_USEC", "2000000"}}, err());
  ASSERT_TRUE(manager.wait_for("READY=1")) << daemon.messages();
  Client client(socket());
  for (int loss = 1; loss <= 5; ++loss) {
    const auto lost = client.next("camera", "LOST");
    ASSERT_FALSE(lost.is_null()) << daemon.messages();
    EXPECT_EQ(lost["serial"], "9");
    EXPECT_GE(lost["lost"].get<int>(), loss);
    const auto back = client.next("camera", "PRESENT");
    ASSERT_FALSE(back.is_null()) << daemon.messages();
    EXPECT_EQ(back["recovered"], lost["lost"]);
  }
  daemon.signal(SIGTERM);
  EXPECT_TRUE(manager.wait_for("STOPPING=1"));
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
}

TEST_F(Daemon, WaitsForACameraThatIsNotThereAndFeedsTheWatchdogMeanwhile) {
  Manager manager(own_.path("notify"));
  DaemonRun daemon(config("openni2:im2fit-virtual://9?folder=" + own_.path("no-such-folder")),
                   {{"NOTIFY_SOCKET", manager.path()}, {"WATCHDOG_USEC", "400000"}}, err());
  ASSERT_TRUE(manager.wait_for("READY=1")) << daemon.messages();
  Client client(socket());
  EXPECT_EQ(client.next("camera")["state"], "WAITING");
  EXPECT_GE(manager.count("WATCHDOG=1", std::chrono::seconds(3)), 4) << daemon.messages();
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
}

// One frame a second: a watchdog fed by the loop instead of by frames would be fed ten times as often.
TEST_F(Daemon, TheWatchdogIsFedByFramesOnly) {
  Manager manager(own_.path("notify"));
  DaemonRun daemon(config(camera("&fps=1")), {{"NOTIFY_SOCKET", manager.path()}, {"WATCHDOG_USEC", "400000"}}, err());
  Client client(socket());
  ASSERT_FALSE(client.next("state").is_null()) << daemon.messages();
  (void)manager.count("", std::chrono::milliseconds(100));  // the messages before
  const int fed = manager.count("WATCHDOG=1", std::chrono::seconds(4));
  EXPECT_GE(fed, 1);
  EXPECT_LE(fed, 8);
}

TEST_F(Daemon, ASilentRecordingStarvesTheWatchdog) {
#if IM2FIT_TEST_ONI
  const auto recorded = test::run_program(
      {test::kProgram, "record", camera("&fps=60"), "--rotate", "90", "--frames", "30", "--out", own_.path("r.oni")});
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  Manager manager(own_.path("notify"));
  test::write_text(own_.path("slow.sh"),
                   "#!/bin/sh\nexec sleep 1000\n");  // a reader that never says anything: opening takes its 5 s
  std::filesystem::permissions(own_.path("slow.sh"), std::filesystem::perms::owner_all);
  DaemonRun daemon(
      config(own_.path("r.oni")),
      {{"NOTIFY_SOCKET", manager.path()}, {"WATCHDOG_USEC", "400000"}, {"IM2FIT_ONI_READER", own_.path("slow.sh")}},
      err());
  ASSERT_TRUE(manager.wait_for("READY=1")) << daemon.messages();
  EXPECT_EQ(manager.count("WATCHDOG=1", std::chrono::seconds(3)), 0);
  EXPECT_EQ(daemon.wait(), 1) << "a recording that gives nothing is an error";
  EXPECT_NE(daemon.messages().find("<3>"), std::string::npos) << daemon.messages();
#else
  GTEST_SKIP() << "no OpenNI2 in this build";
#endif
}

TEST_F(Daemon, EndsWithItsRecording) {
  DaemonRun daemon(config(folder_->path("two")), {}, err());
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
  EXPECT_NE(daemon.messages().find("person 2 is measured"), std::string::npos) << daemon.messages();
}

TEST_F(Daemon, ReadsItsConfigurationAgainAndKeepsASoundOne) {
  DaemonRun daemon(config(camera("&fps=15")), {}, err());
  Client client(socket());
  ASSERT_FALSE(client.next("camera", "PRESENT").is_null()) << daemon.messages();
  const std::string sound = test::read_text(own_.path("im2fitd.yaml"));
  test::write_text(own_.path("im2fitd.yaml"), sound + "colour: red\n");
  daemon.signal(SIGHUP);
  ASSERT_FALSE(client.next("measured").is_null()) << "a wrong file changes nothing: " << daemon.messages();
  EXPECT_NE(daemon.messages().find("line 9: unknown key \"colour\""), std::string::npos) << daemon.messages();
  std::string moved = sound;
  moved.replace(moved.find(socket()), socket().size(), own_.path("t"));
  test::write_text(own_.path("im2fitd.yaml"), moved);
  daemon.signal(SIGHUP);
  EXPECT_FALSE(client.next("end").is_null());
  Client again(own_.path("t"));
  ASSERT_TRUE(again.connected()) << daemon.messages();
  EXPECT_FALSE(again.next("measured").is_null()) << daemon.messages();
  EXPECT_FALSE(std::filesystem::exists(socket()));
}

TEST_F(Daemon, AKilledOneLeavesNothingThatBlocksTheNext) {
  {
    DaemonRun daemon(config(camera("&fps=15")), {}, err());
    Client client(socket());
    ASSERT_TRUE(client.connected());
    daemon.signal(SIGKILL);
    EXPECT_EQ(daemon.wait(), -1);
  }
  EXPECT_TRUE(std::filesystem::exists(socket()));
  DaemonRun daemon(config(camera("&fps=15")), {}, err());
  Client client(socket());
  EXPECT_FALSE(client.next("camera", "PRESENT").is_null()) << daemon.messages();
  DaemonRun other(config(camera("&fps=15")), {}, own_.path("other"));
  EXPECT_EQ(other.wait(), 1) << "two daemons at one socket";
  EXPECT_NE(other.messages().find("another program listens"), std::string::npos) << other.messages();
  EXPECT_FALSE(client.next("measured").is_null()) << "the first one did not notice";
}

}  // namespace
}  // namespace im2fit
