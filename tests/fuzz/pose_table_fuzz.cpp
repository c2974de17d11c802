// SPDX-License-Identifier: Apache-2.0
// poses.csv, and odometry.csv and camera_matrix.csv of Stray Scanner, as anyone may have written them: refused with
// one line, or unit quaternions at places within a kilometre. The first byte chooses the file.
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/file.h"
#include "hal/folder/stray_scanner.h"

namespace {

constexpr int kWide = 16, kHigh = 12;
constexpr const char* kMatrix = "1440, 0, 960\n0, 1440, 720\n0, 0, 1\n";

// A depth folder and a recording of two frames, in memory. Its name outlives every destructor: the end removes the
// folder by it.
const std::string& folder() {
  static const std::string& path = *new std::string([] {
    std::string name = "/dev/shm/im2fit-fuzz-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    std::atexit([] { std::filesystem::remove_all(folder()); });
    const std::vector<std::uint16_t> pixels(std::size_t{kWide} * kHigh, 2000);
    auto bytes =
        im2fit::hal::encode_depth(im2fit::DepthView(pixels.data(), kWide, kHigh), im2fit::hal::DepthFormat::png);
    if (!bytes) std::abort();
    const im2fit::Intrinsics k{kWide, kHigh, 12, 12, 7.5F, 5.5F};
    auto writer = im2fit::hal::FolderWriter::create(name + "/own", k, {});
    if (!writer) std::abort();
    std::filesystem::create_directories(name + "/stray/depth");
    for (const char* frame :
         {"/own/000000.png", "/own/000001.png", "/stray/depth/000000.png", "/stray/depth/000001.png"})
      if (!im2fit::write_file_atomically(name + frame, *bytes)) std::abort();
    return name;
  }());
  return path;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  if (size == 0) return 0;
  const std::string stray = folder() + "/stray";
  const std::string files[] = {folder() + "/own/poses.csv", stray + "/odometry.csv", stray + "/camera_matrix.csv"};
  std::error_code ignored;
  std::filesystem::remove(files[1], ignored);
  if (!write_file_atomically(files[2], std::string(kMatrix))) std::abort();
  const int kind = data[0] % 3;
  if (!write_file_atomically(files[kind], std::as_bytes(std::span(data, size).subspan(1)))) std::abort();
  auto source = kind == 0 ? hal::FolderSource::open(folder() + "/own") : hal::open_stray_scanner(stray, {});
  if (!source) {
    if (source.error().message.empty() || source.error().message.find('\n') != std::string::npos) __builtin_trap();
    return 0;
  }
  std::vector<std::uint16_t> pixels(std::size_t{kWide} * kHigh);
  const Intrinsics& k = (*source)->info().intrinsics;
  for (int i = 0; i < 2; ++i) {
    const auto info = (*source)->next(DepthImage(pixels.data(), k.width, k.height), 0);
    if (!info) __builtin_trap();
    if (!info->pose) continue;
    const hal::CameraPose& q = *info->pose;
    if (!(std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 1e-4F)) __builtin_trap();
    if (!(norm(q.position_mm) < 2e6F)) __builtin_trap();
  }
  return 0;
}
