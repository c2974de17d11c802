// SPDX-License-Identifier: Apache-2.0
#include "capi/frame.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include "hal/depth16.h"
#include "hal/source.h"

namespace im2fit::c {
namespace {

constexpr float kUnitMaxMm = 1000.0F;
constexpr std::size_t kRowBytesMax = std::size_t{1} << 20;  // 2048 samples of 4 bytes are 8 KiB: this is a mistake
constexpr float kDepthMaxMm = 65535.0F;                     // of 16 bits
constexpr float kMmPerMetre = 1000.0F;
// Limits of the length of a down vector, in g, m/s2 or cm/s2: values outside are not an acceleration.
constexpr float kDownMin = 0.01F, kDownMax = 1.0e5F;
constexpr float kUnitTolerance = 0.01F;  // of platforms' quaternions; they are made units
constexpr float kPlaceMaxMm = 1.0e6F;    // floats count tenths of a millimetre up to there

Error wrong(const char* field, const std::string& found, const std::string& expected) {
  return {ErrorCode::invalid_argument, std::string("frame.") + field + " is " + found + ", expected " + expected};
}

std::size_t sample_bytes(std::int32_t format) {
  return format == IM2FIT_FORMAT_F32 ? sizeof(float) : sizeof(std::uint16_t);
}

// Rounded to the nearest; invalid distances and those too far for 16 bits become 0, missing.
std::uint16_t to_mm(float mm) {
  if (!(mm > 0 && mm <= kDepthMaxMm)) return 0;
  return static_cast<std::uint16_t>(std::min(mm + 0.5F, kDepthMaxMm));
}

Status check_rows(const im2fit_frame& f) {
  const std::size_t sample = sample_bytes(f.format), packed = static_cast<std::size_t>(f.width) * sample;
  if (f.row_bytes != 0 && (f.row_bytes < packed || f.row_bytes > kRowBytesMax || f.row_bytes % sample != 0))
    return wrong("row_bytes", std::to_string(f.row_bytes),
                 "0, or a multiple of " + std::to_string(sample) + " from " + std::to_string(packed) + " to " +
                     std::to_string(kRowBytesMax));
  const std::size_t width = static_cast<std::size_t>(f.width);
  if (f.confidence_row_bytes != 0 && (f.confidence_row_bytes < width || f.confidence_row_bytes > kRowBytesMax))
    return wrong("confidence_row_bytes", std::to_string(f.confidence_row_bytes),
                 "0, or " + std::to_string(width) + " to " + std::to_string(kRowBytesMax));
  return Ok{};
}

float turn_length(const im2fit_frame& f) {
  return std::sqrt(f.turn_x * f.turn_x + f.turn_y * f.turn_y + f.turn_z * f.turn_z + f.turn_w * f.turn_w);
}

Status check_pose(const im2fit_frame& f) {
  const float length = turn_length(f);
  const bool told = f.turn_x != 0 || f.turn_y != 0 || f.turn_z != 0 || f.turn_w != 0;
  if (told && !(length > 1 - kUnitTolerance && length < 1 + kUnitTolerance))
    return wrong("turn_x, turn_y, turn_z, turn_w", "of length " + std::to_string(length),
                 "a unit quaternion, or all 0");
  for (const float place : {f.x_mm, f.y_mm, f.z_mm}) {
    if (!(std::abs(place) <= kPlaceMaxMm))
      return wrong("x_mm, y_mm, z_mm", std::to_string(place), "a place up to a kilometre away");
    if (!told && place != 0) return wrong("x_mm, y_mm, z_mm", "set", "0 without turn_x, turn_y, turn_z, turn_w");
  }
  return Ok{};
}

Status check_frame(const im2fit_frame& f, const Intrinsics& upright) {
  if (f.pixels == nullptr) return wrong("pixels", "NULL", "the samples");
  if (f.format < IM2FIT_FORMAT_U16 || f.format > IM2FIT_FORMAT_F32)
    return wrong("format", std::to_string(f.format), "one of IM2FIT_FORMAT_...");
  if (reinterpret_cast<std::uintptr_t>(f.pixels) % sample_bytes(f.format) != 0)
    return wrong("pixels", "an odd address", "one aligned to samples");
  if (!hal::is_rotation(f.rotate_deg)) return wrong("rotate_deg", std::to_string(f.rotate_deg), "0, 90, 180 or 270");
  const bool quarter = f.rotate_deg % 180 != 0;
  const int width = quarter ? upright.height : upright.width, height = quarter ? upright.width : upright.height;
  if (f.width != width || f.height != height)
    return Error{ErrorCode::invalid_argument, "frame is " + std::to_string(f.width) + "x" + std::to_string(f.height) +
                                                  " with rotate_deg " + std::to_string(f.rotate_deg) +
                                                  ", the handle was opened for " + std::to_string(width) + "x" +
                                                  std::to_string(height)};
  if (auto ok = check_rows(f); !ok) return ok;
  if (f.format == IM2FIT_FORMAT_U16 && !(f.unit_mm > 0 && f.unit_mm <= kUnitMaxMm))
    return wrong("unit_mm", std::to_string(f.unit_mm), "above 0 to 1000");
  const int sure = f.format == IM2FIT_FORMAT_DEPTH16 ? hal::kDepth16SureSevenths : 255;
  if (f.confidence_min < 0 || f.confidence_min > sure)
    return wrong("confidence_min", std::to_string(f.confidence_min), "0 to " + std::to_string(sure));
  if (f.format == IM2FIT_FORMAT_DEPTH16 && f.confidence != nullptr)
    return wrong("confidence", "set", "NULL: samples of DEPTH16 have their own");
  if (f.reserved != 0) return wrong("reserved", "set", "0");
  if (f.reserved2 != 0) return wrong("reserved2", "set", "0");
  for (const float k : {f.k1, f.k2, f.k3, f.p1, f.p2})
    if (!std::isfinite(k)) return wrong("k1, k2, k3, p1, p2", "no number", "the lens's coefficients, or all 0");
  if (f.reserved3 != 0) return wrong("reserved3", "set", "0");
  if (auto ok = check_pose(f); !ok) return ok;
  const float down = norm({f.down_x, f.down_y, f.down_z});
  if (!(down < kDownMax) || (down != 0 && down < kDownMin))
    return wrong("down_x, down_y, down_z", "of length " + std::to_string(down), "a direction, or all 0");
  return Ok{};
}

void read_row(const im2fit_frame& f, const std::byte* from, std::uint16_t* mm) {
  const std::size_t count = static_cast<std::size_t>(f.width);
  if (f.format == IM2FIT_FORMAT_F32) {
    const auto* metres = reinterpret_cast<const float*>(from);
    for (std::size_t i = 0; i < count; ++i) mm[i] = to_mm(metres[i] * kMmPerMetre);
    return;
  }
  const auto* samples = reinterpret_cast<const std::uint16_t*>(from);
  if (f.format == IM2FIT_FORMAT_DEPTH16)
    hal::depth16_to_mm(samples, count, f.confidence_min, mm);
  else if (f.unit_mm == 1.0F)
    std::memcpy(mm, samples, count * sizeof *mm);
  else
    for (std::size_t i = 0; i < count; ++i) mm[i] = to_mm(static_cast<float>(samples[i]) * f.unit_mm);
}

void read_samples(const im2fit_frame& f, DepthImage mm) {
  const std::size_t width = static_cast<std::size_t>(f.width);
  const std::size_t row_bytes = f.row_bytes != 0 ? f.row_bytes : width * sample_bytes(f.format);
  const std::size_t sure_bytes = f.confidence_row_bytes != 0 ? f.confidence_row_bytes : width;
  for (int v = 0; v < f.height; ++v) {
    std::uint16_t* row = mm.row(v);
    read_row(f, static_cast<const std::byte*>(f.pixels) + static_cast<std::size_t>(v) * row_bytes, row);
    if (f.confidence == nullptr) continue;
    const std::uint8_t* sure = f.confidence + static_cast<std::size_t>(v) * sure_bytes;
    for (std::size_t u = 0; u < width; ++u)
      if (sure[u] < f.confidence_min) row[u] = 0;
  }
}

// A pinhole's ray (x, y, 1).
struct Ray {
  double x = 0, y = 0;
};
// Of a pixel of the upright picture, in the axes of the frame as delivered. In double, as hal::undistortion_table():
// a folder that names its lens gives the same bits.
Ray delivered_ray(const Intrinsics& upright, int u, int v, int rotate_deg) {
  const double x = (u - static_cast<double>(upright.cx)) / static_cast<double>(upright.fx);
  const double y = (v - static_cast<double>(upright.cy)) / static_cast<double>(upright.fy);
  switch (rotate_deg) {
    case 90:
      return {y, -x};
    case 180:
      return {-x, -y};
    case 270:
      return {-y, x};
    default:
      return {x, y};
  }
}

// What turns an upright picture back into the camera's.
int back_from(int rotate_deg) {
  return (360 - rotate_deg) % 360;
}

bool same(const Intrinsics& a, const Intrinsics& b) {
  return a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy;
}

// Where along one axis a sample of the session's picture lies in the frame's: the ray is the same, the lens is not.
void map_axis(std::span<std::int32_t> map, float session_f, float session_c, float frame_f, float frame_c) {
  for (std::size_t i = 0; i < map.size(); ++i) {
    const float ray = (static_cast<float>(i) - session_c) / session_f;
    const float at = std::floor(frame_c + frame_f * ray + 0.5F);
    map[i] = at >= 0 && at < static_cast<float>(map.size()) ? static_cast<std::int32_t>(at) : -1;
  }
}

}  // namespace

bool FrameReader::Lens::same_as(const Lens& other) const {
  return same(camera, other.camera) && same(session, other.session) && rotate_deg == other.rotate_deg &&
         distortion.coefficients == other.distortion.coefficients;
}

void FrameReader::prepare(const Intrinsics& upright) {
  settings_ = session_ = upright;
  const std::size_t width = static_cast<std::size_t>(upright.width),
                    height = static_cast<std::size_t>(upright.height);
  for (auto* pixels : {&camera_, &upright_}) *pixels = LazyZeros<std::uint16_t>(width * height);
  columns_.resize(width);
  rows_.resize(height);
}

Status FrameReader::take_intrinsics(Engine& engine, const im2fit_frame& f) {
  resample_ = false;
  const bool tells = f.fx != 0 || f.fy != 0 || f.cx != 0 || f.cy != 0;
  Intrinsics seen = settings_;
  if (tells) {
    const Intrinsics camera{f.width, f.height, f.fx, f.fy, f.cx, f.cy};
    if (auto ok = hal::check_intrinsics(camera, "frame"); !ok) return ok;
    seen = hal::rotate_upright(camera, f.rotate_deg);
  }
  if (!told_) {
    if (!same(seen, session_))
      if (auto ok = engine.use_intrinsics(seen); !ok) return ok;
    session_ = seen;
    told_ = true;
  }
  if (same(seen, session_)) return Ok{};
  map_axis(columns_, session_.fx, session_.cx, seen.fx, seen.cx);
  map_axis(rows_, session_.fy, session_.cy, seen.fy, seen.cy);
  resample_ = true;
  return Ok{};
}

Status FrameReader::push(Engine& engine, const im2fit_frame& f) {
  if (auto ok = check_frame(f, settings_); !ok) return ok;
  if (auto ok = take_intrinsics(engine, f); !ok) return ok;
  if (auto ok = take_lens(f); !ok) return ok;
  take_pose(f);
  const auto place = engine.acquire();
  if (!place) return place.error();
  if (undistort_) {
    read_samples(f, DepthImage(camera_.data(), f.width, f.height));
    undistort(*place);
    return commit(engine, *place, f);
  }
  const DepthImage upright = resample_ ? DepthImage(upright_.data(), settings_.width, settings_.height) : *place;
  if (f.rotate_deg == 0) {
    read_samples(f, upright);
  } else {
    const DepthImage camera(camera_.data(), f.width, f.height);
    read_samples(f, camera);
    hal::rotate_upright(camera, f.rotate_deg, upright);
  }
  if (resample_) resample(upright, *place);
  return commit(engine, *place, f);
}

void FrameReader::take_pose(const im2fit_frame& f) {
  const float length = turn_length(f);
  posed_ = length > 0;
  if (!posed_) return;
  if (!steady_) {
    steady_.emplace();
    steady_->prepare(settings_.width, settings_.height);
  }
  const hal::CameraPose delivered{
      f.turn_x / length, f.turn_y / length, f.turn_z / length, f.turn_w / length, {f.x_mm, f.y_mm, f.z_mm}};
  moves_ = steady_->take(hal::rotate_upright(delivered, f.rotate_deg));
}

Status FrameReader::commit(Engine& engine, DepthImage place, const im2fit_frame& f) {
  if (posed_ && moves_) steady_->run(session_, place);
  hal::FrameInfo info;
  info.sequence = f.sequence;
  info.host_ns = f.time_ns;
  info.device_us = f.device_us;
  const Vec3f down = {f.down_x, f.down_y, f.down_z};
  if (norm(down) > 0) {
    const Vec3f upright = hal::rotate_upright(normalized(down), f.rotate_deg);
    info.down = posed_ ? steady_->in_view(upright) : upright;
  }
  return engine.commit(info);
}

Status FrameReader::take_lens(const im2fit_frame& f) {
  hal::Distortion distortion;
  distortion.coefficients = {double{f.k1}, double{f.k2}, double{f.p1}, double{f.p2}, double{f.k3}};
  undistort_ = distortion.any();
  if (!undistort_) return Ok{};
  const bool tells = f.fx != 0 || f.fy != 0 || f.cx != 0 || f.cy != 0;
  const Intrinsics camera = tells ? Intrinsics{f.width, f.height, f.fx, f.fy, f.cx, f.cy}
                                  : hal::rotate_upright(settings_, back_from(f.rotate_deg));
  const Lens lens{camera, session_, f.rotate_deg, distortion};
  if (!table_.empty() && lens.same_as(lens_)) return Ok{};
  table_.resize(camera_.size());
  lens_ = lens;
  std::size_t seen_count = 0;
  for (int v = 0; v < session_.height; ++v)
    for (int u = 0; u < session_.width; ++u) {
      const Ray ray = delivered_ray(session_, u, v, f.rotate_deg);
      const std::int32_t from = hal::pixel_at(camera, hal::seen_at(camera, distortion, ray.x, ray.y));
      table_[static_cast<std::size_t>(v) * static_cast<std::size_t>(session_.width) + static_cast<std::size_t>(u)] =
          from;
      seen_count += from >= 0 ? 1 : 0;
    }
  auto enough = hal::check_seen(seen_count, table_.size(), "frame.k1, k2, k3, p1, p2");
  if (!enough) table_.clear();
  return enough;
}

void FrameReader::undistort(DepthImage to) const {
  const std::int32_t* from = table_.data();
  for (int v = 0; v < to.height; ++v)
    for (int u = 0; u < to.width; ++u, ++from)
      to.at(u, v) = *from < 0 ? std::uint16_t{0} : camera_[static_cast<std::size_t>(*from)];
}

void FrameReader::resample(DepthView from, DepthImage to) const {
  for (int v = 0; v < to.height; ++v) {
    const std::int32_t row = rows_[static_cast<std::size_t>(v)];
    for (int u = 0; u < to.width; ++u) {
      const std::int32_t column = columns_[static_cast<std::size_t>(u)];
      to.at(u, v) = row < 0 || column < 0 ? std::uint16_t{0} : from.at(column, row);
    }
  }
}

}  // namespace im2fit::c
