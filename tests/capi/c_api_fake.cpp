// SPDX-License-Identifier: Apache-2.0
// Opens a handle of the C interface on stages that read their story from the pixels (fake_stages.h).
#include "c_api_fake.h"

#include "capi/c_handle.h"
#include "tests/engine/fake_stages.h"

namespace {

im2fit::test::FakeStages::Control control;

im2fit::Result<std::unique_ptr<im2fit_handle>> open_on_fake_stages(const im2fit_settings& settings) {
  return im2fit::open_c_handle(settings, std::make_unique<im2fit::test::FakeStages>(control));
}

}  // namespace

extern "C" im2fit_handle* open_with_fake_stages(const im2fit_settings* settings) {
  auto handle = open_on_fake_stages(*settings);
  return handle ? handle->release() : nullptr;
}

extern "C" int status_of_opening(const im2fit_settings* settings) {
  const auto handle = open_on_fake_stages(*settings);
  return handle ? static_cast<int>(IM2FIT_OK) : im2fit::status_of(handle.error().code);
}

extern "C" int fake_downs(float* down_y) {
  *down_y = control.down_y;
  return control.downs;
}

extern "C" void fake_damaged_index(int damaged) {
  control.damaged = damaged != 0;
}
