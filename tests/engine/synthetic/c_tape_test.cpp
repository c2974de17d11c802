// SPDX-License-Identifier: Apache-2.0
// A rendered person measured through the C functions on the files of the environment: the tape by id, that it is of
// the body the other functions speak of, garments on that body, and its rig.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "capi/include/im2fit/im2fit.h"
#include "hal/source.h"
#include "hal/steady_view.h"
#include "index/index.h"
#include "person/wardrobe.h"
#include "train/camera/virtual_camera.h"
#include "train/population/population.h"

namespace im2fit {
namespace {

constexpr int kWidth = 320, kHeight = 240, kRotateDeg = 90, kFrames = 12;

class CTape : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"IM2FIT_TRACKER", "IM2FIT_INDEX", "IM2FIT_BODY"})
      if (std::getenv(name) == nullptr) GTEST_SKIP() << name << " names no file";
    const auto model = body::BodyModel::load(std::getenv("IM2FIT_BODY"));
    ASSERT_TRUE(model) << model.error().message;
    const Intrinsics sensor = lab::kinect_intrinsics(kWidth, kHeight);
    const Intrinsics upright = hal::rotate_upright(sensor, kRotateDeg);
    im2fit_settings& settings = settings_;
    im2fit_settings_init(&settings, sizeof settings);
    settings.tracker_path = std::getenv("IM2FIT_TRACKER");
    settings.index_path = std::getenv("IM2FIT_INDEX");
    settings.body_path = std::getenv("IM2FIT_BODY");
    settings.width = upright.width;
    settings.height = upright.height;
    settings.fx = upright.fx, settings.fy = upright.fy, settings.cx = upright.cx, settings.cy = upright.cy;
    settings.frames_wanted = kFrames / 2;
    ASSERT_EQ(im2fit_open(&settings, &handle_), IM2FIT_OK) << im2fit_last_error(nullptr);
    lab::SceneOptions options;
    options.rotate_deg = kRotateDeg;
    lab::VirtualScene scene(*model, lab::draw_subject(*model, lab::Family::training, 5, 2), options, {}, sensor, 5);
    std::vector<std::uint16_t> seen(static_cast<std::size_t>(kWidth) * kHeight);
    for (std::uint64_t i = 0; i < kFrames; ++i) {
      scene.render(i, {seen.data(), kWidth, kHeight});
      std::vector<std::uint16_t>& frame = frames_.emplace_back(seen.size());
      hal::rotate_upright({seen.data(), kWidth, kHeight}, kRotateDeg, {frame.data(), kHeight, kWidth});
      ASSERT_EQ(
          im2fit_push(handle_, frame.data(), kHeight, kWidth, 0, i, static_cast<std::int64_t>(i + 1) * 33333333),
          IM2FIT_OK);
    }
    ASSERT_EQ(im2fit_finish(handle_), IM2FIT_OK);
    ASSERT_EQ(im2fit_poll(handle_, &result_, sizeof result_), IM2FIT_OK);
    ASSERT_EQ(result_.measured, 1) << "guidance bits " << result_.guidance_seen;
  }
  void TearDown() override { im2fit_close(handle_); }

  im2fit_settings settings_{};
  std::vector<std::vector<std::uint16_t>> frames_;  // upright
  im2fit_handle* handle_ = nullptr;
  im2fit_result result_{};
};

TEST_F(CTape, TheModelsAreThoseOfTheFiles) {
  const auto index = index::Index::open(std::getenv("IM2FIT_INDEX"));
  ASSERT_TRUE(index) << index.error().message;
  im2fit_models models{};
  ASSERT_EQ(im2fit_get_models(handle_, &models, sizeof models), IM2FIT_OK);
  EXPECT_EQ(models.people, index->info().subject_count);
  EXPECT_EQ(models.captures, index->size());
  EXPECT_EQ(models.made_by, index->info().provenance);
  EXPECT_EQ(models.tracker_key, index->info().tracker_key);
  EXPECT_EQ(models.has_body, 1);
  EXPECT_EQ(models.answers_shape, 1);
  EXPECT_EQ(models.answers_turned, 1);
  EXPECT_EQ(models.answers_clothed, index->knows_clothed() ? 1 : 0);
  EXPECT_EQ(models.site_corrected, 0);
  // A caller of an older header gets the fields it has room for, one of a newer header zeros.
  struct {
    im2fit_models models;
    std::uint64_t more = 7;
  } grown;
  ASSERT_EQ(im2fit_get_models(handle_, &grown.models, sizeof grown), IM2FIT_OK);
  EXPECT_EQ(grown.more, 0U);
  grown.models.people = 77;
  ASSERT_EQ(im2fit_get_models(handle_, &grown.models, offsetof(im2fit_models, people)), IM2FIT_OK);
  EXPECT_EQ(grown.models.people, 77U);

  // Without body data nothing is fitted, and the library reports it.
  im2fit_settings bare = settings_;
  bare.body_path = nullptr;
  im2fit_handle* without = nullptr;
  ASSERT_EQ(im2fit_open(&bare, &without), IM2FIT_OK) << im2fit_last_error(nullptr);
  ASSERT_EQ(im2fit_get_models(without, &models, sizeof models), IM2FIT_OK);
  EXPECT_EQ(models.people, index->info().subject_count);
  EXPECT_EQ(models.has_body + models.answers_shape + models.answers_turned + models.answers_clothed, 0);
  im2fit_close(without);
}

