/* SPDX-License-Identifier: Apache-2.0 */
/* The C interface used wrongly: each call answers with a status and a text that says what is wrong, and none hangs,
 * crashes or keeps an old text. On stages that read their story from the pixels, as c_api_test.c. */
#define _POSIX_C_SOURCE 200809L
#include <fcntl.h>
#include <math.h>
#include <stdint.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "c_api_fake.h"
#include "c_check.h"
#include "c_small.h"

static void make_frame(uint16_t* depth) {
  memset(depth, 0, PIXELS * sizeof *depth);
  depth[0] = depth[4] = 1;
  depth[6] = IM2FIT_VIEW_FRONT;
}

/* `field` is what the text must name, before any file is looked for. */
static void refused(const im2fit_settings* settings, const char* field) {
  im2fit_handle* handle = (im2fit_handle*)&handle;
  CHECK(im2fit_open(settings, &handle) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(handle == NULL);
  if (strncmp(im2fit_last_error(NULL), field, strlen(field)) != 0) {
    fprintf(stderr, "expected %s..., got %s\n", field, im2fit_last_error(NULL));
    ++check_failures;
  }
}

static void settings_out_of_range_are_named(void) {
  im2fit_settings good = small_settings();
  good.tracker_path = "/nonexistent.i2t";
  good.index_path = "/nonexistent.i2f";
  im2fit_handle* handle = NULL;
  CHECK(im2fit_open(&good, &handle) == IM2FIT_ERROR_NOT_FOUND);
  struct {
    size_t offset;
    int32_t value;
    const char* text;
  } const wrong[] = {
      {offsetof(im2fit_settings, width), 0, "settings.width is 0"},
      {offsetof(im2fit_settings, height), 4096, "settings.height is 4096"},
      {offsetof(im2fit_settings, frames_wanted), 0, "settings.frames_wanted is 0"},
      {offsetof(im2fit_settings, frames_wanted), 1001, "settings.frames_wanted is 1001"},
      {offsetof(im2fit_settings, frames_min), 11, "settings.frames_min is 11"},
      {offsetof(im2fit_settings, frames_min), 0, "settings.frames_min is 0"},
      {offsetof(im2fit_settings, calibration_psi), 2, "settings.calibration_psi is 2"},
      {offsetof(im2fit_settings, live), 2, "settings.live is 2"},
      {offsetof(im2fit_settings, live), -1, "settings.live is -1"},
      {offsetof(im2fit_settings, single_thread), 7, "settings.single_thread is 7"},
      {offsetof(im2fit_settings, pool_frames), 2, "settings.pool_frames is 2"},
      {offsetof(im2fit_settings, pool_frames), 65, "settings.pool_frames is 65"},
      {offsetof(im2fit_settings, user_id), -1, "settings.user_id is -1"},
      {offsetof(im2fit_settings, turn), -1, "settings.turn is -1"},
      {offsetof(im2fit_settings, clothing), 3, "settings.clothing is 3"},
      {offsetof(im2fit_settings, sensor), -1, "settings.sensor is -1"},
      {offsetof(im2fit_settings, tracker_data.kind), 3, "settings.tracker_data.kind is 3"},
      {offsetof(im2fit_settings, tracker_data.kind), IM2FIT_DATA_MEMORY, "settings.tracker_data.size is 0"},
      {offsetof(im2fit_settings, calibration_site_data.kind), 3, "settings.calibration_site_data.kind is 3"},
      {offsetof(im2fit_settings, body_data.kind), IM2FIT_DATA_FD, "settings.body_data.size is 0"},
  };
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
    im2fit_settings s = good;
    memcpy((char*)&s + wrong[i].offset, &wrong[i].value, sizeof wrong[i].value);
    refused(&s, wrong[i].text);
  }
  im2fit_settings s = good;
  s.fx = NAN;
  refused(&s, "settings: the focal length fx");
  s = good;
  s.cy = 1e9F;
  refused(&s, "settings: the principal point cy");
  s = good;
  s.body_data.kind = IM2FIT_DATA_MEMORY;
  s.body_data.size = 16;
  refused(&s, "settings.body_data.bytes is NULL");
  s.body_data.bytes = "0123456789abcdef";
  s.tracker_data = s.body_data;
  CHECK(im2fit_open(&s, &handle) == IM2FIT_ERROR_CORRUPT);
  CHECK(strncmp(im2fit_last_error(NULL), "settings.tracker_data", 21) == 0);
  s.body_data.kind = IM2FIT_DATA_FD;
  s.body_data.fd = -1;
  CHECK(im2fit_open(&s, &handle) == IM2FIT_ERROR_IO);
  s.body_data.offset = -1;
  refused(&s, "settings.body_data.offset is -1");
}

