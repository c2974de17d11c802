/* SPDX-License-Identifier: Apache-2.0 */
/* A C program on libim2fit and libim2fit-cameras alone: the golden clip from its folder, from a .oni and through the
 * OpenNI2 runtime gives what its PNGs, read by libpng and turned by hand, give when they are pushed.
 *   cameras_test GOLDEN SCRATCH RECORDING.oni VIRTUAL      "" for either: this build cannot open it */
#include <errno.h>
#include <im2fit/cameras.h>
#include <png.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "c_check.h"

enum { STORED_WIDTH = 320, STORED_HEIGHT = 240, FRAMES = 8 };
static char golden[2048], scratch[2048], clip[2100];

/* Stands until the fourth call after. */
static const char* joined(const char* folder, const char* name) {
  static char path[4][4200];
  static int turn = 0;
  turn = (turn + 1) % 4;
  snprintf(path[turn], sizeof path[turn], "%s/%s", folder, name);
  return path[turn];
}

/* Of the clip as it is stored; upright it is turned by 90 degrees clockwise. */
static void read_upright(unsigned number, uint16_t* upright) {
  char name[32];
  snprintf(name, sizeof name, "clip/%06u.png", number);
  FILE* file = fopen(joined(golden, name), "rb");
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
  png_infop info = png_create_info_struct(png);
  if (file == NULL || setjmp(png_jmpbuf(png)) != 0) {
    fprintf(stderr, "%s cannot be read\n", name);
    exit(1);
  }
  png_init_io(png, file);
  png_read_png(png, info, PNG_TRANSFORM_SWAP_ENDIAN, NULL);
  CHECK(png_get_image_width(png, info) == STORED_WIDTH && png_get_image_height(png, info) == STORED_HEIGHT);
  for (size_t v = 0; v < STORED_WIDTH; ++v)
    for (size_t u = 0; u < STORED_HEIGHT; ++u)
      upright[v * STORED_HEIGHT + u] = ((const uint16_t*)(void*)png_get_rows(png, info)[STORED_HEIGHT - 1 - u])[v];
  png_destroy_read_struct(&png, &info, NULL);
  fclose(file);
}

static im2fit_settings clip_settings(void) {
  static char tracker[4200], index[4200];
  snprintf(tracker, sizeof tracker, "%s", joined(golden, "tracker.i2t"));
  snprintf(index, sizeof index, "%s", joined(golden, "index.i2f"));
  im2fit_settings s;
  im2fit_settings_init(&s, sizeof s);
  s.tracker_path = tracker;
  s.index_path = index;
  s.frames_wanted = FRAMES;
  return s;
}

/* Closes. */
static im2fit_result end_of(im2fit_handle* handle) {
  im2fit_result result;
  memset(&result, 0, sizeof result);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &result, sizeof result) == IM2FIT_OK);
  im2fit_close(handle);
  return result;
}

static im2fit_result answer_of(im2fit_handle* handle) {
  const im2fit_result result = end_of(handle);
  CHECK(result.measured == 1);
  return result;
}

/* The truth: what the frames give when they are pushed. `s` as described. */
static im2fit_result pushed(im2fit_settings s) {
  static uint16_t depth[STORED_WIDTH * STORED_HEIGHT];
  im2fit_handle* handle = NULL;
  s.live = 0;
  CHECK(im2fit_open(&s, &handle) == IM2FIT_OK);
  for (unsigned i = 0; i < FRAMES; ++i) {
    read_upright(i, depth);
    CHECK(im2fit_push(handle, depth, STORED_HEIGHT, STORED_WIDTH, 0, i, (int64_t)i * 33333333) == IM2FIT_OK);
  }
  return answer_of(handle);
}

/* The end after frames of `uri`, at most FRAMES of them. */
static im2fit_result pumped_to_the_end(im2fit_settings s, const char* uri, const im2fit_cameras_options* options) {
  im2fit_handle* handle = NULL;
  s.live = 0;
  CHECK(im2fit_open(&s, &handle) == IM2FIT_OK);
  CHECK(im2fit_cameras_use(handle, options) == IM2FIT_OK);
  const int attached = im2fit_attach(handle, uri);
  CHECK(attached == IM2FIT_OK);
  if (attached != IM2FIT_OK) fprintf(stderr, "%s; %s\n", im2fit_last_error(handle), im2fit_cameras_error());
  int status = attached;
  for (int i = 0; i < FRAMES && status == IM2FIT_OK; ++i) status = im2fit_pump(handle, 5000);
  CHECK(status == IM2FIT_OK);
  return end_of(handle);
}

static im2fit_result pumped(im2fit_settings s, const char* uri, const im2fit_cameras_options* options) {
  const im2fit_result result = pumped_to_the_end(s, uri, options);
  CHECK(result.measured == 1);
  return result;
}

