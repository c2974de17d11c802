// SPDX-License-Identifier: Apache-2.0
#include "garment/drape/offset_wire.h"

#include <algorithm>
#include <cmath>

namespace im2fit::body {
namespace {

constexpr std::string_view kMagic = "im2c";
constexpr std::uint32_t kGarmentsMax = 16;
constexpr float kNumberMax = 127;

float step_of(int doublings) {
  return kOffsetStepMm * static_cast<float>(1 << doublings);
}

int doublings_for(std::span<const Vec3f> block) {
  float most = 0;
  for (const Vec3f& o : block) most = std::max({most, std::fabs(o.x), std::fabs(o.y), std::fabs(o.z)});
  int doublings = 0;
  while (doublings < kOffsetStepsMax && most > kNumberMax * step_of(doublings)) ++doublings;
  return doublings;
}

char in_steps(float value_mm, float step_mm) {
  const float steps = std::clamp(value_mm / step_mm, -kNumberMax, kNumberMax);
  return static_cast<char>(static_cast<std::int8_t>(static_cast<int>(steps < 0 ? steps - 0.5F : steps + 0.5F)));
}

void append_u32(std::uint32_t value, std::string& out) {
  for (unsigned shift = 0; shift < 32; shift += 8) out.push_back(static_cast<char>(value >> shift & 0xFFU));
}

// Takes bytes from the front; `whole` is false once there were too few.
struct Reader {
  std::string_view left;
  bool whole = true;

  std::string_view take(std::size_t count) {
    whole = whole && count <= left.size();
    if (!whole) return {};
    const std::string_view taken = left.substr(0, count);
    left.remove_prefix(count);
    return taken;
  }
  std::uint32_t u32() {
    std::uint32_t value = 0;
    unsigned shift = 0;
    for (const char c : take(4)) {
      value |= static_cast<std::uint32_t>(static_cast<unsigned char>(c)) << shift;
      shift += 8;
    }
    return value;
  }
};

Error damaged(const char* what) {
  return Error{ErrorCode::invalid_argument, std::string("offsets of cloth: ") + what};
}

}  // namespace

float offset_step_mm(std::span<const Vec3f> block) {
  return step_of(doublings_for(block));
}

void append_offsets(std::span<const Vec3f> offsets, std::string& out) {
  for (std::size_t first = 0; first < offsets.size(); first += kOffsetBlock) {
    const auto block = offsets.subspan(first, std::min(kOffsetBlock, offsets.size() - first));
    const int doublings = doublings_for(block);
    const float step = step_of(doublings);
    out.push_back(static_cast<char>(doublings));
    for (const Vec3f& o : block)
      for (const float value : {o.x, o.y, o.z}) out.push_back(in_steps(value, step));
  }
}

std::string cloth_message(std::uint32_t number, std::span<const std::span<const Vec3f>> garments) {
  std::size_t size = kMagic.size() + 8;
  for (const auto& offsets : garments) size += 4 + offset_bytes(offsets.size());
  std::string out(kMagic);
  out.reserve(size);
  append_u32(number, out);
  append_u32(static_cast<std::uint32_t>(garments.size()), out);
  for (const auto& offsets : garments) {
    append_u32(static_cast<std::uint32_t>(offsets.size()), out);
    append_offsets(offsets, out);
  }
  return out;
}

Result<ClothMessage> read_cloth_message(std::string_view bytes) {
  Reader reader{bytes};
  if (reader.take(kMagic.size()) != kMagic) return damaged("begins otherwise");
  ClothMessage message;
  message.number = reader.u32();
  const std::uint32_t garments = reader.u32();
  if (garments > kGarmentsMax) return damaged("too many garments");
  for (std::uint32_t g = 0; g < garments && reader.whole; ++g) {
    const std::size_t count = reader.u32();
    if (count > reader.left.size()) return damaged("too short");  // before anything of that size is made
    std::vector<Vec3f>& offsets = message.garments.emplace_back();
    while (reader.whole && offsets.size() < count) {
      const std::string_view head = reader.take(1);
      const int doublings = head.empty() ? 0 : static_cast<unsigned char>(head[0]);
      if (doublings > kOffsetStepsMax) return damaged("an invalid step");
      const float step = step_of(doublings);
      const std::string_view block = reader.take(3 * std::min(kOffsetBlock, count - offsets.size()));
      const auto number = [&](std::size_t i) {
        return step * static_cast<float>(static_cast<std::int8_t>(block[i]));
      };
      for (std::size_t i = 0; i < block.size(); i += 3) offsets.push_back({number(i), number(i + 1), number(i + 2)});
    }
  }
  if (!reader.whole) return damaged("too short");
  if (!reader.left.empty()) return damaged("bytes are left over");
  return message;
}

}  // namespace im2fit::body
