// SPDX-License-Identifier: Apache-2.0
#include "hal/intrinsics.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

namespace im2fit::hal {
namespace {

template <class Number>
std::string number(Number value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value);  // the shortest text that names this value exactly
  return {text, end.ptr};
}

std::string distortion_text(const Distortion& distortion) {
  const auto& c = distortion.coefficients;
  const bool rational = c[5] != 0 || c[6] != 0 || c[7] != 0;
  const std::size_t count = rational ? 8 : 5;
  std::string text = std::string("distortion_model: ") + (rational ? "rational_polynomial" : "plumb_bob") + "\n";
  text.append("distortion_coefficients:\n  rows: 1\n  cols: ").append(std::to_string(count)).append("\n  data: [");
  for (std::size_t i = 0; i < count; ++i) text += (i > 0 ? ", " : "") + number(c[i]);
  return text + "]\n";
}

Error off(const std::string& what, const std::string& field, const std::string& found, const std::string& expected) {
  return {ErrorCode::invalid_argument, what + ": " + field + " is " + found + ", expected " + expected +
                                           "; calibrate the camera again or correct the value"};
}

}  // namespace

std::string_view to_string(IntrinsicsOrigin origin) {
  switch (origin) {
    case IntrinsicsOrigin::device:
      return "device";
    case IntrinsicsOrigin::calibration_file:
      return "calibration_file";
    case IntrinsicsOrigin::recording:
      return "recording";
    case IntrinsicsOrigin::field_of_view:
      return "field_of_view";
    case IntrinsicsOrigin::caller:
      return "caller";
    case IntrinsicsOrigin::synthetic:
      return "synthetic";
  }
  return "unknown";
}

std::optional<IntrinsicsOrigin> parse_origin(std::string_view text) {
  for (const auto origin : {IntrinsicsOrigin::device, IntrinsicsOrigin::calibration_file, IntrinsicsOrigin::recording,
                            IntrinsicsOrigin::field_of_view, IntrinsicsOrigin::caller, IntrinsicsOrigin::synthetic})
    if (text == to_string(origin)) return origin;
  return std::nullopt;
}

float widest_field_deg(const Intrinsics& k) {
  constexpr float kRadToDeg = 57.29578F;
  const FieldOfView field = field_of_view(k);
  return std::max(field.horizontal_rad, field.vertical_rad) * kRadToDeg;
}

LensFault lens_fault(const Intrinsics& k) {
  const float widest_deg = widest_field_deg(k);
  if (!(widest_deg >= kFieldMinDeg && widest_deg <= kFieldMaxDeg)) return LensFault::field_of_view;
  const float w = static_cast<float>(k.width), h = static_cast<float>(k.height);
  const auto off = [](float c, float side) { return std::abs(c + 0.5F - 0.5F * side); };
  if (k.width != k.height && off(k.cx, h) < off(k.cx, w) && off(k.cy, w) < off(k.cy, h))
    return LensFault::centre_turned;
  // Values of a picture of twice the size lie at a quarter of both sides, to half a pixel or so. Who crops a picture
  // moves one of them, as a rule.
  constexpr float kCentreOffMax = 0.24F;
  if (off(k.cx, w) > kCentreOffMax * w && off(k.cy, h) > kCentreOffMax * h) return LensFault::centre_elsewhere;
  return LensFault::none;
}

Status check_intrinsics(const Intrinsics& k, const std::string& what) {
  if (k.width < 1 || k.height < 1 || k.width > kImageSideMax || k.height > kImageSideMax)
    return Error{ErrorCode::invalid_argument,
                 what + ": the picture's size is " + std::to_string(k.width) + "x" + std::to_string(k.height) +
                     ", expected 1 to " + std::to_string(kImageSideMax) +
                     " pixels a side; halve larger pictures, and the camera's values with them"};
  const float longer = static_cast<float>(k.width > k.height ? k.width : k.height);
  // Fields of view between about 5 and 136 degrees: a wider one is not a pinhole camera's, a narrower sees no person.
  const float focal_min = 0.2F * longer;
  const float focal_max = 10.0F * longer;
  struct {
    const char* name;
    float value;
    float low;
    float high;
  } const fields[] = {{"the focal length fx", k.fx, focal_min, focal_max},
                      {"the focal length fy", k.fy, focal_min, focal_max},
                      {"the principal point cx", k.cx, 0, static_cast<float>(k.width)},
                      {"the principal point cy", k.cy, 0, static_cast<float>(k.height)}};
  for (const auto& field : fields) {
    if (!std::isfinite(field.value) || field.value < field.low || field.value > field.high)
      return off(what, field.name, number(field.value), number(field.low) + " to " + number(field.high) + " pixels");
  }
  const float ratio = k.fx / k.fy;
  if (ratio < 0.5F || ratio > 2.0F) return off(what, "the ratio fx / fy", number(ratio), "0.5 to 2");
  return Ok{};
}

Result<Intrinsics> intrinsics_from_field_of_view(int width, int height, float horizontal_rad, float vertical_rad,
                                                 const std::string& what) {
  constexpr float kFieldMax_rad = 2.5F;
  for (const float angle : {horizontal_rad, vertical_rad}) {
    if (!std::isfinite(angle) || angle <= 0.05F || angle >= kFieldMax_rad)
      return off(what, "the field of view", number(angle), "0.05 to 2.5 radians");
  }
  const auto focal = [](int side, float angle) {
    return static_cast<float>(0.5 * side / std::tan(0.5 * static_cast<double>(angle)));
  };
  const Intrinsics k{width,
                     height,
                     focal(width, horizontal_rad),
                     focal(height, vertical_rad),
                     0.5F * static_cast<float>(width - 1),
                     0.5F * static_cast<float>(height - 1)};
  if (auto ok = check_intrinsics(k, what); !ok) return ok.error();
  return k;
}

FieldOfView field_of_view(const Intrinsics& k) {
  const auto angle = [](int side, float focal) {
    return static_cast<float>(2.0 * std::atan2(0.5 * side, static_cast<double>(focal)));
  };
  return {angle(k.width, k.fx), angle(k.height, k.fy)};
}

std::string camera_yaml_text(const Calibration& calibration, const std::string& camera_name) {
  const Intrinsics& k = calibration.intrinsics;
  std::string name;
  for (const char c : camera_name)  // YAML's plain scalars stay plain whatever the device calls itself
    name += (c >= ' ' && c != '"' && c != '\\' && c != 0x7F) ? c : ' ';
  const std::string fx = number(k.fx), fy = number(k.fy), cx = number(k.cx), cy = number(k.cy);
  std::string text;
  text += "image_width: " + std::to_string(k.width) + "\n";
  text += "image_height: " + std::to_string(k.height) + "\n";
  text += "camera_name: \"" + name + "\"\n";
  text += "camera_matrix:\n  rows: 3\n  cols: 3\n";
  text += "  data: [" + fx + ", 0, " + cx + ", 0, " + fy + ", " + cy + ", 0, 0, 1]\n";
  text += distortion_text(calibration.distortion);
  text += "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
  text += "projection_matrix:\n  rows: 3\n  cols: 4\n";
  text += "  data: [" + fx + ", 0, " + cx + ", 0, 0, " + fy + ", " + cy + ", 0, 0, 0, 1, 0]\n";
  text += "im2fit_rotate_deg: " + std::to_string(calibration.rotate_deg.value_or(0)) + "\n";
  text += "im2fit_intrinsics_origin: " + std::string(to_string(calibration.origin)) + "\n";
  return text;
}

}  // namespace im2fit::hal
