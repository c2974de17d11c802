// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit/remeasure.h"

#include <nlohmann/json.hpp>

#include "apps/im2fit/session.h"
#include "apps/sessions/store.h"
#include "formats/json_file.h"
#include "report/full_result.h"

namespace im2fit::apps {

Result<Remeasured> remeasure(const RemeasureOptions& given) {
  auto record = sessions::read(given.root, given.id);
  if (!record) return record.error();
  const auto recording = sessions::recording_of(given.root, given.id);
  if (!recording) return recording.error();
  SessionOptions options;
  options.input.source = *recording;
  options.input.body = given.body;
  options.tracker = given.tracker;
  options.index = given.index;
  options.out = given.out;
  const sessions::Settings& settings = record->settings;
  if (settings.frames > 0) options.frames = settings.frames;
  options.turn = settings.turn;
  if (!settings.calibration.empty()) options.calibration = settings.calibration;
  if (!settings.clothing.empty()) options.clothing = settings.clothing;
  if (!settings.sensor.empty()) options.sensor = settings.sensor;
  options.region = settings.region;
  // As the camera's driver reported it; a folder reports nothing.
  if (options.sensor == "auto" && !record->camera.kind.empty()) options.sensor = record->camera.kind;
  auto outcome = run_session(options, nullptr);
  if (!outcome) return outcome.error();
  if (!options.out.empty())
    if (const auto written = write_outputs(*outcome, options.out); !written) return written.error();
  Remeasured done{std::move(*record), nullptr,
                  *parse_json<Json>(full_result_json(outcome->person, outcome->data), "result.json")};
  const auto folder = sessions::folder_of(given.root, given.id);
  auto before = folder ? read_json<Json>(*folder + "/" + sessions::kResultFile, kTextBytesMax) : folder.error();
  if (before && before->is_object()) done.before = std::move(*before);
  return done;
}

}  // namespace im2fit::apps
