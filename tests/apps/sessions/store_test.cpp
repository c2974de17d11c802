// SPDX-License-Identifier: Apache-2.0
#include "apps/sessions/store.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <future>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "a_record.h"

namespace im2fit::sessions {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::UnorderedElementsAre;

std::set<std::string> names_in(const std::string& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

mode_t mode_of(const fs::path& path) {
  struct stat about {};
  return ::stat(path.c_str(), &about) == 0 ? about.st_mode & 07777 : 0;
}

// Runs `work` in a process of its own and returns its result.
template <class Work>
int in_another_process(const Work& work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work());
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

class SessionStore : public testing::Test {
 protected:
  // A complete session; its id.
  std::string saved(const std::string& started_utc = "2026-05-04T12:30:00Z") const {
    auto session = NewSession::begin(root_);
    if (!session) return session.error().message;
    Record record = test::a_record();
    record.started_utc = started_utc;
    const auto finished = session->finish(record);
    return finished ? session->id() : finished.error().message;
  }
  const test::SessionFolder folder_;
  const std::string root_ = folder_.root();
};

TEST_F(SessionStore, ASessionAppearsWholeAndForItsOwnerAlone) {
  ::umask(022);
  auto session = NewSession::begin(root_);
  ASSERT_TRUE(session) << session.error().message;
  EXPECT_TRUE(is_id(session->id()));
  ASSERT_TRUE(session->write(kResultFile, "{}"));
  fs::create_directory(session->path(kRecordingFolder));
  std::ofstream(session->path("recording/camera.yaml")) << "image_width: 480\n";
  EXPECT_THAT(*list(root_), IsEmpty());
  ASSERT_TRUE(session->finish(test::a_record()));
  EXPECT_THAT(names_in(root_), ElementsAre(session->id()));
  const fs::path folder = fs::path(root_) / session->id();
  EXPECT_EQ(mode_of(root_), 0700U);
  EXPECT_EQ(mode_of(folder), 0700U);
  EXPECT_EQ(mode_of(folder / "recording"), 0700U);
  for (const char* file : {"session.json", "result.json", "recording/camera.yaml"})
    EXPECT_EQ(mode_of(folder / file), 0600U) << file;
  const auto read = sessions::read(root_, session->id());
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->id, session->id());
  EXPECT_EQ(*recording_of(root_, session->id()), (folder / "recording").string());
}

TEST_F(SessionStore, OneThatIsGivenUpLeavesNothing) {
  {
    auto session = NewSession::begin(root_);
    ASSERT_TRUE(session);
    ASSERT_TRUE(session->write(kResultFile, "{}"));
    Record record = test::a_record();
    record.person = "";
    const auto finished = session->finish(record);
    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().message, "person is missing");
    EXPECT_THAT(names_in(root_), SizeIs(1));
  }
  EXPECT_THAT(names_in(root_), IsEmpty());
}

TEST_F(SessionStore, AFullDiskLeavesNothingAndSaysSo) {
  const int code = in_another_process([&] {
    std::signal(SIGXFSZ, SIG_IGN);  // then write() fails, as on a full disk
    const rlimit limit{200, 200};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    auto session = NewSession::begin(root_);
    if (!session || !session->write(kResultFile, "{}")) return 1;
    const auto finished = session->finish(test::a_record());
    return !finished && finished.error().message.find("cannot write") != std::string::npos ? 0 : 2;
  });
  EXPECT_EQ(code, 0);
  EXPECT_THAT(names_in(root_), IsEmpty());
}

TEST_F(SessionStore, WhatAKilledProgramLeftGoesAndWhatIsBeingWrittenStays) {
  auto writing = NewSession::begin(root_);
  ASSERT_TRUE(writing);
  const int code = in_another_process([&]() -> int {
    auto session = NewSession::begin(root_);
    ::_exit(session && session->write(kResultFile, "{}") ? 0 : 1);  // as if killed: nothing is destroyed
  });
  EXPECT_EQ(code, 0);
  EXPECT_THAT(names_in(root_), SizeIs(2));
  fs::create_directory(fs::path(root_) / ".20260101-000000-aaaaaaaa.gone");
  for (const char* name : {".not ours.part", ".holiday.part", ".20260101-000000-a.part"})
    fs::create_directory(fs::path(root_) / name);
  const std::string id = saved();
  EXPECT_THAT(names_in(root_), UnorderedElementsAre(".not ours.part", ".holiday.part", ".20260101-000000-a.part",
                                                    "." + writing->id() + ".part", id));
  EXPECT_TRUE(writing->finish(test::a_record()));
}

TEST_F(SessionStore, SweepingDeletesWhatAKilledProgramLeftAndNothingElse) {
  sweep(root_);  // there is none yet
  const std::string id = saved();
  auto writing = NewSession::begin(root_);
  ASSERT_TRUE(writing);
  fs::create_directories(fs::path(root_) / ".20260101-000000-aaaaaaaa.part" / kRecordingFolder);
  sweep(root_);
  EXPECT_THAT(names_in(root_), UnorderedElementsAre("." + writing->id() + ".part", id));
}

