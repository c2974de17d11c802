// SPDX-License-Identifier: Apache-2.0
#include "body/export/figure.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace im2fit::body {
namespace {

float lowest_y(std::span<const Vec3f> vertices) {
  float low = vertices[0].y;
  for (const Vec3f& v : vertices) low = v.y < low ? v.y : low;
  return low;
}

}  // namespace

Result<Figure> make_figure(const Avatar& avatar) {
  if (avatar.model == nullptr) return Error{ErrorCode::invalid_argument, "avatar without a body model: load a .i2b"};
  const BodyModel& model = *avatar.model;
  const auto body = static_cast<std::size_t>(model.body_vertex_count());
  Figure f;
  f.rest.resize(static_cast<std::size_t>(model.vertex_count()));
  f.posed.resize(f.rest.size());
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

void append_number(std::string& out, double value, int decimals) {
  std::array<char, 64> text{};
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals);
  if (error == std::errc()) out.append(text.data(), end);
}

}  // namespace im2fit::body
