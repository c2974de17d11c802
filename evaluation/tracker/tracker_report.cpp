// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/tracker_report.h"

#include <algorithm>
#include <limits>
#include <map>

namespace im2fit::lab {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Rows stand in the order their class is first met, so that reports of one seed are alike.
template <class Tally>
class Classes {
 public:
  Tally& of(const std::string& dimension, const std::string& value) {
    const auto [place, is_new] = index_.try_emplace({dimension, value}, rows_.size());
    if (is_new) rows_.push_back({dimension, value, {}});
    return rows_[place->second].tally;
  }
  struct Row {
    std::string dimension, value;
    Tally tally;
  };
  // Grouped by dimension; dimensions as first met, values by name.
  std::vector<Row> rows() const {
    std::map<std::string, std::size_t> order;
    for (const Row& row : rows_) order.try_emplace(row.dimension, order.size());
    std::vector<Row> sorted = rows_;
    std::stable_sort(sorted.begin(), sorted.end(), [&](const Row& a, const Row& b) {
      const std::size_t ia = order.at(a.dimension);
      const std::size_t ib = order.at(b.dimension);
      return ia != ib ? ia < ib : a.value < b.value;
    });
    return sorted;
  }

 private:
  std::map<std::pair<std::string, std::string>, std::size_t> index_;
  std::vector<Row> rows_;
};

struct StartTallies {
  JointTally cold, converged;
  void add(const TrialOutcome& outcome) {
    cold.add(outcome.cold);
    converged.add(outcome.converged);
  }
};

void add_joint_rows(const std::vector<TrialOutcome>& trials, TrialCondition condition, std::vector<JointRow>& out) {
  Classes<StartTallies> classes;
  std::array<StartTallies, kJointCount> joints;
  for (const TrialOutcome& trial : trials) {
    if (trial.trial.condition != condition) continue;
    classes.of("all", "").add(trial);
    for (const auto& [dimension, value] : trial.labels) classes.of(dimension, value).add(trial);
    for (std::size_t j = 0; j < kJointCount; ++j) {
      joints[j].cold.add(trial.cold, j);
      joints[j].converged.add(trial.converged, j);
    }
  }
  const auto rows = classes.rows();
  for (const auto& row : rows)
    out.push_back({condition, row.dimension, row.value, row.tally.cold.summary(), row.tally.converged.summary()});
  if (rows.empty()) return;
  for (std::size_t j = 0; j < kJointCount; ++j)
    out.push_back(
        {condition, "joint", std::string(kJointNames[j]), joints[j].cold.summary(), joints[j].converged.summary()});
}

struct MaskTally {
  std::vector<double> cold, converged;
};

MaskSummary mask_summary(const std::vector<double>& ious) {
  return {ious.size(), quantile(ious, 0.5), quantile(ious, 0.05), quantile(ious, 0), mean(ious)};
}

std::vector<MaskRow> mask_rows(const std::vector<TrialOutcome>& trials) {
  Classes<MaskTally> classes;
  for (const TrialOutcome& trial : trials) {
    if (trial.trial.condition != TrialCondition::full) continue;
    const auto add = [&](const std::string& dimension, const std::string& value) {
      MaskTally& tally = classes.of(dimension, value);
      tally.cold.push_back(trial.iou_cold.clear);
      tally.converged.push_back(trial.iou_converged.clear);
    };
    add("all", "");
    MaskTally& with_mixed = classes.of("flying pixels", "counted");
    with_mixed.cold.push_back(trial.iou_cold.with_mixed);
    with_mixed.converged.push_back(trial.iou_converged.with_mixed);
    for (const auto& [dimension, value] : trial.labels) add(dimension, value);
  }
  std::vector<MaskRow> out;
  for (const auto& row : classes.rows())
    out.push_back({row.dimension, row.value, mask_summary(row.tally.converged), mask_summary(row.tally.cold)});
  return out;
}

// Same scene at both resolutions: how much worse the small one is. NaN for none.
double half_resolution_ratio(const std::vector<TrialOutcome>& trials, TrialCondition condition) {
  PairedMeans pairs;
  for (std::size_t i = 0; i + 1 < trials.size(); ++i) {
    const Trial& a = trials[i].trial;
    const Trial& b = trials[i + 1].trial;
    if (a.condition == condition && b.condition == condition && a.subject == b.subject && a.scene == b.scene &&
        a.width > b.width)
      pairs.add(trials[i].converged, trials[i + 1].converged);
  }
  return pairs.ratio();
}

std::vector<ReliabilityReport> reliability(const std::vector<TrialOutcome>& trials) {
  Classes<Reliability> classes;
  for (const TrialOutcome& trial : trials) {
    if (trial.trial.condition != TrialCondition::full) continue;
    classes.of("all", "").add(trial.converged);
    for (const auto& [dimension, value] : trial.labels)
      if (dimension == kPoseGroup) classes.of(dimension, value).add(trial.converged);
  }
  std::vector<ReliabilityReport> out;
  for (const auto& row : classes.rows())
    out.push_back({row.dimension == "all" ? "all" : row.value, row.tally.bins(), row.tally.calibration_error(),
                   row.tally.joints()});
  return out;
}

PeopleReport people_report(const std::vector<ClipOutcome>& clips) {
  PeopleReport report;
  report.clips = clips.size();
  for (const ClipOutcome& clip : clips) {
    report.frames += clip.frames;
    report.found += clip.found;
    report.switches += clip.switches;
    report.clips_switched += clip.switches > 0 ? 1 : 0;
    report.id_switches += clip.id_switches;
  }
  return report;
}

EmptyReport empty_report(const std::vector<RoomOutcome>& rooms) {
  EmptyReport report;
  report.rooms = rooms.size();
  std::map<std::string, std::pair<std::uint64_t, std::uint64_t>> by_kind;
  for (const RoomOutcome& room : rooms) {
    report.frames += room.frames;
    report.false_users += room.false_users;
    by_kind[room.kind].first += room.frames;
    by_kind[room.kind].second += room.false_users;
  }
  report.by_kind.assign(by_kind.begin(), by_kind.end());
  return report;
}

std::vector<GuidanceRow> guidance_rows(const std::vector<GuidanceOutcome>& outcomes) {
  std::vector<GuidanceRow> rows;
  for (const GuidanceOutcome& outcome : outcomes) {
    auto row = std::find_if(rows.begin(), rows.end(), [&](const GuidanceRow& r) { return r.kind == outcome.kind; });
    if (row == rows.end()) row = rows.insert(rows.end(), GuidanceRow{outcome.kind, 0, 0, 0, 0, {}, 0});
    ++row->scenes;
    row->right += outcome.right() ? 1 : 0;
    row->silent += outcome.named ? 0 : 1;
    row->unrelated += outcome.unrelated != 0 ? 1 : 0;
    row->nothing += outcome.raised == 0 ? 1 : 0;
    for (std::size_t i = 0; i < kGuidanceCount; ++i) row->raised[i] += (outcome.raised >> i & 1U) != 0 ? 1 : 0;
  }
  return rows;
}

class Targets {
 public:
  explicit Targets(std::vector<Target>& targets) : targets_(targets) {}
  void at_most(const std::string& name, double figure, double limit, int decimals = 1) {
    targets_.push_back({name, figure, limit, true, decimals});
  }
  void at_least(const std::string& name, double figure, double limit, int decimals = 1) {
    targets_.push_back({name, figure, limit, false, decimals});
  }

