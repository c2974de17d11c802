// SPDX-License-Identifier: Apache-2.0
// The band of garments that hang from the waist: laid flat round the skin, following it, and slipping where a lap
// draws it tight.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "garment/drape/cloth.h"

namespace im2fit::body {
namespace {

constexpr float kBeltReachMm = 120;
constexpr int kBeltSmoothPasses = 10;
constexpr float kBeltOffMaxMm = 30;  // where a belt bridges a fold of skin
// A belt gives to trousers that a lap draws tight: it pulls as it does from kBeltFirmMm off its place until it has
// slipped kBeltSlipMm.
constexpr float kBeltFirmMm = 3, kBeltSlipMm = 60;

}  // namespace

void Cloth::close_belt(float girth_mm) {
  float band = 0;
  for (const BandEdge& e : constraints_.band) band += e.length;
  const float share = band > girth_mm && girth_mm > 0 ? girth_mm / band : 1.0F;
  for (const BandEdge& e : constraints_.band) {
    constraints_.stretch[e.batch].length[e.lane] = e.length * share;
    constraints_.edge_mm[e.edge] = e.length * share;
  }
}

// The band's vertices in order round the waist, from the middle of the front on.
void Cloth::find_ring() {
  const std::size_t count = mesh_.vertex_count();
  if (mesh_.hang != Hang::waist) return;
  std::vector<std::array<std::int32_t, 2>> next(count, {-1, -1});
  for (const BandEdge& e : constraints_.band)
    for (const std::size_t k : {0U, 1U}) {
      auto& of = next[static_cast<std::size_t>(constraints_.edges[e.edge][k])];
      of[of[0] < 0 ? 0 : 1] = constraints_.edges[e.edge][1 - k];
    }
  std::int32_t start = -1;
  for (std::size_t v = 0; v < count; ++v)
    if (next[v][1] >= 0 && mesh_.side[v] == 0 && mesh_.layer[v] == kFrontLayer) start = static_cast<std::int32_t>(v);
  for (std::int32_t v = start, before = -1; v >= 0 && ring_.size() < count;) {
    ring_.push_back(v);
    const auto& of = next[static_cast<std::size_t>(v)];
    const std::int32_t after = of[0] != before ? of[0] : of[1];
    before = v;
    v = after == start ? -1 : after;
  }
  ring_at_.resize(ring_.size());
  ring_work_.resize(ring_.size());
}

// A belt lies flat, and its band is spread evenly along it: the places of ring_ in ring_at_.
void Cloth::lay_belt(float up_mm) {
  const std::size_t count = ring_.size();
  const auto vertex = [&](std::size_t i) { return static_cast<std::size_t>(ring_[i % count]); };
  for (std::size_t i = 0; i < count; ++i) ring_at_[i] = position(vertex(i));
  for (int pass = 0; pass < kBeltSmoothPasses; ++pass) {
    std::copy(ring_at_.begin(), ring_at_.end(), ring_work_.begin());
    for (std::size_t i = 0; i < count; ++i)
      ring_at_[i] =
          ring_work_[i] * 0.5F + (ring_work_[(i + count - 1) % count] + ring_work_[(i + 1) % count]) * 0.25F;
  }
  const auto cut_mm = [&](std::size_t i) {
    const Flat a = mesh_.flat[vertex(i)], b = mesh_.flat[vertex(i + 1)];
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y));
  };
  float cut = 0, laid = 0;
  for (std::size_t i = 0; i < count; ++i) {
    cut += cut_mm(i);
    laid += norm(ring_at_[(i + 1) % count] - ring_at_[i]);
  }
  std::copy(ring_at_.begin(), ring_at_.end(), ring_work_.begin());
  std::size_t piece = 0;
  float want = 0, passed = 0;
  for (std::size_t i = 0; i < count; ++i) {
    float length = norm(ring_work_[(piece + 1) % count] - ring_work_[piece]);
    while (piece + 1 < count && passed + length < want) {
      passed += length;
      ++piece;
      length = norm(ring_work_[(piece + 1) % count] - ring_work_[piece]);
    }
    const float share = length > 0 ? std::min(1.0F, (want - passed) / length) : 0;
    ring_at_[i] = ring_work_[piece] + (ring_work_[(piece + 1) % count] - ring_work_[piece]) * share;
    ring_at_[i].y = mesh_.flat[vertex(i)].y + up_mm;
    want += cut_mm(i) * laid / cut;
  }
}

void Cloth::hold_belt(const BodySurface& skin, float up_mm) {
  update_normals();
  lay_belt(up_mm);
  hold_ring(skin);
}

void Cloth::hold_belt_here(const BodySurface& skin) {
  update_normals();
  for (std::size_t i = 0; i < ring_.size(); ++i) ring_at_[i] = position(static_cast<std::size_t>(ring_[i]));
  hold_ring(skin);
}

void Cloth::hold_ring(const BodySurface& skin) {
  belt_.clear();
  for (std::size_t i = 0; i < ring_.size(); ++i) {
    Held held;
    held.vertex = ring_[i];
    const Vec3f facing = normals_[static_cast<std::size_t>(ring_[i])];
    std::int32_t hint = -1;
    if (!skin.nearest(ring_at_[i], facing, 0, kTrunk, kBeltReachMm, hint, held.place)) continue;
    const Vec3f off = ring_at_[i] - skin.at(held.place, false);
    const Vec3f n = skin.facing(held.place, false), along = skin.along(held.place, false);
    held.off_mm = {std::clamp(dot(off, n), kSkinMm, kBeltOffMaxMm), dot(off, along), dot(off, cross(n, along))};
    belt_.push_back(held);
  }
}

void Cloth::follow_belt(const BodySurface& skin) {
  const float per_step = 1.0F / static_cast<float>(substeps_);
  for (Held& held : belt_) {
    const auto held_at = [&](bool at_end) {
      const Vec3f n = skin.facing(held.place, at_end), along = skin.along(held.place, at_end);
      return skin.at(held.place, at_end) + n * held.off_mm.x + along * held.off_mm.y +
             cross(n, along) * held.off_mm.z;
    };
    held.point = held_at(false);
    held.point_step = (held_at(true) - held.point) * per_step;
  }
}

void Cloth::pull_belt(int substep) {
  const float steps = static_cast<float>(substep + 1);
  for (const Held& held : belt_) {
    ClothVertex& p = vertices_[static_cast<std::size_t>(held.vertex)];
    const Vec3f to = held.point + held.point_step * steps - Vec3f{p.x, p.y, p.z};
    const float far = norm(to);
    const float pull = far > kBeltSlipMm + kBeltFirmMm ? far - kBeltSlipMm : std::min(far, kBeltFirmMm);
    const float share = far > 0 ? belt_pull_ * pull / far : 0;
    p.x += share * to.x;
    p.y += share * to.y;
    p.z += share * to.z;
  }
}

}  // namespace im2fit::body
