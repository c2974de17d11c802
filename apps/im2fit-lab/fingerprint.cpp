// SPDX-License-Identifier: Apache-2.0
#include "train/fingerprint.h"

#include <fmt/core.h>

#include <cstdio>

#include "apps/common/paths.h"
#include "apps/im2fit-lab/commands.h"
#include "body/look.h"
#include "core/file.h"
#include "person/data_files.h"

namespace im2fit::apps {
namespace {

struct FingerprintCommand {
  std::string what;
  std::string body = made_body_path();
  std::string tracker = made_tracker_path();
};

Result<std::string> fingerprint_of(const FingerprintCommand& options) {
  const auto model = load_body(options.body);
  if (!model) return model.error();
  if (options.what == "body") return body_fingerprint(*model);
  if (options.what == "tracker") return tracker_fingerprint(*model);
  const auto tracker = Tracker::load(options.tracker);
  if (!tracker) return tracker.error();
  return index_fingerprint(*model, tracker->model());
}

// The body file without its look and start bodies: what trackers and indexes are made of.
Result<int> write_shape(const std::string& path) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const auto shape = body::shape_only(*bytes, path);
  if (!shape) return shape.error();
  if (std::fwrite(shape->data(), 1, shape->size(), stdout) != shape->size())
    return Error{ErrorCode::io, "standard output cannot be written"};
  return kExitOk;
}

Result<int> run_fingerprint(const FingerprintCommand& options) {
  if (options.what == "shape") return write_shape(options.body);
  const auto text = fingerprint_of(options);
  if (!text) return text.error();
  fmt::print("{}\n", *text);
  return kExitOk;
}

}  // namespace

void add_fingerprint(cli::App& app, Command& chosen) {
  auto options = std::make_shared<FingerprintCommand>();
  auto* sub = add_command<FingerprintCommand>(app, chosen, "fingerprint",
                                              "Print versions, and the checksum of a small trial run, of the code "
                                              "that makes data: shows whether earlier data is still valid",
                                              "  im2fit-lab fingerprint tracker", options, run_fingerprint);
  sub->add_option(
         "WHAT", options->what,
         "body, tracker or index; shape: the body file's bytes without what only pictures show, for a digest")
      ->one_of({"body", "tracker", "index", "shape"})
      ->required();
  sub->add_option("--body", options->body, "Body file")->type_name("FILE")->capture_default_str();
  sub->add_option("--tracker", options->tracker, "Tracker file")->type_name("FILE")->capture_default_str();
}

}  // namespace im2fit::apps
