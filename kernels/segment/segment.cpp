// SPDX-License-Identifier: Apache-2.0
#include "kernels/segment/segment.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/segment/blobs.h"
#include "kernels/segment/feet.h"
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
constexpr float kForearmMaxMm = 600.0F;      // with the hand
constexpr float kForearmThickMinMm = 70.0F;  // table tops are thinner
constexpr float kForearmAreaMaxM2 = 0.08F;
constexpr float kHandHeightMinMm = 400.0F;  // above the floor: below it stand boxes and chairs
constexpr float kHandGapMaxMm = 280.0F;     // held towards the camera, the forearm is hidden
constexpr float kPointingMm = 250.0F;       // a hand this far before the body may hide its whole arm
constexpr float kPointingGapMaxMm = 450.0F;
constexpr float kHandMaxMm = 320.0F;
constexpr float kElbowGapMaxMm = 100.0F;
constexpr int kGapReachCells = 9;
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
        refiner(grid),
        feet(w),
        chosen(grid.depth.size()),
        touch(at(segment::kBlobCountMax)),
        border(at(segment::kBlobCountMax)),
        gap_mm(at(segment::kBlobCountMax)),
        gap_max_mm(at(segment::kBlobCountMax)),
        candidate(at(segment::kBlobCountMax)) {}

  int choose() const;
  void absorb_fragments(int person);
  void look_around(int c, int r);
  float hole_share(DepthView depth) const;
  void mark_dead_borders(Person& person) const;
  GuidanceSet advise(const Person& person, DepthView depth, MaskView mask) const;
  GuidanceSet advise_nobody() const;

  int width;
  int height;
  Grid grid;
  FloorFinder floor;
  BlobFinder blobs;
  segment::MaskRefiner refiner;
  segment::FootGrower feet;
  std::vector<std::uint8_t> chosen;
  std::vector<std::int32_t> touch;
  std::vector<std::int32_t> border;
  std::vector<float> gap_mm;  // per blob: nearest to the person in space
  std::vector<float> gap_max_mm;
  std::vector<std::uint8_t> candidate;  // per blob: 0 no, 1 when enclosed, 2 also when near (a hand)
  bool grid_floor_known = false;
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

// A hand or forearm held towards the camera is an island of its own: no larger than that, before the body, off the
// floor, and a short way in space from what is already the person. Islands inside the outline belong as well.
void Segmenter::Workspace::absorb_fragments(int person) {
  const auto labels = blobs.labels();
  const auto list = blobs.blobs();
  const auto label = static_cast<std::uint16_t>(person + 1);
  const Blob& body = list[at(person)];
  for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i] = labels[i] == label ? 1 : 0;
  for (std::size_t b = 0; b < list.size(); ++b) {
    const Blob& other = list[b];
    const float z = other.centroid_mm.z;
    const float cell = static_cast<float>(grid.step) * z / grid.intrinsics.fx;
    const bool small = other.area_m2 < kFragmentAreaMaxM2 && !other.person && b != at(person);
    candidate[b] = small && z > body.centroid_mm.z - 900.0F && z < body.centroid_mm.z + 500.0F ? 1 : 0;
    const float reach = static_cast<float>(std::max(other.c_max - other.c_min, other.r_max - other.r_min)) * cell;
    const bool off_floor = !grid_floor_known || other.height_min_mm > kHandHeightMinMm;
    const float before = body.centroid_mm.z - z;
    gap_max_mm[b] = before > kPointingMm && reach < kHandMaxMm ? kPointingGapMaxMm
                    : before > 60.0F && reach < kForearmMaxMm  ? kHandGapMaxMm
                                                               : kElbowGapMaxMm;
    const bool hand = reach < kForearmMaxMm + 80.0F && other.area_m2 < kForearmAreaMaxM2 && off_floor &&
                      other.height_max_mm - other.height_min_mm > kForearmThickMinMm;
    if (candidate[b] != 0 && hand) candidate[b] = 2;
  }
  for (int pass = 0; pass < 2; ++pass) {  // a hand may hang on a wrist that is an island itself
    std::fill(touch.begin(), touch.end(), 0);
    std::fill(border.begin(), border.end(), 0);
    std::fill(gap_mm.begin(), gap_mm.end(), 1e9F);
    for (int r = 1; r + 1 < grid.height; ++r) {
      for (int c = 1; c + 1 < grid.width; ++c) {
        const int cell = grid.index(c, r);
        if (labels[at(cell)] == 0 || chosen[at(cell)] != 0 || candidate[at(labels[at(cell)] - 1)] == 0) continue;
        look_around(c, r);
      }
    }
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (labels[i] == 0 || chosen[i] != 0) continue;
      const auto b = static_cast<std::size_t>(labels[i] - 1);
      if (candidate[b] == 0) continue;
      const bool enclosed = list[b].centroid_mm.z < body.centroid_mm.z + 130.0F &&
                            static_cast<float>(touch[b]) >= 0.55F * static_cast<float>(border[b]) && touch[b] > 0;
      if (enclosed || (candidate[b] == 2 && gap_mm[b] < gap_max_mm[b])) chosen[i] = 1;
    }
  }
}

