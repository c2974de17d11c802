// SPDX-License-Identifier: Apache-2.0
// A site calibration as anyone may write it: refused with one line, or one that a device may measure with. Checksums
// are made right first, so that the ranges of values are tested.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "core/crc32c.h"
#include "estimate/site_calibration.h"

namespace {

// Layout: core/container.h.
void mend(std::vector<std::byte>& file) {
  constexpr std::size_t kHead = 32, kRow = 40;
  if (file.size() < kHead) return;
  std::uint32_t count = 0;
  std::memcpy(&count, file.data() + 12, sizeof count);
  if (count > 64 || file.size() < kHead + count * kRow) return;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::byte* row = file.data() + kHead + i * kRow;
    std::uint64_t offset = 0, size = 0;
    std::memcpy(&offset, row + 16, sizeof offset);
    std::memcpy(&size, row + 24, sizeof size);
    if (offset > file.size() || size > file.size() - offset) return;
    const std::uint32_t crc = im2fit::crc32c(std::span(file).subspan(offset, size));
    std::memcpy(row + 32, &crc, sizeof crc);
  }
  const std::uint32_t crc = im2fit::crc32c(std::span(file).subspan(kHead, count * kRow));
  std::memcpy(file.data() + 24, &crc, sizeof crc);
  const std::uint64_t size = file.size();
  std::memcpy(file.data() + 16, &size, sizeof size);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  std::vector<std::byte> file(size);
  if (size > 0) std::memcpy(file.data(), data, size);
  mend(file);
  const auto site = SiteCalibration::parse(file, "site.i2c");
  if (!site) {
    if (site.error().message.empty()) __builtin_trap();
    return 0;
  }
  index::Answer answer;
  answer.measurements.fill({1000, 950, 1060});
  answer.female = 0.3F;
  site->for_camera(site->cameras.empty() ? "" : site->cameras.back().name).apply(answer);
  for (const index::IntervalEstimate& e : answer.measurements)
    if (!std::isfinite(e.value) || !(e.low <= e.value && e.value <= e.high) || e.value < 100) __builtin_trap();
  const auto again = site->file();
  if (!again || !SiteCalibration::parse(*again, "again")) __builtin_trap();
  return 0;
}
