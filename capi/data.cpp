// SPDX-License-Identifier: Apache-2.0
#include "capi/data.h"

#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <limits>

namespace im2fit::c {
namespace {

// The largest file of ours is a body of 12 MB; this catches a size that was not set or is an address.
constexpr std::size_t kDataSizeMax = std::size_t{1} << 30;

Error wrong(const std::string& name, const std::string& what) {
  return {ErrorCode::invalid_argument, name + what};
}

Result<std::vector<std::byte>> read_at(const im2fit_data& data, const std::string& name) {
  std::vector<std::byte> bytes(data.size);
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::pread(data.fd, bytes.data() + done, bytes.size() - done,
                              static_cast<off_t>(data.offset) + static_cast<off_t>(done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return Error{ErrorCode::io, "cannot read " + name + ": " + std::strerror(errno)};
    if (n == 0)
      return Error{ErrorCode::corrupt,
                   name + " ends after " + std::to_string(done) + " bytes, expected " + std::to_string(data.size)};
    done += static_cast<std::size_t>(n);
  }
  return bytes;
}

}  // namespace

Result<std::vector<std::byte>> bytes_of(const im2fit_data& data, const char* field) {
  const std::string name = std::string("settings.") + field;
  if (data.kind != IM2FIT_DATA_MEMORY && data.kind != IM2FIT_DATA_FD)
    return wrong(name, ".kind is " + std::to_string(data.kind) + ", expected one of IM2FIT_DATA_...");
  if (data.size == 0 || data.size > kDataSizeMax)
    return wrong(name, ".size is " + std::to_string(data.size) + ", expected 1 to " + std::to_string(kDataSizeMax));
  if (data.kind == IM2FIT_DATA_MEMORY) {
    if (data.bytes == nullptr) return wrong(name, ".bytes is NULL");
    const auto* first = static_cast<const std::byte*>(data.bytes);
    return std::vector<std::byte>(first, first + data.size);
  }
  // A 32-bit machine's off_t may have 32 bits.
  if (data.offset < 0 || data.offset > std::numeric_limits<off_t>::max() - static_cast<off_t>(kDataSizeMax))
    return wrong(name, ".offset is " + std::to_string(data.offset));
  return read_at(data, name);
}

}  // namespace im2fit::c
