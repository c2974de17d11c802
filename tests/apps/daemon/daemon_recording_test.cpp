// SPDX-License-Identifier: Apache-2.0
// im2fitd over a recording, from its start to SIGTERM.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

#include "daemon_run.h"
#include "private_files.h"
#include "two_people.h"

namespace im2fit {
namespace {

TEST(DaemonRecording, IsMeasuredAndKeptForItsOwnerAlone) {
  IM2FIT_NEED_DATA();
  const test::UsualUmask umask;
  const test::TestFolder folder;
  test::write_two_people(folder.path("two"));
  std::filesystem::create_directories(folder.path("state"));
  test::write_text(folder.path("c.yaml"),
                   "source: '" + folder.path("two") + "'\nrotate: 90\nbody: " + test::body_path() +
                       "\ntracker: " + test::tracker_path() + "\nindex: " + test::index_path() +
                       "\nmeasure: {frames: 5}\nsocket: {path: " + folder.path("s") +
                       "}\nstate_directory: " + folder.path("state") + "\n");
  test::DaemonRun daemon(folder.path("c.yaml"), {}, folder.path("messages"));
  const std::string kept = folder.path("state") + "/last-result.json";
  for (const auto end = test::Clock::now() + 3 * test::kPatience;
       test::Clock::now() < end && !std::filesystem::exists(kept);)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.messages();
  EXPECT_THAT(test::all_files_in(folder.path("state")), testing::ElementsAre("last-result.json"))
      << daemon.messages();
  EXPECT_THAT(test::readable_by_others(folder.path("state")), testing::IsEmpty());
  const auto result = nlohmann::json::parse(test::read_text(kept), nullptr, false);
  EXPECT_EQ(result["state"], "MEASURED") << result;
}

}  // namespace
}  // namespace im2fit