TEST_F(CTape, EveryMeasurementHasAValueOrAReason) {
  const std::size_t count = im2fit_tape_count();
  std::vector<im2fit_tape_value> values(count);
  ASSERT_EQ(im2fit_tape(handle_, nullptr, count, values.data(), sizeof values[0]), IM2FIT_OK);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < count; ++i) {
    SCOPED_TRACE(im2fit_tape_id(i));
    if (values[i].status == IM2FIT_TAPE_REFUSED) {
      ++refused;
      EXPECT_TRUE(std::isnan(values[i].value) && std::isnan(values[i].low) && std::isnan(values[i].high));
      ASSERT_NE(values[i].reason, nullptr);
      EXPECT_GT(std::strlen(values[i].reason), 10U);
      continue;
    }
    ASSERT_EQ(values[i].status, IM2FIT_TAPE_MEASURED);
    EXPECT_EQ(values[i].reason, nullptr);
    EXPECT_GT(values[i].value, 10);
    EXPECT_LT(values[i].low, values[i].high);
  }
  EXPECT_EQ(refused, 1U) << "head_girth alone";
}

TEST_F(CTape, TheElevenAreTheResultsByTheBodysResidual) {
  float residual[IM2FIT_MEASUREMENT_COUNT];
  ASSERT_EQ(im2fit_body_residual(handle_, residual), IM2FIT_OK);
  for (int m = 0; m < IM2FIT_MEASUREMENT_COUNT; ++m) {
    const char* id = im2fit_measurement_name(m);
    im2fit_tape_value value;
    ASSERT_EQ(im2fit_tape(handle_, &id, 1, &value, sizeof value), IM2FIT_OK) << id;
    EXPECT_NEAR(value.value, result_.measurements[m].value + residual[m], 0.05F) << id;
    EXPECT_EQ(value.low, result_.measurements[m].low) << id;
    EXPECT_EQ(value.high, result_.measurements[m].high) << id;
  }
}

TEST_F(CTape, EverySizeOfEveryGarmentSitsSomehow) {
  ASSERT_EQ(im2fit_garment_count(), builtin_wardrobe().garments.size());
  for (std::size_t g = 0; g < im2fit_garment_count(); ++g) {
    const char* id = im2fit_garment_id(g);
    SCOPED_TRACE(id);
    const body::GarmentPattern& pattern = builtin_wardrobe().garments[g];
    ASSERT_LE(pattern.regions.size(), static_cast<std::size_t>(IM2FIT_REGION_COUNT_MAX));
    std::size_t count = 0, best = 99;
    ASSERT_EQ(im2fit_garment_fit(handle_, id, nullptr, sizeof(im2fit_size_fit), 0, &count, nullptr),
              IM2FIT_ERROR_TOO_SMALL);
    ASSERT_GT(count, 3U);
    std::vector<im2fit_size_fit> fits(count);
    ASSERT_EQ(im2fit_garment_fit(handle_, id, fits.data(), sizeof fits[0], count, &count, &best), IM2FIT_OK);
    ASSERT_LT(best, count);
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_GE(fits[i].cost, fits[best].cost);
      ASSERT_EQ(fits[i].region_count, static_cast<int>(pattern.regions.size()));
      for (int r = 0; r < fits[i].region_count; ++r) {
        const im2fit_region_fit& region = fits[i].regions[r];
        const body::FitRegion& drawn = pattern.regions[static_cast<std::size_t>(r)];
        EXPECT_EQ(drawn.id, region.name);
        EXPECT_LT(region.low_mm, region.ease_mm);
        EXPECT_GT(region.high_mm, region.ease_mm);
        EXPECT_EQ(region.verdict == IM2FIT_FIT_TIGHT, region.ease_mm < drawn.tight_mm);
        EXPECT_EQ(region.verdict == IM2FIT_FIT_LOOSE, region.ease_mm > drawn.good_high_mm);
        // The ease is that of the tape's body: ease and body together give the size of the cut.
        if (i == 0) continue;
        const char* measure = drawn.measure.c_str();
        im2fit_tape_value value;
        ASSERT_EQ(im2fit_tape(handle_, &measure, 1, &value, sizeof value), IM2FIT_OK);
        EXPECT_GT(region.ease_mm + value.value, fits[i - 1].regions[r].ease_mm + value.value)
            << "larger sizes are wider";
      }
    }
  }
}

