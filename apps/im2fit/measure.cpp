// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include <filesystem>
#include <optional>

#include "apps/common/progress.h"
#include "apps/im2fit/commands.h"
#include "apps/im2fit/preview_renderer.h"
#include "apps/im2fit/session.h"
#include "hal/folder/other_recordings.h"
#include "hal/open/open.h"

namespace im2fit::apps {
namespace {

Result<int> run_measure(const SessionOptions& options) {
  std::optional<Progress> progress(std::in_place, "reading frames", 0);
  auto outcome = run_session(options, [&](std::uint64_t frame_count, const EngineResult& result) {
    const std::string good = fmt::format("{} good", result.frames_used);
    const std::string turn = turn_words(result);
    progress->update(frame_count, turn.empty() ? good : good + "; " + turn);
  });
  progress.reset();  // its line goes before anything else is printed
  if (!outcome) return outcome.error();
  return report_motion(*outcome, options, report_session(*outcome, options));
}

// A camera or a recording has no lengths to find a unit of, and nobody walks round.
Result<int> run_measure_scan(const SessionOptions& options) {
  const std::string& source = options.input.source;
  if (hal::is_scan(source)) return run_measure(options);
  std::error_code code;
  if (std::filesystem::is_regular_file(source, code))
    if (auto other = hal::other_recording(source)) return *other;  // a mesh of another kind, for example
  return Error{ErrorCode::invalid_argument,
               source +
                   " is no scan; expected a file whose name ends in .ply, .obj, .glb or .pcd. A camera or a "
                   "recording is measured by: im2fit measure " +
                   source};
}

}  // namespace

void add_measure(cli::App& app, Command& chosen) {
  auto options = std::make_shared<SessionOptions>();
  options->input.reconnect_s = 10;
  auto* sub =
      add_command<SessionOptions>(app, chosen, "measure", "Measure the person in a recording or in front of a camera",
                                  "  im2fit measure person.oni --out me\n  im2fit measure FOLDER --json\n  im2fit "
                                  "measure synthetic:7 --around --out seven",
                                  options, run_measure);
  add_session_options(*sub, *options);
}

void add_measure_scan(cli::App& app, Command& chosen) {
  auto options = std::make_shared<SessionOptions>();
  options->turn = std::string(kTurnNames[static_cast<std::size_t>(Turn::walk)]);
  // Two of ten scans of other people's meshes were taken for clothed, and measured from the front alone.
  options->clothing = "bare";
  auto* sub = add_command<SessionOptions>(
      app, chosen, "measure-scan", "Measure the person in a body scan: a mesh or a point cloud",
      "  im2fit measure-scan anna.ply --out anna\n  im2fit measure-scan scan.obj --unit 25.4 --up z --json", options,
      run_measure_scan);
  add_session_options(*sub, *options);
}

}  // namespace im2fit::apps
