// SPDX-License-Identifier: Apache-2.0
// The layer's own header: Java's arrays and texts, and the functions that im2fit_jni.c gives the virtual machine.
#pragma once

#include <im2fit/im2fit.h>
#include <jni.h>
#include <stddef.h>
#include <stdint.h>

static inline im2fit_handle* handle_of(jlong handle) {
  return (im2fit_handle*)(intptr_t)handle;
}

enum { SIZES_MAX = 64 };  // of a chart; the built-in ones have 9

// NULL for NULL.
jbyteArray bytes_of(JNIEnv* env, const char* text);
// A zero-ended copy of an element of byte[][]; NULL where the element is null, or after a failure, which is pending.
char* text_at(JNIEnv* env, jobjectArray texts, jsize at);
// A text as element `at`; a failure is pending afterwards. No exception may be pending before.
void put_text(JNIEnv* env, jobjectArray texts, jsize at, const char* text);
// Bytes of the library's as made[0].
void put_bytes(JNIEnv* env, jobjectArray made, const char* bytes, size_t size);

// ---- im2fit_jni_garments.c
jint native_garment_count(JNIEnv* env, jclass type);
void native_garment_words(JNIEnv* env, jclass type, jint index, jbyteArray language, jobjectArray words);
jint native_fit(JNIEnv* env, jclass type, jlong handle, jobjectArray id, jobjectArray sizes, jobjectArray places,
                jfloatArray floats, jintArray verdicts, jintArray counted);
jint native_dressed(JNIEnv* env, jclass type, jlong handle, jobjectArray ids, jobjectArray sizes, jobjectArray made);
jint native_rig(JNIEnv* env, jclass type, jlong handle, jfloatArray floats, jintArray numbers);
void native_rig_nodes(JNIEnv* env, jclass type, jobjectArray names, jintArray parents);
