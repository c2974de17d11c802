// SPDX-License-Identifier: Apache-2.0
// What im2fit.sdk.Native calls: im2fit.h with Java's arrays and buffers for its structs. Nothing is decided and
// nothing thrown here: every function gives back the library's status, and Kotlin makes exceptions of it. Texts are
// bytes of UTF-8, as Java's native strings are another encoding. Exceptions of the virtual machine itself (no memory)
// stay pending, and the function returns at once.
#include "im2fit_jni.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static jbyteArray native_version(JNIEnv* env, jclass type) {
  (void)type;
  return bytes_of(env, im2fit_version());
}

static jbyteArray native_last_error(JNIEnv* env, jclass type, jlong handle) {
  (void)type;
  return bytes_of(env, im2fit_last_error(handle_of(handle)));
}

// Which list of names: Native.NAMES_... has the same numbers.
enum { NAMES_STATUS, NAMES_STATE, NAMES_GUIDANCE, NAMES_MEASUREMENT, NAMES_UNIT, NAMES_JOINT, NAMES_VIEW };

static jbyteArray native_name(JNIEnv* env, jclass type, jint list, jint index) {
  (void)type;
  switch (list) {
    case NAMES_STATUS:
      return bytes_of(env, im2fit_status_name(index));
    case NAMES_STATE:
      return bytes_of(env, im2fit_state_name(index));
    case NAMES_GUIDANCE:
      return bytes_of(env, im2fit_guidance_name(index));
    case NAMES_MEASUREMENT:
      return bytes_of(env, im2fit_measurement_name(index));
    case NAMES_UNIT:
      return bytes_of(env, im2fit_measurement_unit(index));
    case NAMES_JOINT:
      return bytes_of(env, im2fit_joint_name(index));
    case NAMES_VIEW:
      return bytes_of(env, im2fit_view_name(index));
    default:
      return NULL;
  }
}

// Order of `paths`, and of the first four's data.
enum { TRACKER, INDEX, BODY, PACK, MEN_CHART, WOMEN_CHART, PATHS };
enum { DATA = 4 };
// Order of `numbers`.
enum {
  WIDTH,
  HEIGHT,
  FRAMES_WANTED,
  FRAMES_MIN,
  CALIBRATION_PSI,
  LIVE,
  SINGLE_THREAD,
  TURN,
  CLOTHING,
  SENSOR,
  USER_ID
};

