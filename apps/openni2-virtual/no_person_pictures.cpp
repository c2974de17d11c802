// SPDX-License-Identifier: Apache-2.0
// In builds without synth, such as a tablet's: the device replays folders only.
#include "pictures.h"

namespace im2fit::openni2_virtual {

Result<std::unique_ptr<Pictures>> person_pictures(const Settings& /*settings*/) {
  return Error{ErrorCode::unsupported,
               "this virtual camera was built without the synthetic person; give folder=PATH of a depth folder"};
}

}  // namespace im2fit::openni2_virtual
