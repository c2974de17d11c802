// SPDX-License-Identifier: Apache-2.0
// Processor time of the calling thread: the cost of a part, independent of other load.
#pragma once

#include <ctime>

namespace im2fit::lab {

class Stopwatch {
 public:
  // Seconds since construction or the last lap.
  double lap() {
    const double now = seconds();
    const double passed = now - last_;
    last_ = now;
    return passed;
  }

 private:
  static double seconds() {
    std::timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  double last_ = seconds();
};

}  // namespace im2fit::lab
