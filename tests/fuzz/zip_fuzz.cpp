// SPDX-License-Identifier: Apache-2.0
// Archives as anyone may have written them: refused in one line, or unpacked into their folder and nowhere else. What
// was unpacked is then read as a depth folder.
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>

#include "core/file.h"
#include "hal/folder/depth_folder.h"
#include "hal/recording/zip_folder.h"
#include "recording_use.h"

namespace {

// In memory. Its name outlives every destructor: the end removes the folder by it.
const std::string& room() {
  static const std::string& path = *new std::string([] {
    std::string name = "/dev/shm/im2fit-fuzz-XXXXXX";
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    std::atexit([] { std::filesystem::remove_all(room()); });
    return name;
  }());
  return path;
}

void check_nothing_outside() {
  for (const auto& entry : std::filesystem::directory_iterator(room()))
    if (entry.path().filename() != "a.zip" && entry.path().filename() != "folder") __builtin_trap();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  const std::string archive = room() + "/a.zip", folder = room() + "/folder";
  if (!write_file_atomically(archive, std::as_bytes(std::span(data, size)))) std::abort();
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  const Status status = hal::unpack_zip(archive, folder);
  check_nothing_outside();
  if (!status) return fuzz::check_one_line(status.error()), 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_symlink() || (!entry.is_regular_file() && !entry.is_directory())) __builtin_trap();
  auto source = hal::FolderSource::open(folder);
  if (!source) return fuzz::check_one_line(source.error()), 0;
  if (!fuzz::read_to_end(**source, size)) __builtin_trap();
  return 0;
}
