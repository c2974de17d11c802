// SPDX-License-Identifier: Apache-2.0
// A file has its name only once its bytes are on the disk: fsync is this program's own, and looks.
#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <functional>
#include <string>

#include "core/file.h"

namespace {

std::function<int()> on_sync;  // in place of the system's; empty: the system's

}  // namespace

extern "C" int fsync(int fd) {
  return on_sync ? on_sync() : static_cast<int>(::syscall(SYS_fsync, fd));
}

namespace im2fit {
namespace {

class DurableWrite : public testing::Test {
 protected:
  DurableWrite() {
    std::string name = (std::filesystem::temp_directory_path() / "im2fit-core-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~DurableWrite() override {
    on_sync = nullptr;
    std::filesystem::remove_all(folder_);
  }
  std::string path() const { return folder_ + "/result.json"; }
  std::string folder_;
};

TEST_F(DurableWrite, IsOnTheDiskBeforeItHasItsName) {
  int synced = 0;
  on_sync = [&] {
    ++synced;
    EXPECT_FALSE(std::filesystem::exists(path()));
    for (const auto& file : std::filesystem::directory_iterator(folder_)) EXPECT_EQ(file.file_size(), 5U);
    return 0;
  };
  ASSERT_TRUE(write_file_atomically(path(), "hello"));
  EXPECT_EQ(synced, 1);
  EXPECT_TRUE(std::filesystem::exists(path()));
}

TEST_F(DurableWrite, IsGivenUpWhenTheDiskFails) {
  ASSERT_TRUE(write_file_atomically(path(), "before"));
  on_sync = [] {
    errno = EIO;
    return -1;
  };
  const Status written = write_file_atomically(path(), "hello");
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::io);
  EXPECT_EQ(std::filesystem::file_size(path()), 6U) << "the old one stays";
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1) << "and nothing else";
}

}  // namespace
}  // namespace im2fit
