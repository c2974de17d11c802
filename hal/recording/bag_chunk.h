// SPDX-License-Identifier: Apache-2.0
// Chunks of a rosbag, decompressed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/status.h"
#include "hal/recording/file_cursor.h"

namespace im2fit::hal {

// Reads `packed` bytes and makes `size` of them. `compression` is bz2 or lz4. Errors: corrupt, unsupported (more than
// kBagChunkMax, another word, or a library that is not in this build), io.
Status unpack_chunk(FileCursor& file, std::uint32_t packed, const std::string& compression, std::uint32_t size,
                    std::vector<std::byte>& out);

}  // namespace im2fit::hal
