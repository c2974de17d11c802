// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit/commands.h"

int main(int argc, char** argv) {
  using namespace im2fit::apps;
  cli::App app{"Measures a person with one depth camera: body measurements, a clothing size and a 3D body.",
               "im2fit"};
  app.footer(
      "SOURCE is openni2[:URI], usb[:SERIAL], v4l2:/dev/videoN, synthetic[:SEED], a .oni recording or a depth "
      "folder.\n"
      "Exit codes: 0 done, 1 failed, 2 wrong use, 3 the stream gave no measurement.");
  Command chosen;
  for (auto* add : {add_devices, add_measure, add_live, add_record, add_tape, add_try, add_models, add_sessions})
    add(app, chosen);
#if IM2FIT_HAVE_PAGE
  add_serve(app, chosen);
#endif
  return run_program(app, chosen, argc, argv);
}
