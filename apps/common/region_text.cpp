// SPDX-License-Identifier: Apache-2.0
#include "apps/common/region_text.h"

#include <array>
#include <charconv>

namespace im2fit::apps {
namespace {

constexpr float kMmPerMetre = 1000.0F;

}  // namespace

std::optional<FloorRegion> region_of(const std::string& text) {
  std::array<float, 4> mm{};
  const char *from = text.data(), *end = text.data() + text.size();
  for (std::size_t i = 0; i < mm.size(); ++i) {
    while (from != end && *from == ' ') ++from;
    float metres = 0;
    const auto [stop, error] = std::from_chars(from, end, metres);
    const bool last = i + 1 == mm.size();
    if (error != std::errc() || (last ? stop != end : stop == end || *stop != ',')) return std::nullopt;
    mm[i] = metres * kMmPerMetre;
    from = last ? stop : stop + 1;
  }
  const FloorRegion region = {mm[0], mm[1], mm[2], mm[3]};
  return is_region(region) ? std::optional(region) : std::nullopt;
}

std::string region_fault(const std::string& text) {
  return region_of(text) ? std::string()
                         : "'" + text +
                               "' is not a region: expected x0,z0,x1,z1 in metres with x0 < x1 and z0 < z1, such as "
                               "-0.6,1.5,0.6,3";
}

}  // namespace im2fit::apps
