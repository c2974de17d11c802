// SPDX-License-Identifier: Apache-2.0
// The shipped tape on bodies, and the errors for files that are not a tape.
#include "body/tape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <set>

#include "body/measure.h"
#include "body_pack.h"
#include "core/file.h"
#include "person/builtin_tape.h"
#include "person/tape_file.h"
#include "person/tape_regression.h"
#include "train/population/drawn_people.h"

namespace im2fit::body {
namespace {

std::vector<float> measured(TapeMeasurer& measurer, const Tape& tape, const Params& params) {
  std::vector<float> values(tape.definitions.size());
  measurer.measure(tape, params, values);
  return values;
}
float value(const Tape& tape, const std::vector<float>& values, std::string_view id) {
  const int index = definition_index(tape, id);
  return index < 0 ? NAN : values[static_cast<std::size_t>(index)];
}

TEST(BuiltinTape, IsReadAndComplete) {
  const Tape& tape = builtin_tape();
  std::set<std::string> ids, isos;
  std::size_t measured_count = 0;
  for (const TapeDefinition& d : tape.definitions) {
    EXPECT_TRUE(ids.insert(d.id).second) << d.id << " twice";
    EXPECT_TRUE(d.iso_8559.empty() || isos.insert(d.iso_8559).second) << d.iso_8559 << " twice";
    for (std::size_t i = 0; i < kTapeLanguages.size(); ++i)
      EXPECT_FALSE(d.names[i].empty()) << d.id << " has no name in " << kTapeLanguages[i];
    EXPECT_FALSE(d.source.empty()) << d.id;
    measured_count += d.kind != TapeKind::refused ? 1 : 0;
  }
  EXPECT_GE(measured_count, 45U);
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const int index = definition_index(tape, kMeasurementTable[i].id);
    ASSERT_GE(index, 0) << kMeasurementTable[i].id;
    const TapeDefinition& d = tape.definitions[static_cast<std::size_t>(index)];
    EXPECT_EQ(d.kind, TapeKind::value);
    EXPECT_EQ(measurement_index(d.value), i);
    EXPECT_EQ(d.iso_8559, kMeasurementTable[i].iso);
    EXPECT_EQ(unit_of(d), kMeasurementTable[i].unit);
  }
  const TapeDefinition& head = tape.definitions[static_cast<std::size_t>(definition_index(tape, "head_girth"))];
  EXPECT_EQ(head.kind, TapeKind::refused);
  EXPECT_FALSE(head.reason.empty());
}

// The compiled-in tape equals the files.
TEST(BuiltinTape, IsThatOfTheFiles) {
  const auto read = read_shipped_tape(IM2FIT_TAPE_FOLDER);
  ASSERT_TRUE(read) << read.error().message;
  const auto of_files = tape_table(*read), of_program = tape_table(builtin_tape());
  ASSERT_TRUE(of_files && of_program);
  EXPECT_TRUE(*of_files == *of_program) << "run im2fit-lab make tape-table data/tape > person/builtin_tape.inc";
  const auto kept = read_file(IM2FIT_TAPE_FOLDER "/../../person/builtin_tape.inc");
  ASSERT_TRUE(kept) << kept.error().message;
  const std::string text(reinterpret_cast<const char*>(kept->data()), kept->size());
  EXPECT_TRUE(*of_files == text) << "person/builtin_tape.inc was changed by hand";
}

class TapeTest : public testing::Test {
 protected:
  void SetUp() override { IM2FIT_NEEDS_BODY(); }
};

// Of adults: far wider than people, far narrower than a section of the wrong limb or a path the wrong way round.
const std::map<std::string, std::pair<float, float>> kRanges = {
    {"cervical_height", {1100, 1900}},
    {"shoulder_height", {1050, 1850}},
    {"armpit_height", {950, 1650}},
    {"bust_height", {900, 1600}},
    {"waist_height", {750, 1450}},
    {"high_hip_height", {700, 1350}},
    {"hip_height", {600, 1250}},
    {"knee_height", {320, 680}},
    {"ankle_height", {40, 100}},
    {"body_rise", {150, 400}},
    {"waist_to_hip", {80, 320}},
    {"waist_to_knee", {420, 800}},
    {"torso_height", {480, 850}},
    {"scye_depth", {90, 340}},
    {"neck_base_half", {120, 400}},
    {"neck_base_girth", {240, 800}},
    {"under_bust_girth", {480, 1500}},
    {"natural_waist_girth", {480, 1700}},
    {"navel_girth", {480, 1700}},
    {"high_hip_girth", {550, 1800}},
    {"thigh_girth", {330, 1150}},
    {"mid_thigh_girth", {280, 850}},
    {"knee_girth", {230, 600}},
    {"calf_girth", {220, 620}},
    {"ankle_girth", {140, 360}},
    {"armscye_upper", {110, 500}},
    {"armscye_lower", {60, 400}},
    {"armscye_girth", {200, 850}},
    {"upper_arm_girth", {160, 600}},
    {"elbow_girth", {150, 420}},
    {"forearm_girth", {150, 450}},
    {"wrist_girth", {100, 250}},
    {"waist_contour", {480, 1800}},
    {"chest_breadth", {200, 550}},
    {"chest_depth", {130, 450}},
    {"waist_breadth", {180, 600}},
    {"waist_depth", {110, 500}},
    {"hip_breadth", {230, 600}},
    {"hip_depth", {140, 500}},
    {"shoulder_length", {80, 230}},
    {"across_back_shoulder", {280, 700}},
    {"across_back", {220, 650}},
    {"across_front", {180, 600}},
    {"back_neck_to_waist", {270, 620}},
    {"front_neck_to_waist", {220, 560}},
    {"front_waist_length", {300, 720}},
    {"back_waist_length", {300, 680}},
    {"bust_point_to_bust_point", {130, 350}},
    {"neck_to_bust_point", {170, 420}},
    {"back_crotch_length", {210, 600}},
    {"front_crotch_length", {190, 600}},
    {"total_crotch_length", {430, 1200}},
    {"shoulder_to_front_waist", {270, 680}},
    {"shoulder_to_back_waist", {270, 680}},
    {"torso_girth", {1050, 2300}},
    {"waist_to_ankle_side", {700, 1400}},
    {"outside_leg", {760, 1500}},
    {"upper_arm_length", {220, 460}},
    {"lower_arm_length", {170, 380}},
    {"arm_length", {400, 820}},
    {"neck_to_wrist", {560, 1050}},
    {"thigh_length", {300, 600}},
    {"shin_length", {280, 560}},
};

TEST_F(TapeTest, EveryValueIsPlausible) {
  const Tape& tape = builtin_tape();
  TapeMeasurer measurer(*real_body());
  for (std::uint64_t number = 0; number < 40; ++number) {
    const Params p = draw_person(*real_body(), Family::held_out, 31, number).params;
    const std::vector<float> values = measured(measurer, tape, p);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const TapeDefinition& d = tape.definitions[i];
      if (d.kind == TapeKind::refused) {
        EXPECT_TRUE(std::isnan(values[i])) << d.id;
        continue;
      }
      ASSERT_TRUE(std::isfinite(values[i])) << d.id << " of person " << number;
      if (d.kind == TapeKind::value) continue;
      const auto range = kRanges.find(d.id);
      ASSERT_NE(range, kRanges.end()) << d.id;
      EXPECT_GE(values[i], range->second.first) << d.id << " of person " << number;
      EXPECT_LE(values[i], range->second.second) << d.id << " of person " << number;
    }
  }
}

