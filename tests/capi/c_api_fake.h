/* SPDX-License-Identifier: Apache-2.0 */
#ifndef IM2FIT_TESTS_C_API_FAKE_H
#define IM2FIT_TESTS_C_API_FAKE_H

#include "im2fit/im2fit.h"

#ifdef __cplusplus
extern "C" {
#endif
im2fit_handle* open_with_fake_stages(const im2fit_settings* settings); /* NULL: it failed */
int misuse(void);                                       /* c_misuse_test.c, all of it: the program's exit code */
int status_of_opening(const im2fit_settings* settings); /* opens and closes again */
void fake_damaged_index(int damaged);                   /* of the stages of all handles: found when they measure */
int fake_downs(float* down_y); /* how often the stages were told where down is, of all handles, and the last y */
#ifdef __cplusplus
}
#endif

#endif