TEST_F(CTape, ADressedAvatarWearsWhatIsNamed) {
  std::size_t naked = 0, size = 0, tee = 0;
  ASSERT_EQ(im2fit_avatar(handle_, IM2FIT_AVATAR_GLB, nullptr, 0, &naked), IM2FIT_ERROR_TOO_SMALL);
  ASSERT_EQ(im2fit_dressed_avatar(handle_, nullptr, 0, nullptr, 0, &size), IM2FIT_ERROR_TOO_SMALL);
  std::string glb(size, '\0');
  ASSERT_EQ(im2fit_dressed_avatar(handle_, nullptr, 0, glb.data(), size, &size), IM2FIT_OK);
  EXPECT_EQ(glb.substr(0, 4), "glTF");
  EXPECT_NE(glb.find("\"name\":\"trousers\""), std::string::npos);
  EXPECT_NE(glb.find("\"name\":\"t_shirt\""), std::string::npos);
  EXPECT_GT(size, naked);
  // The best size named is the best size; another is another.
  im2fit_size_fit fits[32];
  std::size_t count = 0, best = 0;
  ASSERT_EQ(im2fit_garment_fit(handle_, "t_shirt", fits, sizeof fits[0], 32, &count, &best), IM2FIT_OK);
  const auto shirt = [&](const char* name) {
    const im2fit_worn worn = {"t_shirt", name};
    EXPECT_EQ(im2fit_dressed_avatar(handle_, &worn, 1, nullptr, 0, &tee), IM2FIT_ERROR_TOO_SMALL);
    std::string bytes(tee, '\0');
    EXPECT_EQ(im2fit_dressed_avatar(handle_, &worn, 1, bytes.data(), tee, &tee), IM2FIT_OK);
    return bytes;
  };
  const std::string by_itself = shirt(nullptr);
  EXPECT_TRUE(by_itself == shirt(fits[best].name));
  EXPECT_FALSE(by_itself == shirt(fits[best == 0 ? 1 : best - 1].name));
  EXPECT_EQ(by_itself.find("trousers"), std::string::npos);
  const im2fit_worn foreign[] = {{"toga", nullptr}, {"t_shirt", "XXXXS"}};
  for (const im2fit_worn& worn : foreign) {
    EXPECT_EQ(im2fit_dressed_avatar(handle_, &worn, 1, nullptr, 0, &tee), IM2FIT_ERROR_NOT_FOUND);
    EXPECT_NE(std::strstr(im2fit_last_error(handle_), worn.size != nullptr ? worn.size : worn.garment), nullptr);
  }
}

TEST_F(CTape, TheRigStandsWhereTheJointsAre) {
  im2fit_rig rig;
  ASSERT_EQ(im2fit_live_rig(handle_, &rig, sizeof rig), IM2FIT_OK);
  EXPECT_EQ(rig.user_id, result_.user_id);
  EXPECT_GT(rig.root_m[1], 0.6F);  // of hips above the floor
  EXPECT_LT(rig.root_m[1], 1.2F);
  for (const auto& q : rig.rotations) EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 1e-5F);
  // A caller with an older header gets the fields it knows, one with a newer one zeros.
  struct Grown {
    im2fit_rig rig;
    int more;
  } grown;
  std::memset(static_cast<void*>(&grown), 0x55, sizeof grown);
  ASSERT_EQ(im2fit_live_rig(handle_, &grown.rig, sizeof grown), IM2FIT_OK);
  EXPECT_EQ(std::memcmp(&grown.rig, &rig, sizeof rig), 0);
  EXPECT_EQ(grown.more, 0);
  std::memset(static_cast<void*>(&grown), 0x55, sizeof grown);
  ASSERT_EQ(im2fit_live_rig(handle_, &grown.rig, sizeof rig.root_m), IM2FIT_OK);
  EXPECT_EQ(grown.rig.root_m[2], rig.root_m[2]);
  EXPECT_EQ(grown.rig.rotations[0][0], std::bit_cast<float>(0x55555555));
}

