/* SPDX-License-Identifier: Apache-2.0
 * The smallest program on an installed im2fit. It checks that model files load and fit together.
 *   check_models TRACKER.i2t INDEX.i2f [BODY.i2b] */
#include <im2fit/im2fit.h>
#include <stdio.h>

int main(int argc, char** argv) {
  im2fit_settings settings;
  im2fit_handle* handle = NULL;
  if (argc < 3 || argc > 4) {
    fprintf(stderr, "usage: check_models TRACKER INDEX [BODY]\n");
    return 2;
  }
  im2fit_settings_init(&settings, sizeof settings);
  settings.tracker_path = argv[1];
  settings.index_path = argv[2];
  settings.body_path = argc == 4 ? argv[3] : NULL;
  settings.width = 640;
  settings.height = 480;
  settings.fx = settings.fy = 580;
  settings.cx = 319.5F;
  settings.cy = 239.5F;
  const int status = im2fit_open(&settings, &handle);
  if (status != IM2FIT_OK) {
    fprintf(stderr, "check_models: %s: %s\n", im2fit_status_name(status), im2fit_last_error(NULL));
    return 1;
  }
  printf("im2fit %s: the files fit together\n", im2fit_version());
  im2fit_close(handle);
  return 0;
}
