/* SPDX-License-Identifier: Apache-2.0 */
/* The C interface as a C program uses it, on stages that read their story from the pixels: the first four say whether
 * a person is there, the guidance, whether the fuser refuses, and the pose. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "c_api_fake.h"
#include "c_check.h"
#include "c_small.h"
#include "tests/devices/thread_starts.h"

static int logged;
static void count_log(void* user, int status, const char* text) {
  CHECK(user == &logged);
  CHECK(status < 0);
  CHECK(text[0] != '\0');
  ++logged;
}

static void make_frame(uint16_t* depth, int found, unsigned guidance) {
  for (int i = 0; i < PIXELS; ++i) depth[i] = 10;
  depth[0] = (uint16_t)found;
  depth[1] = (uint16_t)guidance;
  depth[2] = 0;
  depth[3] = 0;
  depth[4] = 1; /* user */
  depth[6] = IM2FIT_VIEW_FRONT;
  depth[7] = 0; /* where the person stands, mm to the right */
  depth[8] = 0; /* arms that are close */
}

static void measures_a_person(int single_thread) {
  im2fit_settings settings = small_settings();
  settings.single_thread = single_thread;
  im2fit_handle* handle = open_with_fake_stages(&settings);
  CHECK(handle != NULL);
  uint16_t depth[PIXELS];
  im2fit_result result;
  size_t count = 0;
  size_t best = 99;
  im2fit_size sizes[32];

  CHECK(im2fit_poll(handle, &result, sizeof result) == IM2FIT_OK);
  CHECK(result.state == IM2FIT_STATE_SEARCHING);
  CHECK(im2fit_sizes(handle, sizes, 32, &count, &best) == IM2FIT_ERROR_NOT_MEASURED);

  make_frame(depth, 1, IM2FIT_GUIDANCE_TOO_NEAR);
  CHECK(im2fit_push(handle, depth, WIDTH, HEIGHT, 0, 1, 100) == IM2FIT_OK);
  make_frame(depth, 1, 0);
  for (int i = 0; i < 10; ++i)
    CHECK(im2fit_push(handle, depth, WIDTH, HEIGHT, WIDTH, (uint64_t)(3 + i), 200 + i) == IM2FIT_OK);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &result, sizeof result) == IM2FIT_OK);
  CHECK(result.state == IM2FIT_STATE_MEASURED);
  CHECK(result.measured == 1);
  CHECK(result.has_joints == 1);
  CHECK(result.guidance == 0);
  CHECK(result.guidance_seen == IM2FIT_GUIDANCE_TOO_NEAR);
  CHECK(result.frames_seen == 11);
  CHECK(result.frames_used == 10 && result.frames_wanted == settings.frames_wanted);
  CHECK(result.sequence_gaps == 1);
  /* The stages sum depth x number of the frame, and 255 for an even pixel: 10 x 55 + 10 x 255. */
  CHECK(result.measurements[IM2FIT_STATURE].value == 3100.0F);
  CHECK(result.measurements[IM2FIT_WEIGHT].value == 3110.0F);
  CHECK(result.measurements[IM2FIT_WEIGHT].low == 3100.0F);
  CHECK(result.measurements[IM2FIT_WEIGHT].high == 3120.0F);
  CHECK(result.paper[IM2FIT_STATURE] == 3100.5F);
  CHECK(result.female == 0.25F);
  CHECK(result.age.value == 40 && result.age.low == 20 && result.age.high == 70);
  CHECK(result.age_bands[1] == 0.5F && result.age_bands[3] == 0.125F);
  CHECK(result.index_entry == 7);
  CHECK(result.joints[0].z == 10.0F);

  CHECK(im2fit_sizes(handle, NULL, 0, &count, NULL) == IM2FIT_ERROR_TOO_SMALL);
  CHECK(count == 9);
  CHECK(im2fit_sizes(handle, sizes, 32, &count, &best) == IM2FIT_OK);
  CHECK(best == 8 && strcmp(sizes[best].name, ">3XL") == 0); /* a chest of 3106 mm */
  float sum = 0;
  for (size_t i = 0; i < count; ++i) sum += sizes[i].probability;
  CHECK(fabsf(sum - 1.0F) < 1e-5F);

  CHECK(im2fit_push(handle, depth, WIDTH, HEIGHT, 0, 0, 0) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_last_error(handle), "reset") != NULL);
  CHECK(im2fit_reset(handle) == IM2FIT_OK);
  CHECK(im2fit_last_error(handle)[0] == '\0');
  CHECK(im2fit_poll(handle, &result, sizeof result) == IM2FIT_OK);
  CHECK(result.measured == 0 && result.frames_seen == 0);
  CHECK(isnan(result.paper[0]));
  CHECK(im2fit_push(handle, depth, WIDTH, HEIGHT, 0, 0, 0) == IM2FIT_OK);
  im2fit_close(handle);
}

