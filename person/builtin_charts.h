// SPDX-License-Identifier: Apache-2.0
// The text of the charts compiled in, so that a device needs no files for them.
#pragma once

namespace im2fit {
extern const char* const kBuiltinMenChart;
extern const char* const kBuiltinWomenChart;
}  // namespace im2fit