// paths: byte[6][]; contents: byte[4][], null for a path; fds, offsets, sizes: of the four, fd -1 where there is
// none.
static jint native_open(JNIEnv* env, jclass type, jobjectArray paths, jobjectArray contents, jintArray fds,
                        jlongArray offsets, jlongArray sizes, jintArray numbers, jfloatArray intrinsics,
                        jlongArray opened) {
  (void)type;
  im2fit_settings settings;
  im2fit_settings_init(&settings, sizeof settings);
  jint n[USER_ID + 1];
  jint fd[DATA];
  jlong offset[DATA];
  jlong size[DATA];
  jfloat k[4];
  (*env)->GetIntArrayRegion(env, numbers, 0, USER_ID + 1, n);
  (*env)->GetIntArrayRegion(env, fds, 0, DATA, fd);
  (*env)->GetLongArrayRegion(env, offsets, 0, DATA, offset);
  (*env)->GetLongArrayRegion(env, sizes, 0, DATA, size);
  (*env)->GetFloatArrayRegion(env, intrinsics, 0, 4, k);
  if ((*env)->ExceptionCheck(env)) return IM2FIT_ERROR_INVALID_ARGUMENT;

  char* path[PATHS];
  for (jsize i = 0; i < PATHS; ++i) path[i] = text_at(env, paths, i);
  settings.tracker_path = path[TRACKER];
  settings.index_path = path[INDEX];
  settings.body_path = path[BODY];
  settings.pack_path = path[PACK];
  settings.men_chart_path = path[MEN_CHART];
  settings.women_chart_path = path[WOMEN_CHART];
  settings.width = n[WIDTH];
  settings.height = n[HEIGHT];
  settings.frames_wanted = n[FRAMES_WANTED];
  settings.frames_min = n[FRAMES_MIN];
  settings.calibration_psi = n[CALIBRATION_PSI];
  settings.live = n[LIVE];
  settings.single_thread = n[SINGLE_THREAD];
  settings.turn = n[TURN];
  settings.clothing = n[CLOTHING];
  settings.sensor = n[SENSOR];
  settings.user_id = n[USER_ID];
  settings.fx = k[0];
  settings.fy = k[1];
  settings.cx = k[2];
  settings.cy = k[3];

  im2fit_data* data[DATA] = {&settings.tracker_data, &settings.index_data, &settings.body_data, &settings.pack_data};
  jbyteArray content[DATA];
  jbyte* elements[DATA];
  for (jsize i = 0; i < DATA; ++i) {
    content[i] = (jbyteArray)(*env)->GetObjectArrayElement(env, contents, i);
    elements[i] = content[i] ? (*env)->GetByteArrayElements(env, content[i], NULL) : NULL;
    if (elements[i]) {
      data[i]->kind = IM2FIT_DATA_MEMORY;
      data[i]->bytes = elements[i];
      data[i]->size = (size_t)(*env)->GetArrayLength(env, content[i]);
    } else if (fd[i] >= 0) {
      data[i]->kind = IM2FIT_DATA_FD;
      data[i]->fd = fd[i];
      data[i]->offset = offset[i];
      data[i]->size = (size_t)size[i];
    }
  }
  im2fit_handle* handle = NULL;
  jint status = IM2FIT_ERROR_NO_MEMORY;
  if (!(*env)->ExceptionCheck(env)) status = im2fit_open(&settings, &handle);
  for (jsize i = 0; i < DATA; ++i)
    if (elements[i]) (*env)->ReleaseByteArrayElements(env, content[i], elements[i], JNI_ABORT);
  for (jsize i = 0; i < PATHS; ++i) free(path[i]);
  const jlong number = (jlong)(intptr_t)handle;
  if (status == IM2FIT_OK) (*env)->SetLongArrayRegion(env, opened, 0, 1, &number);
  return status;
}

static void native_close(JNIEnv* env, jclass type, jlong handle) {
  (void)env;
  (void)type;
  im2fit_close(handle_of(handle));
}

// Order of push's `numbers` and `longs`.
enum { FORMAT, FRAME_WIDTH, FRAME_HEIGHT, ROTATE_DEG, CONFIDENCE_MIN, FRAME_NUMBERS };
enum { PIXELS_AT, ROW_BYTES, CONFIDENCE_AT, CONFIDENCE_ROW_BYTES, SEQUENCE, TIME_NS, DEVICE_US, FRAME_LONGS };
enum {
  UNIT_MM,
  FX,
  FY,
  CX,
  CY,
  DOWN_X,
  DOWN_Y,
  DOWN_Z,
  K1,
  K2,
  K3,
  P1,
  P2,
  TURN_X,
  TURN_Y,
  TURN_Z,
  TURN_W,
  X_MM,
  Y_MM,
  Z_MM,
  FRAME_FLOATS
};