static void refuses_bad_frames_and_says_why(void) {
  im2fit_settings settings = small_settings();
  settings.log = count_log;
  settings.log_user = &logged;
  im2fit_handle* handle = open_with_fake_stages(&settings);
  uint16_t depth[PIXELS];
  size_t n = 0;
  make_frame(depth, 1, 0);
  logged = 0;
  CHECK(im2fit_push(handle, NULL, WIDTH, HEIGHT, 0, 0, 0) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_push(handle, depth, HEIGHT, WIDTH, 0, 0, 0) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_last_error(handle), "12x16") != NULL);
  CHECK(im2fit_push(handle, depth, -1, -1, 0, 0, 0) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_push(handle, depth, WIDTH, HEIGHT, WIDTH - 1, 0, 0) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_pump(handle, 10) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_attach(handle, "x") == IM2FIT_ERROR_UNSUPPORTED);
  CHECK(im2fit_attach(handle, NULL) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_body_mesh(handle, NULL, 0, &n, NULL, 0, &n) == IM2FIT_ERROR_UNSUPPORTED);
  float residual[IM2FIT_MEASUREMENT_COUNT];
  CHECK(im2fit_body_residual(handle, residual) == IM2FIT_ERROR_UNSUPPORTED);
  CHECK(im2fit_body_residual(handle, NULL) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_body_mesh(handle, NULL, 0, NULL, NULL, 0, &n) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_sizes(handle, NULL, 3, &n, NULL) == IM2FIT_ERROR_INVALID_ARGUMENT);
  im2fit_tape_value values[2];
  const char* ids[] = {"thigh_girth", "tail_length"};
  CHECK(im2fit_tape(handle, ids, 1, values, sizeof values[0]) == IM2FIT_ERROR_UNSUPPORTED); /* no body model */
  CHECK(im2fit_tape(handle, ids, 1, NULL, sizeof values[0]) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_tape(handle, ids, 1, values, 8) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_tape(handle, NULL, im2fit_tape_count() + 1, values, sizeof values[0]) ==
        IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(logged == 16);
  CHECK(im2fit_push(NULL, depth, WIDTH, HEIGHT, 0, 0, 0) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_last_error(NULL), "NULL") != NULL);
  im2fit_close(handle);
}

/* A source of five frames: a wait, a damaged one, and the end. */
typedef struct Tape {
  int at;
  int closed;
} Tape;

static int tape_next(void* user, uint16_t* depth, int32_t width, int32_t height, int32_t timeout_ms,
                     uint64_t* sequence, int64_t* time_ns) {
  Tape* tape = user;
  CHECK(width == WIDTH && height == HEIGHT && timeout_ms == 40);
  switch (tape->at++) {
    case 1:
      return IM2FIT_ERROR_TIMEOUT;
    case 3:
      return IM2FIT_ERROR_CORRUPT;
    case 6:
      return IM2FIT_ERROR_END_OF_STREAM;
    default:
      make_frame(depth, 1, 0);
      *sequence = (uint64_t)tape->at;
      *time_ns = tape->at;
      return IM2FIT_OK;
  }
}

static void tape_close(void* user) {
  ++((Tape*)user)->closed;
}

static int open_tape(void* opener_user, const char* uri, im2fit_source* source) {
  if (strcmp(uri, "tape:") != 0) return IM2FIT_ERROR_NO_DEVICE;
  source->user = opener_user;
  source->next = tape_next;
  source->close = tape_close;
  return IM2FIT_OK;
}

/* Of the first frame in m/s2; of the second it does not know, of the third and fourth it gives no direction. */
static int tape_down(void* user, float down[3]) {
  const int at = ((const Tape*)user)->at;
  down[0] = 0;
  down[1] = at == 5 ? 0 : at == 3 ? 7 : -9.81F;
  down[2] = at == 6 ? NAN : 0;
  return at != 3;
}

