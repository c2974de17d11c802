// SPDX-License-Identifier: Apache-2.0
// Loading what was made once, with errors that say how to make it.
#pragma once

#include <memory>
#include <string>

#include "body/model.h"
#include "core/file.h"
#include "core/status.h"
#include "index/index.h"
#include "perception/joints/tracker.h"

namespace im2fit {

Result<body::BodyModel> load_body(const std::string& path);
Result<index::Index> load_index(const std::string& path);

// A joint model and the mapping it views into.
class Tracker {
 public:
  static Result<Tracker> load(const std::string& path);
  const JointModel& model() const { return model_; }

 private:
  Tracker(MappedFile file, JointModel model) : file_(std::move(file)), model_(std::move(model)) {}
  MappedFile file_;
  JointModel model_;
};

}  // namespace im2fit