// pixels, confidence: direct buffers, long enough from their ..._AT on: DepthFrame.kt has checked.
static jint native_push(JNIEnv* env, jclass type, jlong handle, jobject pixels, jobject confidence, jintArray numbers,
                        jlongArray longs, jfloatArray floats) {
  (void)type;
  jint n[FRAME_NUMBERS];
  jlong l[FRAME_LONGS];
  jfloat f[FRAME_FLOATS];
  (*env)->GetIntArrayRegion(env, numbers, 0, FRAME_NUMBERS, n);
  (*env)->GetLongArrayRegion(env, longs, 0, FRAME_LONGS, l);
  (*env)->GetFloatArrayRegion(env, floats, 0, FRAME_FLOATS, f);
  if ((*env)->ExceptionCheck(env)) return IM2FIT_ERROR_INVALID_ARGUMENT;
  im2fit_frame frame;
  im2fit_frame_init(&frame, sizeof frame);
  const uint8_t* first = (const uint8_t*)(*env)->GetDirectBufferAddress(env, pixels);
  if (first) frame.pixels = first + l[PIXELS_AT];
  if (confidence) {
    const uint8_t* plane = (const uint8_t*)(*env)->GetDirectBufferAddress(env, confidence);
    if (plane) frame.confidence = plane + l[CONFIDENCE_AT];
  }
  frame.format = n[FORMAT];
  frame.width = n[FRAME_WIDTH];
  frame.height = n[FRAME_HEIGHT];
  frame.rotate_deg = n[ROTATE_DEG];
  frame.confidence_min = n[CONFIDENCE_MIN];
  frame.row_bytes = (size_t)l[ROW_BYTES];
  frame.confidence_row_bytes = (size_t)l[CONFIDENCE_ROW_BYTES];
  frame.sequence = (uint64_t)l[SEQUENCE];
  frame.time_ns = l[TIME_NS];
  frame.device_us = l[DEVICE_US];
  frame.unit_mm = f[UNIT_MM];
  frame.fx = f[FX];
  frame.fy = f[FY];
  frame.cx = f[CX];
  frame.cy = f[CY];
  frame.down_x = f[DOWN_X];
  frame.down_y = f[DOWN_Y];
  frame.down_z = f[DOWN_Z];
  frame.k1 = f[K1];
  frame.k2 = f[K2];
  frame.k3 = f[K3];
  frame.p1 = f[P1];
  frame.p2 = f[P2];
  frame.turn_x = f[TURN_X];
  frame.turn_y = f[TURN_Y];
  frame.turn_z = f[TURN_Z];
  frame.turn_w = f[TURN_W];
  frame.x_mm = f[X_MM];
  frame.y_mm = f[Y_MM];
  frame.z_mm = f[Z_MM];
  return im2fit_push_frame(handle_of(handle), &frame);
}

// What to do with a handle alone: Native.DO_... has the same numbers. `number`: wait's time, select's id.
enum { DO_WAIT, DO_FINISH, DO_RESET, DO_NEXT, DO_SELECT_USER };

static jint native_act(JNIEnv* env, jclass type, jlong handle, jint what, jint number) {
  (void)env;
  (void)type;
  switch (what) {
    case DO_WAIT:
      return im2fit_wait(handle_of(handle), number);
    case DO_FINISH:
      return im2fit_finish(handle_of(handle));
    case DO_RESET:
      return im2fit_reset(handle_of(handle));
    case DO_NEXT:
      return im2fit_next(handle_of(handle));
    case DO_SELECT_USER:
      return im2fit_select_user(handle_of(handle), number);
    default:
      return IM2FIT_ERROR_INVALID_ARGUMENT;
  }
}

// poll's layout, for Result.kt: whole numbers, then floats.
enum {
  RESULT_LONGS = 15,
  RESULT_FLOATS = 3 * IM2FIT_MEASUREMENT_COUNT + 8 * IM2FIT_JOINT_COUNT + 6 + IM2FIT_AGE_BAND_COUNT + 1
};

static jfloat* put_estimate(jfloat* to, const im2fit_estimate* estimate) {
  *to++ = estimate->value;
  *to++ = estimate->low;
  *to++ = estimate->high;
  return to;
}

static jfloat* put_joints(jfloat* to, const im2fit_joint* joints) {
  for (int i = 0; i < IM2FIT_JOINT_COUNT; ++i) {
    *to++ = joints[i].x;
    *to++ = joints[i].y;
    *to++ = joints[i].z;
    *to++ = joints[i].confidence;
  }
  return to;
}

