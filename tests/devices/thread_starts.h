/* SPDX-License-Identifier: Apache-2.0 */
/* A pthread_create that fails when a test wants it to, as at a limit of processes or of memory: such limits do not
 * bind root, and memory also runs out elsewhere. A program that is linked with thread_starts.cpp has it. */
#ifndef IM2FIT_TESTS_THREAD_STARTS_H
#define IM2FIT_TESTS_THREAD_STARTS_H

#ifdef __cplusplus
extern "C" {
#endif
/* The next `count` threads start, the one after them does not (EAGAIN), all later ones do. */
void fail_thread_start_after(int count);
#ifdef __cplusplus
}
#endif

#endif
