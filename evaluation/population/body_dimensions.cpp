// SPDX-License-Identifier: Apache-2.0
#include "evaluation/population/body_dimensions.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "body/measure.h"
#include "body/model_data.h"
#include "body/section.h"

namespace im2fit::lab {
namespace {

using body::Landmark;
using body::Segment;
using body::Triangle;

constexpr float kExtremeMm = 6;            // points that near to the outermost share what pulls at a breadth
constexpr float kRearmostMm = 2;           // the same for the height of the rearmost point
constexpr float kHeadSectionMm = 75;       // below the crown: above the ears, where heads are widest
constexpr float kThighBelowCrotchMm = 35;  // where buttock and thigh join
constexpr float kNeckReachMm = 120;
constexpr float kDeltoidShare = 0.2F;  // of the upper arm
constexpr float kArmOutShare = 0.2F;   // sine of a hanging arm's abduction, 12 degrees

constexpr std::size_t at(Segment s) {
  return static_cast<std::size_t>(s);
}

// A point of a section: between two vertices.
struct Cut {
  float u = 0, v = 0;
  std::int32_t a = 0, b = 0;
  float t = 0;
};

struct Outline {
  body::SectionPlane plane;
  std::vector<Cut> hull;  // counter-clockwise in (u, v)
};

double turn(const Cut& o, const Cut& a, const Cut& b) {
  return (static_cast<double>(a.u) - o.u) * (static_cast<double>(b.v) - o.v) -
         (static_cast<double>(a.v) - o.v) * (static_cast<double>(b.u) - o.u);
}

// Andrew's monotone chain, as in body/section.cpp, on points that remember their edge.
std::vector<Cut> hull_of(std::vector<Cut> points) {
  std::sort(points.begin(), points.end(),
            [](const Cut& a, const Cut& b) { return a.u != b.u ? a.u < b.u : a.v < b.v; });
  points.erase(
      std::unique(points.begin(), points.end(), [](const Cut& a, const Cut& b) { return a.u == b.u && a.v == b.v; }),
      points.end());
  if (points.size() < 3) return {};
  std::vector<Cut> hull(2 * points.size());
  std::size_t size = 0;
  for (const Cut& p : points) {
    while (size >= 2 && turn(hull[size - 2], hull[size - 1], p) <= 0) --size;
    hull[size++] = p;
  }
  const std::size_t lower = size + 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) {
    while (size >= lower && turn(hull[size - 2], hull[size - 1], points[i]) <= 0) --size;
    hull[size++] = points[i];
  }
  hull.resize(size - 1);
  return hull;
}

Outline cut(std::span<const Vec3f> mesh, std::span<const Triangle> triangles, const body::SectionPlane& plane) {
  std::vector<Cut> points;
  for (const Triangle& t : triangles) {
    std::array<float, 3> height{};
    for (std::size_t i = 0; i < 3; ++i)
      height[i] = dot(mesh[static_cast<std::size_t>(t[i])] - plane.origin, plane.normal);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      if ((height[i] > 0) == (height[j] > 0)) continue;
      const float share = height[i] / (height[i] - height[j]);
      const Vec3f a = mesh[static_cast<std::size_t>(t[i])], b = mesh[static_cast<std::size_t>(t[j])];
      const Vec3f p = a + (b - a) * share - plane.origin;
      points.push_back({dot(p, plane.u), dot(p, plane.v), t[i], t[j], share});
    }
  }
  return {plane, hull_of(std::move(points))};
}

void pull_point(const Cut& p, Vec3f gradient, PullRow& row) {
  row.push_back({p.a, gradient * (1 - p.t)});
  row.push_back({p.b, gradient * p.t});
}

double girth(const Outline& o, float weight, PullRow* row) {
  double sum = 0;
  const std::size_t n = o.hull.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Cut& p = o.hull[i];
    const Cut& next = o.hull[(i + 1) % n];
    const Cut& last = o.hull[(i + n - 1) % n];
    const auto to_next = std::hypot(p.u - next.u, p.v - next.v), to_last = std::hypot(p.u - last.u, p.v - last.v);
    sum += static_cast<double>(to_next);
    if (row == nullptr || to_next <= 0 || to_last <= 0) continue;
    const float gu = (p.u - next.u) / to_next + (p.u - last.u) / to_last;
    const float gv = (p.v - next.v) / to_next + (p.v - last.v) / to_last;
    pull_point(p, (o.plane.u * gu + o.plane.v * gv) * weight, *row);
  }
  return weight * sum;
}