/* The text is that of the latest call, and NULL's that of the thread's latest failure. */
static void errors_are_of_the_latest_call(void) {
  im2fit_settings settings = small_settings();
  im2fit_handle* handle = open_with_fake_stages(&settings);
  im2fit_result result;
  CHECK(im2fit_select_user(handle, -5) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_last_error(handle), "-5") != NULL);
  CHECK(strcmp(im2fit_last_error(NULL), im2fit_last_error(handle)) == 0);
  CHECK(im2fit_set_region(handle, 500, 1000, -500, 3000) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_last_error(handle), "expected x0 < x1") != NULL);
  CHECK(im2fit_set_region(handle, -500, 1000, 30000, 3000) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_set_region(handle, -500, 1000, 500, 3000) == IM2FIT_OK);
  CHECK(im2fit_set_region(handle, 0, 0, 0, 0) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, NULL, sizeof result) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_last_error(NULL), "result") != NULL);
  CHECK(im2fit_poll(NULL, &result, sizeof result) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strcmp(im2fit_last_error(NULL), "the handle is NULL") == 0);
  CHECK(im2fit_reset(handle) == IM2FIT_OK);
  CHECK(im2fit_last_error(handle)[0] == '\0');
  im2fit_close(handle);
}

static void every_function_refuses_null(void) {
  im2fit_settings settings = small_settings();
  im2fit_handle* handle = open_with_fake_stages(&settings);
  uint16_t depth[PIXELS];
  size_t n = 0;
  const int invalid = IM2FIT_ERROR_INVALID_ARGUMENT;
  make_frame(depth);
  CHECK(im2fit_push_frame(NULL, NULL) == invalid);
  CHECK(im2fit_push_frame(handle, NULL) == invalid);
  CHECK(im2fit_wait(NULL, 1) == invalid);
  CHECK(im2fit_finish(NULL) == invalid && im2fit_reset(NULL) == invalid && im2fit_next(NULL) == invalid);
  CHECK(im2fit_set_opener_down(NULL, NULL) == invalid);
  CHECK(im2fit_set_opener(NULL, NULL, NULL) == invalid && im2fit_attach(NULL, "x") == invalid);
  CHECK(im2fit_pump(NULL, 0) == invalid && im2fit_detach(NULL) == invalid);
  CHECK(im2fit_sizes(NULL, NULL, 0, &n, NULL) == invalid);
  CHECK(im2fit_body_mesh(NULL, NULL, 0, &n, NULL, 0, &n) == invalid);
  CHECK(im2fit_result_json(NULL, NULL, 0, &n) == invalid);
  CHECK(im2fit_result_json(handle, NULL, 0, NULL) == invalid);
  CHECK(im2fit_result_json(handle, NULL, 5, &n) == invalid);
  CHECK(im2fit_avatar(handle, 3, NULL, 0, &n) == invalid);
  CHECK(im2fit_avatar(handle, IM2FIT_AVATAR_GLB, NULL, 0, &n) == IM2FIT_ERROR_UNSUPPORTED);
  im2fit_size_fit fit;
  im2fit_rig rig;
  const im2fit_worn worn[5] = {{"t_shirt", NULL}, {NULL, NULL}};
  CHECK(im2fit_garment_fit(NULL, "t_shirt", &fit, sizeof fit, 1, &n, NULL) == invalid);
  CHECK(im2fit_garment_fit(handle, NULL, &fit, sizeof fit, 1, &n, NULL) == invalid);
  CHECK(im2fit_garment_fit(handle, "t_shirt", NULL, sizeof fit, 1, &n, NULL) == invalid);
  CHECK(im2fit_garment_fit(handle, "t_shirt", &fit, sizeof fit, 1, NULL, NULL) == invalid);
  CHECK(im2fit_garment_fit(handle, "t_shirt", &fit, sizeof fit - 1, 1, &n, NULL) == invalid);
  CHECK(strstr(im2fit_last_error(handle), "fit_size") != NULL);
  CHECK(im2fit_garment_fit(handle, "t_shirt", &fit, sizeof fit, 1, &n, NULL) == IM2FIT_ERROR_UNSUPPORTED);
  CHECK(im2fit_dressed_avatar(NULL, NULL, 0, NULL, 0, &n) == invalid);
  CHECK(im2fit_dressed_avatar(handle, NULL, 0, NULL, 0, NULL) == invalid);
  CHECK(im2fit_dressed_avatar(handle, NULL, 0, NULL, 5, &n) == invalid);
  CHECK(im2fit_dressed_avatar(handle, NULL, 1, NULL, 0, &n) == invalid);
  CHECK(im2fit_dressed_avatar(handle, worn, 2, NULL, 0, &n) == invalid);
  CHECK(im2fit_dressed_avatar(handle, worn, 5, NULL, 0, &n) == invalid);
  CHECK(im2fit_dressed_avatar(handle, NULL, 0, NULL, 0, &n) == IM2FIT_ERROR_UNSUPPORTED);
  im2fit_models models;
  CHECK(im2fit_get_models(NULL, &models, sizeof models) == invalid);
  CHECK(im2fit_get_models(handle, NULL, sizeof models) == invalid);
  CHECK(im2fit_get_models(handle, &models, sizeof models) == IM2FIT_OK && models.people == 0 && models.made_by[0] == 0);
  CHECK(im2fit_live_rig(NULL, &rig, sizeof rig) == invalid && im2fit_live_rig(handle, NULL, sizeof rig) == invalid);
  CHECK(im2fit_live_rig(handle, &rig, sizeof rig) == IM2FIT_ERROR_UNSUPPORTED);
  im2fit_frame_init(NULL, 8);
  im2fit_settings_init(NULL, 8);
  im2fit_close(NULL);
  im2fit_close(handle);
}