static void pumps_an_attached_source(void) {
  im2fit_settings settings = small_settings();
  im2fit_handle* handle = open_with_fake_stages(&settings);
  Tape tape = {0, 0};
  im2fit_result result;
  CHECK(im2fit_set_opener(handle, open_tape, &tape) == IM2FIT_OK);
  CHECK(im2fit_attach(handle, "camera:") == IM2FIT_ERROR_NO_DEVICE);
  CHECK(strstr(im2fit_last_error(handle), "camera:") != NULL);
  CHECK(im2fit_attach(handle, "tape:") == IM2FIT_OK);
  const int expected[] = {IM2FIT_OK, IM2FIT_ERROR_TIMEOUT,      IM2FIT_OK, IM2FIT_ERROR_CORRUPT, IM2FIT_OK,
                          IM2FIT_OK, IM2FIT_ERROR_END_OF_STREAM};
  for (int i = 0; i < 7; ++i) CHECK(im2fit_pump(handle, 40) == expected[i]);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &result, sizeof result) == IM2FIT_OK);
  CHECK(result.frames_seen == 4 && result.measured == 1);
  CHECK(im2fit_attach(handle, "tape:") == IM2FIT_OK);
  CHECK(tape.closed == 1);
  CHECK(im2fit_detach(handle) == IM2FIT_OK);
  CHECK(tape.closed == 2);
  CHECK(im2fit_attach(handle, "tape:") == IM2FIT_OK);
  CHECK(im2fit_reset(handle) == IM2FIT_OK);
  tape.at = 0;
  float down_y = 0;
  CHECK(fake_downs(&down_y) == 0);
  CHECK(im2fit_set_opener_down(handle, tape_down) == IM2FIT_OK);
  CHECK(im2fit_attach(handle, "tape:") == IM2FIT_OK);
  for (int i = 0; i < 7; ++i) CHECK(im2fit_pump(handle, 40) == expected[i]);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(fake_downs(&down_y) == 1 && down_y == -1);
  im2fit_close(handle);
  CHECK(tape.closed == 4);
}

/* A source of good and damaged frames in turns, without end. */
static int broken_tape_next(void* user, uint16_t* depth_mm, int32_t width, int32_t height, int32_t timeout_ms,
                            uint64_t* sequence, int64_t* time_ns) {
  Tape* tape = user;
  (void)timeout_ms;
  if (++tape->at % 2 == 0) return IM2FIT_ERROR_CORRUPT;
  CHECK(width == WIDTH && height == HEIGHT);
  make_frame(depth_mm, 1, 0);
  *sequence = (uint64_t)tape->at;
  *time_ns = tape->at * 33333333LL;
  return IM2FIT_OK;
}

static int open_broken_tape(void* opener_user, const char* uri, im2fit_source* source) {
  (void)uri;
  source->user = opener_user;
  source->next = broken_tape_next;
  source->close = tape_close;
  return IM2FIT_OK;
}

/* im2fit_pump returns CORRUPT for a damaged frame and for a damaged index. im2fit_wait tells them apart. */
static void a_damaged_index_is_told_from_a_damaged_frame(int32_t single_thread) {
  im2fit_settings settings = small_settings();
  settings.single_thread = single_thread;
  im2fit_handle* handle = open_with_fake_stages(&settings);
  Tape tape = {0, 0};
  fake_damaged_index(1);
  CHECK(im2fit_set_opener(handle, open_broken_tape, &tape) == IM2FIT_OK);
  CHECK(im2fit_attach(handle, "tape:") == IM2FIT_OK);
  int damaged_frames = 0;
  int damaged_index = 0;
  for (int i = 0; i < 100 && damaged_index == 0; ++i) {
    const int status = im2fit_pump(handle, 1000);
    CHECK(status == IM2FIT_OK || status == IM2FIT_ERROR_CORRUPT);
    if (status == IM2FIT_OK) continue;
    damaged_index = im2fit_wait(handle, 10000) == IM2FIT_ERROR_CORRUPT;
    damaged_frames += damaged_index == 0;
  }
  CHECK(damaged_index == 1 && damaged_frames > 0);
  CHECK(strstr(im2fit_last_error(handle), "people.i2f") != NULL);
  for (int i = 0; i < 3; ++i) CHECK(im2fit_pump(handle, 1000) == IM2FIT_ERROR_CORRUPT);
  CHECK(im2fit_reset(handle) == IM2FIT_OK);
  CHECK(im2fit_wait(handle, 10000) == IM2FIT_OK);
  im2fit_close(handle);
  fake_damaged_index(0);
}