// Where the outline reaches farthest along (u, v): how far, and the weighted points there.
struct Extreme {
  double reach = 0;
  std::vector<std::pair<const Cut*, float>> points;
};
Extreme extreme(const Outline& o, float u, float v) {
  Extreme e;
  float most = -1e9F;
  for (const Cut& p : o.hull) most = std::max(most, p.u * u + p.v * v);
  e.reach = static_cast<double>(most);
  float sum = 0;
  for (const Cut& p : o.hull) {
    const float behind = most - (p.u * u + p.v * v);
    if (behind > 4 * kExtremeMm) continue;
    e.points.emplace_back(&p, std::exp(-behind / kExtremeMm));
    sum += e.points.back().second;
  }
  for (auto& [p, w] : e.points) w /= sum;
  return e;
}
void pull_extreme(const Extreme& e, Vec3f gradient, PullRow* row) {
  if (row == nullptr) return;
  for (const auto& [p, w] : e.points) pull_point(*p, gradient * w, *row);
}

}  // namespace

struct BodyDimensions::State {
  explicit State(DimensionSurface of) : surface(std::move(of)) {}
  DimensionSurface surface;
  std::vector<Triangle> trunk, neck, head;
  std::array<std::vector<Triangle>, 2> thigh, shank, upper_arm, forearm;  // left, right
  std::array<std::vector<std::int32_t>, 2> hand, foot;                    // vertices
  std::array<std::int32_t, 2> ear{};
  std::vector<std::int32_t> seat;  // where the rearmost point may be
  float neck_share = 0.5F, calf_share = 0.3F, ankle_share = 0.9F, upper_arm_share = 0.5F, forearm_share = 0.2F,
        wrist_share = 0.97F;

  std::span<const std::int32_t> head_of(Segment s) const { return surface.head[at(s)]; }
  std::span<const std::int32_t> tail_of(Segment s) const { return surface.tail[at(s)]; }
  std::int32_t landmark(Landmark l) const { return surface.landmarks[static_cast<std::size_t>(l)]; }

  static Segment sided(Segment left, std::size_t side) {
    if (side == 0) return left;
    const std::size_t legs = at(Segment::left_upper_leg);
    return static_cast<Segment>(at(left) + (at(left) >= legs ? 3 : 4));
  }
};

namespace {

Vec3f mean(std::span<const Vec3f> mesh, std::span<const std::int32_t> list) {
  Vec3f sum;
  for (const std::int32_t v : list) sum = sum + mesh[static_cast<std::size_t>(v)];
  return sum * (1.0F / static_cast<float>(list.size()));
}
void pull_mean(std::span<const std::int32_t> list, Vec3f gradient, PullRow* row) {
  if (row == nullptr) return;
  for (const std::int32_t v : list) row->push_back({v, gradient * (1.0F / static_cast<float>(list.size()))});
}

std::size_t side_of_arm(Segment s) {
  return at(s) >= at(Segment::right_shoulder) ? 1 : 0;
}
bool is(Segment s, Segment left) {
  return s == left || s == static_cast<Segment>(at(left) + (at(left) >= at(Segment::left_upper_leg) ? 3 : 4));
}

}  // namespace

// One mesh being measured.
class Measuring {
 public:
  Measuring(const BodyDimensions::State& s, std::span<const Vec3f> mesh, std::vector<PullRow>* rows)
      : s_(s), mesh_(mesh), rows_(rows) {
    if (rows_ != nullptr) rows_->assign(kSurveyDimensionCount, {});
    for (std::size_t side = 0; side < 2; ++side)
      sole_[side] = *std::min_element(s.foot[side].begin(), s.foot[side].end(),
                                      [&](std::int32_t a, std::int32_t b) { return point(a).y < point(b).y; });
    // As body/measure.cpp finds the hips.
    const float low = landmark(Landmark::crotch).y - 60, high = landmark(Landmark::navel).y;
    float rearmost = 1e9F;
    const auto of_seat = [&](std::int32_t v) { return point(v).y > low && point(v).y < high; };
    for (const std::int32_t v : s.seat)
      if (of_seat(v)) rearmost = std::min(rearmost, point(v).z);
    float sum = 0;
    for (const std::int32_t v : s.seat) {
      const float before = point(v).z - rearmost;
      if (!of_seat(v) || before > 4 * kRearmostMm) continue;
      buttocks_.emplace_back(v, std::exp(-before / kRearmostMm));
      sum += buttocks_.back().second;
    }
    for (auto& [v, share] : buttocks_) buttock_y_ += point(v).y * (share /= sum);
  }

