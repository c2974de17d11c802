// SPDX-License-Identifier: Apache-2.0
#include "kernels/segment/segment.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/segment/blobs.h"
#include "kernels/segment/floor.h"
#include "kernels/segment/grid.h"
#include "kernels/segment/mask.h"

namespace im2fit {

using segment::Blob;
using segment::BlobFinder;
using segment::FloorFinder;
using segment::Grid;

namespace {

constexpr float kNearMm = 1000.0F;
constexpr float kFarMm = 4000.0F;
constexpr float kFragmentAreaMaxM2 = 0.12F;  // a forearm pointing at the camera
constexpr float kHoleShareMax = 0.30F;
constexpr float kFeetMissingMm = 220.0F;  // lowest visible part this far above the floor: the feet are hidden
constexpr float kWholeBodyMinMm = 1250.0F;
constexpr int kDeadBorderPx = 12;  // sensors leave some columns at the border without data

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

GuidanceSet bit(Guidance g) {
  return static_cast<GuidanceSet>(g);
}

}  // namespace

struct Segmenter::Workspace {
  Workspace(int w, int h)
      : width(w),
        height(h),
        grid(w, h),
        floor(grid),
        blobs(grid),
        chosen(grid.depth.size()),
        touch(at(segment::kBlobCountMax)),
        border(at(segment::kBlobCountMax)) {}

  int choose() const;
  void absorb_fragments(int person);
  float hole_share(DepthView depth) const;
  void mark_dead_borders(Person& person) const;
  GuidanceSet advise(const Person& person, DepthView depth, MaskView mask) const;
  GuidanceSet advise_nobody() const;

  int width;
  int height;
  Grid grid;
  FloorFinder floor;
  BlobFinder blobs;
  std::vector<std::uint8_t> chosen;
  std::vector<std::int32_t> touch;
  std::vector<std::int32_t> border;
  bool has_last = false;
  Vec3f last_mm;
};

// Nearest and most central; the person of the last frame keeps an advantage, so that the choice does not flicker.
int Segmenter::Workspace::choose() const {
  int best = -1;
  float best_cost = 1e30F;
  const auto list = blobs.blobs();
  for (std::size_t b = 0; b < list.size(); ++b) {
    if (!list[b].person) continue;
    const Vec3f c = list[b].centroid_mm;
    float cost = c.z + 0.8F * std::fabs(c.x) + (list[b].has_head ? 0.0F : 700.0F);
    if (has_last && norm(c - last_mm) < 350.0F) cost -= 300.0F;
    if (cost < best_cost) {
      best_cost = cost;
      best = static_cast<int>(b);
    }
  }
  return best;
}

// A forearm held towards the camera is an island of its own: small, before the body, mostly surrounded by it.
void Segmenter::Workspace::absorb_fragments(int person) {
  const auto labels = blobs.labels();
  const auto list = blobs.blobs();
  const auto label = static_cast<std::uint16_t>(person + 1);
  std::fill(touch.begin(), touch.end(), 0);
  std::fill(border.begin(), border.end(), 0);
  for (int r = 1; r + 1 < grid.height; ++r) {
    for (int c = 1; c + 1 < grid.width; ++c) {
      const int cell = grid.index(c, r);
      const std::uint16_t own = labels[at(cell)];
      if (own == 0 || own == label) continue;
      const auto look = [&](int step) {
        int other = cell + step;
        const int next = other + step;
        if (labels[at(other)] == own) return;
        if (grid.depth[at(other)] == 0 && next >= 0 && next < static_cast<int>(labels.size())) other = next;
        ++border[at(own - 1)];
        if (labels[at(other)] == label) ++touch[at(own - 1)];
      };
      look(-1);
      look(1);
      look(-grid.width);
      look(grid.width);
    }
  }
  const Blob& body = list[at(person)];
  const float limit = body.centroid_mm.z;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    chosen[i] = 0;
    if (labels[i] == 0) continue;
    if (labels[i] == label) {
      chosen[i] = 1;
      continue;
    }
    const auto b = static_cast<std::size_t>(labels[i] - 1);
    const Blob& other = list[b];
    if (other.person || other.area_m2 > kFragmentAreaMaxM2) continue;
    const float z = other.centroid_mm.z;
    if (z < limit - 900.0F || z > limit + 130.0F) continue;
    const float share = z < limit - 60.0F ? 0.5F : 0.6F;
    if (static_cast<float>(touch[b]) >= share * static_cast<float>(border[b])) chosen[i] = 1;
  }
}

// Share of the person's pixels without data, counting lost cells with the person on two sides.
float Segmenter::Workspace::hole_share(DepthView depth) const {
  int total = 0;
  int lost = 0;
  const auto is_person = [&](int c, int r) {
    return c >= 0 && r >= 0 && c < grid.width && r < grid.height && chosen[at(grid.index(c, r))] != 0;
  };
  for (int r = 0; r < grid.height; ++r) {
    for (int c = 0; c < grid.width; ++c) {
      const int cell = grid.index(c, r);
      if (chosen[at(cell)] == 0) {
        if (grid.depth[at(cell)] != 0) continue;
        const bool across =
            (is_person(c - 1, r) || is_person(c - 2, r)) && (is_person(c + 1, r) || is_person(c + 2, r));
        const bool along =
            (is_person(c, r - 1) || is_person(c, r - 2)) && (is_person(c, r + 1) || is_person(c, r + 2));
        if (!across || !along) continue;
      }
      for (int v = r * grid.step; v < (r + 1) * grid.step; ++v)
        for (int u = c * grid.step; u < (c + 1) * grid.step; ++u) lost += depth.at(u, v) == 0 ? 1 : 0;
      total += grid.step * grid.step;
    }
  }
  return total > 0 ? static_cast<float>(lost) / static_cast<float>(total) : 1.0F;
}