static void frames_out_of_range_are_named(void) {
  im2fit_settings settings = small_settings();
  im2fit_handle* handle = open_with_fake_stages(&settings);
  uint16_t depth[PIXELS];
  make_frame(depth);
  im2fit_frame good;
  im2fit_frame_init(&good, sizeof good);
  good.pixels = depth;
  good.width = WIDTH;
  good.height = HEIGHT;
  CHECK(good.unit_mm == 1.0F && good.device_us == -1 && good.struct_size == sizeof good);
  CHECK(im2fit_push_frame(handle, &good) == IM2FIT_OK);
  im2fit_frame f;
#define REFUSED(field_of, status, text)                       \
  do {                                                        \
    f = good;                                                 \
    field_of;                                                 \
    CHECK(im2fit_push_frame(handle, &f) == (status));         \
    CHECK(strstr(im2fit_last_error(handle), (text)) != NULL); \
  } while (0)
  const int invalid = IM2FIT_ERROR_INVALID_ARGUMENT;
  REFUSED(f.struct_size = 8, IM2FIT_ERROR_UNSUPPORTED, "struct_size");
  REFUSED(f.pixels = NULL, invalid, "frame.pixels");
  REFUSED(f.pixels = (const char*)depth + 1, invalid, "frame.pixels");
  REFUSED(f.format = 3, invalid, "frame.format is 3");
  REFUSED(f.rotate_deg = 45, invalid, "frame.rotate_deg is 45");
  REFUSED(f.rotate_deg = 90, invalid, "12x16");
  REFUSED(f.width = 0, invalid, "0x12");
  REFUSED(f.row_bytes = 2 * WIDTH - 2, invalid, "frame.row_bytes is 30");
  REFUSED(f.row_bytes = 2 * WIDTH + 1, invalid, "frame.row_bytes is 33");
  REFUSED(f.row_bytes = SIZE_MAX - 1, invalid, "frame.row_bytes");
  REFUSED(f.unit_mm = 0, invalid, "frame.unit_mm");
  REFUSED(f.unit_mm = NAN, invalid, "frame.unit_mm");
  REFUSED(f.unit_mm = 1e6F, invalid, "frame.unit_mm");
  REFUSED(f.confidence_min = 256, invalid, "frame.confidence_min is 256");
  REFUSED((f.format = IM2FIT_FORMAT_DEPTH16, f.confidence_min = 8), invalid, "frame.confidence_min is 8");
  REFUSED((f.format = IM2FIT_FORMAT_DEPTH16, f.confidence = (const uint8_t*)depth), invalid, "frame.confidence");
  REFUSED(f.confidence_row_bytes = 3, invalid, "frame.confidence_row_bytes is 3");
  REFUSED(f.fx = 14, invalid, "frame: the focal length fy");
  REFUSED(f.fx = f.fy = INFINITY, invalid, "frame: the focal length fx");
  REFUSED(f.k2 = NAN, invalid, "frame.k1, k2, k3, p1, p2");
  REFUSED(f.k1 = 1e6F, invalid, "distortion_coefficients leave");
  REFUSED(f.down_y = NAN, invalid, "frame.down_x, down_y, down_z");
  REFUSED(f.down_y = 1e-6F, invalid, "frame.down_x, down_y, down_z");
  REFUSED(f.reserved = 1, invalid, "frame.reserved is");
  REFUSED(f.reserved2 = 1, invalid, "frame.reserved2");
  REFUSED(f.reserved3 = 1, invalid, "frame.reserved3");
  REFUSED(f.turn_w = 2, invalid, "frame.turn_x, turn_y, turn_z, turn_w");
  REFUSED(f.turn_z = NAN, invalid, "frame.turn_x, turn_y, turn_z, turn_w");
  REFUSED(f.x_mm = 1, invalid, "frame.x_mm, y_mm, z_mm");
  REFUSED((f.turn_w = 1, f.z_mm = INFINITY), invalid, "frame.x_mm, y_mm, z_mm");
#undef REFUSED
  im2fit_close(handle);
}