TEST_F(TapeTest, TheElevenAreMeasuresOwnToTheBit) {
  const Tape& tape = builtin_tape();
  TapeMeasurer measurer(*real_body());
  for (std::uint64_t number = 0; number < 10; ++number) {
    const Params p = draw_person(*real_body(), Family::training, 32, number).params;
    const MeasurementValues own = measure_person(*real_body(), p);
    const std::vector<float> values = measured(measurer, tape, p);
    for (std::size_t i = 0; i < kMeasurementCount; ++i)
      EXPECT_EQ(value(tape, values, kMeasurementTable[i].id), own[i]) << kMeasurementTable[i].id;
    // Sections at the same level by the other way: the same tape.
    const auto added = parse_tape(
        "schema: im2fit.tape/1\nmeasurements:\n"
        "- {id: my_waist, name: {en: w}, kind: girth, points: [waist_middle], source: s}\n"
        "- {id: my_hip, name: {en: h}, kind: girth, points: [hip_middle], source: s}\n",
        "mine", tape);
    ASSERT_TRUE(added) << added.error().message;
    const std::vector<float> again = measured(measurer, *added, p);
    EXPECT_NEAR(value(*added, again, "my_waist"), value(tape, values, "waist_girth"), 0.5);
    EXPECT_NEAR(value(*added, again, "my_hip"), value(tape, values, "hip_girth"), 0.5);
  }
}

