// SPDX-License-Identifier: Apache-2.0
// im2fit-train-tracker --body FILE.i2b --out FILE.i2t [--images N] [--seed S] [--threads T]
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "core/file.h"
#include "lab/tracker_training/train_tracker.h"

namespace {

int wrong_use(const char* detail) {
  std::fprintf(stderr,
               "im2fit-train-tracker: %s; use --body FILE.i2b --out FILE.i2t [--images N] [--seed S] [--threads T]\n",
               detail);
  return 2;
}

int failed(const std::string& message) {
  std::fprintf(stderr, "im2fit-train-tracker: %s\n", message.c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  std::string body_path;
  std::string out_path;
  im2fit::lab::TrainOptions options;
  const unsigned cores = std::thread::hardware_concurrency();
  options.thread_count = cores > 0 ? static_cast<int>(cores) : 1;
  for (int i = 1; i < argc; i += 2) {
    const std::string key = argv[i];
    if (i + 1 >= argc) return wrong_use("an option lacks its value");
    const std::string value = argv[i + 1];
    if (key == "--body")
      body_path = value;
    else if (key == "--out")
      out_path = value;
    else if (key == "--images")
      options.image_count = std::atoi(value.c_str());
    else if (key == "--seed")
      options.seed = std::strtoull(value.c_str(), nullptr, 10);
    else if (key == "--threads")
      options.thread_count = std::atoi(value.c_str());
    else
      return wrong_use(("unknown option " + key).c_str());
  }
  if (body_path.empty() || out_path.empty()) return wrong_use("--body and --out are needed");
  const auto model = im2fit::body::BodyModel::load(body_path);
  if (!model) return failed(model.error().message);
  int shown = -1;
  const auto bytes = im2fit::lab::train_tracker(*model, options, [&](double share, std::string_view stage) {
    const int percent = static_cast<int>(100 * share);
    if (percent == shown) return;
    shown = percent;
    std::fprintf(stderr, "\r%3d %% %-12.*s", percent, static_cast<int>(stage.size()), stage.data());
  });
  std::fprintf(stderr, "\n");
  if (!bytes) return failed(bytes.error().message);
  const auto written = im2fit::write_file_atomically(out_path, *bytes);
  return written ? 0 : failed(written.error().message);
}