 private:
  std::vector<Target>& targets_;
};

void add_joint_targets(const TrackerReport& report, const std::vector<TrialOutcome>& trials, Targets targets) {
  struct Limit {
    TrialCondition condition;
    const char* group;
    double mean_mm, within;
  };
  constexpr Limit kLimits[] = {{TrialCondition::full, "calm", 24, 98.5},
                               {TrialCondition::full, "free", 40, 94},
                               {TrialCondition::bare, "calm", 18, 99.5},
                               {TrialCondition::bare, "free", 30, 96}};
  for (const Limit& limit : kLimits) {
    const auto row = std::find_if(report.joints.begin(), report.joints.end(), [&](const JointRow& r) {
      return r.condition == limit.condition && r.dimension == kPoseGroup && r.value == limit.group;
    });
    if (row == report.joints.end()) continue;
    const std::string name = std::string(name_of(limit.condition)) + ", " + limit.group;
    targets.at_most(name + ": mean error, mm", row->converged.mean_mm, limit.mean_mm);
    targets.at_least(name + ": within 10 cm, %", 100 * row->converged.within_100mm, limit.within);
  }
  for (const TrialCondition condition : {TrialCondition::full, TrialCondition::bare}) {
    const double ratio = half_resolution_ratio(trials, condition);
    if (ratio > 0) targets.at_most(std::string(name_of(condition)) + ": 320x240 worse by, %", 100 * (ratio - 1), 15);
  }
}

void add_confidence_targets(const TrackerReport& report, Targets targets) {
  if (report.reliability.empty()) return;
  const ReliabilityBin& ninety = report.reliability.front().bins[9];
  targets.at_least("joints stated 90 % sure: within 5 cm, %", 100 * ninety.within, 85);
  targets.at_most("joints stated 90 % sure: within 5 cm, %", 100 * ninety.within, 95);
}

}  // namespace

TrackerReport tracker_report(const TrackerOutcomes& outcomes, const TrackerSections& sections) {
  TrackerReport report;
  Targets targets(report.targets);
  if (outcomes.trials) {
    if (sections.joints) {
      add_joint_rows(*outcomes.trials, TrialCondition::full, report.joints);
      add_joint_rows(*outcomes.trials, TrialCondition::bare, report.joints);
      add_joint_rows(*outcomes.trials, TrialCondition::wide, report.joints);
      add_joint_targets(report, *outcomes.trials, targets);
    }
    if (sections.segmentation) {
      report.masks = mask_rows(*outcomes.trials);
      if (!report.masks.empty()) {
        targets.at_least("mask IoU, median", report.masks.front().converged.median, 0.98, 3);
        targets.at_least("mask IoU, p5", report.masks.front().converged.p5, 0.95, 3);
      }
    }
    if (sections.confidence) {
      report.reliability = reliability(*outcomes.trials);
      add_confidence_targets(report, targets);
    }
  }
  if (outcomes.clips) {
    report.people = people_report(*outcomes.clips);
    targets.at_most("identity switches in two-person clips",
                    static_cast<double>(report.people->switches + report.people->id_switches), 0, 0);
  }
  if (outcomes.rooms) {
    report.empty = empty_report(*outcomes.rooms);
    const double rate = share(report.empty->false_users, report.empty->frames);
    targets.at_most("false users in 10,000 frames", report.empty->frames > 0 ? 10'000 * rate : kNaN, 1);
  }
  if (outcomes.guidance) {
    report.guidance = guidance_rows(*outcomes.guidance);
    for (const GuidanceRow& row : report.guidance)
      targets.at_least("guidance right, " + row.kind + ", %", 100 * share(row.right, row.scenes), 97);
  }
  return report;
}

}  // namespace im2fit::lab
