// SPDX-License-Identifier: Apache-2.0
#include "perception/segment/segment.h"

#include <algorithm>
#include <array>
#include <cmath>
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
#include "perception/segment/users.h"

namespace im2fit {

using segment::Blob;
using segment::Grid;

namespace {

constexpr float kHeadlessMm = 700.0F;            // one without a head must be that much nearer to be chosen
constexpr float kUnconfirmedCostMm = 20'000.0F;  // any confirmed user comes before a candidate
constexpr float kStayMm = 300.0F;                // advantage of the user chosen in the last frame
constexpr float kFarBehindMm = 1500.0F;          // a user further behind the person measured does not disturb
// Log-odds of a person's shape. Of 1,000 people with furniture about them none had anything above -0.7 within that
// reach; of 7 people beside others who were not confirmed 5 were above.
constexpr float kDisturbingOdds = 0.0F;
constexpr float kSecondsMin = 0.001F;  // two frames of one time stamp: a speed must not divide by it

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

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

  bool is_rejected(int id) const { return std::find(rejected.begin(), rejected.end(), id) != rejected.end(); }
  int choose() const;
  int people_count() const;
  bool disturbed(int chosen_user) const;
  std::span<const std::uint8_t> not_feet();

  int width;
  int height;
  Grid grid;
  segment::FloorFinder floor;
  segment::Background background;
  segment::BlobFinder blobs;
  segment::UserTracker users;
  segment::SplitLimbJoiner split_limbs;
  segment::FurnitureCutter furniture;
  segment::MaskRefiner refiner;
  segment::FootGrower feet;
  std::vector<std::uint8_t> chosen;
  std::vector<std::uint8_t> barred;
  int selected_id = 0;
  int last_id = 0;
  std::array<int, kUserCountMax> rejected{};  // 0: free
};

// Index of the user to be measured, -1: none. Nearest and most central; the person of the last frame keeps an
// advantage, so that the choice does not flicker.
int Segmenter::Workspace::choose() const {
  int best = -1;
  float best_cost = 1e30F;
  const auto list = users.users();
  for (std::size_t i = 0; i < list.size(); ++i) {
    const User& user = list[i];
    if (selected_id != 0 && user.id != selected_id) continue;
    const bool candidate = users.is_candidate(i);
    if (!user.confirmed && !candidate) continue;
    const Vec3f c = user.centroid_mm;
    float cost = c.z + 0.8F * std::fabs(c.x) + (user.has_head ? 0.0F : kHeadlessMm);
    if (user.id == last_id) cost -= kStayMm;
    if (candidate) cost += kUnconfirmedCostMm;
    if (is_rejected(user.id)) cost += kUnconfirmedCostMm;
    if (cost < best_cost) {
      best_cost = cost;
      best = static_cast<int>(i);
    }
  }
  return best;
}

int Segmenter::Workspace::people_count() const {
  int count = 0;
  for (const User& user : users.users()) count += user.confirmed ? 1 : 0;
  return count;
}

// By another person near enough to touch, hide or be taken for the one measured. The joints of others are not
// estimated: an unconfirmed candidate counts only if shaped like a person.
bool Segmenter::Workspace::disturbed(int chosen_user) const {
  const auto list = users.users();
  const float limit = list[at(chosen_user)].centroid_mm.z + kFarBehindMm;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const User& other = list[i];
    if (static_cast<int>(i) == chosen_user || other.centroid_mm.z >= limit || is_rejected(other.id)) continue;
    if (other.confirmed || (users.is_candidate(i) && users.shape_odds(other.id) > kDisturbingOdds)) return true;
  }
  return false;
}

// Where the mask must not grow down to the floor: what stands there.
std::span<const std::uint8_t> Segmenter::Workspace::not_feet() {
  const auto shown = background.shown();
  const auto cut = furniture.cut();
  for (std::size_t i = 0; i < barred.size(); ++i) barred[i] = shown[i] | cut[i];
  return barred;
}

Segmenter::Segmenter(int width, int height) : work_(std::make_unique<Workspace>(width, height)) {}
Segmenter::~Segmenter() = default;
Segmenter::Segmenter(Segmenter&&) noexcept = default;
Segmenter& Segmenter::operator=(Segmenter&&) noexcept = default;

void Segmenter::reset() {
  work_->floor.reset();
  work_->background.reset();
  work_->users.reset();
  work_->selected_id = work_->last_id = 0;
  work_->rejected = {};
}

void Segmenter::set_rejected(int id, bool rejected) {
  auto& list = work_->rejected;
  const auto found = std::find(list.begin(), list.end(), id);
  if (!rejected) work_->users.confirm(id);
  if (found != list.end()) {
    if (!rejected) *found = 0;
    return;
  }
  if (!rejected) return;
  std::copy_backward(list.begin(), list.end() - 1, list.end());  // the oldest goes
  list[0] = id;
}

void Segmenter::select(int id) {
  work_->selected_id = id;
}

float Segmenter::shape_odds(int id) const {
  return work_->users.shape_odds(id);
}

std::span<const User> Segmenter::users() const {
  return work_->users.users();
}

Person Segmenter::run(DepthView depth, const Intrinsics& intrinsics, MaskImage mask, float seconds) {
  Workspace& w = *work_;
  Person person;
  w.grid.sample(depth, intrinsics);
  person.floor = w.floor.find(w.grid);
  w.grid.measure_heights(person.floor);
  w.background.observe(w.grid, person.floor);
  w.blobs.run(w.grid, person.floor, w.background.shown(), w.users.expected());
  w.users.run(w.grid, w.blobs, person.floor, std::max(seconds, kSecondsMin));
  person.people_count = w.people_count();

  int who = w.choose();
  // A person too near to be found comes before an unconfirmed candidate.
  const GuidanceSet none_found =
      who >= 0 && w.users.users()[at(who)].confirmed ? 0 : segment::advise_none_found(w.grid, w.blobs.blobs());
  if (has(none_found, Guidance::too_near)) who = -1;
  if (who < 0) {
    std::fill(w.chosen.begin(), w.chosen.end(), std::uint8_t{0});
    person.guidance = none_found;
    // A person too near to be found must not become the background.
    if (!has(person.guidance, Guidance::too_near)) w.background.learn(w.grid, w.users.keepouts(), w.chosen);
    w.refiner.run(w.grid, depth, w.chosen, mask);
    w.last_id = 0;
    return person;
  }
  const User& user = w.users.users()[at(who)];
  person.people_count = std::max(1, person.people_count);  // one without a head may be chosen
  w.last_id = user.id;
  w.split_limbs.run(w.grid, w.blobs, person.floor.known, w.users.blob_of(at(who)), w.chosen);
  w.furniture.run(w.grid, person.floor, w.chosen);
  w.background.learn(w.grid, w.users.keepouts(), w.chosen);
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
  person.guidance = segment::advise(w.grid, person, depth, mask, w.chosen, w.disturbed(who));
  return person;
}

}  // namespace im2fit