// But for the diagonals along which quads are split: those are not mirrored.
TEST_F(TapeTest, LeftIsRightOnASymmetricBody) {
  Tape left = builtin_tape(), right = left;
  for (Tape* tape : {&left, &right})
    for (TapeDefinition& d : tape->definitions)
      if (d.side == TapeSide::mean) d.side = tape == &left ? TapeSide::left : TapeSide::right;
  TapeMeasurer measurer(*real_body());
  for (const float gender : {0.0F, 1.0F}) {
    Params p;
    p.gender = gender;
    const std::vector<float> a = measured(measurer, left, p), b = measured(measurer, right, p);
    for (std::size_t i = 0; i < a.size(); ++i)
      if (left.definitions[i].kind != TapeKind::refused) {
        EXPECT_NEAR(a[i], b[i], 1.5) << left.definitions[i].id << ", gender " << gender;
      }
  }
}

// Wrists and ankles as good as none.
TEST_F(TapeTest, HeavierPeopleHaveLargerGirths) {
  const Tape& tape = builtin_tape();
  TapeMeasurer measurer(*real_body());
  for (const float gender : {0.0F, 1.0F}) {
    Params slim, heavy;
    slim.gender = heavy.gender = gender;
    slim.weight = 0.4F;
    heavy.weight = 0.8F;
    const std::vector<float> a = measured(measurer, tape, slim), b = measured(measurer, tape, heavy);
    for (std::size_t i = 0; i < a.size(); ++i) {
      const TapeDefinition& d = tape.definitions[i];
      if (d.kind == TapeKind::girth || d.kind == TapeKind::breadth || d.kind == TapeKind::depth) {
        EXPECT_GT(b[i], a[i] - 1) << d.id << ", gender " << gender;
      }
    }
  }
}

// From the waist a convex line to the crotch is shorter than the way down and the way forward together. The crotch of
// these people lies up to 10 mm off the middle plane, where an arc would run round a thigh.
TEST_F(TapeTest, WhatGoesThroughTheCrotchGoesRoundNoThigh) {
  const Tape& tape = builtin_tape();
  TapeMeasurer measurer(*real_body());
  for (std::uint64_t number = 0; number < 30; ++number) {
    const Params p = draw_person(*real_body(), Family::training, 0x7461, number).params;
    const std::vector<float> values = measured(measurer, tape, p);
    const float both = value(tape, values, "body_rise") + value(tape, values, "hip_depth");
    for (const char* id : {"front_crotch_length", "back_crotch_length"}) {
      EXPECT_LT(value(tape, values, id), 0.9F * both) << number << " " << id;
      EXPECT_GT(value(tape, values, id), value(tape, values, "body_rise")) << number << " " << id;
    }
  }
}

// Flesh of these people joins their thighs below the crotch, where a tape once went round both.
TEST_F(TapeTest, AThighIsMeasuredAlone) {
  const Tape& tape = builtin_tape();
  TapeMeasurer measurer(*real_body());
  for (const std::uint64_t number : {7U, 17U, 39U, 55U}) {
    const Params p = draw_person(*real_body(), Family::held_out, 0x6472, number).params;
    const std::vector<float> values = measured(measurer, tape, p);
    const float thigh = value(tape, values, "thigh_girth");
    EXPECT_LT(thigh, 0.75F * value(tape, values, "hip_girth")) << number;
    EXPECT_GT(thigh, value(tape, values, "mid_thigh_girth")) << number;
  }
}

TEST_F(TapeTest, TheSameBitsWhateverWasMeasuredBefore) {
  const Tape& tape = builtin_tape();
  const Params a = draw_person(*real_body(), Family::training, 33, 4).params;
  const Params b = draw_person(*real_body(), Family::training, 33, 5).params;
  TapeMeasurer one(*real_body()), other(*real_body());
  measured(other, tape, b);
  const std::vector<float> first = measured(one, tape, a), second = measured(other, tape, a);
  for (std::size_t i = 0; i < first.size(); ++i)
    EXPECT_TRUE(first[i] == second[i] || std::isnan(first[i])) << tape.definitions[i].id;
  for (std::size_t i = 0; i < first.size(); ++i)
    EXPECT_EQ(one.lines(tape, static_cast<int>(i)).empty(),
              tape.definitions[i].kind == TapeKind::refused || tape.definitions[i].id == "weight")
        << tape.definitions[i].id;
}

