// SPDX-License-Identifier: Apache-2.0
// Bytes to and from .xz, whole.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/status.h"

namespace im2fit::apps {

// One thread and one fixed setting: the same bytes from the same liblzma on every machine.
Result<std::vector<std::byte>> compress_xz(std::span<const std::byte> bytes);
// `size` is what must come out; more or less is an error, so that a file that claims little cannot fill the memory.
Result<std::vector<std::byte>> decompress_xz(std::span<const std::byte> bytes, std::size_t size,
                                             const std::string& what);

}  // namespace im2fit::apps
