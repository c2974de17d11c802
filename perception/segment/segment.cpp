// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/segment.h"

#include <algorithm>
#include <vector>

#include "perception/segment/advice.h"
#include "perception/segment/background.h"
#include "perception/segment/blobs.h"
#include "perception/segment/feet.h"
#include "perception/segment/floor.h"
#include "perception/segment/furniture.h"
#include "perception/segment/grid.h"
#include "perception/segment/mask.h"
#include "perception/segment/split_limbs.h"

namespace im2fit {

using segment::at;
using segment::Blob;
using segment::Grid;

namespace {

constexpr float kSecondsMin = 0.001F;  // two frames of one time stamp: a speed must not divide by it

}  // namespace

struct Segmenter::Workspace {
  Workspace(int w, int h)
      : width(w),
        height(h),
        grid(w, h),
        floor(grid),
        background(grid),
        blobs(grid),
        furniture(grid),
        refiner(grid),
        feet(w),
        chosen(grid.depth.size()),
        barred(grid.depth.size()) {}

  std::span<const std::uint8_t> not_feet();

  int width;
  int height;
  Grid grid;
  segment::FloorFinder floor;
  segment::Background background;
  segment::Blobs blobs;
  segment::SplitLimbJoiner split_limbs;
  segment::FurnitureCutter furniture;
  segment::MaskRefiner refiner;
  segment::FootGrower feet;
  std::vector<std::uint8_t> chosen;
  std::vector<std::uint8_t> barred;
};

// Where the mask must not grow down to the floor: what stands there.
std::span<const std::uint8_t> Segmenter::Workspace::not_feet() {
  const std::uint8_t *shown = background.shown().data(), *cut = furniture.cut().data();
  std::uint8_t* __restrict bars = barred.data();
  for (std::size_t i = 0, count = barred.size(); i < count; ++i) bars[i] = shown[i] | cut[i];
  return barred;
}

Segmenter::Segmenter(int width, int height) : work_(std::make_unique<Workspace>(width, height)) {}
Segmenter::~Segmenter() = default;
Segmenter::Segmenter(Segmenter&&) noexcept = default;
Segmenter& Segmenter::operator=(Segmenter&&) noexcept = default;

void Segmenter::reset() {
  work_->floor.reset();
  work_->background.reset();
  work_->blobs.reset();
}

Person Segmenter::run(DepthView depth, const Intrinsics& intrinsics, PersonTracker& people, MaskImage mask,
                      float seconds, const std::optional<Vec3f>& up) {
  Workspace& w = *work_;
  Person person;
  w.grid.sample(depth, intrinsics);
  person.floor = w.floor.find(w.grid, up);
  w.grid.measure_heights(person.floor);
  w.background.observe(w.grid, person.floor);
  segment::find_blobs(w.grid, person.floor, w.background.shown(), people.expected(), w.blobs);
  people.follow(w.grid, w.blobs, person.floor, std::max(seconds, kSecondsMin));
  person.people_count = people.people_count();

  int who = people.choose();
  // A person too near to be found comes before an unconfirmed candidate.
  const GuidanceSet none_found = who >= 0 && people.users()[at(who)].confirmed
                                     ? 0
                                     : segment::advise_none_found(w.grid, person.floor, w.blobs, people);
  if (has(none_found, Guidance::too_near)) who = -1;
  people.look_at(who);
  if (who < 0) {
    std::fill(w.chosen.begin(), w.chosen.end(), std::uint8_t{0});
    person.guidance = none_found;
    // A person too near to be found must not become the background.
    if (!has(person.guidance, Guidance::too_near)) w.background.learn(w.grid, people.keepouts(), w.chosen);
    w.refiner.run(w.grid, depth, w.chosen, mask);
    return person;
  }
  const User& user = people.users()[at(who)];
  person.people_count = std::max(1, person.people_count);  // one without a head may be chosen
  w.split_limbs.run(w.grid, w.blobs, person.floor.known, people.blob_of(at(who)), w.chosen);
  w.furniture.run(w.grid, person.floor, w.chosen);
  w.background.learn(w.grid, people.keepouts(), w.chosen);
  if (person.floor.known) {
    const Vec3f c = user.centroid_mm;
    const Vec3f feet = c - person.floor.up * (dot(person.floor.up, c) + person.floor.camera_height_mm);
    person.floor = w.floor.refine(w.grid, depth, person.floor, feet, w.chosen);
  }
  w.refiner.run(w.grid, depth, w.chosen, mask);
  w.feet.run(w.grid, depth, person.floor, w.chosen, w.not_feet(), mask);
  segment::describe_mask(w.grid, depth, mask, person);
  if (person.pixel_count == 0) {
    person.guidance = static_cast<GuidanceSet>(Guidance::no_person);
    return person;
  }
  person.found = true;
  person.id = user.id;
  segment::mark_dead_borders(w.grid, w.width, w.height, person);
  person.guidance = segment::advise(w.grid, person, depth, mask, w.chosen, people.disturbed(who));
  return person;
}

}  // namespace im2fit