/* Callers built with an older or newer header. */
static void structs_may_grow(void) {
  im2fit_settings settings = small_settings();
  im2fit_handle* handle = open_with_fake_stages(&settings);
  struct {
    im2fit_result result;
    char more[64];
  } grown;
  memset(&grown, 0x55, sizeof grown);
  CHECK(im2fit_poll(handle, &grown.result, sizeof grown) == IM2FIT_OK);
  CHECK(grown.more[0] == 0 && grown.more[63] == 0);
  im2fit_result small;
  memset(&small, 0x55, sizeof small);
  CHECK(im2fit_poll(handle, &small, offsetof(im2fit_result, frames_seen)) == IM2FIT_OK);
  CHECK(small.state == IM2FIT_STATE_SEARCHING);
  CHECK(small.frames_seen == 0x5555555555555555ULL);
  CHECK(im2fit_poll(handle, &small, offsetof(im2fit_result, front_measured)) == IM2FIT_OK);
  CHECK(small.frames_seen == 0 && small.front_measured == 0x55555555);
  CHECK(im2fit_poll(handle, NULL, 8) == IM2FIT_ERROR_INVALID_ARGUMENT);
  im2fit_close(handle);
}

/* A caller whose struct ends before user_id: the fields from there on are not read. */
static void shorter_settings_still_open(void) {
  struct {
    im2fit_settings settings;
    char more[16];
  } newer;
  memset(&newer, 0, sizeof newer);
  im2fit_handle* handle = NULL;
  newer.settings = small_settings();
  newer.settings.tracker_path = "/nonexistent.i2t";
  newer.settings.index_path = "/nonexistent.i2f";
  newer.settings.user_id = -77;
  newer.settings.turn = 1;
  newer.settings.struct_size = offsetof(im2fit_settings, user_id);
  CHECK(im2fit_open(&newer.settings, &handle) == IM2FIT_ERROR_NOT_FOUND); /* past the size: the file is missing */
  newer.settings.struct_size = offsetof(im2fit_settings, log_user);
  CHECK(im2fit_open(&newer.settings, &handle) == IM2FIT_ERROR_UNSUPPORTED);
  newer.settings.struct_size = sizeof newer;
  newer.settings.user_id = 0;
  CHECK(im2fit_open(&newer.settings, &handle) == IM2FIT_ERROR_NOT_FOUND);
  newer.more[15] = 1;
  CHECK(im2fit_open(&newer.settings, &handle) == IM2FIT_ERROR_UNSUPPORTED);
}

static void threads_that_cannot_be_started_are_an_error(void) {
  const im2fit_settings settings = small_settings();
  for (int started = 0; started < 2; ++started) {
    fail_thread_start_after(started);
    CHECK(status_of_opening(&settings) == IM2FIT_ERROR_IO);
  }
  CHECK(status_of_opening(&settings) == IM2FIT_OK);
}

static void push_person(im2fit_handle* handle, int found, int user, int view, int x_mm, int count) {
  static uint64_t sequence;
  uint16_t depth[PIXELS];
  make_frame(depth, found, 0);
  depth[4] = (uint16_t)user;
  depth[6] = (uint16_t)view;
  depth[7] = (uint16_t)x_mm;
  for (int i = 0; i < count; ++i) {
    ++sequence;
    CHECK(im2fit_push(handle, depth, WIDTH, HEIGHT, 0, sequence, (int64_t)sequence * 33333333) == IM2FIT_OK);
  }
}

