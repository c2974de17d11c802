// SPDX-License-Identifier: Apache-2.0
// Whole-file reading, read-only mapping, and writing that leaves either the old file or the whole new one.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit {

// The largest file that is read whole, unless its reader specifies less.
inline constexpr std::size_t kReadBytesMax = std::size_t{256} << 20;
inline constexpr std::size_t kTextBytesMax = std::size_t{1} << 20;  // a configuration, a chart, a calibration
// Regular files only: a FIFO would hang, a device never end. Errors: not_found, io, unsupported (larger than
// `size_max`, checked before anything is read).
Result<std::vector<std::byte>> read_file(const std::string& path, std::size_t size_max = kReadBytesMax);
// The same into `bytes`, whose memory is kept from file to file; at most the first `count`.
Status read_file_into(const std::string& path, std::size_t size_max, std::size_t count,
                      std::vector<std::byte>& bytes);

// Who may read a new file: the users the umask allows, or the owner alone (files with a person's data).
enum class Readable { as_umask, by_owner };

// Writes to a temporary name beside `path` (temporary_of), syncs, renames: a reader of `path` gets either the old
// file or the whole new one. Any failure removes the temporary file; a program that is killed leaves it.
Status write_file_atomically(const std::string& path, std::span<const std::byte> bytes,
                             Readable readable = Readable::as_umask);
Status write_file_atomically(const std::string& path, const std::string& text,
                             Readable readable = Readable::as_umask);
// Whether `name` is a temporary name that write_file_atomically gives to the later `final_name`.
bool is_temporary_of(const std::string& name, const std::string& final_name);

// Creates the directory and its parents; fine when it exists. Checks that it can be written to.
Status make_directory(const std::string& path);

// A file's bytes, read-only; movable, freed on destruction. A file of up to kCopiedMax is copied: whatever happens to
// it afterwards, its bytes stay. A larger one is mapped, and must not be written to or truncated meanwhile (reading
// pages that are gone ends the program): replace it by a rename, as write_file_atomically does.
class MappedFile {
 public:
  static constexpr std::size_t kCopiedMax = std::size_t{64} << 20;
  // Errors: as read_file, without a limit of size.
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
