// SPDX-License-Identifier: Apache-2.0
// Opens a handle of the C interface on stages that read their story from the pixels (fake_stages.h).
#include "c_api_fake.h"

#include "engine/c_handle.h"
#include "fake_stages.h"

extern "C" im2fit_handle* open_with_fake_stages(const im2fit_settings* settings) {
  static im2fit::test::FakeStages::Control control;
  auto handle = im2fit::open_c_handle(*settings, std::make_unique<im2fit::test::FakeStages>(control));
  return handle ? handle->release() : nullptr;
}