// The frames of a hand that turns the camera by two degrees to and fro, three times a second: the reported poses undo
// the turn.
TEST_F(CTape, ACameraInTheHandSaysWhereItIs) {
  const Intrinsics k{settings_.width, settings_.height, settings_.fx, settings_.fy, settings_.cx, settings_.cy};
  const auto measured = [&](bool told) {
    im2fit_handle* handle = nullptr;
    EXPECT_EQ(im2fit_open(&settings_, &handle), IM2FIT_OK) << im2fit_last_error(nullptr);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      constexpr std::array<float, 10> kTurnDeg = {0, 1.2F, 1.9F, 1.9F, 1.2F, 0, -1.2F, -1.9F, -1.9F, -1.2F};
      const float half = kTurnDeg[i % kTurnDeg.size()] * 3.14159265F / 360;  // its sine is itself
      const hal::CameraPose pose{half * 0.6F, half * 0.8F, 0, std::sqrt(1 - half * half), {}};
      auto depth = frames_[i];
      hal::SteadyView turn;  // from the camera at rest to the turned one
      turn.prepare(k.width, k.height);
      static_cast<void>(turn.take(pose));
      if (turn.take({})) turn.run(k, {depth.data(), k.width, k.height});
      im2fit_frame frame;
      im2fit_frame_init(&frame, sizeof frame);
      frame.pixels = depth.data();
      frame.width = k.width;
      frame.height = k.height;
      frame.sequence = i;
      frame.time_ns = static_cast<std::int64_t>(i + 1) * 33333333;
      if (told) frame.turn_x = pose.x, frame.turn_y = pose.y, frame.turn_w = pose.w;
      EXPECT_EQ(im2fit_push_frame(handle, &frame), IM2FIT_OK) << im2fit_last_error(handle);
    }
    EXPECT_EQ(im2fit_finish(handle), IM2FIT_OK);
    im2fit_result result{};
    EXPECT_EQ(im2fit_poll(handle, &result, sizeof result), IM2FIT_OK);
    im2fit_close(handle);
    return result;
  };
  const im2fit_result told = measured(true), untold = measured(false);
  ASSERT_EQ(told.measured, 1) << "guidance bits " << told.guidance_seen;
  EXPECT_NEAR(told.measurements[IM2FIT_STATURE].value, result_.measurements[IM2FIT_STATURE].value, 10);
  EXPECT_NEAR(told.measurements[IM2FIT_WAIST_GIRTH].value, result_.measurements[IM2FIT_WAIST_GIRTH].value, 40);
  EXPECT_EQ(told.guidance_seen & IM2FIT_GUIDANCE_MOVING, 0U);
  EXPECT_NE(untold.guidance_seen & IM2FIT_GUIDANCE_MOVING, 0U)
      << "a picture that turns looks like one who moves; seen " << told.frames_seen << " and " << untold.frames_seen;
}

// In the caller's order, at the caller's distance; after an error nothing is written.
TEST_F(CTape, IdsComeInAnyOrderAndStructsMayGrow) {
  struct Grown {
    im2fit_tape_value value;
    char more[16];
  };
  Grown grown[3];
  std::memset(static_cast<void*>(grown), 0x55, sizeof grown);
  const char* ids[] = {"knee_girth", "head_girth", "knee_girth"};
  ASSERT_EQ(im2fit_tape(handle_, ids, 3, &grown[0].value, sizeof grown[0]), IM2FIT_OK);
  EXPECT_EQ(grown[0].value.value, grown[2].value.value);
  EXPECT_EQ(grown[1].value.status, IM2FIT_TAPE_REFUSED);
  EXPECT_EQ(grown[2].more[15], 0);
  ids[2] = "tail_length";
  grown[0].value.value = 1;
  EXPECT_EQ(im2fit_tape(handle_, ids, 3, &grown[0].value, sizeof grown[0]), IM2FIT_ERROR_NOT_FOUND);
  EXPECT_EQ(grown[0].value.value, 1);
  ids[2] = nullptr;
  EXPECT_EQ(im2fit_tape(handle_, ids, 3, &grown[0].value, sizeof grown[0]), IM2FIT_ERROR_INVALID_ARGUMENT);
  ASSERT_EQ(im2fit_reset(handle_), IM2FIT_OK);
  EXPECT_EQ(im2fit_tape(handle_, ids, 2, &grown[0].value, sizeof grown[0]), IM2FIT_ERROR_NOT_MEASURED)
      << "what was said of who is forgotten is forgotten too";
  std::size_t count = 0;
  im2fit_rig rig;
  EXPECT_EQ(im2fit_garment_fit(handle_, "t_shirt", nullptr, sizeof(im2fit_size_fit), 0, &count, nullptr),
            IM2FIT_ERROR_NOT_MEASURED);
  EXPECT_EQ(im2fit_dressed_avatar(handle_, nullptr, 0, nullptr, 0, &count), IM2FIT_ERROR_NOT_MEASURED);
  EXPECT_EQ(im2fit_live_rig(handle_, &rig, sizeof rig), IM2FIT_ERROR_NOT_MEASURED);
}

}  // namespace
}  // namespace im2fit
