/* SPDX-License-Identifier: Apache-2.0
 * Measures the person in a folder of 16-bit depth pictures (000000.png ..., mm).
 *   measure_folder FOLDER TRACKER.i2t INDEX.i2f FX FY CX CY [ROTATE]
 * FX FY CX CY: intrinsics of the depth camera, pixels of its pictures. ROTATE: clockwise rotation that makes them
 * upright: 0, 90, 180, 270. */
#include <im2fit/im2fit.h>
#include <png.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct picture {
  int32_t width, height;
  uint16_t* depth_mm;
} picture;

/* Returns 1 when read, 0 when the file does not exist or is not a 16-bit grey PNG. */
static int read_picture(const char* path, picture* out) {
  FILE* file = fopen(path, "rb");
  if (file == NULL) return 0;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
  png_infop info = png_create_info_struct(png);
  int good = 0;
  out->depth_mm = NULL;
  if (setjmp(png_jmpbuf(png)) == 0) {
    png_init_io(png, file);
    png_read_png(png, info, PNG_TRANSFORM_SWAP_ENDIAN, NULL);
    out->width = (int32_t)png_get_image_width(png, info);
    out->height = (int32_t)png_get_image_height(png, info);
    good = png_get_bit_depth(png, info) == 16 && png_get_channels(png, info) == 1;
    size_t row = (size_t)out->width;
    out->depth_mm = malloc(row * (size_t)out->height * sizeof(uint16_t));
    for (int32_t v = 0; good && v < out->height; ++v)
      for (size_t u = 0; u < row; ++u)
        out->depth_mm[(size_t)v * row + u] = ((const uint16_t*)(void*)png_get_rows(png, info)[v])[u];
  }
  png_destroy_read_struct(&png, &info, NULL);
  fclose(file);
  return good;
}

static int failed(const im2fit_handle* handle, const char* what) {
  fprintf(stderr, "measure_folder: %s: %s\n", what, im2fit_last_error(handle));
  return 1;
}

/* The settings are of the upright picture: im2fit_frame.rotate_deg has the formulas. */
static void set_upright(im2fit_settings* to, const im2fit_frame* k, const picture* p) {
  const int quarter = k->rotate_deg == 90 || k->rotate_deg == 270;
  const float right = (float)p->width - 1 - k->cx, below = (float)p->height - 1 - k->cy; /* of the principal point */
  to->width = quarter ? p->height : p->width, to->height = quarter ? p->width : p->height;
  to->fx = quarter ? k->fy : k->fx, to->fy = quarter ? k->fx : k->fy;
  to->cx = k->rotate_deg == 90 ? below : k->rotate_deg == 180 ? right : k->rotate_deg == 270 ? k->cy : k->cx;
  to->cy = k->rotate_deg == 90 ? k->cx : k->rotate_deg == 180 ? below : k->rotate_deg == 270 ? right : k->cy;
}

int main(int argc, char** argv) {
  char path[4096];
  picture frame = {0, 0, NULL};
  im2fit_settings settings;
  im2fit_handle* handle = NULL;
  if (argc != 8 && argc != 9)
    return fprintf(stderr, "usage: measure_folder FOLDER TRACKER INDEX FX FY CX CY [ROTATE]\n"), 2;
  snprintf(path, sizeof path, "%s/000000.png", argv[1]);
  if (!read_picture(path, &frame)) return fprintf(stderr, "measure_folder: %s: no 16-bit PNG\n", path), 1;

  im2fit_settings_init(&settings, sizeof settings);
  settings.tracker_path = argv[2];
  settings.index_path = argv[3];
  im2fit_frame pushed;
  im2fit_frame_init(&pushed, sizeof pushed);
  pushed.fx = strtof(argv[4], NULL), pushed.fy = strtof(argv[5], NULL);
  pushed.cx = strtof(argv[6], NULL), pushed.cy = strtof(argv[7], NULL);
  pushed.rotate_deg = argc == 9 ? atoi(argv[8]) : 0;
  set_upright(&settings, &pushed, &frame);
  if (im2fit_open(&settings, &handle) != IM2FIT_OK) return failed(NULL, "open");
  for (unsigned number = 0; number == 0 || read_picture(path, &frame);) {
    pushed.pixels = frame.depth_mm, pushed.width = frame.width, pushed.height = frame.height;
    pushed.sequence = number;
    if (im2fit_push_frame(handle, &pushed) != IM2FIT_OK) return failed(handle, path);
    free(frame.depth_mm);
    snprintf(path, sizeof path, "%s/%06u.png", argv[1], ++number);
  }

  im2fit_result result;
  if (im2fit_finish(handle) != IM2FIT_OK) return failed(handle, "finish");
  if (im2fit_poll(handle, &result, sizeof result) != IM2FIT_OK) return failed(handle, "poll");
  printf("%s, %d of %d frames used\n", im2fit_state_name(result.state), (int)result.frames_used,
         (int)result.frames_seen);
  for (int i = 0; result.measured && i < IM2FIT_MEASUREMENT_COUNT; ++i)
    printf("%-17s %7.1f %s  [%.1f, %.1f]\n", im2fit_measurement_name(i), (double)result.measurements[i].value,
           im2fit_measurement_unit(i), (double)result.measurements[i].low, (double)result.measurements[i].high);
  for (int bit = 0; !result.measured && bit < IM2FIT_GUIDANCE_COUNT; ++bit)
    if (result.guidance_seen >> bit & 1) printf("%s\n", im2fit_guidance_text(bit, "en"));
  im2fit_close(handle);
  return result.measured ? 0 : 3;
}