TEST_F(SessionStore, ListsTheOldestFirstAndDamagedOnesWithWhatIsWrong) {
  EXPECT_THAT(*list(root_), IsEmpty());
  const std::string second = saved("2026-05-04T12:30:00Z"), first = saved("2025-05-04T12:30:00Z");
  fs::create_directory(fs::path(root_) / "damaged");
  std::ofstream(fs::path(root_) / "damaged" / "session.json") << "{";
  fs::copy(fs::path(root_) / first, fs::path(root_) / "renamed", fs::copy_options::recursive);
  const auto all = list(root_);
  ASSERT_TRUE(all) << all.error().message;
  ASSERT_THAT(*all, SizeIs(4));
  EXPECT_EQ((*all)[0].id, "damaged");
  EXPECT_THAT((*all)[0].damage, HasSubstr("damaged/session.json: not JSON"));
  EXPECT_THAT((*all)[1].damage, HasSubstr("expected the folder's name"));
  EXPECT_EQ((*all)[2].id, first);
  EXPECT_EQ((*all)[3].id, second);
  EXPECT_EQ((*all)[3].damage, "");
}

TEST_F(SessionStore, ALinkToItselfIsNamedAndTheOthersAreListed) {
  const std::string id = saved();
  fs::create_symlink("loop", fs::path(root_) / "loop");
  const auto all = list(root_);
  ASSERT_TRUE(all) << all.error().message;
  ASSERT_THAT(*all, SizeIs(2));
  EXPECT_EQ((*all)[0].id, "loop");
  EXPECT_THAT((*all)[0].damage, HasSubstr("sessions/loop: Too many levels of symbolic links"));
  EXPECT_EQ((*all)[1].id, id);
  EXPECT_FALSE(list(root_ + "/loop"));
}

TEST_F(SessionStore, OneThatIsDeletedWhileTheyAreListedIsNotDamaged) {
  std::vector<std::string> ids;
  for (int i = 0; i < 100; ++i) ids.push_back(saved());
  std::atomic<bool> over{false};
  std::thread deleting([&] {
    for (const std::string& id : ids) EXPECT_TRUE(remove(root_, id)) << id;
    over = true;
  });
  std::set<std::string> damages;
  while (!over) {
    const auto all = list(root_);
    if (!all) {
      damages.insert(all.error().message);
      continue;
    }
    for (const Listed& one : *all) damages.insert(one.damage);
  }
  deleting.join();
  damages.erase("");
  EXPECT_THAT(damages, IsEmpty());
  fs::create_symlink("nowhere", fs::path(root_) / "lost");
  EXPECT_THAT(*list(root_), SizeIs(1)) << "a link that leads nowhere is named";
}

TEST_F(SessionStore, DeletesAllOfOneById) {
  const std::string one = saved(), other = saved();
  ASSERT_TRUE(remove(root_, one));
  EXPECT_THAT(names_in(root_), ElementsAre(other));
  EXPECT_EQ(remove(root_, one).error().code, ErrorCode::not_found);
}

// A person's own Delete and the operator's, both behind somebody who holds the folder.
TEST_F(SessionStore, OfTwoWhoDeleteOneTheSecondFindsNone) {
  const std::string id = saved();
  const int held = ::open(root_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(::flock(held, LOCK_EX), 0);
  const auto deletion = [&] {
    return std::async(std::launch::async, [&] {
      const Status gone = remove(root_, id);
      return gone ? std::optional<ErrorCode>() : gone.error().code;
    });
  };
  auto one = deletion(), other = deletion();
  EXPECT_EQ(one.wait_for(std::chrono::milliseconds(200)), std::future_status::timeout);
  EXPECT_EQ(other.wait_for(std::chrono::milliseconds(200)), std::future_status::timeout);
  ::close(held);
  EXPECT_THAT((std::array{one.get(), other.get()}),
              UnorderedElementsAre(std::optional<ErrorCode>(), std::optional(ErrorCode::not_found)));
  EXPECT_THAT(names_in(root_), IsEmpty());
}

TEST_F(SessionStore, AnIdLeadsNowhereElse) {
  const std::string id = saved();
  std::ofstream(fs::path(root_).parent_path() / "session.json") << "{}";
  for (const std::string& bad :
       {std::string(".."), std::string("../sessions"), "../sessions/" + id, id + "/..", std::string(),
        std::string("a\0b", 3), std::string("."), std::string(41, 'a'), root_ + "/" + id}) {
    EXPECT_EQ(folder_of(root_, bad).error().code, ErrorCode::invalid_argument) << bad;
    EXPECT_EQ(sessions::read(root_, bad).error().code, ErrorCode::invalid_argument) << bad;
    EXPECT_EQ(remove(root_, bad).error().code, ErrorCode::invalid_argument) << bad;
  }
  EXPECT_THAT(names_in(root_), ElementsAre(id));
}

TEST_F(SessionStore, WithoutARecordingOrARootItSaysSo) {
  EXPECT_EQ(sessions::read(root_, "a").error().code, ErrorCode::not_found);
  const std::string id = saved();
  EXPECT_THAT(recording_of(root_, id).error().message, HasSubstr("has no recording"));
  std::ofstream(fs::path(root_) / "file");
  const auto begun = NewSession::begin(root_ + "/file/below");
  ASSERT_FALSE(begun);
  EXPECT_THAT(begun.error().message, HasSubstr("file"));
}

}  // namespace
}  // namespace im2fit::sessions
