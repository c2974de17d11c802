// SPDX-License-Identifier: Apache-2.0
// How often operator new has run in this program (model_test.cpp replaces it).
#pragma once

#include <cstddef>

namespace im2fit::body {

std::size_t allocations_so_far();

}  // namespace im2fit::body