TEST(TapeRegression, EveryShippedMeasurementHasAnInterval) {
  const Tape& tape = builtin_tape();
  index::Answer answer;
  for (index::IntervalEstimate& e : answer.measurements) e = {1000, 960, 1040};
  std::vector<float> values(tape.definitions.size(), 500);
  const std::vector<TapeInterval> exact = [&] {
    index::Answer known = answer;
    for (index::IntervalEstimate& e : known.measurements) e = {1000, 1000, 1000};
    return tape_intervals(tape, values, known);
  }();
  const std::vector<TapeInterval> all = tape_intervals(tape, values, answer);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const TapeDefinition& d = tape.definitions[i];
    if (d.kind == TapeKind::refused) {
      EXPECT_FALSE(all[i].known);
    } else if (d.kind == TapeKind::value) {
      EXPECT_EQ(all[i].low, 960) << "the answer's own";
    } else {
      EXPECT_TRUE(has_tape_regression(d.id)) << d.id << ": run im2fit-lab make tape-regression again";
      EXPECT_TRUE(all[i].known && all[i].low < 500 && all[i].high > 500) << d.id;
      EXPECT_GE(all[i].high, exact[i].high) << d.id << ": what is known less well is not known better";
    }
  }
  const auto mine = parse_tape(
      "schema: im2fit.tape/1\nmeasurements:\n"
      "- {id: mine, name: {en: m}, kind: girth, points: [navel_level], source: s}\n",
      "mine", tape);
  ASSERT_TRUE(mine);
  values.push_back(500);
  EXPECT_FALSE(tape_intervals(*mine, values, answer).back().known) << "nothing was measured of it";
}

TEST(TapeFile, ATextMayReferToTheShipped) {
  const auto tape = parse_tape(
      "schema: im2fit.tape/1\n"
      "points:\n"
      "  below_knee: {from: knee, by_mm: [0, -80, 0]}\n"
      "measurements:\n"
      "- {id: boot, name: {en: Boot, de: Stiefel}, kind: girth, points: [below_knee], side: mean, source: mine}\n"
      "- {id: twice, name: {en: Twice}, kind: sum, terms: {boot: 2}, source: mine}\n",
      "mine.yaml", builtin_tape());
  ASSERT_TRUE(tape) << tape.error().message;
  EXPECT_EQ(tape->definitions.size(), builtin_tape().definitions.size() + 2);
}