/* Ids, view and steadied joints of whoever is in view, and one person after the other. */
static void one_person_after_the_other(int single_thread) {
  im2fit_settings settings = small_settings();
  settings.single_thread = single_thread;
  im2fit_handle* handle = open_with_fake_stages(&settings);
  im2fit_result r;
  push_person(handle, 1, 4, IM2FIT_VIEW_BACK, 0, 1);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.user_id == 4 && r.view == IM2FIT_VIEW_BACK && r.session == 0);
  CHECK(r.state == IM2FIT_STATE_USER_FOUND && r.frames_used == 0);
  CHECK(r.guidance == IM2FIT_GUIDANCE_NOT_FRONTAL); /* asked to turn round */
  CHECK(r.joints_inferred == 0);
  CHECK(r.display_joints[3].x == 180.0F && r.display_joints[3].confidence == r.joints[3].confidence);

  CHECK(im2fit_next(handle) == IM2FIT_OK); /* nothing measured: anew */
  push_person(handle, 1, 4, IM2FIT_VIEW_FRONT, 0, 12);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.state == IM2FIT_STATE_MEASURED && r.session == 1 && r.user_id == 4);

  CHECK(im2fit_next(handle) == IM2FIT_OK);
  push_person(handle, 1, 4, IM2FIT_VIEW_SIDE, 90, 40); /* does not leave */
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.measured == 1 && r.session == 1 && r.frames_seen == 10);
  CHECK(r.view == IM2FIT_VIEW_SIDE);
  CHECK(fabsf(r.display_joints[3].x - 270.0F) < 1.0F); /* followed; */
  CHECK(r.joints[3].x == 180.0F);                      /* what was measured stands */

  CHECK(im2fit_next(handle) == IM2FIT_OK);
  push_person(handle, 0, 0, 0, 0, 20); /* gone */
  push_person(handle, 1, 5, IM2FIT_VIEW_FRONT, 0, 12);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.measured == 1 && r.session == 2 && r.user_id == 5);
  CHECK(im2fit_reset(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.measured == 0 && r.session == 0 && r.user_id == 0 && r.display_joints[3].confidence == 0.0F);
  im2fit_close(handle);
}

/* What a person reports moves the answer, also after the capture; what cannot be is named and changes nothing. */
static void known_facts_are_evidence(int single_thread) {
  im2fit_settings settings = small_settings();
  settings.single_thread = single_thread;
  settings.frames_wanted = 5;
  im2fit_handle* handle = open_with_fake_stages(&settings);
  im2fit_result before, r;
  im2fit_known known;
  push_person(handle, 1, 1, IM2FIT_VIEW_FRONT, 0, 6);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &before, sizeof before) == IM2FIT_OK);
  CHECK(before.measured == 1 && before.known_used == 0 && before.known_doubted == 0);
  const im2fit_estimate was = before.measurements[IM2FIT_STATURE];

  im2fit_known_init(&known, sizeof known);
  known.stature_mm = was.value + 6;
  known.stature_sd_mm = 5;
  known.sex = IM2FIT_SEX_WOMAN;
  CHECK(im2fit_set_known(handle, &known) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.known_used == (IM2FIT_KNOWN_STATURE | IM2FIT_KNOWN_SEX) && r.known_doubted == 0);
  CHECK(r.measurements[IM2FIT_STATURE].value > was.value && r.measurements[IM2FIT_STATURE].value < was.value + 6);
  CHECK(r.measurements[IM2FIT_STATURE].high - r.measurements[IM2FIT_STATURE].low < was.high - was.low);
  CHECK(r.female == 1.0F);

  known.stature_mm = was.value + 500; /* corrected, wrongly */
  CHECK(im2fit_set_known(handle, &known) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.known_used == IM2FIT_KNOWN_SEX && r.known_doubted == IM2FIT_KNOWN_STATURE);

  known.stature_mm = 175; /* centimetres: what was set before stays */
  CHECK(im2fit_set_known(handle, &known) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_last_error(handle), "known stature: expected 500 to 2500 mm") != NULL);
  known.stature_mm = 0;
  known.stature_sd_mm = 0;
  known.sex = 3;
  CHECK(im2fit_set_known(handle, &known) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_set_known(handle, NULL) == IM2FIT_ERROR_INVALID_ARGUMENT);
  known.sex = IM2FIT_SEX_UNKNOWN;
  known.struct_size = 4;
  CHECK(im2fit_set_known(handle, &known) == IM2FIT_ERROR_UNSUPPORTED);
  im2fit_known_init(&known, sizeof known);
  known.reserved = 1;
  CHECK(im2fit_set_known(handle, &known) == IM2FIT_ERROR_UNSUPPORTED);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.known_used == IM2FIT_KNOWN_SEX && r.known_doubted == IM2FIT_KNOWN_STATURE);

  im2fit_known_init(&known, sizeof known); /* nothing known: the answer of the frames alone */
  CHECK(im2fit_set_known(handle, &known) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(memcmp(r.measurements, before.measurements, sizeof r.measurements) == 0 && r.female == before.female);

  /* After im2fit_next the facts are of the next person; the one measured keeps the answer, with the facts it rests
   * on. */
  known.sex = IM2FIT_SEX_MAN;
  CHECK(im2fit_set_known(handle, &known) == IM2FIT_OK);
  CHECK(im2fit_next(handle) == IM2FIT_OK);
  known.sex = IM2FIT_SEX_WOMAN;
  CHECK(im2fit_set_known(handle, &known) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.measured == 1 && r.session == 0 && r.known_used == IM2FIT_KNOWN_SEX && r.female == 0.0F);
  push_person(handle, 0, 0, 0, 0, 20);
  push_person(handle, 1, 2, IM2FIT_VIEW_FRONT, 0, 6);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.measured == 1 && r.session == 1 && r.known_used == IM2FIT_KNOWN_SEX && r.female == 1.0F);

  CHECK(im2fit_reset(handle) == IM2FIT_OK); /* a new person: nothing is known */
  push_person(handle, 1, 3, IM2FIT_VIEW_FRONT, 0, 6);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.measured == 1 && r.known_used == 0);
  CHECK(im2fit_set_known(handle, &known) ==
        IM2FIT_OK); /* of this person: im2fit_next was called for an earlier one */
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.session == 0 && r.known_used == IM2FIT_KNOWN_SEX && r.female == 1.0F);
  im2fit_close(handle);
}

