// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace im2fit::apps {

// Memory that is freed stays with the process, for programs that make meshes and pictures by the hundred kilobytes:
// handing them back to the system each time costs as many page faults as a third of a scene. Call once, before
// threads; glibc only, elsewhere nothing.
void keep_freed_memory();

}  // namespace im2fit::apps