TEST(TapeFile, FaultsAreNamedByLineAndField) {
  const std::string begin = "schema: im2fit.tape/1\nmeasurements:\n";
  const std::string rest = ", name: {en: X}, source: s";
  const std::vector<std::pair<std::string, std::string>> table = {
      {"", "line 1: file is empty, expected fields"},
      {"- a\n", "line 1: file"},
      {"points: {}\n", "line 1: schema is missing, expected im2fit.tape/1"},
      {"schema: im2fit.tape/2\n", "line 1: schema is \"im2fit.tape/2\", expected im2fit.tape/1"},
      {"schema: im2fit.tape/1\nmeasurement: []\n", "line 2: file.measurement is not known"},
      {"schema: im2fit.tape/1\npoints:\n  a: {vertex: 13380}\n",
       "line 3: points.a.vertex is \"13380\", expected a vertex"},
      {"schema: im2fit.tape/1\npoints:\n  a: {vertex: [1, 2, 3]}\n", "line 3: points.a.vertex"},
      {"schema: im2fit.tape/1\npoints:\n  a: {bone: tail, end: head}\n",
       "line 3: points.a.bone is \"tail\", expected a bone"},
      {"schema: im2fit.tape/1\npoints:\n  a: {bone: neck, end: foot}\n",
       "line 3: points.a.end is \"foot\", expected head or tail"},
      {"schema: im2fit.tape/1\npoints:\n  a: {level: stature}\n",
       "line 3: points.a.level is \"stature\", expected one of neck_girth"},
      {"schema: im2fit.tape/1\npoints:\n  a: {at: b, height_of: a}\n",
       "line 3: points.a.at is \"b\", expected a point defined before it"},
      {"schema: im2fit.tape/1\npoints:\n  a: {skin: up, of: crotch}\n",
       "line 3: points.a.skin is \"up\", expected front, back or outside"},
      {"schema: im2fit.tape/1\npoints:\n  knee: {vertex: 5}\n", "line 3: points.knee appears twice"},
      {"schema: im2fit.tape/1\npoints:\n  a: {height: 5}\n", "line 3: points.a has no place"},
      {"schema: im2fit.tape/1\npoints:\n  a: {between: [left crotch, knee]}\n",
       "line 3: points.a.between is \"left crotch\", but that point has no sides"},
      {"schema: im2fit.tape/1\npoints:\n  a: {between: [crotch, navel], share: half}\n",
       "line 3: points.a.share is \"half\", expected a number from -2 to 3"},
      {begin + "- {kind: sum}\n", "line 3: measurement.id is missing"},
      {begin + "- {id: A b, kind: sum}\n", "line 3: measurement.id is \"A b\", expected small letters"},
      {begin + "- {id: hip_girth, kind: sum}\n", "line 3: measurement.id \"hip_girth\" appears twice"},
      {begin + "- {id: x, kind: sum, source: s}\n", "line 3: x.name is missing"},
      {begin + "- {id: x, name: {de: X}, source: s}\n", "line 3: x.name.en is missing"},
      {begin + "- {id: x, name: {it: X}, source: s}\n", "line 3: x.name.it is not known"},
      {begin + "- {id: x" + rest + "}\n", "line 3: x.kind is missing"},
      {begin + "- {id: x, name: {en: X}, kind: sum}\n", "line 3: x.source is missing"},
      {begin + "- {id: x" + rest + ", kind: round}\n", "line 3: x.kind is \"round\", expected one of value, height"},
      {begin + "- {id: x" + rest + ", kind: girth}\n", "line 3: x.points is missing"},
      {begin + "- {id: x" + rest + ", kind: girth, points: [elbow_of]}\n",
       "line 3: x.points is \"elbow_of\", expected a point"},
      {begin + "- {id: x" + rest + ", kind: girth, points: [knee]}\n", "line 3: x.side expected left, right or mean"},
      {begin + "- {id: x" + rest + ", kind: girth, plane: sagittal, points: [crotch]}\n",
       "line 3: x.plane is \"sagittal\", expected level, line or points"},
      {begin + "- {id: x" + rest + ", kind: girth, plane: points, points: [crotch]}\n",
       "line 3: x.points has 1 points, expected 3"},
      {begin + "- {id: x" + rest + ", kind: arc, points: [crotch, navel]}\n",
       "line 3: x.points has 2 points, expected 3"},
      {begin + "- {id: x" + rest + ", kind: height, points: [crotch], share: .5}\n",
       "line 3: x.share is for a section"},
      {begin + "- {id: x" + rest + ", kind: sum, terms: {waist: 1}}\n",
       "line 3: x.terms \"waist\" is not a measurement"},
      {begin + "- {id: x" + rest + ", kind: sum, terms: {weight: 1}}\n",
       "line 3: x.terms \"weight\" is not a measured length"},
      {begin + "- {id: x" + rest + ", kind: sum, terms: {hip_girth: .nan}}\n",
       "line 3: x.terms.hip_girth is \".nan\", expected a number"},
      {begin + "- {id: x" + rest + ", kind: refused}\n", "line 3: x.reason is missing"},
      {begin + "- {id: x" + rest + ", kind: value, value: head}\n",
       "line 3: x.value is \"head\", expected one of stature"},
      {begin + "- {id: x" + rest + ", color: red, kind: value}\n", "line 3: measurement.color is not known"},
      {begin + "- {id: x, id: y}\n", "line 3: measurement.id appears twice"},
      {begin + "- {id: x\n", "expected a tape in YAML"},
  };
  for (const auto& [text, words] : table) {
    SCOPED_TRACE(text);
    const auto tape = parse_tape(text, "mine.yaml", builtin_tape());
    ASSERT_FALSE(tape);
    EXPECT_THAT(tape.error().message, testing::StartsWith("mine.yaml line "));
    EXPECT_THAT(tape.error().message, testing::HasSubstr(words));
    EXPECT_EQ(tape.error().message.find('\n'), std::string::npos);
  }
  EXPECT_FALSE(load_tape("/nothing/of/this/name.yaml", builtin_tape()));
}

}  // namespace
}  // namespace im2fit::body
