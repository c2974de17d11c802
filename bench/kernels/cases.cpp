// SPDX-License-Identifier: Apache-2.0
#include "bench/kernels/cases.h"

namespace im2fit::bench {

void add_fpfh_cases(Cases& cases);
void add_unproject_cases(Cases& cases);

Cases all_cases() {
  Cases cases;
  for (const auto add : {add_unproject_cases, add_fpfh_cases}) add(cases);
  return cases;
}

}  // namespace im2fit::bench
