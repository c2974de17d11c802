// SPDX-License-Identifier: Apache-2.0
// Recordings in archives, which Python's zipfile writes.
#include "hal/recording/zip_folder.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "core/file.h"
#include "hal/folder/depth_folder.h"
#include "hal/open/open.h"
#include "made_folder.h"
#include "other_programs.h"
#include "small_png.h"

namespace im2fit::hal {
namespace {

class ZipFolder : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.path(name); }

  void SetUp() override {
    const char* before = std::getenv("TMPDIR");
    before_ = before ? std::optional<std::string>(before) : std::nullopt;
    if (!have_program("python3")) GTEST_SKIP() << "no python3";
    std::filesystem::create_directory(path("tmp"));
    ::setenv("TMPDIR", path("tmp").c_str(), 1);
    make_folder(path("frames"));
  }
  void TearDown() override {
    if (before_)
      ::setenv("TMPDIR", before_->c_str(), 1);
    else
      ::unsetenv("TMPDIR");
    EXPECT_TRUE(nothing_left());
  }
  bool nothing_left() const {
    return !std::filesystem::exists(path("tmp")) || std::filesystem::is_empty(path("tmp"));
  }

  // `more`: lines of Python with the archive `z` open.
  bool zip(const std::string& name, const std::string& more,
           const std::string& method = "zipfile.ZIP_DEFLATED") const {
    put(path("make.py"),
        "import glob, zipfile\nwith zipfile.ZipFile('" + name + "', 'w', " + method + ") as z:\n" + more);
    return run_in(folder_.path(), "python3 make.py");
  }
  static std::string frames_under(const std::string& folder) {
    return " for f in sorted(glob.glob('frames/**', recursive=True)):\n  z.write(f, f.replace('frames/', '" + folder +
           "', 1))\n";
  }

  void expect_frames(const std::string& name) const {
    auto folder = open_source(path("frames"));
    ASSERT_TRUE(folder);
    auto source = open_source(path(name));
    ASSERT_TRUE(source) << source.error().message;
    EXPECT_FALSE(nothing_left());
    EXPECT_EQ((*source)->info().uri, path(name));
    EXPECT_EQ((*source)->info().name, path(name));
    EXPECT_EQ((*source)->info().frame_count, 4);
    EXPECT_NE(folder_of(**source), nullptr);
    for (int round = 0; round < 2; ++round) {
      ASSERT_TRUE((*source)->start());
      ASSERT_TRUE((*folder)->start());
      Picture out(kMadeWidth, kMadeHeight), expected(kMadeWidth, kMadeHeight);
      for (int i = 0; i < 4; ++i) {
        const auto got = (*source)->next(out.image(), 0), wanted = (*folder)->next(expected.image(), 0);
        ASSERT_TRUE(got && wanted);
        EXPECT_EQ(out.pixels, expected.pixels);
        EXPECT_EQ(got->host_ns, wanted->host_ns);
      }
      EXPECT_EQ((*source)->next(out.image(), 0).error().code, ErrorCode::end_of_stream);
    }
    EXPECT_EQ((*source)->stats().delivered, 4U);
  }