  DimensionValues run() {
    heights();
    trunk(SurveyDimension::chest_breadth, nipple_y());
    trunk(SurveyDimension::waist_breadth, landmark(Landmark::navel).y);
    trunk(SurveyDimension::hip_breadth, buttock_y());
    value(SurveyDimension::neck_girth) = girth(neck(s_.neck_share), 1, row(SurveyDimension::neck_girth));
    for (std::size_t side = 0; side < 2; ++side) limbs(side);
    shoulders();
    head();
    weight();
    return values_;
  }

  Outline neck(float share) const {
    const Vec3f root = mean(mesh_, s_.head_of(Segment::neck)), top = mean(mesh_, s_.head_of(Segment::head));
    return cut(mesh_, s_.neck, body::plane_through(root + (top - root) * share, top - root));
  }
  Outline across(Segment left, std::size_t side, std::span<const Triangle> triangles, float share) const {
    const Segment s = BodyDimensions::State::sided(left, side);
    const Vec3f from = mean(mesh_, s_.head_of(s)), to = mean(mesh_, s_.tail_of(s));
    return cut(mesh_, triangles, body::plane_through(from + (to - from) * share, to - from));
  }
  Outline level(float y) const { return cut(mesh_, s_.trunk, body::level_plane(y)); }

  float nipple_y() const { return 0.5F * (landmark(Landmark::left_nipple).y + landmark(Landmark::right_nipple).y); }
  float buttock_y() const { return buttock_y_; }
  Vec3f landmark(Landmark l) const { return point(s_.landmark(l)); }

 private:
  Vec3f point(std::int32_t v) const { return mesh_[static_cast<std::size_t>(v)]; }
  PullRow* row(SurveyDimension d) { return rows_ != nullptr ? &(*rows_)[dimension_index(d)] : nullptr; }
  double& value(SurveyDimension d) { return values_[dimension_index(d)]; }
  void pull(SurveyDimension d, std::int32_t v, Vec3f gradient) {
    if (PullRow* r = row(d)) r->push_back({v, gradient});
  }

  void height(SurveyDimension d, std::span<const std::int32_t> of) {
    const float floor = 0.5F * (point(sole_[0]).y + point(sole_[1]).y);
    value(d) = static_cast<double>(mean(mesh_, of).y - floor);
    pull_mean(of, {0, 1, 0}, row(d));
    for (const std::int32_t v : sole_) pull(d, v, {0, -0.5F, 0});
  }

  void heights() {
    const auto body_count = s_.surface.vertex_count;
    std::int32_t crown = 0;
    for (std::int32_t v = 0; v < body_count; ++v)
      if (point(v).y > point(crown).y) crown = v;
    crown_ = crown;
    height(SurveyDimension::stature, std::array{crown});
    height(SurveyDimension::cervicale_height, std::array{s_.landmark(Landmark::c7)});
    height(SurveyDimension::acromial_height,
           std::array{s_.landmark(Landmark::left_acromion), s_.landmark(Landmark::right_acromion)});
    height(SurveyDimension::chest_height,
           std::array{s_.landmark(Landmark::left_nipple), s_.landmark(Landmark::right_nipple)});
    height(SurveyDimension::waist_height, std::array{s_.landmark(Landmark::navel)});
    height(SurveyDimension::buttock_height, std::array{s_.landmark(Landmark::crotch)});
    value(SurveyDimension::buttock_height) += static_cast<double>(buttock_y_ - landmark(Landmark::crotch).y);
    pull(SurveyDimension::buttock_height, s_.landmark(Landmark::crotch), {0, -1, 0});
    for (const auto& [v, share] : buttocks_) pull(SurveyDimension::buttock_height, v, {0, share, 0});
    height(SurveyDimension::crotch_height, std::array{s_.landmark(Landmark::crotch)});
    std::vector<std::int32_t> hips, knees;
    for (const Segment s : {Segment::left_upper_leg, Segment::right_upper_leg}) {
      hips.insert(hips.end(), s_.head_of(s).begin(), s_.head_of(s).end());
      knees.insert(knees.end(), s_.tail_of(s).begin(), s_.tail_of(s).end());
    }
    height(SurveyDimension::trochanter_height, hips);
    height(SurveyDimension::knee_height, knees);
  }

