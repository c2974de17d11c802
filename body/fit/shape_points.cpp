// SPDX-License-Identifier: Apache-2.0
#include "body/fit/shape_points.h"

#include <algorithm>

#include "body/model_data.h"
#include "body/shape_space.h"

namespace im2fit::body {
namespace {

Vec3f corner(std::span<const Vec3f> mesh, const Quad& quad, std::size_t i) {
  return mesh[static_cast<std::size_t>(quad[i])];
}

bool is_hand(std::uint8_t number) {
  const auto segment = static_cast<Segment>(number);
  return segment == Segment::left_hand || segment == Segment::right_hand;
}

// Vertices that a hand may move. Of most quads no corner is one: their weights need not be added up.
std::vector<std::uint8_t> vertices_of_hands(const BodyModel& model) {
  std::vector<std::uint8_t> of_hand(static_cast<std::size_t>(model.body_vertex_count()));
  for (std::size_t v = 0; v < of_hand.size(); ++v)
    for (const std::uint8_t segment : model.data().skin[v].segment)
      if (is_hand(segment)) of_hand[v] = 1;
  return of_hand;
}

struct QuadAreas {
  std::vector<Quad> quads;
  std::vector<double> area_before;
  double area = 0;
};
QuadAreas quad_areas(const BodyModel& model, std::span<const Vec3f> mesh) {
  QuadAreas all;
  all.quads.reserve(model.body_quads().size());
  all.area_before.reserve(model.body_quads().size());
  const std::vector<std::uint8_t> of_hand = vertices_of_hands(model);
  for (const Quad& quad : model.body_quads()) {
    bool any = false;
    for (const std::int32_t v : quad) any = any || of_hand[static_cast<std::size_t>(v)] != 0;
    if (any && is_hand(skin_of_quad(model, quad).segment[0])) continue;
    all.quads.push_back(quad);
    all.area_before.push_back(all.area);
    all.area += 0.5 * static_cast<double>(norm(cross(corner(mesh, quad, 2) - corner(mesh, quad, 0),
                                                     corner(mesh, quad, 3) - corner(mesh, quad, 1))));
  }
  return all;
}

// Calls visit(quad) in order with each quad that lies at one of `count` equal steps of area, until it returns false.
template <class F>
void for_each_at_equal_steps(const QuadAreas& all, std::size_t count, F visit) {
  std::size_t at = 0, before = all.quads.size();
  for (std::size_t i = 0; i < count; ++i) {
    const double wanted = all.area * (static_cast<double>(i) + 0.5) / static_cast<double>(count);
    while (at + 1 < all.quads.size() && all.area_before[at + 1] <= wanted) ++at;
    if (at != before && !visit(all.quads[at])) return;
    before = at;
  }
}

bool same(const SkinRecord& a, const SkinRecord& b) {
  for (std::size_t i = 0; i < 4; ++i)
    if (a.weight[i] != b.weight[i] || (a.weight[i] > 0 && a.segment[i] != b.segment[i])) return false;
  return true;
}

}  // namespace

SkinRecord skin_of_quad(const BodyModel& model, const Quad& quad) {
  std::array<float, kSegmentCount> sum{};
  for (const std::int32_t v : quad) {
    const SkinRecord& r = model.data().skin[static_cast<std::size_t>(v)];
    for (std::size_t i = 0; i < 4; ++i) sum[r.segment[i]] += 0.25F * r.weight[i];
  }
  SkinRecord out;
  float total = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto heaviest = std::max_element(sum.begin(), sum.end());
    out.segment[i] = static_cast<std::uint8_t>(heaviest - sum.begin());
    out.weight[i] = *heaviest;
    total += *heaviest;
    *heaviest = 0;
  }
  for (float& w : out.weight) w /= total;
  return out;
}

std::vector<Quad> quads_at_equal_area(const BodyModel& model, std::span<const Vec3f> mesh, std::size_t count) {
  std::vector<Quad> chosen;
  for_each_at_equal_steps(quad_areas(model, mesh), count, [&](const Quad& quad) {
    chosen.push_back(quad);
    return true;
  });
  return chosen;
}

// The file stores the number of points, not the number requested of quads_at_equal_area: the requested count is
// searched for. One of the first points rules out most wrong counts.
std::vector<Quad> quads_of_shape_space(const BodyModel& model) {
  const ShapeSpace& space = model.shape_space();
  if (space.point_count == 0) return {};
  std::vector<Vec3f> mesh(static_cast<std::size_t>(model.vertex_count()));
  model.morph({}, mesh);
  const QuadAreas all = quad_areas(model, mesh);
  std::vector<Quad> quads;
  quads.reserve(space.point_count);
  for (std::size_t count = space.point_count; count <= space.point_count + space.point_count / 4; ++count) {
    bool alike = true;
    quads.clear();
    for_each_at_equal_steps(all, count, [&](const Quad& quad) {
      alike = quads.size() < space.point_count && same(skin_of_quad(model, quad), space.skin[quads.size()]);
      if (alike) quads.push_back(quad);
      return alike;
    });
    if (alike && quads.size() == space.point_count) return quads;
  }
  return {};
}

}  // namespace im2fit::body
