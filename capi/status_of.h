// SPDX-License-Identifier: Apache-2.0
// The statuses of im2fit.h for what the C++ below reports.
#pragma once

#include "capi/include/im2fit/im2fit.h"
#include "core/status.h"

namespace im2fit {

inline int status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::invalid_argument:
      return IM2FIT_ERROR_INVALID_ARGUMENT;
    case ErrorCode::not_found:
      return IM2FIT_ERROR_NOT_FOUND;
    case ErrorCode::io:
      return IM2FIT_ERROR_IO;
    case ErrorCode::corrupt:
      return IM2FIT_ERROR_CORRUPT;
    case ErrorCode::unsupported:
      return IM2FIT_ERROR_UNSUPPORTED;
    case ErrorCode::no_device:
      return IM2FIT_ERROR_NO_DEVICE;
    case ErrorCode::timeout:
      return IM2FIT_ERROR_TIMEOUT;
    case ErrorCode::end_of_stream:
      break;
  }
  return IM2FIT_ERROR_END_OF_STREAM;
}

}  // namespace im2fit