  // Breadth, depth, girth and back, in the enumeration's order from `breadth`.
  void trunk(SurveyDimension breadth, float y) {
    const auto next = [&](int n) { return static_cast<SurveyDimension>(static_cast<int>(breadth) + n); };
    const Outline o = level(y);
    // u is z (front), v is x (the person's left): level_plane().
    const Extreme left = extreme(o, 0, 1), right = extreme(o, 0, -1), front = extreme(o, 1, 0),
                  back = extreme(o, -1, 0);
    value(breadth) = left.reach + right.reach;
    pull_extreme(left, {1, 0, 0}, row(breadth));
    pull_extreme(right, {-1, 0, 0}, row(breadth));
    value(next(1)) = front.reach + back.reach;
    pull_extreme(front, {0, 0, 1}, row(next(1)));
    pull_extreme(back, {0, 0, -1}, row(next(1)));
    value(next(2)) = girth(o, 1, row(next(2)));
    double sides = 0;
    for (const Extreme* e : {&left, &right})
      for (const auto& [p, w] : e->points) sides += 0.5 * static_cast<double>(w * p->u);
    value(next(3)) = sides + back.reach;
    pull_extreme(back, {0, 0, -1}, row(next(3)));
    for (const Extreme* e : {&left, &right}) pull_extreme(*e, {0, 0, 0.5F}, row(next(3)));
  }

  void limb(SurveyDimension d, const Outline& o) { value(d) += girth(o, 0.5F, row(d)); }

  void distance(SurveyDimension d, std::span<const std::int32_t> from, std::span<const std::int32_t> to) {
    const Vec3f apart = mean(mesh_, to) - mean(mesh_, from);
    value(d) += 0.5 * static_cast<double>(norm(apart));
    pull_mean(to, normalized(apart) * 0.5F, row(d));
    pull_mean(from, normalized(apart) * -0.5F, row(d));
  }

  void extent(SurveyDimension d, std::span<const std::int32_t> vertices, Vec3f along) {
    const auto less = [&](std::int32_t a, std::int32_t b) { return dot(point(a), along) < dot(point(b), along); };
    const auto [low, high] = std::minmax_element(vertices.begin(), vertices.end(), less);
    value(d) += 0.5 * static_cast<double>(dot(point(*high) - point(*low), along));
    pull(d, *high, along * 0.5F);
    pull(d, *low, along * -0.5F);
  }

  void limbs(std::size_t side) {
    const auto sided = [&](Segment left) { return BodyDimensions::State::sided(left, side); };
    const Segment thigh = sided(Segment::left_upper_leg);
    const Vec3f hip = mean(mesh_, s_.head_of(thigh)), knee = mean(mesh_, s_.tail_of(thigh));
    const float thigh_share = (hip.y - landmark(Landmark::crotch).y + kThighBelowCrotchMm) / (hip.y - knee.y);
    limb(SurveyDimension::thigh_girth, across(Segment::left_upper_leg, side, s_.thigh[side], thigh_share));
    limb(SurveyDimension::lower_thigh_girth, across(Segment::left_upper_leg, side, s_.thigh[side], 0.87F));
    limb(SurveyDimension::calf_girth, across(Segment::left_lower_leg, side, s_.shank[side], s_.calf_share));
    limb(SurveyDimension::ankle_girth, across(Segment::left_lower_leg, side, s_.shank[side], s_.ankle_share));
    limb(SurveyDimension::upper_arm_girth,
         across(Segment::left_upper_arm, side, s_.upper_arm[side], s_.upper_arm_share));
    limb(SurveyDimension::forearm_girth, across(Segment::left_lower_arm, side, s_.forearm[side], s_.forearm_share));
    limb(SurveyDimension::wrist_girth, across(Segment::left_lower_arm, side, s_.forearm[side], s_.wrist_share));
    const std::array acromion = {s_.landmark(side == 0 ? Landmark::left_acromion : Landmark::right_acromion)};
    const Segment lower_arm = sided(Segment::left_lower_arm), hand = sided(Segment::left_hand);
    distance(SurveyDimension::upper_arm_length, acromion, s_.head_of(lower_arm));
    distance(SurveyDimension::forearm_length, s_.head_of(lower_arm), s_.head_of(hand));
    hand_length(side, s_.head_of(hand));
    const Segment foot = sided(Segment::left_foot);
    Vec3f toes = mean(mesh_, s_.tail_of(foot)) - mean(mesh_, s_.head_of(foot));
    toes = normalized({toes.x, 0, toes.z});
    extent(SurveyDimension::foot_length, s_.foot[side], toes);
    extent(SurveyDimension::foot_breadth, s_.foot[side], {toes.z, 0, -toes.x});
  }

