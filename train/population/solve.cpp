// SPDX-License-Identifier: Apache-2.0
#include "train/population/solve.h"

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "body/fatness.h"
#include "body/measure.h"
#include "body/model_data.h"

namespace im2fit::body {
namespace {

constexpr int kStepCountMax = 24;
constexpr int kFirstLikelyStep = 2;  // goals are mostly met at it, and derivatives would be for nothing
constexpr int kWarpStepCountMax = 8;
constexpr double kStatureToleranceMm = 0.1;
constexpr double kVolumeToleranceL = 0.01;

using Mesh = std::vector<Vec3f>;

// A vertex and a fourth number of no meaning.
using Four = float __attribute__((vector_size(4 * sizeof(float))));
Four vertex(const Mesh& mesh, std::size_t v) {
  Four out;
  std::memcpy(&out, mesh.data() + v, sizeof out);
  return out;
}
Four cross(Four a, Four b) {
  return __builtin_shufflevector(a, a, 1, 2, 0, 3) * __builtin_shufflevector(b, b, 2, 0, 1, 3) -
         __builtin_shufflevector(a, a, 2, 0, 1, 3) * __builtin_shufflevector(b, b, 1, 2, 0, 3);
}
// x + y + z of each of three.
Four sums_of(Four a, Four b, Four c) {
  const Four low = __builtin_shufflevector(a, b, 0, 4, 1, 5), high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  return __builtin_shufflevector(low, c, 0, 1, 4, 4) + __builtin_shufflevector(low, c, 2, 3, 5, 5) +
         __builtin_shufflevector(high, c, 0, 1, 6, 6);
}

struct Sliders {
  float height;
  float build;  // the weight slider 0..1; above it 1 + fatness, below it minus slimness
};

// How far stature and volume are from their goals, and their derivatives along the two sliders.
struct Response {
  double more_stature, more_volume;
  double stature_by_height, stature_by_build;
  double volume_by_height, volume_by_build;
};

class Solver {
 public:
  Solver(const BodyModel& model, const Params& params)
      : model_(model), original_(params), body_count_(static_cast<std::size_t>(model.body_vertex_count())) {
    for (std::size_t i = 0; i < std::size(kFatness); ++i)
      fatness_index_[i] = model.modifier_index(kFatness[i].modifier);
    original_.modifiers.resize(model.modifier_names().size());
    trials_.fill(original_);
    const auto count = static_cast<std::size_t>(model.vertex_count());
    for (Mesh* m : {&here_, &by_height_, &by_build_}) m->resize(count + 1);  // a vertex is read as four numbers
  }

  // Newton in both sliders; sliders that no longer move are against their stops. Along each the mesh is affine
  // between the slider's kinks, so the derivative at a point is the difference to any other point of its piece.
  bool solve(double stature_goal, double volume_goal, Sliders& s) {
    for (int step = 0; step < kStepCountMax; ++step) {
      go_to(s);
      if (met(stature_goal, volume_goal, step)) return true;
      const Sliders n = next(s, response_);
      if (n.height == s.height && n.build == s.build) return false;
      s = n;
    }
    return false;
  }

  const Params& at(Sliders s, std::size_t trial = 0) {
    Params& p = trials_[trial];
    p.height = s.height;
    p.weight = limited(s.build, 0, 1);
    p.modifiers = original_.modifiers;
    for (std::size_t i = 0; i < std::size(kFatness); ++i)
      if (fatness_index_[i] >= 0) p.modifiers[static_cast<std::size_t>(fatness_index_[i])] = modifier_at(s.build, i);
    return p;
  }

 private:
  // The kinks of the two sliders; between them the mesh is affine. Beyond the build's ends a modifier of the set has
  // a kink where it changes sign and where it reaches its limit.
  static int height_piece(float h) { return h < 0.5F ? 0 : 1; }
  int build_piece(float b) const {
    if (!beyond_slider(b)) return b < 0.5F ? 0 : 1;
    int piece = b < 0 ? 2 : 3;  // other numbers than the pieces of the slider itself
    for (std::size_t i = 0; i < std::size(kFatness); ++i) {
      if (fatness_index_[i] < 0) continue;
      const float value = modifier_at(b, i);
      piece = piece * 4 + (value < 0 ? 1 : 0) + (std::fabs(value) > kModifierLimit ? 2 : 0);
    }
    return piece;
  }
  static bool beyond_slider(float b) { return b < 0 || b > 1; }
  float modifier_at(float build, std::size_t i) const {
    const float fatness = build - limited(build, 0, 1);
    return original_.modifiers[static_cast<std::size_t>(fatness_index_[i])] + fatness * kFatness[i].share;
  }

  // The mesh there, and its derivatives where they are others than here.
  void go_to(Sliders s) {
    const int height = height_piece(s.height), build = build_piece(s.build);
    if (height == height_piece_ && build == build_piece_) {
      advance(s.height - last_.height, s.build - last_.build);
    } else {
      move(s, height != height_piece_, build != build_piece_);
    }
    height_piece_ = height;
    build_piece_ = build;
    last_ = s;
    find_extremes();
  }

