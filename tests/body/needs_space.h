// SPDX-License-Identifier: Apache-2.0
// For tests that fit: skips without a body file that has a shape space.
#pragma once

#include "body_pack.h"

#define IM2FIT_NEEDS_SPACE()                       \
  IM2FIT_NEEDS_BODY();                             \
  if (real_body()->shape_space().point_count == 0) \
  GTEST_SKIP() << body_pack_path() << " has no shape space: run im2fit-lab fetch"
