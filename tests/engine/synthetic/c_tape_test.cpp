// SPDX-License-Identifier: Apache-2.0
// A rendered person measured through the C functions on the files of the environment: the tape by id, and that it is
// of the body the other functions speak of.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "engine/include/im2fit/im2fit.h"
#include "hal/source.h"
#include "lab/camera/virtual_camera.h"
#include "lab/population/population.h"

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
    im2fit_settings settings;
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
    std::vector<std::uint16_t> seen(static_cast<std::size_t>(kWidth) * kHeight), frame(seen.size());
    for (std::uint64_t i = 0; i < kFrames; ++i) {
      scene.render(i, {seen.data(), kWidth, kHeight});
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

  im2fit_handle* handle_ = nullptr;
  im2fit_result result_{};
};

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
}

}  // namespace
}  // namespace im2fit
