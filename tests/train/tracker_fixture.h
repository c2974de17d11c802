// SPDX-License-Identifier: Apache-2.0
// Body pack and tracker, loaded once: env IM2FIT_TRACKER, else the cache. Tests skip where one is missing.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/file.h"
#include "perception/joints/tracker.h"
#include "tests/train/body_fixture.h"

namespace im2fit::lab {

class WithTracker : public WithBody {
 protected:
  void SetUp() override {
    WithBody::SetUp();
    if (IsSkipped()) return;
    if (loaded().model == nullptr) {
      auto bytes = read_file(path());
      if (!bytes) GTEST_SKIP() << "no tracker at " << path();
      loaded().bytes = std::move(*bytes);
      auto model = JointModel::parse(loaded().bytes, path());
      ASSERT_TRUE(model) << model.error().message;
      loaded().model = std::make_unique<JointModel>(std::move(*model));
    }
  }
  static const JointModel& tracker() { return *loaded().model; }

 private:
  struct Loaded {
    std::vector<std::byte> bytes;  // the model points into these
    std::unique_ptr<JointModel> model;
  };
  static Loaded& loaded() {
    static Loaded loaded;
    return loaded;
  }
  static std::string path() { return data_path("IM2FIT_TRACKER", "tracker.i2t"); }
};

}  // namespace im2fit::lab