// How much of a candidate's border faces the person, and how near in space it comes.
void Segmenter::Workspace::look_around(int c, int r) {
  const auto labels = blobs.labels();
  const int cell = grid.index(c, r);
  const std::uint16_t own = labels[at(cell)];
  const auto b = at(own - 1);
  bool edge = false;
  for (const int step : {-1, 1, -grid.width, grid.width}) {
    int other = cell + step;
    if (labels[at(other)] == own) continue;
    edge = true;
    const int next = other + step;
    if (grid.depth[at(other)] == 0 && next >= 0 && next < static_cast<int>(labels.size())) other = next;
    ++border[b];
    if (chosen[at(other)] != 0) ++touch[b];
  }
  if (!edge || candidate[b] != 2) return;
  const Vec3f here = grid.point(cell);
  for (int rr = std::max(0, r - kGapReachCells); rr <= std::min(grid.height - 1, r + kGapReachCells); ++rr) {
    for (int cc = std::max(0, c - kGapReachCells); cc <= std::min(grid.width - 1, c + kGapReachCells); ++cc) {
      const int other = grid.index(cc, rr);
      if (chosen[at(other)] != 0) gap_mm[b] = std::min(gap_mm[b], norm(grid.point(other) - here));
    }
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
  for (int v = person.v_min; v <= person.v_max; ++v) {
    for (int u = person.u_min; u <= person.u_max; u += grid.step) {
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
  for (const Blob& blob : w.blobs.blobs()) person.people_count += blob.has_head ? 1 : 0;

  const int who = w.choose();
  if (who >= 0) person.people_count = std::max(1, person.people_count);  // one without a head may be chosen
  if (who < 0) {
    std::fill(w.chosen.begin(), w.chosen.end(), std::uint8_t{0});
    w.refiner.run(w.grid, depth, w.chosen, mask);
    person.guidance = w.advise_nobody();
    w.has_last = false;
    return person;
  }
  w.grid_floor_known = person.floor.known;
  w.absorb_fragments(who);
  w.last_mm = w.blobs.blobs()[at(who)].centroid_mm;
  w.has_last = true;
  if (person.floor.known) {
    const Vec3f feet =
        w.last_mm - person.floor.up * (dot(person.floor.up, w.last_mm) + person.floor.camera_height_mm);
    person.floor = w.floor.refine(w.grid, depth, person.floor, feet, w.chosen);
  }
  w.refiner.run(w.grid, depth, w.chosen, mask);
  w.feet.run(w.grid, depth, person.floor, w.chosen, mask);
  segment::describe_mask(w.grid, depth, mask, person);
  person.found = person.pixel_count > 0;
  w.mark_dead_borders(person);
  person.guidance = person.found ? w.advise(person, depth, mask) : bit(Guidance::no_person);
  return person;
}

}  // namespace im2fit
