/* SPDX-License-Identifier: Apache-2.0 */
/* A C program linked to libim2fit.so alone: versions, names and failures to open. Where IM2FIT_TRACKER, IM2FIT_INDEX
 * and IM2FIT_BODY name files: a session on them with an empty room pushed. */
#include <stdlib.h>
#include <string.h>

#include "c_check.h"
#include "im2fit/im2fit.h"

static void names_and_version(void) {
  char version[32];
  snprintf(version, sizeof version, "%d.%d.%d", IM2FIT_VERSION_MAJOR, IM2FIT_VERSION_MINOR, IM2FIT_VERSION_PATCH);
  CHECK(strcmp(im2fit_version(), version) == 0);
  CHECK(strcmp(im2fit_status_name(IM2FIT_OK), "ok") == 0);
  CHECK(strcmp(im2fit_status_name(IM2FIT_ERROR_TIMEOUT), "timeout") == 0);
  CHECK(strcmp(im2fit_status_name(IM2FIT_ERROR_INTERNAL), "internal") == 0);
  CHECK(strcmp(im2fit_status_name(IM2FIT_ERROR_FORKED), "forked") == 0);
  CHECK(strcmp(im2fit_status_name(-14), "unknown") == 0);
  CHECK(strcmp(im2fit_status_name(1), "unknown") == 0);
  CHECK(strcmp(im2fit_state_name(IM2FIT_STATE_LOST), "LOST") == 0);
  CHECK(im2fit_state_name(7) == NULL && im2fit_state_name(-1) == NULL);
  CHECK(strcmp(im2fit_guidance_name(3), "FEET_CUT") == 0);
  CHECK(strcmp(im2fit_state_name(IM2FIT_STATE_TURNING), "TURNING") == 0);
  CHECK(strcmp(im2fit_guidance_name(13), "TURN_ROUND") == 0);
  CHECK(im2fit_guidance_name(IM2FIT_GUIDANCE_COUNT) == NULL);
  static const char* const kLanguages[] = {"en", "de", "es", "fr", "zh"};
  for (int language = 0; language < 5; ++language)
    for (int bit = 0; bit < IM2FIT_GUIDANCE_COUNT; ++bit) {
      const char* text = im2fit_guidance_text(bit, kLanguages[language]);
      CHECK(text != NULL && text[0] != '\0');
      for (int other = 0; other < bit && text != NULL; ++other)
        CHECK(strcmp(text, im2fit_guidance_text(other, kLanguages[language])) != 0);
    }
  CHECK(strcmp(im2fit_guidance_text(1, "en"), im2fit_guidance_text(1, "de")) != 0);
  CHECK(im2fit_guidance_text(IM2FIT_GUIDANCE_COUNT, "en") == NULL && im2fit_guidance_text(-1, "en") == NULL);
  CHECK(im2fit_guidance_text(0, "it") == NULL && im2fit_guidance_text(0, NULL) == NULL);
  CHECK(strcmp(im2fit_measurement_name(IM2FIT_CHEST_GIRTH), "chest_girth") == 0);
  CHECK(strcmp(im2fit_measurement_name(IM2FIT_INSIDE_LEG), "inside_leg") == 0);
  CHECK(strcmp(im2fit_measurement_unit(IM2FIT_WEIGHT), "kg") == 0);
  CHECK(im2fit_measurement_name(IM2FIT_MEASUREMENT_COUNT) == NULL);
  CHECK(strcmp(im2fit_joint_name(14), "RF") == 0);
  CHECK(im2fit_joint_name(15) == NULL);
  CHECK(im2fit_tape_count() >= 75);
  CHECK(strcmp(im2fit_tape_id(0), "stature") == 0 && strcmp(im2fit_tape_iso(0), "5.1.1") == 0);
  CHECK(im2fit_tape_id(im2fit_tape_count()) == NULL && im2fit_tape_unit(im2fit_tape_count()) == NULL);
  CHECK(im2fit_tape_iso(im2fit_tape_count()) == NULL && im2fit_tape_name(im2fit_tape_count(), "en") == NULL);
  CHECK(im2fit_tape_name(0, "it") == NULL && im2fit_tape_name(0, NULL) == NULL);
  CHECK(im2fit_garment_count() == 6);
  CHECK(im2fit_garment_id(6) == NULL && im2fit_garment_name(6, "en") == NULL && im2fit_garment_name(0, "it") == NULL);
  CHECK(im2fit_garment_name(0, NULL) == NULL);
  for (size_t i = 0; i < im2fit_garment_count(); ++i)
    CHECK(im2fit_garment_id(i)[0] != '\0' && im2fit_garment_name(i, "de")[0] != '\0');
  CHECK(strcmp(im2fit_fit_name(IM2FIT_FIT_TIGHT), "tight") == 0 && strcmp(im2fit_fit_name(3), "loose") == 0);
  CHECK(im2fit_fit_name(-1) == NULL && im2fit_fit_name(4) == NULL);
  CHECK(strcmp(im2fit_rig_node_name(0), "pelvis") == 0 && im2fit_rig_node_parent(0) == -1);
  CHECK(im2fit_rig_node_name(IM2FIT_RIG_NODE_COUNT) == NULL && im2fit_rig_node_name(-1) == NULL);
  CHECK(im2fit_rig_node_parent(IM2FIT_RIG_NODE_COUNT) == -1);
  for (int i = 1; i < IM2FIT_RIG_NODE_COUNT; ++i)
    CHECK(im2fit_rig_node_name(i)[0] != '\0' && im2fit_rig_node_parent(i) >= 0 && im2fit_rig_node_parent(i) < i);
  for (size_t i = 0; i < im2fit_tape_count(); ++i) {
    CHECK(strcmp(im2fit_tape_unit(i), strcmp(im2fit_tape_id(i), "weight") == 0 ? "kg" : "mm") == 0);
    CHECK(im2fit_tape_name(i, "en")[0] != '\0' && im2fit_tape_name(i, "zh")[0] != '\0');
  }
}