static void same_answers(const im2fit_result* a, const im2fit_result* b) {
  CHECK(a->frames_used == b->frames_used && a->frames_used >= 5);
  CHECK(memcmp(a->measurements, b->measurements, sizeof a->measurements) == 0);
  CHECK(memcmp(a->paper, b->paper, sizeof a->paper) == 0);
  CHECK(memcmp(a->joints, b->joints, sizeof a->joints) == 0);
  CHECK(memcmp(&a->female, &b->female, sizeof a->female) == 0 && a->index_entry == b->index_entry);
}

static void a_folder(void) {
  const char* uri = clip;
  im2fit_settings s = clip_settings();
  CHECK(im2fit_cameras_describe(uri, NULL, &s) == IM2FIT_OK);
  /* camera.yaml: 287.9 0 159.5, 287.9 119.5, to be turned by 90 degrees. */
  CHECK(s.width == STORED_HEIGHT && s.height == STORED_WIDTH && s.live == 0);
  CHECK(s.fx == 287.9F && s.fy == 287.9F && s.cx == 119.5F && s.cy == 159.5F);
  const im2fit_result truth = pushed(s);
  const im2fit_result seen = pumped(s, uri, NULL);
  same_answers(&truth, &seen);

  im2fit_cameras_options options;
  im2fit_cameras_options_init(&options, sizeof options);
  options.rotate_deg = 0;
  CHECK(im2fit_cameras_describe(uri, &options, &s) == IM2FIT_OK);
  CHECK(s.width == STORED_WIDTH && s.height == STORED_HEIGHT && s.cx == 159.5F);
  options.rotate_deg = -1;
  char other[2200];
  snprintf(other, sizeof other, "%s/other.yaml", scratch);
  options.calibration_path = other;
  FILE* yaml = fopen(other, "w");
  CHECK(yaml != NULL);
  if (yaml == NULL) return;
  fputs(
      "image_width: 320\nimage_height: 240\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: [300, 0, 150, 0, 290, 110, 0, 0, 1]\n",
      yaml);
  fclose(yaml);
  CHECK(im2fit_cameras_describe(uri, &options, &s) == IM2FIT_OK);
  CHECK(s.fx == 300.0F && s.cy == 110.0F);
}

static void a_recording(const char* uri) {
  im2fit_settings s = clip_settings();
  CHECK(im2fit_cameras_describe(uri, NULL, &s) == IM2FIT_OK);
  CHECK(s.width == STORED_HEIGHT && s.height == STORED_WIDTH);
  const im2fit_result truth = pushed(s);
  const im2fit_result seen = pumped(s, uri, NULL);
  same_answers(&truth, &seen);

  /* Cut off in the middle: its checksum, in FILE.oni.yaml, is another. */
  static char bytes[1 << 20];
  FILE* from = fopen(uri, "rb");
  FILE* to = fopen(joined(scratch, "cut.oni"), "wb");
  CHECK(from != NULL && to != NULL);
  if (from == NULL || to == NULL) return;
  const size_t size = fread(bytes, 1, sizeof bytes, from);
  CHECK(size > 1000 && size < sizeof bytes);
  CHECK(fwrite(bytes, 1, size / 2, to) == size / 2);
  fclose(from);
  fclose(to);
  char beside[4200];
  snprintf(beside, sizeof beside, "%s.yaml", uri);
  from = fopen(beside, "rb");
  to = fopen(joined(scratch, "cut.oni.yaml"), "wb");
  CHECK(from != NULL && to != NULL);
  if (from == NULL || to == NULL) return;
  const size_t told = fread(bytes, 1, sizeof bytes, from);
  CHECK(fwrite(bytes, 1, told, to) == told);
  fclose(from);
  fclose(to);
  CHECK(im2fit_cameras_describe(joined(scratch, "cut.oni"), NULL, &s) == IM2FIT_ERROR_CORRUPT);
  CHECK(strstr(im2fit_cameras_error(), "cut.oni") != NULL && strstr(im2fit_cameras_error(), "checksum") != NULL);
}

