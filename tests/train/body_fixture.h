// SPDX-License-Identifier: Apache-2.0
// The real body pack, loaded once: env IM2FIT_BODY, else the cache. Tests skip where there is none.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "body/model.h"

namespace im2fit::lab {

// The file the environment variable names, else the file in the cache.
inline std::string data_path(const char* variable, const char* file) {
  if (const char* given = std::getenv(variable)) return given;
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  return (cache != nullptr ? std::string(cache) : std::string(home != nullptr ? home : ".") + "/.cache") +
         "/im2fit/" + file;
}

class WithBody : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (shared() != nullptr) return;
    if (auto loaded = body::BodyModel::load(path())) shared() = std::make_unique<body::BodyModel>(std::move(*loaded));
  }
  void SetUp() override {
    if (shared() == nullptr) GTEST_SKIP() << "no body pack at " << path();
  }
  static const body::BodyModel& model() { return *shared(); }

 private:
  static std::unique_ptr<body::BodyModel>& shared() {
    static std::unique_ptr<body::BodyModel> model;
    return model;
  }
  static std::string path() { return data_path("IM2FIT_BODY", "body.i2b"); }
};

}  // namespace im2fit::lab
