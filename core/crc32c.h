// SPDX-License-Identifier: Apache-2.0
// CRC-32C (Castagnoli, RFC 3720 appendix B.4): crc32c("123456789") == 0xE3069283.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace im2fit {
std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t previous = 0);
}
