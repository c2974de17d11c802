// SPDX-License-Identifier: Apache-2.0
// What was judged, summed up: rows by class, targets, text for people, JSON for machines. All figures are synthetic.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "evaluation/tracker/clip_trials.h"
#include "evaluation/tracker/guidance_trials.h"
#include "evaluation/tracker/room_trials.h"
#include "evaluation/tracker/scene_trials.h"
#include "evaluation/tracker/statistics.h"

namespace im2fit::lab {

struct TrackerOutcomes {
  std::optional<std::vector<TrialOutcome>> trials;
  std::optional<std::vector<ClipOutcome>> clips;
  std::optional<std::vector<RoomOutcome>> rooms;
  std::optional<std::vector<GuidanceOutcome>> guidance;
};

// Which tables are wanted; trials feed three of them.
struct TrackerSections {
  bool joints = true, segmentation = true, people = true, empty = true, guidance = true, confidence = true;
};

// One class of one condition. dimension "joint": one joint; "all": everything.
struct JointRow {
  TrialCondition condition = TrialCondition::full;
  std::string dimension, value;
  JointSummary cold, converged;
};

struct MaskSummary {
  std::uint64_t frames = 0;
  double median = 0, p5 = 0, worst = 0, mean = 0;  // intersection over union, 0..1; not found counts 0
};
struct MaskRow {
  std::string dimension, value;
  MaskSummary converged, cold;
};

struct ReliabilityReport {
  std::string of;
  std::array<ReliabilityBin, Reliability::kBins> bins;
  double calibration_error = 0;
  std::uint64_t joints = 0;
};

struct PeopleReport {
  std::uint64_t clips = 0, frames = 0;
  std::uint64_t found = 0;     // frames with a chosen mask on a person
  std::uint64_t switches = 0;  // the chosen id's mask came to lie on the other person
  std::uint64_t clips_switched = 0;
  std::uint64_t id_switches = 0;  // a person's id changed, or an id went to another person
};

struct EmptyReport {
  std::uint64_t rooms = 0, frames = 0, false_users = 0;
  std::vector<std::pair<std::string, std::pair<std::uint64_t, std::uint64_t>>> by_kind;  // frames, false users
};

struct GuidanceRow {
  std::string kind;
  std::uint64_t scenes = 0, right = 0, silent = 0, unrelated = 0;  // silent: the named code was not raised
  std::array<std::uint64_t, kGuidanceCount> raised{};
  std::uint64_t nothing = 0;  // scenes that raised no code
};

struct Target {
  std::string name;
  double figure = 0;  // NaN: not measured in this run
  double limit = 0;
  bool at_most = true;
  int decimals = 1;
  bool met() const { return at_most ? figure <= limit : figure >= limit; }
};

struct TrackerReport {
  std::uint64_t seed = 0;
  int subjects = 0;
  std::string model;  // its provenance
  std::vector<JointRow> joints;
  std::vector<MaskRow> masks;
  std::vector<ReliabilityReport> reliability;
  std::optional<PeopleReport> people;
  std::optional<EmptyReport> empty;
  std::vector<GuidanceRow> guidance;
  std::vector<Target> targets;
};

TrackerReport tracker_report(const TrackerOutcomes& outcomes, const TrackerSections& sections);
std::string text_of(const TrackerReport& report);
std::string json_of(const TrackerReport& report);

}  // namespace im2fit::lab