  std::string refused(const std::string& name) const {
    const auto source = open_source(path(name));
    EXPECT_FALSE(source);
    EXPECT_TRUE(nothing_left());
    if (source) return "";
    EXPECT_FALSE(contains(source.error().message, "\n")) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, name)) << source.error().message;
    EXPECT_FALSE(contains(source.error().message, path("tmp"))) << source.error().message;
    return source.error().message;
  }

  // An archive with more files than a recording, whose end says something else.
  void expect_forged_ends_are_refused(const std::string& name) const {
    put(path("forge.py"), R"(import struct, sys
data = open(sys.argv[1], 'rb').read()
rest, end64, locator, end = data[:-98], data[-98:-42], data[-42:-22], data[-22:]
assert end64[:4] == b'PK\6\6' and locator[:4] == b'PK\6\7' and end[:4] == b'PK\5\6'
count, size, offset = struct.unpack('<QQQ', end64[32:])
def make(name, *parts):
    open(name, 'wb').write(b''.join(parts))
def classic(count, size, comment=0):
    return struct.pack('<4s4H2IH', b'PK\5\6', 0, 0, count, count, size, offset, comment)
make('locator.zip', rest, end64, locator, classic(1, 46))
make('comment.zip', rest, classic(65535, size, 22), classic(0, 0))
make('modulo.zip', rest, classic(count % 65536, size))
make('ends.zip', *[classic(0, 0, 22 * i) for i in reversed(range(9))])
)");
    ASSERT_TRUE(run_in(folder_.path(), "python3 forge.py " + name));
    EXPECT_TRUE(contains(refused("locator.zip"), "(zip64); unpack it and give the folder")) << refused("locator.zip");
    EXPECT_TRUE(contains(refused("ends.zip"), "is not a whole .zip archive")) << refused("ends.zip");
    for (const char* forged : {"comment.zip", "modulo.zip"})
      EXPECT_TRUE(contains(refused(forged), "more files than a recording")) << refused(forged);
  }

  TestFolder folder_;
  std::optional<std::string> before_;
};

#if IM2FIT_HAVE_ZIP
TEST_F(ZipFolder, ADepthFolderIsTheSameInAnArchive) {
  ASSERT_TRUE(zip("plain.zip", frames_under("")));
  expect_frames("plain.zip");
  EXPECT_TRUE(nothing_left());
  ASSERT_TRUE(zip("Stored.ZIP", frames_under("my person/"), "zipfile.ZIP_STORED"));
  expect_frames("Stored.ZIP");
  for (const char* folder : {"depth/", "person/depth/"}) {
    ASSERT_TRUE(zip("depth.zip", frames_under(folder)));
    expect_frames("depth.zip");
  }
  // bsdtar's and PowerShell's names.
  for (const char* folder : {"./", "./person/./", "person\\\\", ".\\\\"}) {
    ASSERT_TRUE(zip("named.zip", " for f in sorted(glob.glob('frames/*.*')):\n  z.writestr(f.replace('frames/', '" +
                                     std::string(folder) + "', 1), open(f, 'rb').read())\n"));
    expect_frames("named.zip");
  }
  // Written into a pipe, as phones share: sizes stand behind the files.
  zip("/dev/stdout", frames_under(""));
  ASSERT_TRUE(run_in(folder_.path(), "python3 make.py | cat >streamed.zip"));
  expect_frames("streamed.zip");
}

TEST_F(ZipFolder, AStrayScannersRecordingIsFoundAmongWhatIsNotRead) {
  std::filesystem::create_directories(path("rec/depth"));
  for (int i = 0; i < 2; ++i)
    write_grey_png(path("rec/depth/00000" + std::to_string(i) + ".png"), 256, 192, 16,
                   [&](int u, int v) { return 1000 + 100 * i + u + v; });
  put(path("rec/camera_matrix.csv"), "1440.5, 0.0, 955.1\n0.0, 1440.5, 722.9\n0.0, 0.0, 1.0\n");
  ASSERT_TRUE(zip("stray.zip",
                  " for f in sorted(glob.glob('rec/**', recursive=True)):\n"
                  "  z.write(f, f.replace('rec/', 'c00a170fe1/', 1))\n"
                  " z.writestr('c00a170fe1/rgb.mp4', b'\\0' * 100000000)\n"
                  " z.writestr('__MACOSX/c00a170fe1/depth/._000000.png', b'x')\n"
                  " z.writestr('../outside.exe', b'x')\n"));
  auto folder = open_source(path("rec"));
  ASSERT_TRUE(folder) << folder.error().message;
  auto source = open_source(path("stray.zip"));
  ASSERT_TRUE(source) << source.error().message;
  const Intrinsics k = (*source)->info().intrinsics;
  EXPECT_EQ(k.fx, (*folder)->info().intrinsics.fx);
  EXPECT_EQ(k.width, 192) << "upright";
  Picture out(k.width, k.height), expected(k.width, k.height);
  ASSERT_TRUE((*source)->next(out.image(), 0));
  ASSERT_TRUE((*folder)->next(expected.image(), 0));
  EXPECT_EQ(out.pixels, expected.pixels);
  EXPECT_FALSE(std::filesystem::exists(path("outside.exe")));
}