  void hand_length(std::size_t side, std::span<const std::int32_t> wrist) {
    const Vec3f from = mean(mesh_, wrist);
    const auto tip = *std::max_element(
        s_.hand[side].begin(), s_.hand[side].end(),
        [&](std::int32_t a, std::int32_t b) { return norm(point(a) - from) < norm(point(b) - from); });
    distance(SurveyDimension::hand_length, wrist, std::array{tip});
  }

  void shoulders() {
    const std::array left = {s_.landmark(Landmark::left_acromion)}, right = {s_.landmark(Landmark::right_acromion)};
    for (int i = 0; i < 2; ++i) distance(SurveyDimension::acromion_breadth, right, left);
    const auto joint_left = s_.head_of(Segment::left_upper_arm), joint_right = s_.head_of(Segment::right_upper_arm);
    for (int i = 0; i < 2; ++i) distance(SurveyDimension::deltoid_breadth, joint_right, joint_left);
    for (std::size_t side = 0; side < 2; ++side) {
      const Segment s = BodyDimensions::State::sided(Segment::left_upper_arm, side);
      const Vec3f from = mean(mesh_, s_.head_of(s)), to = mean(mesh_, s_.tail_of(s));
      const Outline o = across(Segment::left_upper_arm, side, s_.upper_arm[side], kDeltoidShare);
      const Vec3f arm = normalized(to - from);
      // Outwards of the arm in the frontal plane: sideways when it hangs.
      const Vec3f out = normalized(side == 0 ? Vec3f{-arm.y, arm.x, 0} : Vec3f{arm.y, -arm.x, 0});
      const Extreme e = extreme(o, dot(out, o.plane.u), dot(out, o.plane.v));
      value(SurveyDimension::deltoid_breadth) +=
          e.reach + static_cast<double>(kArmOutShare * kDeltoidShare * norm(to - from));
      pull_extreme(e, out, row(SurveyDimension::deltoid_breadth));
      pull_mean(s_.head_of(s), -out, row(SurveyDimension::deltoid_breadth));
    }
  }

  void head() {
    const float crown_y = point(crown_).y;
    const Outline o = cut(mesh_, s_.head, body::level_plane(crown_y - kHeadSectionMm));
    const Extreme left = extreme(o, 0, 1), right = extreme(o, 0, -1), front = extreme(o, 1, 0),
                  back = extreme(o, -1, 0);
    value(SurveyDimension::head_breadth) = left.reach + right.reach;
    pull_extreme(left, {1, 0, 0}, row(SurveyDimension::head_breadth));
    pull_extreme(right, {-1, 0, 0}, row(SurveyDimension::head_breadth));
    value(SurveyDimension::head_length) = front.reach + back.reach;
    pull_extreme(front, {0, 0, 1}, row(SurveyDimension::head_length));
    pull_extreme(back, {0, 0, -1}, row(SurveyDimension::head_length));
    value(SurveyDimension::crown_height) =
        static_cast<double>(crown_y - 0.5F * (point(s_.ear[0]).y + point(s_.ear[1]).y));
    pull(SurveyDimension::crown_height, crown_, {0, 1, 0});
    for (const std::int32_t v : s_.ear) pull(SurveyDimension::crown_height, v, {0, -0.5F, 0});
  }