static jint native_poll(JNIEnv* env, jclass type, jlong handle, jlongArray longs, jfloatArray floats) {
  (void)type;
  im2fit_result result;
  const jint status = im2fit_poll(handle_of(handle), &result, sizeof result);
  if (status != IM2FIT_OK) return status;
  const jlong l[RESULT_LONGS] = {result.state,
                                 result.guidance,
                                 result.guidance_seen,
                                 result.arms_close,
                                 result.has_joints,
                                 result.measured,
                                 result.views,
                                 result.user_id,
                                 result.session,
                                 (jlong)result.frames_seen,
                                 (jlong)result.frames_used,
                                 (jlong)result.frames_dropped,
                                 result.frames_wanted,
                                 result.known_used,
                                 result.known_doubted};
  jfloat f[RESULT_FLOATS];
  jfloat* to = f;
  for (int i = 0; i < IM2FIT_MEASUREMENT_COUNT; ++i) to = put_estimate(to, &result.measurements[i]);
  to = put_estimate(to, &result.age);
  *to++ = result.female;
  *to++ = result.clothing_probability;
  *to++ = result.clothing_ease_mm;
  for (int i = 0; i < IM2FIT_AGE_BAND_COUNT; ++i) *to++ = result.age_bands[i];
  to = put_joints(to, result.joints);
  to = put_joints(to, result.display_joints);
  *to = result.turned_deg;
  (*env)->SetLongArrayRegion(env, longs, 0, RESULT_LONGS, l);
  if (!(*env)->ExceptionCheck(env)) (*env)->SetFloatArrayRegion(env, floats, 0, RESULT_FLOATS, f);
  return IM2FIT_OK;
}

// pixels: null to ask for `longs`, else as many bytes as the mask has; longs: width, height, the person's id, the
// frame's sequence number and time.
static jint native_mask(JNIEnv* env, jclass type, jlong handle, jbyteArray pixels, jlongArray longs) {
  (void)type;
  im2fit_mask_info info;
  jbyte* to = pixels ? (*env)->GetByteArrayElements(env, pixels, NULL) : NULL;
  if (pixels && !to) return IM2FIT_ERROR_NO_MEMORY;
  const size_t capacity = pixels ? (size_t)(*env)->GetArrayLength(env, pixels) : 0;
  const jint status = im2fit_mask(handle_of(handle), (uint8_t*)to, capacity, &info, sizeof info);
  if (to) (*env)->ReleaseByteArrayElements(env, pixels, to, 0);
  if (status != IM2FIT_OK) return status;
  const jlong l[] = {info.width, info.height, info.user_id, (jlong)info.sequence, info.time_ns};
  (*env)->SetLongArrayRegion(env, longs, 0, (jsize)(sizeof l / sizeof l[0]), l);
  return IM2FIT_OK;
}

// depth: an upright frame, millimetres; numbers: code and rotation; unit: one value. The text, or null with the status in
// numbers[0] below zero.
static jbyteArray native_diagnose(JNIEnv* env, jclass type, jlong handle, jshortArray depth, jint width, jint height,
                                  jintArray numbers, jfloatArray unit) {
  (void)type;
  im2fit_diagnosis found;
  jint n[2] = {0, 0};
  jbyteArray text = NULL;
  jshort* from = (*env)->GetShortArrayElements(env, depth, NULL);
  if (!from) return NULL; /* an OutOfMemoryError is thrown on return */
  const int status = im2fit_diagnose(handle_of(handle), (const uint16_t*)from, width, height, 0, &found, sizeof found);
  (*env)->ReleaseShortArrayElements(env, depth, from, JNI_ABORT);
  n[0] = status == IM2FIT_OK ? found.code : status;
  if (status == IM2FIT_OK) {
    n[1] = found.rotate_deg;
    (*env)->SetFloatArrayRegion(env, unit, 0, 1, &found.unit_mm);
    text = bytes_of(env, found.text);
  }
  (*env)->SetIntArrayRegion(env, numbers, 0, 2, n);
  return text;
}