/* The clip upright, and where down is said to be in its first frame: ten degrees off, so that the person leans. */
static void a_recording_that_feels_gravity(void) {
  static uint16_t depth[STORED_WIDTH * STORED_HEIGHT];
  const float down[3] = {0, 0.9848F, 0.1736F};
  char folder[2100];
  snprintf(folder, sizeof folder, "%s/gravity", scratch);
  CHECK(mkdir(folder, 0755) == 0 || errno == EEXIST);
  FILE* yaml = fopen(joined(folder, "camera.yaml"), "w");
  FILE* times = fopen(joined(folder, "timestamps.csv"), "w");
  CHECK(yaml != NULL && times != NULL);
  if (yaml == NULL || times == NULL) return;
  fputs(
      "image_width: 240\nimage_height: 320\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
      "  data: [287.9, 0, 119.5, 0, 287.9, 159.5, 0, 0, 1]\n",
      yaml);
  fclose(yaml);
  im2fit_settings s = clip_settings();
  im2fit_handle* handle = NULL;
  fputs("frame,host_ns,down_x,down_y,down_z\n", times);
  for (unsigned i = 0; i < FRAMES; ++i) {
    char name[32];
    snprintf(name, sizeof name, "%06u.pgm", i);
    FILE* picture = fopen(joined(folder, name), "wb");
    CHECK(picture != NULL);
    if (picture == NULL) return;
    fprintf(picture, "P5 %d %d 65535\n", STORED_HEIGHT, STORED_WIDTH);
    read_upright(i, depth);
    for (size_t k = 0; k < sizeof depth / sizeof *depth; ++k) {
      fputc(depth[k] >> 8, picture);
      fputc(depth[k] & 255, picture);
    }
    fclose(picture);
    fprintf(times, "%u,%lld,", i, (long long)i * 33333333);
    if (i == 0) fprintf(times, "%.9g,%.9g,%.9g", (double)down[0], (double)down[1], (double)down[2]);
    fputs(i == 0 ? "\n" : ",,\n", times);
  }
  fclose(times);

  CHECK(im2fit_cameras_describe(folder, NULL, &s) == IM2FIT_OK);
  CHECK(pushed(s).measured == 1);
  CHECK(im2fit_open(&s, &handle) == IM2FIT_OK);
  for (unsigned i = 0; i < FRAMES; ++i) {
    im2fit_frame frame;
    im2fit_frame_init(&frame, sizeof frame);
    read_upright(i, depth);
    frame.pixels = depth;
    frame.width = STORED_HEIGHT;
    frame.height = STORED_WIDTH;
    frame.sequence = i;
    frame.time_ns = (int64_t)i * 33333333;
    if (i == 0) {
      frame.down_x = down[0];
      frame.down_y = down[1];
      frame.down_z = down[2];
    }
    CHECK(im2fit_push_frame(handle, &frame) == IM2FIT_OK);
  }
  const im2fit_result truth = end_of(handle);
  const im2fit_result seen = pumped_to_the_end(s, folder, NULL);
  CHECK(truth.measured == 0 && truth.guidance != 0);
  CHECK(seen.measured == 0 && seen.guidance == truth.guidance && seen.frames_seen == truth.frames_seen);
}

/* The virtual device shows the clip again and again, by what the runtime says of its lens. */
static void a_camera(void) {
  char uri[4200];
  im2fit_settings none = clip_settings();
  CHECK(im2fit_cameras_describe("openni2:nonexistent", NULL, &none) == IM2FIT_ERROR_NO_DEVICE);
  CHECK(strstr(im2fit_cameras_error(), "nonexistent") != NULL);
  snprintf(uri, sizeof uri, "openni2:im2fit-virtual://77?folder=%s&fps=20", clip);
  im2fit_cameras_options options;
  im2fit_cameras_options_init(&options, sizeof options);
  options.rotate_deg = 90;
  im2fit_settings s = clip_settings();
  const int described = im2fit_cameras_describe(uri, &options, &s);
  CHECK(described == IM2FIT_OK);
  if (described != IM2FIT_OK) fprintf(stderr, "%s\n", im2fit_cameras_error());
  CHECK(s.width == STORED_HEIGHT && s.height == STORED_WIDTH && s.live == 1);
  const im2fit_result truth = pushed(s);
  /* A machine that is busy may lose a frame, which the numbers of the frames tell: then again. */
  for (int attempt = 0; attempt < 5; ++attempt) {
    const im2fit_result seen = pumped(s, uri, &options);
    if (seen.sequence_gaps > 0 && attempt < 4) continue;
    CHECK(seen.sequence_gaps == 0);
    same_answers(&truth, &seen);
    break;
  }
}