  void advance(float height, float build) {
    float* here = &here_[0].x;
    const float* by_height = &by_height_[0].x;
    const float* by_build = &by_build_[0].x;
    for (std::size_t i = 0; i < 3 * body_count_; ++i) here[i] = here[i] + by_height[i] * height + by_build[i] * build;
  }

  // here_ and, where wanted, by_height_ and by_build_: movement of each vertex per unit of a slider.
  void move(Sliders s, bool by_height, bool by_build) {
    std::array<BodyModel::BodyMove, BodyModel::kBodyMovesMax> moves;
    std::size_t count = 0;
    const Params& here = at(s, 0);
    moves[count++] = {height_piece_ < 0 ? nullptr : &at(last_, 1), &here, 1, here_};
    const auto slope = [&](Sliders other, float step, Mesh& out) {
      std::fill(out.begin(), out.end(), Vec3f{});
      moves[count] = {&here, &at(other, count + 1), 1 / step, out};
      ++count;
    };
    if (by_height) slope({other_point(s.height), s.build}, other_point(s.height) - s.height, by_height_);
    if (by_build) {
      const float other = beyond_slider(s.build) ? other_fatness(s.build) : other_point(s.build);
      slope({s.height, other}, other - s.build, by_build_);
    }
    model_.move_bodies(std::span(moves).first(count));
  }

  // A second point of the same piece of a slider, 0..0.5 or 0.5..1.
  static float other_point(float v) { return v < 0.25F || (v >= 0.5F && v < 0.75F) ? v + 0.25F : v - 0.25F; }
  float other_fatness(float v) const {
    const int piece = build_piece(v);
    for (const float step : {0.05F, 0.0125F, 0.003125F})
      for (const float other : {v + step, v - step})
        if (build_piece(other) == piece) return other;
    return v + (v < 0 ? -0.05F : 0.05F);  // between two kinks that are closer: near enough
  }

  void find_extremes() {
    low_ = high_ = 0;
    float lowest = here_[0].y, highest = lowest;
    for (std::size_t i = 0; i < body_count_; ++i) {
      const float y = here_[i].y;
      if (y < lowest) lowest = y, low_ = i;
      if (y > highest) highest = y, high_ = i;
    }
  }
  double tall(const Mesh& m) const { return static_cast<double>(m[high_].y) - m[low_].y; }

  // Whether the goals are met; unless they are, response_.
  bool met(double stature_goal, double volume_goal, int step) {
    response_.more_stature = stature_goal - tall(here_);
    const bool tall_enough = std::fabs(response_.more_stature) < kStatureToleranceMm;
    if (tall_enough && step >= kFirstLikelyStep) {
      integrate<false>();
      if (std::fabs(volume_goal - volume_l_) < kVolumeToleranceL) return true;
    }
    integrate<true>();
    response_.more_volume = volume_goal - volume_l_;
    response_.stature_by_height = tall(by_height_);
    response_.stature_by_build = tall(by_build_);
    return tall_enough && std::fabs(response_.more_volume) < kVolumeToleranceL;
  }

  // Volume, and its first variation along both sliders: a closed mesh's volume is a sixth of (edge x edge) . corner,
  // which is the same for a triangle's three corners, and the variation a sixth of (edge x edge) . (sum of the
  // corners' movements). A quad is its triangles 0 1 2 and 0 2 3, as body_triangles() has them.
  template <bool kVariations>
  void integrate() {
    double volume = 0, by_height = 0, by_build = 0;
    struct Corner {
      Four here, by_height, by_build;
    };
    const auto add = [&](const Corner& a, const Corner& b, const Corner& c) {
      const Four n = cross(b.here - a.here, c.here - a.here), own = n * (a.here + b.here + c.here);
      if constexpr (kVariations) {
        const Four sums =
            sums_of(own, n * (a.by_height + b.by_height + c.by_height), n * (a.by_build + b.by_build + c.by_build));
        volume += static_cast<double>(sums[0]);
        by_height += static_cast<double>(sums[1]);
        by_build += static_cast<double>(sums[2]);
      } else {
        volume += static_cast<double>(sums_of(own, own, own)[0]);
      }
    };
    for (const auto& q : model_.body_quads()) {
      const auto corner = [&](std::size_t i) {
        const auto v = static_cast<std::size_t>(q[i]);
        if constexpr (kVariations) return Corner{vertex(here_, v), vertex(by_height_, v), vertex(by_build_, v)};
        return Corner{vertex(here_, v), {}, {}};
      };
      const Corner a = corner(0), b = corner(1), c = corner(2), d = corner(3);
      add(a, b, c);
      add(a, c, d);
    }
    volume_l_ = volume / 18e6;
    response_.volume_by_height = by_height / 6e6;
    response_.volume_by_build = by_build / 6e6;
  }

