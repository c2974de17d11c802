// SPDX-License-Identifier: Apache-2.0
// Garments, the person in them, and the rig that moves both.
#include <stdlib.h>

#include "im2fit_jni.h"

jint native_garment_count(JNIEnv* env, jclass type) {
  (void)env;
  (void)type;
  return (jint)im2fit_garment_count();
}

// id and name in `language` of one garment.
void native_garment_words(JNIEnv* env, jclass type, jint index, jbyteArray language, jobjectArray words) {
  (void)type;
  char code[8] = {0};
  const jsize length = (*env)->GetArrayLength(env, language);
  (*env)->GetByteArrayRegion(env, language, 0, length < 7 ? length : 7, (jbyte*)code);
  const char* texts[2] = {im2fit_garment_id((size_t)index), im2fit_garment_name((size_t)index, code)};
  for (jsize i = 0; i < 2 && !(*env)->ExceptionCheck(env); ++i) put_text(env, words, i, texts[i]);
}

// Of a garment, the only element of `id`: sizes' names byte[SIZES_MAX][], places' names
// byte[IM2FIT_REGION_COUNT_MAX][]; a float a size, its cost, and three a place, one size after the other; an int a
// place, its verdict; counted: sizes, the best one, places.
jint native_fit(JNIEnv* env, jclass type, jlong handle, jobjectArray id, jobjectArray sizes, jobjectArray places,
                jfloatArray floats, jintArray verdicts, jintArray counted) {
  (void)type;
  char* garment = text_at(env, id, 0);
  im2fit_size_fit* fits = (im2fit_size_fit*)calloc(SIZES_MAX, sizeof *fits);
  size_t count = 0;
  size_t best = 0;
  jint status = IM2FIT_ERROR_NO_MEMORY;
  if (garment && fits)
    status = im2fit_garment_fit(handle_of(handle), garment, fits, sizeof *fits, SIZES_MAX, &count, &best);
  jint place_count = 0;
  for (size_t i = 0; status == IM2FIT_OK && i < count && !(*env)->ExceptionCheck(env); ++i) {
    jfloat f[1 + 3 * IM2FIT_REGION_COUNT_MAX];
    jint v[IM2FIT_REGION_COUNT_MAX];
    place_count = fits[i].region_count;
    f[0] = fits[i].cost;
    for (jint r = 0; r < place_count; ++r) {
      const im2fit_region_fit* place = &fits[i].regions[r];
      f[1 + 3 * r] = place->ease_mm;
      f[2 + 3 * r] = place->low_mm;
      f[3 + 3 * r] = place->high_mm;
      v[r] = place->verdict;
      if (i == 0) put_text(env, places, r, place->name);
    }
    if (!(*env)->ExceptionCheck(env)) put_text(env, sizes, (jsize)i, fits[i].name);
    const jsize step = 1 + 3 * place_count;
    if (!(*env)->ExceptionCheck(env)) (*env)->SetFloatArrayRegion(env, floats, (jsize)i * step, step, f);
    if (!(*env)->ExceptionCheck(env))
      (*env)->SetIntArrayRegion(env, verdicts, (jsize)i * place_count, place_count, v);
  }
  free(fits);
  free(garment);
  if ((*env)->ExceptionCheck(env)) return IM2FIT_ERROR_NO_MEMORY;
  const jint numbers[3] = {(jint)count, (jint)best, place_count};
  (*env)->SetIntArrayRegion(env, counted, 0, 3, numbers);
  return status;
}

// ids, sizes: byte[count][]; a size null for the best. The avatar into made[0].
jint native_dressed(JNIEnv* env, jclass type, jlong handle, jobjectArray ids, jobjectArray sizes, jobjectArray made) {
  (void)type;
  im2fit_worn worn[IM2FIT_WORN_COUNT_MAX];
  char* texts[2 * IM2FIT_WORN_COUNT_MAX] = {NULL};
  const jsize length = (*env)->GetArrayLength(env, ids);
  const jsize count = length < IM2FIT_WORN_COUNT_MAX ? length : IM2FIT_WORN_COUNT_MAX; /* FitSession.kt has checked */
  for (jsize i = 0; i < count && !(*env)->ExceptionCheck(env); ++i) {
    texts[2 * i] = text_at(env, ids, i);
    if (!(*env)->ExceptionCheck(env)) texts[2 * i + 1] = text_at(env, sizes, i);
    worn[i].garment = texts[2 * i];
    worn[i].size = texts[2 * i + 1];
  }
  jint status = IM2FIT_ERROR_NO_MEMORY;
  if (!(*env)->ExceptionCheck(env)) {
    size_t size = 0;
    im2fit_handle* const of = handle_of(handle);
    char* bytes = NULL;
    status = im2fit_dressed_avatar(of, worn, (size_t)count, NULL, 0, &size);
    if (status == IM2FIT_ERROR_TOO_SMALL) {
      bytes = (char*)malloc(size);
      status = bytes ? im2fit_dressed_avatar(of, worn, (size_t)count, bytes, size, &size) : IM2FIT_ERROR_NO_MEMORY;
    }
    if (status == IM2FIT_OK) put_bytes(env, made, bytes, size);
    free(bytes);
  }
  for (jsize i = 0; i < 2 * IM2FIT_WORN_COUNT_MAX; ++i) free(texts[i]);
  return status;
}

// floats: the root, then the nodes' quaternions; numbers: whose, and the inferred joints' bits.
jint native_rig(JNIEnv* env, jclass type, jlong handle, jfloatArray floats, jintArray numbers) {
  (void)type;
  im2fit_rig rig;
  const jint status = im2fit_live_rig(handle_of(handle), &rig, sizeof rig);
  if (status != IM2FIT_OK) return status;
  (*env)->SetFloatArrayRegion(env, floats, 0, 3, rig.root_m);
  if (!(*env)->ExceptionCheck(env))
    (*env)->SetFloatArrayRegion(env, floats, 3, 4 * IM2FIT_RIG_NODE_COUNT, rig.rotations[0]);
  const jint n[2] = {rig.user_id, (jint)rig.joints_inferred};
  if (!(*env)->ExceptionCheck(env)) (*env)->SetIntArrayRegion(env, numbers, 0, 2, n);
  return IM2FIT_OK;
}

// Names of the nodes, and the numbers of their parents.
void native_rig_nodes(JNIEnv* env, jclass type, jobjectArray names, jintArray parents) {
  (void)type;
  jint of[IM2FIT_RIG_NODE_COUNT];
  for (jsize i = 0; i < IM2FIT_RIG_NODE_COUNT && !(*env)->ExceptionCheck(env); ++i) {
    put_text(env, names, i, im2fit_rig_node_name(i));
    of[i] = im2fit_rig_node_parent(i);
  }
  if (!(*env)->ExceptionCheck(env)) (*env)->SetIntArrayRegion(env, parents, 0, IM2FIT_RIG_NODE_COUNT, of);
}