  void weight() {
    const double litres = volume_litres();
    const double density = body::density_kg_m3(extent_mm(), litres);
    value(SurveyDimension::weight) = litres * 1e-3 * density;
    PullRow* r = row(SurveyDimension::weight);
    if (r == nullptr) return;
    std::vector<Vec3f> sum(static_cast<std::size_t>(s_.surface.vertex_count));
    for (const auto& t : s_.surface.triangles) {
      const auto i = [&](std::size_t c) { return static_cast<std::size_t>(t[c]); };
      for (std::size_t c = 0; c < 3; ++c) sum[i(c)] = sum[i(c)] + cross(mesh_[i((c + 1) % 3)], mesh_[i((c + 2) % 3)]);
    }
    const auto kg_per = static_cast<float>(density * 1e-9 / 6);
    for (std::size_t v = 0; v < sum.size(); ++v) r->push_back({static_cast<std::int32_t>(v), sum[v] * kg_per});
  }

  double volume_litres() const {
    double six_volumes = 0;
    for (const auto& t : s_.surface.triangles)
      six_volumes += static_cast<double>(dot(point(t[0]), cross(point(t[1]), point(t[2]))));
    return six_volumes / 6e6;
  }
  double extent_mm() const {
    float low = point(0).y, high = low;
    for (std::int32_t v = 0; v < s_.surface.vertex_count; ++v) {
      low = std::min(low, point(v).y);
      high = std::max(high, point(v).y);
    }
    return static_cast<double>(high) - static_cast<double>(low);
  }

  const BodyDimensions::State& s_;
  std::span<const Vec3f> mesh_;
  std::vector<PullRow>* rows_;
  DimensionValues values_{};
  std::array<std::int32_t, 2> sole_{};
  std::int32_t crown_ = 0;
  std::vector<std::pair<std::int32_t, float>> buttocks_;  // the rearmost vertices, by share
  float buttock_y_ = 0;
};

DimensionSurface surface_of(const body::BodyModel& model) {
  const auto& d = model.data();
  DimensionSurface s;
  s.vertex_count = model.body_vertex_count();
  s.triangles = d.triangles;
  s.triangle_is_arm = d.triangle_is_arm;
  for (std::int32_t v = 0; v < s.vertex_count; ++v)
    s.segment.push_back(static_cast<Segment>(d.skin[static_cast<std::size_t>(v)].segment[0]));
  s.landmarks.assign(d.landmarks.begin(), d.landmarks.end());
  const auto list = [&](std::size_t number) {
    const auto of = d.list_vertices.subspan(d.lists[number].first, d.lists[number].count);
    return std::vector<std::int32_t>(of.begin(), of.end());
  };
  for (std::size_t i = 0; i < s.head.size(); ++i) {
    s.head[i] = list(body::kHeadLists + i);
    s.tail[i] = list(body::kTailLists + i);
  }
  return s;
}