/* An opener and a source of someone else's, whose codes are not ours. */
static int next_status;
static int foreign_next(void* user, uint16_t* depth, int32_t width, int32_t height, int32_t timeout_ms,
                        uint64_t* sequence, int64_t* time_ns) {
  (void)user, (void)width, (void)height, (void)timeout_ms;
  make_frame(depth);
  *sequence = 1;
  *time_ns = 1;
  return next_status;
}
static int foreign_open(void* opener_user, const char* uri, im2fit_source* source) {
  (void)uri;
  source->next = foreign_next;
  return *(int*)opener_user;
}

static void foreign_codes_become_ours(void) {
  im2fit_settings settings = small_settings();
  im2fit_handle* handle = open_with_fake_stages(&settings);
  int opened = 42;
  CHECK(im2fit_set_opener(handle, foreign_open, &opened) == IM2FIT_OK);
  CHECK(im2fit_attach(handle, "x:") == IM2FIT_ERROR_IO);
  CHECK(strstr(im2fit_last_error(handle), "42") != NULL);
  opened = -14;
  CHECK(im2fit_attach(handle, "x:") == IM2FIT_ERROR_IO);
  opened = IM2FIT_ERROR_NOT_FOUND;
  CHECK(im2fit_attach(handle, "x:") == IM2FIT_ERROR_NOT_FOUND);
  opened = IM2FIT_OK;
  CHECK(im2fit_attach(handle, "x:") == IM2FIT_OK);
  next_status = 77;
  CHECK(im2fit_pump(handle, 1) == IM2FIT_ERROR_IO);
  CHECK(strstr(im2fit_last_error(handle), "77") != NULL);
  next_status = INT32_MIN;
  CHECK(im2fit_pump(handle, 1) == IM2FIT_ERROR_IO);
  next_status = IM2FIT_OK;
  CHECK(im2fit_pump(handle, 1) == IM2FIT_OK);
  im2fit_close(handle);
}

