// SPDX-License-Identifier: Apache-2.0
#include "core/file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>

#include "core/text.h"

namespace {

std::function<int()> on_sync;  // in place of the system's; empty: the system's

}  // namespace

extern "C" int fsync(int fd) {
  return on_sync ? on_sync() : static_cast<int>(::syscall(SYS_fsync, fd));
}

namespace im2fit {
namespace {

class Files : public testing::Test {
 protected:
  Files() {
    std::string name = (std::filesystem::temp_directory_path() / "im2fit-core-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~Files() override { std::filesystem::remove_all(folder_); }
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  static unsigned mode_of(const std::string& path) {
    struct stat about {};
    EXPECT_EQ(::stat(path.c_str(), &about), 0);
    return about.st_mode & 07777U;
  }
  std::string folder_;
};

TEST_F(Files, WhatIsNoFileIsRefusedAtOnce) {
  ASSERT_EQ(::mkfifo(path("fifo").c_str(), 0600), 0);  // to open one for reading waits for a writer
  for (const std::string& name : {path("fifo"), folder_, std::string("/dev/zero")}) {
    EXPECT_EQ(read_file(name).error().code, ErrorCode::io) << name;
    EXPECT_EQ(MappedFile::open(name).error().code, ErrorCode::io) << name;
  }
  EXPECT_EQ(read_file(path("absent")).error().code, ErrorCode::not_found);
}

TEST_F(Files, SizeIsLookedAtBeforeReading) {
  const int fd = ::open(path("sparse").c_str(), O_CREAT | O_WRONLY, 0600);
  ASSERT_EQ(::ftruncate(fd, 2'000'000'000), 0);
  ::close(fd);
  const auto refused = read_file(path("sparse"), kTextBytesMax);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
  EXPECT_NE(refused.error().message.find("2000000000 bytes, expected at most 1048576"), std::string::npos);
  EXPECT_FALSE(read_file(path("sparse")));
  ASSERT_TRUE(write_file_atomically(path("small"), std::string("12345")));
  EXPECT_TRUE(read_file(path("small"), 5));
  EXPECT_FALSE(read_file(path("small"), 4));
  std::vector<std::byte> bytes;
  ASSERT_TRUE(read_file_into(path("small"), 5, 2, bytes));
  EXPECT_EQ(bytes.size(), 2U);
}

// Another program may write to the file; to read pages that are gone would end this one.
TEST_F(Files, BytesStayWhateverHappensToTheFile) {
  ASSERT_TRUE(write_file_atomically(path("f"), std::string(100'000, 'a')));
  const auto file = MappedFile::open(path("f"));
  ASSERT_TRUE(file);
  ASSERT_EQ(::truncate(path("f").c_str(), 0), 0);
  EXPECT_EQ(file->bytes().size(), 100'000U);
  EXPECT_EQ(file->bytes().back(), std::byte{'a'});
  ASSERT_TRUE(write_file_atomically(path("f"), std::string(100'000, 'b')));
  EXPECT_EQ(file->bytes().front(), std::byte{'a'});
}

TEST_F(Files, ReadersAreThoseTheUmaskLetsOrTheOwnerAlone) {
  const mode_t before = ::umask(022);
  EXPECT_TRUE(write_file_atomically(path("open"), std::string("x")));
  EXPECT_TRUE(write_file_atomically(path("own"), std::string("x"), Readable::by_owner));
  ::umask(077);
  EXPECT_TRUE(write_file_atomically(path("closed"), std::string("x")));
  ::umask(before);
  EXPECT_EQ(mode_of(path("open")), 0644U);
  EXPECT_EQ(mode_of(path("own")), 0600U);
  EXPECT_EQ(mode_of(path("closed")), 0600U);
  // Who could read the old file cannot read what takes its place.
  EXPECT_TRUE(write_file_atomically(path("open"), std::string("y"), Readable::by_owner));
  EXPECT_EQ(mode_of(path("open")), 0600U);
}

TEST_F(Files, ALinkIsReplacedAndNotFollowed) {
  ASSERT_TRUE(write_file_atomically(path("target"), std::string("target")));
  ASSERT_EQ(::symlink(path("target").c_str(), path("link").c_str()), 0);
  ASSERT_TRUE(write_file_atomically(path("link"), std::string("new")));
  EXPECT_EQ(read_file(path("target"))->size(), 6U);
  EXPECT_FALSE(std::filesystem::is_symlink(path("link")));
}

TEST_F(Files, NothingIsLeftBehindWhenItFails) {
  EXPECT_FALSE(write_file_atomically(path("no/such/folder/f"), std::string("x")));
  std::filesystem::create_directory(path("folder"));
  EXPECT_FALSE(write_file_atomically(path("folder"), std::string("x"))) << "a folder is there";
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
}

TEST(Temporary, NamesAreKnown) {
  EXPECT_TRUE(is_temporary_of("a.i2d.ab12z9", "a.i2d"));
  for (const char* name : {"a.i2d", "a.i2d.ab12z", "a.i2d.ab12z99", "a.i2d.AB12Z9", "b.i2d.ab12z9", "a.i2d-ab12z9"})
    EXPECT_FALSE(is_temporary_of(name, "a.i2d")) << name;
}

TEST(Text, ControlCharactersAreNotShown) {
  EXPECT_EQ(printable("a\x1B[31mb\nc\x7F"
                      "d\xC2\x9B"
                      "e"),
            "a [31mb c d  e");
  EXPECT_EQ(printable("Größe 特大"), "Größe 特大");
  EXPECT_EQ(character_count("Größe 特大"), 8U);
}

// A file has its name only once its bytes are on the disk: fsync is this program's own, and looks.
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
