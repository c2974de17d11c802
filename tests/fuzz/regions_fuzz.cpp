// SPDX-License-Identifier: Apache-2.0
// The file of kept regions as anyone may write it, and a region's own text: refused with one line, or a rectangle.
#include <cstdint>
#include <string>
#include <string_view>

#include "apps/common/region_text.h"
#include "apps/kiosk/regions_text.h"
#include "core/floor_region.h"

namespace {

void use(const std::string& text) {
  using namespace im2fit;
  const auto region = apps::region_of(text);
  if (region.has_value() != apps::region_fault(text).empty()) __builtin_trap();
  if (region && (!is_region(*region) || !region->holds(region->x0_mm, region->z1_mm))) __builtin_trap();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace im2fit;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  use(std::string(text));
  for (const char* camera : {"", "a", "Kinect"}) {
    const auto region = apps::region_in(text, "regions", camera);
    if (!region && (region.error().message.empty() || region.error().message.find('\n') != std::string::npos))
      __builtin_trap();
    if (region && !region->empty()) {
      if (!apps::region_of(*region)) __builtin_trap();
      use(*region);
    }
  }
  return 0;
}
