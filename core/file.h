// SPDX-License-Identifier: Apache-2.0
// Reading and mapping files, and atomic writing: a failure leaves the old file.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/status.h"

namespace im2fit {

// Size limit of a file that is read completely, unless the caller sets a smaller limit.
inline constexpr std::size_t kReadBytesMax = std::size_t{256} << 20;
inline constexpr std::size_t kTextBytesMax = std::size_t{1} << 20;  // a configuration, a chart, a calibration
// Regular files only, because a FIFO would block and a device would not end. Errors: not_found, io, unsupported
// (larger than `size_max`, checked before anything is read).
Result<std::vector<std::byte>> read_file(const std::string& path, std::size_t size_max = kReadBytesMax);
// The same into `bytes`, whose memory is reused; reads at most the first `count` bytes.
Status read_file_into(const std::string& path, std::size_t size_max, std::size_t count,
                      std::vector<std::byte>& bytes);

// Who may read a new file: users allowed by the umask, or only the owner (files with personal data).
enum class Readable { as_umask, by_owner };

// Writes a temporary file beside `path`, syncs and renames it: a reader of `path` gets the old or the complete new
// file. A failure removes the temporary file. A program that is killed leaves it.
Status write_file_atomically(const std::string& path, std::span<const std::byte> bytes,
                             Readable readable = Readable::as_umask);
Status write_file_atomically(const std::string& path, const std::string& text,
                             Readable readable = Readable::as_umask);
// Whether `name` is a temporary name that write_file_atomically gives to the later `final_name`.
bool is_temporary_of(const std::string& name, const std::string& final_name);

// Creates the directory and its parents if they do not exist. Checks that the directory is writable.
Status make_directory(const std::string& path);

// The bytes of a file, read-only; movable, freed on destruction. A file of up to kCopiedMax is copied, so later
// changes of the file have no effect. A larger file is mapped and must not be changed or truncated in place, because
// reading a truncated page ends the program. Replace it by a rename, as write_file_atomically does.
class MappedFile {
 public:
  static constexpr std::size_t kCopiedMax = std::size_t{64} << 20;
  // Errors: as read_file, without a size limit.
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
