// SPDX-License-Identifier: Apache-2.0
// A site that does not exist: synthetic people before a virtual camera before the real engine, and a simulated tape.
// It differs from the index' people in one known way, so that the effect of a calibration can be checked.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "estimate/site_calibration.h"
#include "evaluation/measurements/evaluation.h"
#include "evaluation/measurements/session.h"
#include "evaluation/study/site_person.h"
#include "train/common/parallel.h"

namespace im2fit::lab {

// people: of another make than the index has seen (family ansur). camera: its depth is 1.5 % too large, as a Kinect's
// is that was never calibrated. tape: pulled 1.5 % tight round every girth, the waist taken 25 mm wider (at the
// navel), and the stature in shoes of 15 mm. plain: none of it.
enum class SiteKind { plain, people, camera, tape };
inline constexpr std::array<std::string_view, 4> kSiteKindNames = {"plain", "people", "camera", "tape"};
constexpr std::string_view name_of(SiteKind kind) {
  return kSiteKindNames[static_cast<std::size_t>(kind)];
}

inline constexpr double kSimulatedCameraScale = 1.015;
inline constexpr double kSimulatedTightness = 0.985, kSimulatedWaistMm = 25, kSimulatedShoesMm = 15;
// SD of a simulated tape's own error: half of ISO 20685's allowance, 0.2 kg of the weight.
double simulated_tape_error(std::size_t measurement);

struct SimulatedSite {
  SiteKind kind = SiteKind::plain;
  int people = 20;
  std::uint64_t seed = 1;
  int frames = 30;
  int threads = 1;
  ProgressSink progress = {};
  std::shared_ptr<const AnsurPeople> ansur;  // not null of kind people
};

struct SimulatedVisit {
  bool measured = false;
  SitePerson person;
  double age_years = 0;
  Intrinsics intrinsics;    // of the upright picture
  std::string result_json;  // im2fit.result/1
};

// `calibration`: the device's, or null. Depends on the site, not on its threads.
Result<std::vector<SimulatedVisit>> simulate(const body::BodyModel& model, const JointModel& joints,
                                             const index::Index& index, const SimulatedSite& site,
                                             const SiteCalibration* calibration);

}  // namespace im2fit::lab
