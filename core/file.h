// SPDX-License-Identifier: Apache-2.0
// Whole-file reading, read-only mapping, and writing that leaves either the old file or the whole new one.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit {

Result<std::vector<std::byte>> read_file(const std::string& path);

// Writes to a temporary name beside `path`, syncs, renames. On any failure nothing is left behind.
Status write_file_atomically(const std::string& path, std::span<const std::byte> bytes);
Status write_file_atomically(const std::string& path, const std::string& text);

// Creates the directory and its parents; fine when it exists. Checks that it can be written to.
Status make_directory(const std::string& path);

// A file mapped read-only; movable, unmapped on destruction.
class MappedFile {
 public:
  static Result<MappedFile> open(const std::string& path);
  MappedFile() = default;
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  ~MappedFile();
  std::span<const std::byte> bytes() const { return {data_, size_}; }

 private:
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace im2fit
