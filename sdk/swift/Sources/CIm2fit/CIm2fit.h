/* SPDX-License-Identifier: Apache-2.0 */
#include <im2fit/im2fit.h>