static im2fit_settings kinect_settings(void) {
  im2fit_settings s;
  im2fit_settings_init(&s, sizeof s);
  s.width = 480;
  s.height = 640;
  s.fx = s.fy = 575.8F;
  s.cx = 239.5F;
  s.cy = 319.5F;
  return s;
}

static int last_logged;
static void keep_status(void* user, int status, const char* text) {
  (void)user;
  (void)text;
  last_logged = status;
}

static void opening_fails_cleanly(void) {
  im2fit_handle* handle = (im2fit_handle*)&handle;
  im2fit_settings s = kinect_settings();
  CHECK(s.frames_wanted == 15 && s.frames_min == 5 && s.pool_frames == 8);
  CHECK(im2fit_open(NULL, &handle) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(handle == NULL);
  CHECK(im2fit_open(&s, NULL) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(im2fit_open(&s, &handle) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_last_error(NULL), "tracker_path") != NULL);
  s.tracker_path = "/nonexistent/tracker.i2t";
  s.index_path = "/nonexistent/index.i2f";
  s.log = keep_status;
  CHECK(im2fit_open(&s, &handle) == IM2FIT_ERROR_NOT_FOUND);
  CHECK(last_logged == IM2FIT_ERROR_NOT_FOUND);
  CHECK(strstr(im2fit_last_error(NULL), "/nonexistent/tracker.i2t") != NULL);
  s.men_chart_path = "/nonexistent/chart.csv";
  CHECK(im2fit_open(&s, &handle) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_last_error(NULL), "women_chart_path") != NULL);
  s.sensor = 4;
  CHECK(im2fit_open(&s, &handle) == IM2FIT_ERROR_INVALID_ARGUMENT);
  CHECK(strstr(im2fit_last_error(NULL), "settings.sensor is 4") != NULL);
  s.struct_size = 8;
  CHECK(im2fit_open(&s, &handle) == IM2FIT_ERROR_UNSUPPORTED);
  struct {
    im2fit_settings settings;
    int newer;
  } grown;
  im2fit_settings_init(&grown.settings, sizeof grown);
  CHECK(grown.newer == 0);
  CHECK(im2fit_open(&grown.settings, &handle) == IM2FIT_ERROR_INVALID_ARGUMENT);
  grown.newer = 1;
  CHECK(im2fit_open(&grown.settings, &handle) == IM2FIT_ERROR_UNSUPPORTED);
  CHECK(handle == NULL);
  im2fit_close(NULL);
}