static void only_the_requested_user(void) {
  im2fit_settings settings = small_settings();
  settings.user_id = 2;
  im2fit_handle* handle = open_with_fake_stages(&settings);
  im2fit_result r;
  push_person(handle, 1, 1, IM2FIT_VIEW_FRONT, 0, 12);
  push_person(handle, 1, 2, IM2FIT_VIEW_FRONT, 0, 3);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.measured == 1 && r.user_id == 2 && r.frames_seen == 15 && r.frames_used == 3);
  CHECK(r.user_count == 1 && r.users[0].id == 2 && r.users[0].right == WIDTH - 1 && r.users[0].z == 2000.0F);
  CHECK(im2fit_select_user(handle, 3) == IM2FIT_OK);
  push_person(handle, 1, 2, IM2FIT_VIEW_FRONT, 0, 1);
  push_person(handle, 1, 3, IM2FIT_VIEW_FRONT, 0, 3);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.measured == 1 && r.user_id == 3 && r.session == 1);
  CHECK(im2fit_reset(handle) == IM2FIT_OK);
  push_person(handle, 1, 3, IM2FIT_VIEW_BACK, 0, 3);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.measured == 0 && r.view == IM2FIT_VIEW_BACK); /* the index knows fronts only */
  CHECK(im2fit_select_user(handle, -1) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_next(NULL) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strcmp(im2fit_view_name(IM2FIT_VIEW_BACK), "back") == 0);
  CHECK(im2fit_view_name(4) == NULL && im2fit_view_name(-1) == NULL);
  im2fit_close(handle);
  settings.user_id = -1;
  CHECK(open_with_fake_stages(&settings) == NULL);
}

/* What is wrong with a frame, and what to do: a wall 3 m away in tenths of a millimetre. */
static void diagnoses(void) {
  im2fit_settings settings = small_settings();
  im2fit_handle* handle = open_with_fake_stages(&settings);
  uint16_t depth[PIXELS];
  for (int i = 0; i < PIXELS; ++i) depth[i] = 30001;
  struct {
    im2fit_diagnosis known;
    int32_t newer;
  } place = {{0, 0, 0, ""}, 7};
  CHECK(im2fit_diagnose(handle, depth, WIDTH, HEIGHT, 0, &place.known, sizeof place) == IM2FIT_OK);
  CHECK(place.known.code == IM2FIT_DIAGNOSIS_UNIT && place.known.unit_mm == 0.1F && place.known.rotate_deg == 0);
  CHECK(strcmp(place.known.text, "values look like 0.1 mm units; try --unit 0.1") == 0);
  CHECK(place.newer == 0);
  CHECK(strcmp(im2fit_diagnosis_name(place.known.code), "UNIT") == 0);
  CHECK(im2fit_diagnosis_name(0)[0] == '\0' && im2fit_diagnosis_name(12) == NULL && im2fit_diagnosis_name(-1) == NULL);
  for (int i = 0; i < PIXELS; ++i) depth[i] = 3000;
  CHECK(im2fit_diagnose(handle, depth, WIDTH, HEIGHT, 0, &place.known, sizeof place.known) == IM2FIT_OK);
  CHECK(place.known.code == IM2FIT_DIAGNOSIS_NONE && place.known.text[0] == '\0');
  CHECK(im2fit_diagnose(handle, depth, HEIGHT, WIDTH, 0, &place.known, sizeof place.known) ==
        IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_diagnose(handle, depth, WIDTH, HEIGHT, WIDTH - 1, &place.known, sizeof place.known) ==
        IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_diagnose(handle, NULL, WIDTH, HEIGHT, 0, &place.known, sizeof place.known) ==
        IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_diagnose(handle, depth, WIDTH, HEIGHT, 0, NULL, 0) == IM2FIT_ERROR_INVALID_ARGUMENT);
  im2fit_close(handle);
}