BodyDimensions::BodyDimensions(DimensionSurface surface, std::span<const Vec3f> mean_rest)
    : state_(std::make_unique<State>(std::move(surface))) {
  State& s = *state_;
  const DimensionSurface& d = s.surface;
  const auto main = [&](std::int32_t v) { return d.segment[static_cast<std::size_t>(v)]; };
  const Vec3f neck_root = mean(mean_rest, s.head_of(Segment::neck)),
              skull = mean(mean_rest, s.head_of(Segment::head));
  const Vec3f axis = normalized(skull - neck_root);
  for (std::size_t i = 0; i < d.triangles.size(); ++i) {
    const Triangle& t = d.triangles[i];
    const std::array<Segment, 3> segment = {main(t[0]), main(t[1]), main(t[2])};
    const auto all = [&](auto&& of) { return of(segment[0]) && of(segment[1]) && of(segment[2]); };
    const bool left = mean_rest[static_cast<std::size_t>(t[0])].x > 0;
    const std::size_t side = left ? 0 : 1;
    if (d.triangle_is_arm[i] == 0) {
      s.trunk.push_back(t);
      const Vec3f p = mean_rest[static_cast<std::size_t>(t[0])] - neck_root;
      const float along = dot(p, axis);
      const bool near = dot(p, p) - along * along < kNeckReachMm * kNeckReachMm;
      if (near && along > -30 && along < norm(skull - neck_root) + 60) s.neck.push_back(t);
    }
    if (all([](Segment x) { return x == Segment::head; })) s.head.push_back(t);
    if (all([](Segment x) { return is(x, Segment::left_upper_leg) || is(x, Segment::left_lower_leg); }))
      s.thigh[side].push_back(t);
    if (all([](Segment x) { return is(x, Segment::left_lower_leg) || is(x, Segment::left_foot); }))
      s.shank[side].push_back(t);
    if (all([](Segment x) { return is(x, Segment::left_upper_arm) || is(x, Segment::left_lower_arm); }))
      s.upper_arm[side_of_arm(segment[0])].push_back(t);
    if (all([](Segment x) { return is(x, Segment::left_lower_arm) || is(x, Segment::left_hand); }))
      s.forearm[side_of_arm(segment[0])].push_back(t);
  }
  for (std::int32_t v = 0; v < d.vertex_count; ++v) {
    const Segment m = main(v);
    const Vec3f p = mean_rest[static_cast<std::size_t>(v)];
    const std::size_t side = p.x > 0 ? 0 : 1;
    if (is(m, Segment::left_hand)) s.hand[side_of_arm(m)].push_back(v);
    if (is(m, Segment::left_foot)) s.foot[side].push_back(v);
    const Vec3f ear = mean_rest[static_cast<std::size_t>(s.ear[side])];
    if (m == Segment::head && std::fabs(p.x) > (s.ear[side] != 0 ? std::fabs(ear.x) : 0)) s.ear[side] = v;
    if (m == Segment::pelvis || is(m, Segment::left_upper_leg)) s.seat.push_back(v);
  }
  // Where the survey finds a limb thickest or thinnest, on the mean mesh.
  const Measuring measuring(s, mean_rest, nullptr);
  const auto best = [&](float from, float to, bool most, auto&& outline) {
    float share = from;
    double found = most ? 0 : 1e9;
    for (int i = 0; i <= 20; ++i) {
      const float here = from + (to - from) * static_cast<float>(i) / 20;
      const double mm = girth(outline(here), 1, nullptr);
      if (mm > 0 && (most ? mm > found : mm < found)) {
        found = mm;
        share = here;
      }
    }
    return share;
  };
  const auto limb = [&](Segment of, std::span<const Triangle> triangles) {
    return [&measuring, of, triangles](float share) { return measuring.across(of, 0, triangles, share); };
  };
  s.neck_share = best(0, 1, false, [&](float share) { return measuring.neck(share); });
  s.calf_share = best(0.2F, 0.5F, true, limb(Segment::left_lower_leg, s.shank[0]));
  s.ankle_share = best(0.75F, 0.88F, false, limb(Segment::left_lower_leg, s.shank[0]));
  s.upper_arm_share = best(0.45F, 0.7F, true, limb(Segment::left_upper_arm, s.upper_arm[0]));
  s.forearm_share = best(0.1F, 0.4F, true, limb(Segment::left_lower_arm, s.forearm[0]));
  s.wrist_share = best(0.85F, 1.0F, false, limb(Segment::left_lower_arm, s.forearm[0]));
}

BodyDimensions::BodyDimensions(BodyDimensions&&) noexcept = default;
BodyDimensions::~BodyDimensions() = default;

const DimensionSurface& BodyDimensions::surface() const {
  return state_->surface;
}

DimensionValues BodyDimensions::measure(std::span<const Vec3f> rest, std::vector<PullRow>* gradients) const {
  return Measuring(*state_, rest, gradients).run();
}

std::array<PullRow, 3> BodyDimensions::squaring_rows(std::span<const Vec3f> rest) const {
  const Measuring measuring(*state_, rest, nullptr);
  std::array<PullRow, 3> rows;
  const std::array<float, 3> levels = {measuring.nipple_y(), measuring.landmark(Landmark::navel).y,
                                       measuring.buttock_y()};
  for (std::size_t i = 0; i < 3; ++i) {
    const Outline o = measuring.level(levels[i]);
    float u_low = 1e9F, u_high = -1e9F, v_low = 1e9F, v_high = -1e9F;
    for (const Cut& p : o.hull) {
      u_low = std::min(u_low, p.u), u_high = std::max(u_high, p.u);
      v_low = std::min(v_low, p.v), v_high = std::max(v_high, p.v);
    }
    const float u_mid = (u_low + u_high) / 2, v_mid = (v_low + v_high) / 2;
    for (const Cut& p : o.hull) {
      const float u = 2 * (p.u - u_mid) / (u_high - u_low), v = 2 * (p.v - v_mid) / (v_high - v_low);
      const float angle = std::atan2(v, u);
      const Vec3f out = normalized(o.plane.u * u + o.plane.v * v);
      pull_point(p, out * -std::cos(4 * angle), rows[i]);
    }
  }
  return rows;
}

}  // namespace im2fit::lab