static void what_cannot_be_opened_is_said(void) {
  im2fit_settings s = clip_settings();
  const im2fit_settings before = s;
  CHECK(im2fit_cameras_describe(NULL, NULL, &s) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_cameras_describe("x", NULL, NULL) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_cameras_describe("telepathy:1", NULL, &s) == IM2FIT_ERROR_NOT_FOUND);
  CHECK(strstr(im2fit_cameras_error(), "telepathy:1") != NULL && strstr(im2fit_cameras_error(), "openni2") != NULL);
  CHECK(im2fit_cameras_describe("synthetic:1", NULL, &s) == IM2FIT_ERROR_UNSUPPORTED);
  CHECK(im2fit_cameras_describe("v4l2:/dev/nonexistent", NULL, &s) == IM2FIT_ERROR_NOT_FOUND);
  CHECK(strstr(im2fit_cameras_error(), "/dev/nonexistent") != NULL);
  CHECK(memcmp(&s, &before, sizeof s) == 0);
  im2fit_cameras_options options;
  im2fit_cameras_options_init(&options, sizeof options);
  options.rotate_deg = 45;
  CHECK(im2fit_cameras_describe(clip, &options, &s) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_cameras_error(), "45") != NULL);
  options.rotate_deg = 0;
  options.unit_mm = 0;
  CHECK(im2fit_cameras_describe(clip, &options, &s) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_cameras_error(), "unit_mm") != NULL);
  options.unit_mm = 1;
  options.width = 0;
  CHECK(im2fit_cameras_use(NULL, &options) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_cameras_error(), "width") != NULL);
  options.struct_size = 3;
  CHECK(im2fit_cameras_use(NULL, &options) == IM2FIT_ERROR_UNSUPPORTED);
  CHECK(im2fit_cameras_use(NULL, NULL) == IM2FIT_ERROR_INVALID_ARGUMENT);

  /* A folder whose pictures are no pictures. */
  const char* folder = joined(scratch, "torn");
  CHECK(mkdir(folder, 0755) == 0 || errno == EEXIST);
  FILE* torn = fopen(joined(folder, "000000.png"), "wb");
  CHECK(torn != NULL && fputs("no picture", torn) >= 0);
  if (torn != NULL) fclose(torn);
  options = (im2fit_cameras_options){0};
  im2fit_cameras_options_init(&options, sizeof options);
  options.calibration_path = joined(golden, "clip/camera.yaml");
  CHECK(im2fit_cameras_describe(folder, &options, &s) == IM2FIT_ERROR_CORRUPT);

  /* By a handle. */
  CHECK(im2fit_cameras_describe(clip, NULL, &s) == IM2FIT_OK);
  im2fit_handle* handle = NULL;
  CHECK(im2fit_open(&s, &handle) == IM2FIT_OK);
  CHECK(im2fit_cameras_use(handle, NULL) == IM2FIT_OK);
  CHECK(im2fit_attach(handle, "telepathy:1") == IM2FIT_ERROR_NOT_FOUND);
  CHECK(strstr(im2fit_last_error(handle), "telepathy:1") != NULL);
  CHECK(strstr(im2fit_last_error(handle), "not_found") != NULL);
  CHECK(strstr(im2fit_cameras_error(), "does not exist") != NULL);
  CHECK(im2fit_attach(handle, "v4l2:/dev/nonexistent") == IM2FIT_ERROR_NOT_FOUND);
  CHECK(strstr(im2fit_cameras_error(), "plugged in") != NULL);
  CHECK(im2fit_pump(handle, 0) == IM2FIT_ERROR_INVALID_ARGUMENT);
  /* One of another size: its frames are not pushed. */
  im2fit_cameras_options turned;
  im2fit_cameras_options_init(&turned, sizeof turned);
  turned.rotate_deg = 0;
  CHECK(im2fit_cameras_use(handle, &turned) == IM2FIT_OK);
  CHECK(im2fit_attach(handle, clip) == IM2FIT_OK);
  CHECK(im2fit_pump(handle, 1000) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_cameras_error(), "320x240") != NULL && strstr(im2fit_cameras_error(), "240x320") != NULL);
  /* To the end of a folder, and one after the other. */
  CHECK(im2fit_cameras_use(handle, NULL) == IM2FIT_OK);
  for (int again = 0; again < 2; ++again) {
    CHECK(im2fit_attach(handle, clip) == IM2FIT_OK);
    for (int i = 0; i < FRAMES; ++i) CHECK(im2fit_pump(handle, 1000) == IM2FIT_OK);
    CHECK(im2fit_pump(handle, 1000) == IM2FIT_ERROR_END_OF_STREAM);
  }
  im2fit_close(handle);
}

int main(int argc, char** argv) {
  if (argc != 5) return fprintf(stderr, "usage: cameras_test GOLDEN SCRATCH RECORDING.oni VIRTUAL\n"), 2;
  snprintf(golden, sizeof golden, "%s", argv[1]);
  snprintf(scratch, sizeof scratch, "%s", argv[2]);
  snprintf(clip, sizeof clip, "%s/clip", golden);
  CHECK(mkdir(scratch, 0755) == 0 || errno == EEXIST);
  what_cannot_be_opened_is_said();
  a_folder();
  a_recording_that_feels_gravity();
  if (argv[3][0] != '\0') a_recording(argv[3]);
  if (argv[4][0] != '\0') a_camera();
  return check_failures == 0 ? 0 : 1;
}
