// SPDX-License-Identifier: Apache-2.0
// im2fit-oni-reader FILE FD: plays a recording into a pipe, so that a damaged one harms this process only. Started by
// OniSource, not by hand.
#include <unistd.h>

#include <cstdlib>

#include "hal/openni2/oni_reader.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const int fd = std::atoi(argv[2]);
  ::_exit(
      im2fit::hal::serve_oni(argv[1], fd));  // no destructors of the runtime's: they may not survive the recording
}