/* Front, then back: the preliminary answer, the guidance, and both sides in the end. */
static void front_then_back(int single_thread) {
  im2fit_settings settings = small_settings();
  settings.single_thread = single_thread;
  settings.turn = 1;
  im2fit_handle* handle = open_with_fake_stages(&settings);
  im2fit_result r;
  size_t count = 0;
  push_person(handle, 1, 4, IM2FIT_VIEW_FRONT, 0, 12);
  CHECK(im2fit_select_user(handle, 0) == IM2FIT_OK); /* no change, but waits for the frames in the pipeline */
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.state == IM2FIT_STATE_TURNING && strcmp(im2fit_state_name(r.state), "TURNING") == 0);
  CHECK(r.guidance == IM2FIT_GUIDANCE_TURN_ROUND && strcmp(im2fit_guidance_name(13), "TURN_ROUND") == 0);
  CHECK(r.measured == 0 && r.front_measured == 1 && r.views == IM2FIT_VIEWS_FRONT);
  CHECK(r.measurements[IM2FIT_STATURE].value == 3100.0F);
  CHECK(im2fit_sizes(handle, NULL, 0, &count, NULL) == IM2FIT_ERROR_NOT_MEASURED);
  push_person(handle, 1, 4, IM2FIT_VIEW_BACK, 0, 10);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.state == IM2FIT_STATE_MEASURED && r.measured == 1 && r.guidance == 0);
  CHECK(r.views == IM2FIT_VIEWS_FRONT_AND_BACK && r.frames_used == 20 && r.frames_back == 10);
  CHECK(r.measurements[IM2FIT_STATURE].value == 3131.0F); /* the stages add a hundredth of the back's sum */
  im2fit_close(handle);
}

/* The fake person's pixels are those of an even depth. */
static int shows_the_person(const uint8_t* mask, const uint16_t* depth) {
  for (int i = 0; i < PIXELS; ++i)
    if (mask[i] != (depth[i] % 2 == 0 ? 255 : 0)) return 0;
  return 1;
}

static int is_empty(const uint8_t* mask) {
  for (int i = 0; i < PIXELS; ++i)
    if (mask[i] != 0) return 0;
  return 1;
}

