// SPDX-License-Identifier: Apache-2.0
#include "body/export/figure.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

namespace im2fit::body {
namespace {

float lowest_y(std::span<const Vec3f> vertices) {
  float low = vertices[0].y;
  for (const Vec3f& v : vertices) low = v.y < low ? v.y : low;
  return low;
}

}  // namespace

Result<Figure> make_figure(const Avatar& avatar, std::span<const Vec3f> rest) {
  if (avatar.model == nullptr) return Error{ErrorCode::invalid_argument, "avatar without a body model: load a .i2b"};
  const BodyModel& model = *avatar.model;
  const auto body = static_cast<std::size_t>(model.body_vertex_count());
  Figure f;
  f.rest.resize(static_cast<std::size_t>(model.vertex_count()));
  f.posed.resize(f.rest.size());
  if (rest.size() == f.rest.size())
    std::copy(rest.begin(), rest.end(), f.rest.begin());
  else
    model.morph(avatar.params, f.rest);
  f.skeleton = rest_skeleton(model, f.rest);
  f.pose = avatar.pose;
  skin(model, f.rest, f.skeleton, f.pose, f.posed);
  f.floor_rest = lowest_y(std::span(f.rest).first(body));
  f.pose.translation_mm.y -= lowest_y(std::span(f.posed).first(body));
  skin(model, f.rest, f.skeleton, f.pose, f.posed);
  return f;
}

Mat3f local_rotation(const Pose& pose, std::size_t segment) {
  const int parent = kSegmentParent[segment];
  return parent < 0 ? pose.rotation[segment]
                    : transpose(pose.rotation[static_cast<std::size_t>(parent)]) * pose.rotation[segment];
}

// What fits 15 digits is written as a whole number's, which is four times as quick.
void append_number(std::string& out, double value, int decimals) {
  constexpr double kWholeMax = 1e15;
  constexpr std::array<double, 8> kTens = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7};
  std::array<char, 64> text{};
  const auto places = static_cast<std::size_t>(std::max(decimals, 0));
  const double scaled = places < kTens.size() ? std::fabs(value) * kTens[places] : kWholeMax;
  if (!(scaled < kWholeMax)) {
    const auto [end, error] =
        std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals);
    if (error == std::errc()) out.append(text.data(), end);
    return;
  }
  auto whole = static_cast<std::uint64_t>(scaled + 0.5);
  char* const end = text.data() + text.size();
  char* at = end;
  const auto put_digit = [&] {
    *--at = static_cast<char>('0' + whole % 10);
    whole /= 10;
  };
  for (std::size_t i = 0; i < places; ++i) put_digit();
  if (places > 0) *--at = '.';
  do {
    put_digit();
  } while (whole > 0);
  if (std::signbit(value)) *--at = '-';
  out.append(at, end);
}

}  // namespace im2fit::body
