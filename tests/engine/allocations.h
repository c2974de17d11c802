// SPDX-License-Identifier: Apache-2.0
// Counts every operator new of the program while armed, on all threads.
#pragma once

namespace im2fit::test {
void arm_allocation_count();
long disarm_allocation_count();  // allocations since arming
}  // namespace im2fit::test
