// SPDX-License-Identifier: Apache-2.0
// Texts and bytes between C and Java. A failure of the virtual machine (no memory) stays pending.
#include <stdlib.h>
#include <string.h>

#include "im2fit_jni.h"

jbyteArray bytes_of(JNIEnv* env, const char* text) {
  if (!text) return NULL;
  const jsize length = (jsize)strlen(text);
  jbyteArray bytes = (*env)->NewByteArray(env, length);
  if (bytes) (*env)->SetByteArrayRegion(env, bytes, 0, length, (const jbyte*)text);
  return bytes;
}

char* text_at(JNIEnv* env, jobjectArray texts, jsize at) {
  jbyteArray bytes = (jbyteArray)(*env)->GetObjectArrayElement(env, texts, at);
  if (!bytes) return NULL;
  const jsize length = (*env)->GetArrayLength(env, bytes);
  char* text = (char*)malloc((size_t)length + 1);
  if (text) {
    (*env)->GetByteArrayRegion(env, bytes, 0, length, (jbyte*)text);
    text[length] = 0;
  }
  (*env)->DeleteLocalRef(env, bytes);
  return text;
}

void put_text(JNIEnv* env, jobjectArray texts, jsize at, const char* text) {
  jbyteArray bytes = bytes_of(env, text);
  if ((*env)->ExceptionCheck(env)) return;
  (*env)->SetObjectArrayElement(env, texts, at, bytes);
  if (bytes) (*env)->DeleteLocalRef(env, bytes);
}

void put_bytes(JNIEnv* env, jobjectArray made, const char* bytes, size_t size) {
  jbyteArray array = (*env)->NewByteArray(env, (jsize)size);
  if (!array) return;
  (*env)->SetByteArrayRegion(env, array, 0, (jsize)size, (const jbyte*)bytes);
  (*env)->SetObjectArrayElement(env, made, 0, array);
}
