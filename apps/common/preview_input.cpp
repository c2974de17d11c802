// SPDX-License-Identifier: Apache-2.0
#include "apps/common/preview_input.h"

namespace im2fit::apps {

PreviewInput preview_of(const FrameSeen& frame, const Intrinsics& intrinsics) {
  PreviewInput input;
  input.intrinsics = intrinsics;
  input.depth = frame.depth;
  input.mask = frame.mask;
  input.has_joints = frame.result.has_joints;
  input.joints = frame.result.display_joints;
  input.inferred = frame.result.joints_inferred;
  input.users.assign(frame.users.begin(), frame.users.end());
  input.measured_user = frame.result.user;
  return input;
}

}  // namespace im2fit::apps