// Names that are times, and no tables.
TEST_F(ZipFolder, PicturesOfATumFolderKeepTheirs) {
  std::filesystem::create_directories(path("tum/depth"));
  for (const char* name : {"100.000000", "100.033333"})
    write_grey_png(path("tum/depth/" + std::string(name) + ".png"), 640, 480, 16, [](int, int) { return 5000; });
  ASSERT_TRUE(zip("tum.zip", " for f in sorted(glob.glob('tum/*/*')):\n  z.write(f)\n"));
  auto source = open_source(path("tum.zip"));
  ASSERT_TRUE(source) << source.error().message;
  EXPECT_EQ((*source)->info().frame_count, 2);
  Picture out(640, 480);
  ASSERT_TRUE((*source)->next(out.image(), 0));
  EXPECT_EQ(out.pixels.front(), 1000);
}

TEST_F(ZipFolder, DamageOfAFrameNamesTheArchive) {
  put(path("frames/000002.png"), "no picture");
  ASSERT_TRUE(zip("a.zip", frames_under("")));
  auto source = open_source(path("a.zip"));
  ASSERT_TRUE(source) << source.error().message;
  Picture out(kMadeWidth, kMadeHeight);
  ASSERT_TRUE((*source)->next(out.image(), 0));
  ASSERT_TRUE((*source)->next(out.image(), 0));
  const auto damage = (*source)->next(out.image(), 0);
  ASSERT_FALSE(damage);
  EXPECT_TRUE(contains(damage.error().message, path("a.zip") + "/000002.png")) << damage.error().message;
  EXPECT_EQ((*source)->stats().damaged, 1U);
}

TEST_F(ZipFolder, HostileArchivesAreRefusedInOneLine) {
  put(path("empty.zip"), "");
  EXPECT_TRUE(contains(refused("empty.zip"), "is not a whole .zip archive"));
  put(path("text.zip"), std::string(100000, 'x'));
  EXPECT_TRUE(contains(refused("text.zip"), "is not a whole .zip archive"));
  ASSERT_TRUE(zip("nothing.zip", " z.writestr('rgb.mp4', b'x')\n"));
  EXPECT_TRUE(contains(refused("nothing.zip"), "holds no pictures"));
  for (const char* name : {"../out.png", "/out.png", "a/../../out.png", "a//b.png", "..\\\\out.png", "\\\\out.png",
                           "a\\\\..\\\\..\\\\out.png", "./../out.png", ".//out.png"}) {
    ASSERT_TRUE(zip("out.zip", " z.writestr('" + std::string(name) + "', b'x')\n"));
    EXPECT_TRUE(contains(refused("out.zip"), "lies outside of it")) << name;
  }
  ASSERT_TRUE(zip("bomb.zip", " z.writestr('000000.png', b'\\0' * (65 << 20))\n"));
  EXPECT_TRUE(contains(refused("bomb.zip"), "of 68157440 bytes, expected at most 67108864"));
  ASSERT_TRUE(zip("many.zip", " for i in range(65600):\n  z.writestr('%d.mp4' % i, b'')\n"));
  EXPECT_TRUE(contains(refused("many.zip"), "more files than a recording"));
  expect_forged_ends_are_refused("many.zip");
  ASSERT_TRUE(zip("twice.zip", " z.writestr('000000.png', b'x')\n z.writestr('000000.png', b'y')\n"));
  EXPECT_TRUE(contains(refused("twice.zip"), "has the file 000000.png twice")) << refused("twice.zip");
  ASSERT_TRUE(zip("blind.zip", " z.write('frames/000000.png', '000000.png')\n"));
  EXPECT_TRUE(contains(refused("blind.zip"), "camera.yaml is missing")) << refused("blind.zip");
}