// names: byte[SIZES_MAX][]; counted: their number and the likeliest's index.
static jint native_sizes(JNIEnv* env, jclass type, jlong handle, jobjectArray names, jfloatArray probabilities,
                         jintArray counted) {
  (void)type;
  im2fit_size sizes[SIZES_MAX];
  size_t count = 0;
  size_t best = 0;
  const jint status = im2fit_sizes(handle_of(handle), sizes, SIZES_MAX, &count, &best);
  if (status != IM2FIT_OK) return status;
  for (size_t i = 0; i < count; ++i) {
    jbyteArray name = bytes_of(env, sizes[i].name);
    if (!name) return IM2FIT_ERROR_NO_MEMORY;
    (*env)->SetObjectArrayElement(env, names, (jsize)i, name);
    (*env)->DeleteLocalRef(env, name);
    if ((*env)->ExceptionCheck(env)) return IM2FIT_ERROR_NO_MEMORY;
    (*env)->SetFloatArrayRegion(env, probabilities, (jsize)i, 1, &sizes[i].probability);
  }
  const jint numbers[2] = {(jint)count, (jint)best};
  (*env)->SetIntArrayRegion(env, counted, 0, 2, numbers);
  return IM2FIT_OK;
}

// What to say for a bit of the guidance in `language`; null where there is no such bit or language.
static jbyteArray native_guidance_text(JNIEnv* env, jclass type, jint bit, jbyteArray language) {
  (void)type;
  char code[8] = {0};
  const jsize length = (*env)->GetArrayLength(env, language);
  (*env)->GetByteArrayRegion(env, language, 0, length < 7 ? length : 7, (jbyte*)code);
  return bytes_of(env, im2fit_guidance_text(bit, code));
}

static jint native_tape_count(JNIEnv* env, jclass type) {
  (void)env;
  (void)type;
  return (jint)im2fit_tape_count();
}

// id, unit, ISO number and name in `language` of one definition.
static void native_tape_words(JNIEnv* env, jclass type, jint index, jbyteArray language, jobjectArray words) {
  (void)type;
  char code[8] = {0};
  const jsize length = (*env)->GetArrayLength(env, language);
  (*env)->GetByteArrayRegion(env, language, 0, length < 7 ? length : 7, (jbyte*)code);
  const size_t at = (size_t)index;
  const char* texts[4] = {im2fit_tape_id(at), im2fit_tape_unit(at), im2fit_tape_iso(at), im2fit_tape_name(at, code)};
  for (jsize i = 0; i < 4 && !(*env)->ExceptionCheck(env); ++i) {
    jbyteArray word = bytes_of(env, texts[i]);
    if ((*env)->ExceptionCheck(env)) return;
    (*env)->SetObjectArrayElement(env, words, i, word);
    if (word) (*env)->DeleteLocalRef(env, word);
  }
}

// The whole tape: statuses int[count], values float[3 count], reasons byte[count][].
static jint native_tape(JNIEnv* env, jclass type, jlong handle, jintArray statuses, jfloatArray values,
                        jobjectArray reasons) {
  (void)type;
  const size_t count = im2fit_tape_count();
  im2fit_tape_value* tape = (im2fit_tape_value*)calloc(count, sizeof *tape);
  if (!tape) return IM2FIT_ERROR_NO_MEMORY;
  const jint status = im2fit_tape(handle_of(handle), NULL, count, tape, sizeof *tape);
  for (size_t i = 0; status == IM2FIT_OK && i < count && !(*env)->ExceptionCheck(env); ++i) {
    const jfloat value[3] = {tape[i].value, tape[i].low, tape[i].high};
    const jint kind = tape[i].status;
    (*env)->SetIntArrayRegion(env, statuses, (jsize)i, 1, &kind);
    if (!(*env)->ExceptionCheck(env)) (*env)->SetFloatArrayRegion(env, values, (jsize)(3 * i), 3, value);
    if (!tape[i].reason || (*env)->ExceptionCheck(env)) continue;
    jbyteArray reason = bytes_of(env, tape[i].reason);
    if (!reason) break;
    (*env)->SetObjectArrayElement(env, reasons, (jsize)i, reason);
    (*env)->DeleteLocalRef(env, reason);
  }
  free(tape);
  return status;
}