  static Sliders next(Sliders s, const Response& r) {
    const double more_stature = r.more_stature, more_volume = r.more_volume;
    const double det = r.stature_by_height * r.volume_by_build - r.stature_by_build * r.volume_by_height;
    double dh = 0, db = 0;
    if (r.volume_by_build > 0 && std::fabs(det) > 1e-9) {
      dh = (more_stature * r.volume_by_build - r.stature_by_build * more_volume) / det;
      db = (r.stature_by_height * more_volume - r.volume_by_height * more_stature) / det;
    } else if (r.stature_by_height > 0) {
      dh = more_stature / r.stature_by_height;
    }
    Sliders n = {limited(s.height + limited(dh, -0.3, 0.3), 0, 1),
                 limited(s.build + limited(db, -0.5, 0.5), -kSlimnessMax, 1 + kFatnessMax)};
    // Stop at a kink instead of leaping it: beyond, another derivative holds.
    for (const float kink : {0.0F, 0.5F, 1.0F})
      if ((s.build < kink && n.build > kink) || (s.build > kink && n.build < kink)) n.build = kink;
    // Against a stop the other slider alone must serve stature.
    if (n.build == s.build && r.stature_by_height > 0)
      n.height = limited(s.height + limited(more_stature / r.stature_by_height, -0.3, 0.3), 0, 1);
    return n;
  }

  static float limited(double v, double low, double high) {
    return static_cast<float>(v > low ? (v < high ? v : high) : low);
  }

  const BodyModel& model_;
  Params original_;
  std::array<Params, BodyModel::kBodyMovesMax + 1> trials_;
  std::array<int, std::size(kFatness)> fatness_index_{};
  Sliders last_{};
  int height_piece_ = -1;
  int build_piece_ = -1;
  std::size_t body_count_;
  Mesh here_, by_height_, by_build_;  // without the helpers
  std::size_t low_ = 0, high_ = 0;    // vertices of here_: the soles' and the crown's
  double volume_l_ = 0;
  Response response_{};
};

// The volume whose mass at this stature is weight_kg; density falls slowly with volume, so iteration contracts.
double volume_of_weight(double stature_mm, double weight_kg) {
  double volume_l = weight_kg;
  for (int i = 0; i < 30; ++i) volume_l = weight_kg * 1e3 / density_kg_m3(stature_mm, volume_l);
  return volume_l;
}

// The start of a search: linear in the values that move the sliders most, fitted to 2,000 people of the training
// family. It misses their height by 0.05 and their build by 0.18.
Sliders likely_sliders(const Params& p, double stature_mm, double weight_kg) {
  const double metres = stature_mm / 1000, mass_index = weight_kg / (metres * metres);
  const auto within = [](double v, double low, double high) { return v > low ? (v < high ? v : high) : low; };
  const double woman = 1 - within(static_cast<double>(p.gender), 0, 1);
  const double mass = within(mass_index - 26, -10, 20), muscle = static_cast<double>(p.muscle) - 0.4;
  const double race_sum = static_cast<double>(p.race[0] + p.race[1] + p.race[2]);
  const double share = race_sum > 0 ? 1 / race_sum : 0;
  const double height = 0.424 + 0.092 * woman + 1.015 * (metres - 1.7) +
                        share * (0.114 * static_cast<double>(p.race[1]) - 0.07 * static_cast<double>(p.race[0]));
  const double build = 0.957 + 0.44 * woman + 0.13 * mass + 1.57 * muscle + 0.17 * mass * muscle;
  return {static_cast<float>(within(height, 0.05, 0.95)), static_cast<float>(within(build, -0.4, 2.4))};
}

}  // namespace

bool solve_stature_and_weight(const BodyModel& model, Params& params, double stature_mm, double weight_kg) {
  if (!(stature_mm > 0 && stature_mm < 1e5 && weight_kg > 0 && weight_kg < 1e5)) return false;
  Solver solver(model, params);
  const double volume_l = volume_of_weight(stature_mm, weight_kg);
  const bool warped = !params.warp.is_none();
  std::vector<Vec3f> mesh(warped ? static_cast<std::size_t>(model.vertex_count()) : 0);
  double goal_l =
      volume_l;  // of the mesh before the warp, which changes volumes by nearly the same factor everywhere
  for (int step = 0; step < kWarpStepCountMax; ++step) {
    Sliders sliders = likely_sliders(params, stature_mm, weight_kg);
    const bool solved = solver.solve(stature_mm, goal_l, sliders);
    params = solver.at(sliders);
    if (!warped || !solved) return solved;
    model.morph(params, mesh);
    const double got_l = volume_litres(model, mesh);
    if (std::fabs(got_l - volume_l) < kVolumeToleranceL) return true;
    goal_l *= volume_l / got_l;
  }
  return false;
}

}  // namespace im2fit::body