TEST_F(ZipFolder, AnotherCompressionIsNoDamage) {
  ASSERT_TRUE(zip("whole.zip", frames_under("")));
  const auto whole = read_file(path("whole.zip"));
  ASSERT_TRUE(whole);
  std::string bytes(reinterpret_cast<const char*>(whole->data()), whole->size());
  constexpr char kPpmd = 98;
  for (std::size_t at = 0; (at = bytes.find("PK\3\4", at)) != std::string::npos; ++at) bytes[at + 8] = kPpmd;
  for (std::size_t at = 0; (at = bytes.find("PK\1\2", at)) != std::string::npos; ++at) bytes[at + 10] = kPpmd;
  put(path("ppmd.zip"), bytes);
  EXPECT_EQ(open_source(path("ppmd.zip")).error().code, ErrorCode::unsupported);
  EXPECT_TRUE(contains(refused("ppmd.zip"), "is compressed by a method this build does not read; unpack it"))
      << refused("ppmd.zip");
}

TEST_F(ZipFolder, AChangedOrMissingPartGivesFramesOrOneLine) {
  ASSERT_TRUE(zip("whole.zip", frames_under("")));
  const auto whole = read_file(path("whole.zip"));
  ASSERT_TRUE(whole);
  for (std::size_t step = 0, at = 0; at < whole->size(); ++step, at += whole->size() / 60) {
    auto bytes = *whole;
    if (step % 2 == 0)
      bytes.resize(at);
    else
      bytes[at] ^= std::byte{0xFF};
    ASSERT_TRUE(write_file_atomically(path("changed.zip"), std::span<const std::byte>(bytes)));
    const auto source = open_source(path("changed.zip"));
    if (source) continue;
    EXPECT_FALSE(contains(source.error().message, "\n")) << source.error().message;
    EXPECT_TRUE(contains(source.error().message, "changed.zip")) << source.error().message;
    EXPECT_TRUE(nothing_left());
  }
}

// Whatever ends the program.
TEST_F(ZipFolder, TheTemporaryFolderGoesWithAProgramThatIsKilled) {
  ASSERT_TRUE(zip("a.zip", frames_under("")));
  int ready[2];
  ASSERT_EQ(::pipe(ready), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const auto source = open_source(path("a.zip"));
    const char word = source ? 'y' : 'n';
    if (::write(ready[1], &word, 1) == 1) ::pause();
    ::_exit(0);
  }
  char word = 0;
  ASSERT_EQ(::read(ready[0], &word, 1), 1);
  EXPECT_EQ(word, 'y');
  EXPECT_FALSE(nothing_left());
  ASSERT_EQ(::kill(child, SIGKILL), 0);
  ::waitpid(child, nullptr, 0);
  for (int i = 0; i < 500 && !nothing_left(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_TRUE(nothing_left());
  ::close(ready[0]);
  ::close(ready[1]);
}

// A program without input and output: their numbers are free, and what it prints all the same goes nowhere.
TEST_F(ZipFolder, WhatAProgramPrintsDoesNotEndItsFolder) {
  ASSERT_TRUE(zip("a.zip", frames_under("")));
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::close(STDIN_FILENO);
    ::close(STDOUT_FILENO);
    const auto source = open_source(path("a.zip"));
    for (const int number : {STDIN_FILENO, STDOUT_FILENO})
      if (::write(number, "words\n", 6) >= 0) ::_exit(2);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    ::_exit(source && !nothing_left() ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  for (int i = 0; i < 500 && !nothing_left(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_TRUE(nothing_left());
}

#else

TEST_F(ZipFolder, IsRefusedByNameWithoutLibzip) {
  ASSERT_TRUE(zip("a.zip", frames_under("")));
  EXPECT_TRUE(contains(refused("a.zip"), "this build has no libzip; unpack it and give the folder"));
}

#endif

}  // namespace
}  // namespace im2fit::hal
