/* SPDX-License-Identifier: Apache-2.0 */
/* The smallest session of the C test programs. */
#ifndef IM2FIT_TESTS_C_SMALL_H
#define IM2FIT_TESTS_C_SMALL_H

#include "im2fit/im2fit.h"

enum { WIDTH = 16, HEIGHT = 12, PIXELS = WIDTH * HEIGHT };

static im2fit_settings small_settings(void) {
  im2fit_settings s;
  im2fit_settings_init(&s, sizeof s);
  s.width = WIDTH;
  s.height = HEIGHT;
  s.fx = s.fy = 14.0F;
  s.cx = 7.5F;
  s.cy = 5.5F;
  s.frames_wanted = 10;
  s.frames_min = 3;
  return s;
}

#endif