// Where the sensor leaves border columns or rows empty, the picture ends at the first with data.
void Segmenter::Workspace::mark_dead_borders(Person& person) const {
  int c_min = grid.width;
  int c_max = -1;
  int r_min = grid.height;
  int r_max = -1;
  for (int r = 0; r < grid.height; ++r) {
    for (int c = 0; c < grid.width; ++c) {
      if (grid.depth[at(grid.index(c, r))] == 0) continue;
      c_min = std::min(c_min, c);
      c_max = std::max(c_max, c);
      r_min = std::min(r_min, r);
      r_max = std::max(r_max, r);
    }
  }
  const int dead = std::max(2, kDeadBorderPx * grid.step / 4);
  const auto ends = [&](int gap_px, int distance_px) { return gap_px <= dead && distance_px < grid.step; };
  const int left = c_min * grid.step;
  const int right = (c_max + 1) * grid.step - 1;
  const int top = r_min * grid.step;
  const int bottom = (r_max + 1) * grid.step - 1;
  if (ends(left, person.u_min - left)) person.cut_left = true;
  if (ends(width - 1 - right, right - person.u_max)) person.cut_right = true;
  if (ends(top, person.v_min - top)) person.cut_top = true;
  if (ends(height - 1 - bottom, bottom - person.v_max)) person.cut_bottom = true;
}

GuidanceSet Segmenter::Workspace::advise(const Person& person, DepthView depth, MaskView mask) const {
  GuidanceSet out = 0;
  if (person.centroid_mm.z < kNearMm) out |= bit(Guidance::too_near);
  if (person.centroid_mm.z > kFarMm) out |= bit(Guidance::too_far);
  if (person.cut_top) out |= bit(Guidance::head_cut);
  if (person.cut_left || person.cut_right) out |= bit(Guidance::side_cut);
  if (person.people_count > 1) out |= bit(Guidance::several_people);
  if (hole_share(depth) > kHoleShareMax) out |= bit(Guidance::too_noisy);
  const Vec3f up = person.floor.known ? person.floor.up : Vec3f{0, -1, 0};
  float lowest = 1e9F;
  float highest = -1e9F;
  for (int u = person.u_min; u <= person.u_max; u += grid.step) {
    for (int v = person.v_min; v <= person.v_max; ++v) {
      if (mask.at(u, v) == 0) continue;
      const float h = dot(up, unproject(grid.intrinsics, static_cast<float>(u), static_cast<float>(v),
                                        static_cast<float>(depth.at(u, v))));
      lowest = std::min(lowest, h);
      highest = std::max(highest, h);
    }
  }
  const bool feet_hidden = person.floor.known ? lowest + person.floor.camera_height_mm > kFeetMissingMm
                                              : highest - lowest < kWholeBodyMinMm;
  if (person.cut_bottom || feet_hidden) out |= bit(Guidance::feet_cut);
  return out;
}

GuidanceSet Segmenter::Workspace::advise_nobody() const {
  GuidanceSet out = bit(Guidance::no_person);
  int clustered = 0;
  for (const Blob& blob : blobs.blobs()) {
    clustered += blob.cell_count;
    const bool large = blob.cell_count * 8 > static_cast<int>(grid.depth.size());
    if (large && blob.centroid_mm.z < kNearMm) out |= bit(Guidance::too_near);
  }
  return out;
}

Segmenter::Segmenter(int width, int height) : work_(std::make_unique<Workspace>(width, height)) {}
Segmenter::~Segmenter() = default;
Segmenter::Segmenter(Segmenter&&) noexcept = default;
Segmenter& Segmenter::operator=(Segmenter&&) noexcept = default;

void Segmenter::reset() {
  work_->floor.reset();
  work_->has_last = false;
}

Person Segmenter::run(DepthView depth, const Intrinsics& intrinsics, MaskImage mask) {
  Workspace& w = *work_;
  Person person;
  w.grid.sample(depth, intrinsics);
  person.floor = w.floor.find(w.grid);
  w.grid.measure_heights(person.floor);
  w.blobs.run(w.grid, person.floor);
  for (const Blob& blob : w.blobs.blobs()) person.people_count += blob.person ? 1 : 0;

  const int who = w.choose();
  if (who < 0) {
    std::fill(w.chosen.begin(), w.chosen.end(), std::uint8_t{0});
    segment::refine_mask(w.grid, depth, w.chosen, mask);
    person.guidance = w.advise_nobody();
    w.has_last = false;
    return person;
  }
  w.absorb_fragments(who);
  w.last_mm = w.blobs.blobs()[at(who)].centroid_mm;
  w.has_last = true;
  if (person.floor.known) {
    const Vec3f feet =
        w.last_mm - person.floor.up * (dot(person.floor.up, w.last_mm) + person.floor.camera_height_mm);
    person.floor = w.floor.refine(w.grid, depth, person.floor, feet, w.chosen);
  }
  segment::refine_mask(w.grid, depth, w.chosen, mask);
  segment::grow_feet(w.grid, depth, person.floor, mask);
  segment::describe_mask(w.grid, depth, mask, person);
  person.found = person.pixel_count > 0;
  w.mark_dead_borders(person);
  person.guidance = person.found ? w.advise(person, depth, mask) : bit(Guidance::no_person);
  return person;
}

}  // namespace im2fit
