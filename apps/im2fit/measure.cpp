// SPDX-License-Identifier: Apache-2.0
#include <fmt/core.h>

#include "apps/im2fit/commands.h"
#include "apps/im2fit/session.h"

namespace im2fit::apps {
namespace {

// Files, then the answer on stdout; exit 3 when there is none.
Result<int> report(const SessionOutcome& outcome, const SessionOptions& options) {
  const EngineResult& result = outcome.report.result;
  if (!options.out.empty())
    if (const auto written = write_outputs(outcome, options.out); !written) return written.error();
  if (options.json) fmt::print("{}", result_json(outcome.report));
  if (const auto flushed = flush_output(); !flushed) return flushed.error();
  if (!result.measured) {
    print_error(fmt::format("no measurement after {} frames ({} good ones); needed: {}", result.frames_seen,
                            result.frames_used, guidance_words(reported_guidance(result))));
    return kExitNoMeasurement;
  }
  if (!options.json) {
    fmt::print("{}", result_table(outcome));
    if (!options.out.empty()) fmt::print("written to {}\n", options.out);
  }
  return kExitOk;
}

Result<int> run_measure(const SessionOptions& options) {
  Progress progress("reading frames", 0);
  const auto outcome = run_session(options, [&](std::uint64_t frame_count, const EngineResult& result) {
    progress.update(frame_count, fmt::format("{} good", result.frames_used));
  });
  if (!outcome) return outcome.error();
  return report(*outcome, options);
}

// Prints what the person should do whenever it changes.
Result<int> run_live(const SessionOptions& options) {
  SessionState state = SessionState::searching;
  GuidanceSet guidance = 0;
  bool first = true;
  const auto outcome = run_session(options, [&](std::uint64_t, const EngineResult& result) {
    if (!first && result.state == state && result.guidance == guidance) return;
    first = false;
    state = result.state;
    guidance = result.guidance;
    fmt::print(stderr, "{:<12} needed: {}  ({} good frames)\n", name_of(state), guidance_words(guidance),
               result.frames_used);
  });
  if (!outcome) return outcome.error();
  return report(*outcome, options);
}

}  // namespace

void add_measure(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<SessionOptions>();
  auto* sub =
      add_command<SessionOptions>(app, chosen, "measure", "Measure the person in a recording or before a camera",
                                  "  im2fit measure person.oni --out me\n  im2fit measure FOLDER --json\n  im2fit "
                                  "measure synthetic:7 --out seven",
                                  options, run_measure);
  add_session_options(*sub, *options);
}

void add_live(CLI::App& app, Command& chosen) {
  auto options = std::make_shared<SessionOptions>();
  options->live = true;
  auto* sub = add_command<SessionOptions>(
      app, chosen, "live", "Guide the person before a camera, then measure; Ctrl-C measures with what there is",
      "  im2fit live openni2 --rotate 90 --out me\n  im2fit live synthetic:7", options, run_live);
  add_session_options(*sub, *options);
}

}  // namespace im2fit::apps
