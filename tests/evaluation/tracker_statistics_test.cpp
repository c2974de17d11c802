// SPDX-License-Identifier: Apache-2.0
// The figures of `eval --tracker`, worked out by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluation/tracker/statistics.h"
#include "evaluation/tracker/tracker_report.h"
#include "evaluation/tracker/upright_scene.h"

namespace im2fit::lab {
namespace {

JointFrame frame_of(float error_mm, float confidence = 0.9F) {
  JointFrame frame;
  frame.finding = Finding::person;
  frame.error_mm.fill(error_mm);
  frame.confidence.fill(confidence);
  frame.in_picture.fill(true);
  return frame;
}

JointFrame missed(Finding finding = Finding::none) {
  JointFrame frame = frame_of(5);
  frame.finding = finding;
  return frame;
}

TEST(Quantile, IsTheNearestRank) {
  const std::vector<double> values = {50, 10, 40, 20, 30};
  EXPECT_EQ(quantile(values, 0), 10);
  EXPECT_EQ(quantile(values, 0.2), 10);
  EXPECT_EQ(quantile(values, 0.21), 20);
  EXPECT_EQ(quantile(values, 0.5), 30);
  EXPECT_EQ(quantile(values, 0.95), 50);
  EXPECT_EQ(quantile(values, 1), 50);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

TEST(JointTally, CountsWhoIsNotFoundAgainstTheShareButNotTheMean) {
  JointTally tally;
  tally.add(frame_of(20));
  tally.add(frame_of(120));
  tally.add(missed());
  tally.add(missed(Finding::other));
  const JointSummary s = tally.summary();
  EXPECT_EQ(s.frames, 4U);
  EXPECT_EQ(s.found, 2U);
  EXPECT_EQ(s.other, 1U);
  EXPECT_EQ(s.joints, 60U);
  EXPECT_DOUBLE_EQ(s.mean_mm, 70);
  EXPECT_DOUBLE_EQ(s.median_mm, 20);
  EXPECT_DOUBLE_EQ(s.p95_mm, 120);
  EXPECT_DOUBLE_EQ(s.within_100mm, 0.25);
  EXPECT_DOUBLE_EQ(s.within_50mm, 0.25);
}

TEST(JointTally, LeavesOutJointsBesideThePicture) {
  JointFrame frame = frame_of(20);
  frame.error_mm[3] = 900;
  frame.in_picture[3] = false;
  JointTally tally, third;
  tally.add(frame);
  third.add(frame, 3);
  EXPECT_EQ(tally.summary().joints, 14U);
  EXPECT_DOUBLE_EQ(tally.summary().mean_mm, 20);
  EXPECT_EQ(third.summary().frames, 0U);
  EXPECT_TRUE(std::isnan(third.summary().mean_mm));
  EXPECT_TRUE(std::isnan(third.summary().within_100mm));
}

TEST(JointTally, LimitsAreWithin) {
  JointTally tally;
  tally.add(frame_of(100));
  tally.add(frame_of(100.5F));
  EXPECT_DOUBLE_EQ(tally.summary().within_100mm, 0.5);
}

TEST(PairedMeans, CompareOnlyWhatBothHave) {
  PairedMeans pairs;
  pairs.add(frame_of(20), frame_of(23));
  pairs.add(frame_of(20), missed());
  pairs.add(missed(), frame_of(500));
  EXPECT_NEAR(pairs.ratio(), 1.15, 1e-6);
  EXPECT_TRUE(std::isnan(PairedMeans().ratio()));
}

TEST(Reliability, BinsStandAboutTheTens) {
  Reliability reliability;
  reliability.add(frame_of(49, 0.86F));
  reliability.add(frame_of(51, 0.94F));
  reliability.add(frame_of(10, 0.96F));
  reliability.add(missed());
  const auto bins = reliability.bins();
  EXPECT_EQ(bins[9].joints, 30U);
  EXPECT_NEAR(bins[9].stated, 0.90, 1e-6);
  EXPECT_DOUBLE_EQ(bins[9].within, 0.5);
  EXPECT_EQ(bins[10].joints, 15U);
  EXPECT_DOUBLE_EQ(bins[10].within, 1);
  EXPECT_EQ(bins[0].joints, 0U);
  EXPECT_NEAR(reliability.calibration_error(), (30 * 0.4 + 15 * 0.04) / 45, 1e-6);
}

TEST(Overlap, CountsPixelsWithDataOnly) {
  // Row by row: both, ours alone, truth alone, both but without data.
  std::vector<std::uint16_t> depth = {1, 1, 1, 0};
  std::vector<std::uint8_t> ours = {255, 255, 0, 255}, truth = {255, 0, 255, 255};
  const Overlap o =
      overlap_of(DepthView(depth.data(), 4, 1), MaskView(ours.data(), 4, 1), MaskView(truth.data(), 4, 1));
  EXPECT_EQ(o.both, 1U);
  EXPECT_DOUBLE_EQ(o.iou(), 1.0 / 3);
  EXPECT_EQ(o.finding(), Finding::other);  // half of it is not more than half
  EXPECT_EQ((Overlap{0, 0, 7}.finding()), Finding::none);
  EXPECT_EQ((Overlap{2, 3, 7}.finding()), Finding::person);
  EXPECT_DOUBLE_EQ((Overlap{0, 0, 0}.iou()), 0);
}

TEST(Overlap, LeavesUnownedPixelsOut) {
  std::vector<std::uint16_t> depth = {1, 1, 1, 1};
  std::vector<std::uint8_t> ours = {255, 255, 0, 255}, truth = {255, 0, 255, 255}, unowned = {0, 0, 255, 255};
  const Overlap o = overlap_of(DepthView(depth.data(), 4, 1), MaskView(ours.data(), 4, 1),
                               MaskView(truth.data(), 4, 1), MaskView(unowned.data(), 4, 1));
  EXPECT_EQ(o.both, 1U);
  EXPECT_EQ(o.ours, 2U);
  EXPECT_EQ(o.truth, 1U);
}

TEST(JudgeJoints, KnowsWhichTrueJointsAreInThePicture) {
  const Intrinsics k{64, 48, 100, 100, 31.5F, 23.5F};
  JointSet truth, found;
  truth.position_mm.fill({0, 0, 1000});
  found.position_mm.fill({0, 30, 1040});
  truth.position_mm[1] = {330, 0, 1000};  // column 64.5
  truth.position_mm[2] = {0, 0, -1000};
  const JointFrame frame = judge_joints(found, truth, k, Finding::person);
  EXPECT_FLOAT_EQ(frame.error_mm[0], 50);
  EXPECT_TRUE(frame.in_picture[0]);
  EXPECT_FALSE(frame.in_picture[1]);
  EXPECT_FALSE(frame.in_picture[2]);
}

TrialOutcome trial(TrialCondition condition, int width, const char* group, float error_mm) {
  TrialOutcome outcome;
  outcome.trial = {condition, width, 0, 0};
  outcome.labels = {{kPoseGroup, group}};
  outcome.cold = outcome.converged = frame_of(error_mm);
  outcome.iou_cold = outcome.iou_converged = {0.99, 0.95};
  return outcome;
}

const Target& target_of(const TrackerReport& report, const std::string& name) {
  for (const Target& target : report.targets)
    if (target.name == name) return target;
  ADD_FAILURE() << "no target " << name;
  static const Target kNone;
  return kNone;
}

TEST(TrackerReport, HoldsFiguresAgainstTheBars) {
  TrackerOutcomes outcomes;
  outcomes.trials = {trial(TrialCondition::full, 640, "calm", 20), trial(TrialCondition::full, 320, "calm", 24),
                     trial(TrialCondition::full, 640, "free", 60)};
  outcomes.rooms = {{0, "furniture", 20, 0}, {1, "furniture", 20, 1}};
  outcomes.clips = {{0, 300, 300, 0, 0}, {1, 300, 290, 2, 1}};
  GuidanceOutcome named, silent, unrelated;
  named.kind = silent.kind = unrelated.kind = "TOO_FAR";
  named.named = unrelated.named = true;
  unrelated.unrelated = static_cast<GuidanceSet>(Guidance::moving);
  unrelated.raised = Guidance::moving | Guidance::too_far;
  outcomes.guidance = {named, silent, unrelated};
  const TrackerReport report = tracker_report(outcomes, {});
  EXPECT_NEAR(target_of(report, "full, calm: mean error, mm").figure, 22, 1e-9);
  EXPECT_TRUE(target_of(report, "full, calm: mean error, mm").met());
  EXPECT_FALSE(target_of(report, "full, free: mean error, mm").met());
  EXPECT_NEAR(target_of(report, "full: 320x240 worse by, %").figure, 20, 1e-6);
  EXPECT_FALSE(target_of(report, "full: 320x240 worse by, %").met());
  EXPECT_TRUE(target_of(report, "mask IoU, median").met());
  const auto flying = std::find_if(report.masks.begin(), report.masks.end(),
                                   [](const MaskRow& row) { return row.dimension == "flying pixels"; });
  ASSERT_NE(flying, report.masks.end());
  EXPECT_EQ(flying->converged.median, 0.95);
  EXPECT_NEAR(target_of(report, "false users in 10,000 frames").figure, 250, 1e-9);
  EXPECT_EQ(target_of(report, "identity switches in two-person clips").figure, 3);
  EXPECT_NEAR(target_of(report, "guidance right, TOO_FAR, %").figure, 100.0 / 3, 1e-9);
  ASSERT_EQ(report.guidance.size(), 1U);
  EXPECT_EQ(report.guidance[0].silent, 1U);
  EXPECT_EQ(report.guidance[0].unrelated, 1U);

  const auto json = nlohmann::json::parse(json_of(report));
  EXPECT_EQ(json.at("schema"), "im2fit.tracker-evaluation/1");
  EXPECT_EQ(json.at("empty").at("false_users"), 1);
  EXPECT_EQ(json.at("guidance").at(0).at("raised").at("MOVING"), 1);
  EXPECT_EQ(json.at("joints").at(0).at("converged").at("frames"), 3);
  EXPECT_NE(text_of(report).find("MISSED"), std::string::npos);
}

TEST(TrackerReport, HasOnlyTheSectionsGiven) {
  TrackerOutcomes outcomes;
  outcomes.trials = {trial(TrialCondition::full, 640, "calm", 20)};
  TrackerSections sections;
  sections.joints = sections.confidence = false;
  const auto json = nlohmann::json::parse(json_of(tracker_report(outcomes, sections)));
  EXPECT_TRUE(json.contains("segmentation"));
  for (const char* absent : {"joints", "confidence", "people", "empty", "guidance"})
    EXPECT_FALSE(json.contains(absent)) << absent;
}

}  // namespace
}  // namespace im2fit::lab
