// SPDX-License-Identifier: Apache-2.0
// A camera behind the OpenNI2 runtime.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "hal/intrinsics.h"
#include "hal/openni2/runtime.h"
#include "hal/source.h"

namespace im2fit::hal {

struct OpenNi2Options {
  int rotate_deg = 0;
  int width = 640;  // wanted; the nearest depth mode is taken
  int height = 480;
  int fps = 30;
  bool fine_units = false;                 // prefer 100 um to 1 mm; delivered frames are mm in both cases
  std::optional<Calibration> calibration;  // instead of the field of view the device reports; of the mode's size. Its
                                           // rotate_deg is not looked at
};

class OpenNi2Source final : public Source {
 public:
  // `uri` "" takes the first device. Errors: no_device, unsupported (no depth mode we can use), io.
  static Result<std::unique_ptr<OpenNi2Source>> open(const std::string& uri, const OpenNi2Options& options);
  ~OpenNi2Source() override;

  const SourceInfo& info() const override;
  Status start() override;
  Result<FrameInfo> next(DepthImage depth, int timeout_ms) override;
  void stop() override;
  SourceStats stats() const override;

 private:
  struct Impl;
  explicit OpenNi2Source(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace im2fit::hal