// vertices, triangles: null to ask for `counted`, else arrays of 3 numbers each.
static jint native_mesh(JNIEnv* env, jclass type, jlong handle, jfloatArray vertices, jintArray triangles,
                        jintArray counted) {
  (void)type;
  size_t vertex_count = 0;
  size_t triangle_count = 0;
  jfloat* v = NULL;
  jint* t = NULL;
  size_t vertex_capacity = 0;
  size_t triangle_capacity = 0;
  if (vertices && triangles) {
    v = (*env)->GetFloatArrayElements(env, vertices, NULL);
    t = v ? (*env)->GetIntArrayElements(env, triangles, NULL) : NULL;
    if (!t) {
      if (v) (*env)->ReleaseFloatArrayElements(env, vertices, v, JNI_ABORT);
      return IM2FIT_ERROR_NO_MEMORY;
    }
    vertex_capacity = (size_t)(*env)->GetArrayLength(env, vertices) / 3;
    triangle_capacity = (size_t)(*env)->GetArrayLength(env, triangles) / 3;
  }
  const jint status = im2fit_body_mesh(handle_of(handle), v, vertex_capacity, &vertex_count, (int32_t*)t,
                                       triangle_capacity, &triangle_count);
  if (v) (*env)->ReleaseFloatArrayElements(env, vertices, v, 0);
  if (t) (*env)->ReleaseIntArrayElements(env, triangles, t, 0);
  const jint numbers[2] = {(jint)vertex_count, (jint)triangle_count};
  (*env)->SetIntArrayRegion(env, counted, 0, 2, numbers);
  return status;
}

// values: float[IM2FIT_MEASUREMENT_COUNT].
static jint native_residual(JNIEnv* env, jclass type, jlong handle, jfloatArray values) {
  (void)type;
  jfloat residual[IM2FIT_MEASUREMENT_COUNT];
  const jint status = im2fit_body_residual(handle_of(handle), residual);
  if (status == IM2FIT_OK) (*env)->SetFloatArrayRegion(env, values, 0, IM2FIT_MEASUREMENT_COUNT, residual);
  return status;
}

// Order of setKnown's `facts`.
enum { STATURE_MM, STATURE_SD_MM, WEIGHT_KG, WEIGHT_SD_KG, AGE_YEARS, AGE_SD_YEARS, FACTS };

static jint native_set_known(JNIEnv* env, jclass type, jlong handle, jfloatArray facts, jint sex) {
  (void)type;
  jfloat f[FACTS];
  (*env)->GetFloatArrayRegion(env, facts, 0, FACTS, f);
  if ((*env)->ExceptionCheck(env)) return IM2FIT_ERROR_INVALID_ARGUMENT;
  im2fit_known known;
  im2fit_known_init(&known, sizeof known);
  known.stature_mm = f[STATURE_MM];
  known.stature_sd_mm = f[STATURE_SD_MM];
  known.weight_kg = f[WEIGHT_KG];
  known.weight_sd_kg = f[WEIGHT_SD_KG];
  known.age_years = f[AGE_YEARS];
  known.age_sd_years = f[AGE_SD_YEARS];
  known.sex = sex;
  return im2fit_set_known(handle_of(handle), &known);
}

static jint native_set_region(JNIEnv* env, jclass type, jlong handle, jfloatArray region) {
  (void)type;
  jfloat mm[4];
  (*env)->GetFloatArrayRegion(env, region, 0, 4, mm);
  if ((*env)->ExceptionCheck(env)) return IM2FIT_ERROR_INVALID_ARGUMENT;
  return im2fit_set_region(handle_of(handle), mm[0], mm[1], mm[2], mm[3]);
}

enum { BYTES_JSON = -1 };  // else IM2FIT_AVATAR_...

// The result as JSON, or an avatar, into made[0].
static jint native_bytes(JNIEnv* env, jclass type, jlong handle, jint what, jobjectArray made) {
  (void)type;
  size_t size = 0;
  char* bytes = NULL;
  im2fit_handle* const of = handle_of(handle);
  jint status = what == BYTES_JSON ? im2fit_result_json(of, NULL, 0, &size) : im2fit_avatar(of, what, NULL, 0, &size);
  if (status == IM2FIT_ERROR_TOO_SMALL) {
    bytes = (char*)malloc(size + 1);
    if (!bytes) return IM2FIT_ERROR_NO_MEMORY;
    status = what == BYTES_JSON ? im2fit_result_json(of, bytes, size + 1, &size)
                                : im2fit_avatar(of, what, bytes, size + 1, &size);
  }
  if (status == IM2FIT_OK) put_bytes(env, made, bytes, size);
  free(bytes);
  return status;
}