static void the_mask_is_of_the_latest_frame(int single_thread) {
  im2fit_settings settings = small_settings();
  settings.single_thread = single_thread;
  im2fit_handle* handle = open_with_fake_stages(&settings);
  uint16_t depth[PIXELS];
  uint8_t mask[PIXELS];
  im2fit_mask_info info;
  make_frame(depth, 1, 0);
  CHECK(im2fit_push(handle, depth, WIDTH, HEIGHT, 0, 1, 100) == IM2FIT_OK);
  CHECK(im2fit_wait(handle, -1) == IM2FIT_OK);
  /* None is kept before the first call. */
  CHECK(im2fit_mask(handle, mask, sizeof mask, &info, sizeof info) == IM2FIT_ERROR_NOT_FOUND);
  CHECK(im2fit_last_error(handle)[0] == '\0' && im2fit_last_error(NULL)[0] != '\0');
  depth[20] = 11;
  CHECK(im2fit_push(handle, depth, WIDTH, HEIGHT, 0, 7, 200) == IM2FIT_OK);
  CHECK(im2fit_wait(handle, -1) == IM2FIT_OK);
  memset(mask, 3, sizeof mask);
  CHECK(im2fit_mask(handle, mask, sizeof mask, &info, sizeof info) == IM2FIT_OK);
  CHECK(shows_the_person(mask, depth));
  CHECK(info.width == WIDTH && info.height == HEIGHT && info.user_id == 1);
  CHECK(info.sequence == 7 && info.time_ns == 200);
  CHECK(im2fit_mask(handle, mask, sizeof mask, NULL, 0) == IM2FIT_OK);
  memset(mask, 3, sizeof mask);
  CHECK(im2fit_mask(handle, mask, sizeof mask - 1, &info, sizeof info) == IM2FIT_ERROR_TOO_SMALL);
  CHECK(mask[0] == 3 && info.width == WIDTH);
  memset(&info, 0, sizeof info);
  CHECK(im2fit_mask(handle, NULL, 0, &info, sizeof info) == IM2FIT_OK && info.sequence == 7);
  CHECK(im2fit_mask(handle, NULL, 0, NULL, 0) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_mask(handle, NULL, 5, &info, sizeof info) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_mask(NULL, mask, sizeof mask, &info, sizeof info) == IM2FIT_ERROR_INVALID_ARGUMENT);
  struct {
    im2fit_mask_info info;
    int newer;
  } grown = {{0}, 5};
  CHECK(im2fit_mask(handle, NULL, 0, &grown.info, sizeof grown) == IM2FIT_OK);
  CHECK(grown.info.user_id == 1 && grown.newer == 0);
  /* Nobody's: a figure that was refused leaves no pixels behind. */
  make_frame(depth, 0, IM2FIT_GUIDANCE_NO_PERSON);
  CHECK(im2fit_push(handle, depth, WIDTH, HEIGHT, 0, 8, 300) == IM2FIT_OK);
  CHECK(im2fit_wait(handle, -1) == IM2FIT_OK);
  CHECK(im2fit_mask(handle, mask, sizeof mask, &info, sizeof info) == IM2FIT_OK);
  CHECK(is_empty(mask) && info.user_id == 0 && info.sequence == 8);
  CHECK(im2fit_reset(handle) == IM2FIT_OK);
  CHECK(im2fit_mask(handle, mask, sizeof mask, &info, sizeof info) == IM2FIT_ERROR_NOT_FOUND);
  im2fit_close(handle);
}

/* ARMS_CLOSE says which arm; one good frame does not take it away. */
static void arms_close_are_named(void) {
  im2fit_settings settings = small_settings();
  im2fit_handle* handle = open_with_fake_stages(&settings);
  uint16_t depth[PIXELS];
  im2fit_result r;
  for (int i = 0; i < 8; ++i) {
    make_frame(depth, 1, i < 7 ? IM2FIT_GUIDANCE_ARMS_CLOSE : 0);
    depth[8] = i < 7 ? IM2FIT_ARM_RIGHT : 0;
    CHECK(im2fit_push(handle, depth, WIDTH, HEIGHT, 0, (uint64_t)(i + 1), i * 33333333LL) == IM2FIT_OK);
  }
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  CHECK(im2fit_poll(handle, &r, sizeof r) == IM2FIT_OK);
  CHECK(r.guidance == IM2FIT_GUIDANCE_ARMS_CLOSE && r.arms_close == IM2FIT_ARM_RIGHT && r.frames_used == 0);
  im2fit_close(handle);
}

/* `capi_test misuse` runs c_misuse_test.c alone: it counts this process's memory and descriptors. */
int main(int argc, char** argv) {
  if (argc == 2 && strcmp(argv[1], "misuse") == 0) return misuse();
  arms_close_are_named();
  measures_a_person(0);
  measures_a_person(1);
  refuses_bad_frames_and_says_why();
  pumps_an_attached_source();
  a_damaged_index_is_told_from_a_damaged_frame(0);
  a_damaged_index_is_told_from_a_damaged_frame(1);
  structs_may_grow();
  shorter_settings_still_open();
  threads_that_cannot_be_started_are_an_error();
  one_person_after_the_other(0);
  one_person_after_the_other(1);
  known_facts_are_evidence(0);
  known_facts_are_evidence(1);
  only_the_requested_user();
  diagnoses();
  front_then_back(0);
  front_then_back(1);
  the_mask_is_of_the_latest_frame(0);
  the_mask_is_of_the_latest_frame(1);
  return check_failures == 0 ? 0 : 1;
}