static void an_empty_room_has_no_person(void) {
  im2fit_settings s = kinect_settings();
  s.tracker_path = getenv("IM2FIT_TRACKER");
  s.index_path = getenv("IM2FIT_INDEX");
  s.body_path = getenv("IM2FIT_BODY");
  im2fit_handle* handle = NULL;
  const int opened = im2fit_open(&s, &handle);
  CHECK(opened == IM2FIT_OK);
  if (opened != IM2FIT_OK) {
    fprintf(stderr, "%s\n", im2fit_last_error(NULL));
    return;
  }
  uint16_t* depth = calloc((size_t)s.width * (size_t)s.height, sizeof *depth);
  for (uint64_t i = 0; i < 8; ++i)
    CHECK(im2fit_push(handle, depth, s.width, s.height, 0, i, (int64_t)i * 33333333) == IM2FIT_OK);
  CHECK(im2fit_finish(handle) == IM2FIT_OK);
  im2fit_result result;
  CHECK(im2fit_poll(handle, &result, sizeof result) == IM2FIT_OK);
  CHECK(result.measured == 0 && result.frames_seen == 8);
  CHECK((result.guidance & IM2FIT_GUIDANCE_NO_PERSON) != 0);
  size_t vertex_count = 0;
  size_t triangle_count = 0;
  CHECK(im2fit_body_mesh(handle, NULL, 0, &vertex_count, NULL, 0, &triangle_count) == IM2FIT_ERROR_NOT_MEASURED);
  CHECK(vertex_count == 13380);
  im2fit_tape_value value;
  const char* id = "thigh_girth";
  CHECK(im2fit_tape(handle, &id, 1, &value, sizeof value) == IM2FIT_ERROR_NOT_MEASURED);
  id = "tail_length";
  CHECK(im2fit_tape(handle, &id, 1, &value, sizeof value) == IM2FIT_ERROR_NOT_FOUND);
  CHECK(strstr(im2fit_last_error(handle), "tail_length") != NULL);
  size_t size = 0;
  im2fit_size_fit fit;
  im2fit_rig rig;
  const im2fit_worn worn = {"toga", NULL};
  CHECK(im2fit_garment_fit(handle, "t_shirt", &fit, sizeof fit, 1, &size, NULL) == IM2FIT_ERROR_NOT_MEASURED);
  CHECK(im2fit_garment_fit(handle, "toga", &fit, sizeof fit, 1, &size, NULL) == IM2FIT_ERROR_NOT_FOUND);
  CHECK(strstr(im2fit_last_error(handle), "toga") != NULL);
  CHECK(im2fit_dressed_avatar(handle, NULL, 0, NULL, 0, &size) == IM2FIT_ERROR_NOT_MEASURED);
  CHECK(im2fit_dressed_avatar(handle, &worn, 1, NULL, 0, &size) == IM2FIT_ERROR_NOT_FOUND);
  CHECK(im2fit_live_rig(handle, &rig, sizeof rig) == IM2FIT_ERROR_NOT_MEASURED);
  free(depth);
  im2fit_close(handle);
}

static int names_a_file(const char* variable) {
  const char* path = getenv(variable);
  FILE* file = path != NULL ? fopen(path, "rb") : NULL;
  if (file != NULL) fclose(file);
  return file != NULL;
}

int main(void) {
  names_and_version();
  opening_fails_cleanly();
  if (names_a_file("IM2FIT_TRACKER") && names_a_file("IM2FIT_INDEX") && names_a_file("IM2FIT_BODY"))
    an_empty_room_has_no_person();
  else
    puts("IM2FIT_TRACKER, IM2FIT_INDEX, IM2FIT_BODY name no files: the session on real files is left out");
  return check_failures == 0 ? 0 : 1;
}