// longs: people, captures, the tracker's key, and whether body, shape, backs, clothes and the site's corrections are
// there; texts[0]: what made the index.
static jint native_models(JNIEnv* env, jclass type, jlong handle, jlongArray longs, jobjectArray texts) {
  (void)type;
  im2fit_models models;
  const jint status = im2fit_get_models(handle_of(handle), &models, sizeof models);
  if (status != IM2FIT_OK) return status;
  const jlong known[] = {models.people,        models.captures,       models.tracker_key,     models.has_body,
                         models.answers_shape, models.answers_turned, models.answers_clothed, models.site_corrected};
  (*env)->SetLongArrayRegion(env, longs, 0, (jsize)(sizeof known / sizeof known[0]), known);
  if (!(*env)->ExceptionCheck(env)) put_text(env, texts, 0, models.made_by);
  return IM2FIT_OK;
}

// By name rather than by Java_im2fit_sdk_...: a method that is missing on either side fails when the library is
// loaded.
JNIEXPORT jint JNICALL JNI_OnLoad(JavaVM* machine, void* reserved) {
  (void)reserved;
  static const JNINativeMethod methods[] = {
      {"version", "()[B", (void*)native_version},
      {"lastError", "(J)[B", (void*)native_last_error},
      {"name", "(II)[B", (void*)native_name},
      {"open", "([[B[[B[I[J[J[I[F[J)I", (void*)native_open},
      {"close", "(J)V", (void*)native_close},
      {"push", "(JLjava/nio/ByteBuffer;Ljava/nio/ByteBuffer;[I[J[F)I", (void*)native_push},
      {"act", "(JII)I", (void*)native_act},
      {"poll", "(J[J[F)I", (void*)native_poll},
      {"mask", "(J[B[J)I", (void*)native_mask},
      {"diagnose", "(J[SII[I[F)[B", (void*)native_diagnose},
      {"guidanceText", "(I[B)[B", (void*)native_guidance_text},
      {"sizes", "(J[[B[F[I)I", (void*)native_sizes},
      {"tapeCount", "()I", (void*)native_tape_count},
      {"tapeWords", "(I[B[[B)V", (void*)native_tape_words},
      {"tape", "(J[I[F[[B)I", (void*)native_tape},
      {"mesh", "(J[F[I[I)I", (void*)native_mesh},
      {"residual", "(J[F)I", (void*)native_residual},
      {"setKnown", "(J[FI)I", (void*)native_set_known},
      {"setRegion", "(J[F)I", (void*)native_set_region},
      {"bytes", "(JI[[B)I", (void*)native_bytes},
      {"garmentCount", "()I", (void*)native_garment_count},
      {"garmentWords", "(I[B[[B)V", (void*)native_garment_words},
      {"fit", "(J[[B[[B[[B[F[I[I)I", (void*)native_fit},
      {"dressed", "(J[[B[[B[[B)I", (void*)native_dressed},
      {"rig", "(J[F[I)I", (void*)native_rig},
      {"models", "(J[J[[B)I", (void*)native_models},
      {"rigNodes", "([[B[I)V", (void*)native_rig_nodes},
  };
  JNIEnv* env = NULL;
  if ((*machine)->GetEnv(machine, (void**)&env, JNI_VERSION_1_6) != JNI_OK) return JNI_ERR;
  jclass native = (*env)->FindClass(env, "im2fit/sdk/Native");
  if (!native) return JNI_ERR;
  if ((*env)->RegisterNatives(env, native, methods, sizeof methods / sizeof methods[0]) != JNI_OK) return JNI_ERR;
  return JNI_VERSION_1_6;
}
