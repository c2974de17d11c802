/* SPDX-License-Identifier: Apache-2.0
 * A recorded clip through the C library, for scripts/android-link: everything it says, floats to the last bit.
 *   clip FRAMES.raw TRACKER.i2t INDEX.i2f BODY.i2b      320x240 16-bit mm, to be turned by 90 degrees; BODY may be ""
 */
#include <im2fit/im2fit.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 320, HEIGHT = 240 };
static uint16_t depth_mm[WIDTH * HEIGHT];

static int failed(const im2fit_handle* handle, const char* what) {
  fprintf(stderr, "clip: %s: %s\n", what, im2fit_last_error(handle));
  return 1;
}

/* FNV-1a of bytes too many to print. */
static void print_digest(const char* what, const unsigned char* bytes, size_t size) {
  uint64_t digest = 14695981039346656037ULL;
  for (size_t i = 0; i < size; ++i) digest = (digest ^ bytes[i]) * 1099511628211ULL;
  printf("%s %lu bytes %016llx\n", what, (unsigned long)size, (unsigned long long)digest);
}

int main(int argc, char** argv) {
  im2fit_settings settings;
  im2fit_handle* handle = NULL;
  if (argc != 5) return fprintf(stderr, "usage: clip FRAMES TRACKER INDEX BODY\n"), 2;
  im2fit_settings_init(&settings, sizeof settings);
  settings.tracker_path = argv[2];
  settings.index_path = argv[3];
  settings.body_path = argv[4][0] ? argv[4] : NULL;
  settings.width = HEIGHT;
  settings.height = WIDTH;
  settings.fx = settings.fy = 287.9F;
  settings.cx = 119.5F;
  settings.cy = 159.5F;
  settings.frames_wanted = 6;
  if (im2fit_open(&settings, &handle) != IM2FIT_OK) return failed(NULL, "open");

  FILE* frames = fopen(argv[1], "rb");
  if (!frames) return fprintf(stderr, "clip: no %s\n", argv[1]), 1;
  im2fit_frame frame;
  im2fit_frame_init(&frame, sizeof frame);
  frame.pixels = depth_mm;
  frame.width = WIDTH;
  frame.height = HEIGHT;
  frame.rotate_deg = 90;
  for (; fread(depth_mm, sizeof depth_mm, 1, frames) == 1; ++frame.sequence, frame.time_ns += 33333333)
    if (im2fit_push_frame(handle, &frame) != IM2FIT_OK) return failed(handle, "push");
  fclose(frames);

  im2fit_result result;
  if (im2fit_finish(handle) != IM2FIT_OK) return failed(handle, "finish");
  if (im2fit_poll(handle, &result, sizeof result) != IM2FIT_OK) return failed(handle, "poll");
  printf("%s, %d frames used\n", im2fit_state_name(result.state), (int)result.frames_used);
  for (int i = 0; i < IM2FIT_MEASUREMENT_COUNT; ++i)
    printf("%s %a %a %a\n", im2fit_measurement_name(i), (double)result.measurements[i].value,
           (double)result.measurements[i].low, (double)result.measurements[i].high);
  for (int i = 0; i < IM2FIT_JOINT_COUNT; ++i)
    printf("%s %a %a %a %a\n", im2fit_joint_name(i), (double)result.joints[i].x, (double)result.joints[i].y,
           (double)result.joints[i].z, (double)result.joints[i].confidence);
  size_t size = 0;
  if (im2fit_result_json(handle, NULL, 0, &size) != IM2FIT_ERROR_TOO_SMALL) return failed(handle, "JSON");
  char* text = malloc(size + 1);
  if (!text || im2fit_result_json(handle, text, size + 1, &size) != IM2FIT_OK) return failed(handle, "JSON");
  puts(text);
  free(text);
  for (int format = IM2FIT_AVATAR_GLB; settings.body_path && format <= IM2FIT_AVATAR_BVH; ++format) {
    im2fit_avatar(handle, format, NULL, 0, &size);
    unsigned char* bytes = malloc(size);
    if (!bytes || im2fit_avatar(handle, format, bytes, size, &size) != IM2FIT_OK) return failed(handle, "avatar");
    print_digest("avatar", bytes, size);
    free(bytes);
  }
  /* Errors cross the boundary as statuses: the library's own exceptions end inside. */
  settings.tracker_path = "/nonexistent.i2t";
  im2fit_handle* none = NULL;
  printf("%s\n", im2fit_status_name(im2fit_open(&settings, &none)));
  im2fit_close(handle);
  return result.measured ? 0 : 3;
}
