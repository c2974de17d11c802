// SPDX-License-Identifier: Apache-2.0
// The exported avatar measures what result.json says: ten held-out people, every other one from both sides, and the
// tape of another program. IM2FIT_ONE_BODY_PEOPLE: another number of people.
#include "apps/common/measuring.h"
#include "avatar_mesh.h"
#include "body/model.h"
#include "body/model_data.h"
#include "measure_run.h"

namespace im2fit {
namespace {

// glb vertices are the body's, in their order, before the copies at seams of the texture.
test::AvatarFacts facts_of(const body::BodyModel& model) {
  test::AvatarFacts facts;
  for (int v = 0; v < model.body_vertex_count(); ++v) facts.place_of_vertex.emplace(v, v);
  facts.left_acromion = model.data().landmark(body::Landmark::left_acromion);
  facts.right_acromion = model.data().landmark(body::Landmark::right_acromion);
  return facts;
}

TEST(OneBody, TheExportedMeshMeasuresWhatIsReported) {
  IM2FIT_NEED_DATA();
  const auto model = body::BodyModel::load(test::body_path());
  ASSERT_TRUE(model) << model.error().message;
  test::AvatarFacts facts = facts_of(*model);
  double girth_sum = 0;
  int girths = 0, measured = 0;
  const char* given = std::getenv("IM2FIT_ONE_BODY_PEOPLE");
  const int people = given != nullptr ? std::atoi(given) : 10;
  double girth_most = 0, length_most = 0;
  for (int seed = 41; measured < people; ++seed) {
    ASSERT_LT(seed, 61 + 2 * people);
    const test::TestFolder folder;
    const std::string out = folder.path("out");
    std::vector<std::string> words = {"--frames", "5"};
    if (seed % 4 >= 2) words.emplace_back("--turn");  // even seeds are men, odd ones women
    const test::Run run = test::measure("synthetic:" + std::to_string(seed), out, words);
    if (run.exit_code == 3) continue;  // this person got guidance first
    ASSERT_EQ(run.exit_code, 0) << run.err;
    ++measured;
    const auto result = nlohmann::json::parse(test::read_text(out + "/result.json"));
    EXPECT_EQ(result["body"]["meets_measurements"], true) << result["body"];
    facts.gender = result["body"]["parameters"]["gender"];
    const test::AvatarMesh mesh(test::read_text(out + "/avatar.glb"));
    const test::AvatarTape tape(mesh, facts);
    ASSERT_EQ(tape.values().size(), result["measurements"].size());
    for (const auto& [id, value] : tape.values()) {
      const auto& said = result["measurements"][id];
      const double off = value - said["value"].get<double>();
      const bool girth = id.ends_with("_girth");
      EXPECT_LE(std::abs(off), id == "weight" ? 0.3 : 3) << id << " of synthetic:" << seed;
      EXPECT_TRUE(value >= said["interval"][0] && value <= said["interval"][1]) << id << " of synthetic:" << seed;
      // The program's values of its own mesh are right.
      const double own = id == "weight" ? result["body"]["residual_kg"].get<double>()
                                        : result["body"]["residual_mm"][id].get<double>();
      EXPECT_NEAR(off, own, girth ? 0.5 : 0.2) << id << " of synthetic:" << seed;
      if (id != "weight")
        (girth ? girth_most : length_most) = std::max(girth ? girth_most : length_most, std::abs(off));
      girth_sum += girth ? std::abs(off) : 0;
      girths += girth ? 1 : 0;
    }
  }
  EXPECT_LE(girth_sum / girths, 1);
  std::cout << measured << " people: girths " << girth_sum / girths << " mm in the mean, at most " << girth_most
            << " mm, lengths at most " << length_most << " mm\n";
}

TEST(OneBody, WhatNoBodyMeasuresIsSaid) {
  PersonMeasurement person;
  EXPECT_EQ(apps::body_note(person), "") << "there is no body";
  MeasurementValues& residual = person.body.emplace().fit.residual;
  residual[measurement_index(Measurement::waist_girth)] = 12;
  residual[measurement_index(Measurement::inside_leg)] = -3.4F;
  EXPECT_EQ(apps::body_note(person),
            "no body has all of the reported values; the avatar differs by waist_girth +12 mm, inside_leg -3 mm");
  residual[measurement_index(Measurement::waist_girth)] = -2;
  EXPECT_EQ(apps::body_note(person), "") << "a length alone is not told";
}

}  // namespace
}  // namespace im2fit