/* A child of the process that opened the handle: its threads are not there. An alarm ends it should it hang. */
static int child(im2fit_handle* handle) {
  uint16_t depth[PIXELS];
  im2fit_result result;
  make_frame(depth);
  alarm(20);
  for (int i = 0; i < 100; ++i)
    if (im2fit_push(handle, depth, WIDTH, HEIGHT, 0, 0, 0) != IM2FIT_ERROR_FORKED) return 1;
  if (strstr(im2fit_last_error(NULL), "fork") == NULL) return 2;
  if (im2fit_finish(handle) != IM2FIT_ERROR_FORKED || im2fit_wait(handle, -1) != IM2FIT_ERROR_FORKED) return 3;
  if (im2fit_reset(handle) != IM2FIT_ERROR_FORKED || im2fit_next(handle) != IM2FIT_ERROR_FORKED) return 4;
  if (im2fit_poll(handle, &result, sizeof result) != IM2FIT_ERROR_FORKED) return 5;
  if (strcmp(im2fit_status_name(IM2FIT_ERROR_FORKED), "forked") != 0) return 6;
  im2fit_close(handle);
  im2fit_settings settings = small_settings(); /* one of its own is as good as the parent's */
  settings.single_thread = 1;                  /* ThreadSanitizer takes no new threads after fork() */
  handle = open_with_fake_stages(&settings);
  for (uint64_t i = 1; i <= 12; ++i)
    if (im2fit_push(handle, depth, WIDTH, HEIGHT, 0, i, (int64_t)i * 33333333) != IM2FIT_OK) return 7;
  if (im2fit_wait(handle, 10000) != IM2FIT_OK) return 8;
  if (im2fit_poll(handle, &result, sizeof result) != IM2FIT_OK || result.measured != 1) return 9;
  im2fit_close(handle);
  return 0;
}

static void a_forked_child_is_told(void) {
  im2fit_settings settings = small_settings();
  im2fit_handle* handle = open_with_fake_stages(&settings);
  const pid_t pid = fork();
  CHECK(pid >= 0);
  if (pid == 0) _exit(child(handle));
  int status = 0;
  CHECK(waitpid(pid, &status, 0) == pid);
  CHECK(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  if (WIFEXITED(status) && WEXITSTATUS(status) != 0) fprintf(stderr, "child: %d\n", WEXITSTATUS(status));
  uint16_t depth[PIXELS]; /* the parent goes on */
  im2fit_result result;
  make_frame(depth);
  for (uint64_t i = 1; i <= 12; ++i)
    CHECK(im2fit_push(handle, depth, WIDTH, HEIGHT, 0, i, (int64_t)i * 33333333) == IM2FIT_OK);
  CHECK(im2fit_wait(handle, 10000) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &result, sizeof result) == IM2FIT_OK);
  CHECK(result.measured == 1 && result.frames_seen == 10);
  im2fit_close(handle);
}

/* Sanitizers keep what was freed for a while. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define KEEPS_WHAT_WAS_FREED 1
#else
#define KEEPS_WHAT_WAS_FREED 0
#endif

/* Resident memory in pages; -1 where the system does not say. */
static long resident_pages(void) {
  long size = 0, resident = -1;
  FILE* file = fopen("/proc/self/statm", "r");
  if (file == NULL) return -1;
  if (fscanf(file, "%ld %ld", &size, &resident) != 2) resident = -1;
  fclose(file);
  return resident;
}

static int open_descriptors(void) {
  int count = 0;
  for (int fd = 0; fd < 1024; ++fd) count += fcntl(fd, F_GETFD) >= 0;
  return count;
}

/* Ten thousand times, every fiftieth with its threads, and memory and descriptors are where they were after the first
 * thousand. */
static void opens_and_closes(void) {
  im2fit_settings settings = small_settings();
  long pages = 0;
  int descriptors = 0;
  for (int i = 0; i < 10000; ++i) {
    settings.single_thread = i % 50 != 0;
    im2fit_handle* handle = open_with_fake_stages(&settings);
    CHECK(handle != NULL);
    im2fit_close(handle);
    if (i == 999) pages = resident_pages(), descriptors = open_descriptors();
  }
  CHECK(open_descriptors() == descriptors);
  /* 9,000 handles of which each left 100 bytes would be 220 pages. */
  const long more = resident_pages() - pages;
  if (more >= 64) fprintf(stderr, "%ld pages more\n", more);
  CHECK(KEEPS_WHAT_WAS_FREED || more < 64);
}

int misuse(void) {
  settings_out_of_range_are_named();
  errors_are_of_the_latest_call();
  every_function_refuses_null();
  frames_out_of_range_are_named();
  foreign_codes_become_ours();
  a_forked_child_is_told();
  opens_and_closes();
  return check_failures == 0 ? 0 : 1;
}
