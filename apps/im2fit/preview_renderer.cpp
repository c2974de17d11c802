// SPDX-License-Identifier: Apache-2.0
#include "apps/im2fit/preview_renderer.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "apps/im2fit/session.h"
#include "core/file.h"
#include "engine/engine.h"
#include "report/overlay.h"

namespace im2fit::apps {
namespace {

// Views into the frame: valid as long as that is.
PreviewInput preview_of(const FrameSeen& frame, const Intrinsics& intrinsics) {
  PreviewInput input;
  input.intrinsics = intrinsics;
  input.depth = frame.depth;
  input.mask = frame.mask;
  input.has_joints = frame.result.has_joints;
  input.joints = frame.result.display_joints;
  input.inferred = frame.result.joints_inferred;
  input.users.assign(frame.users.begin(), frame.users.end());
  input.measured_user = frame.result.user;
  return input;
}

constexpr auto kShowPeriod = std::chrono::milliseconds(100);
constexpr int kPictureHeightPx = 960;
constexpr int kLineCount = 3;

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return c == '_' ? ' ' : static_cast<char>(std::toupper(c)); });
  return text;
}

}  // namespace

std::string turn_words(const EngineResult& result) {
  if (has(result.guidance, Guidance::turn_round)) return "please turn round";
  const bool slower = has(result.guidance, Guidance::turn_slower);
  if (result.turn == Turn::walk && (slower || has(result.guidance, Guidance::walk_round)))
    return fmt::format("please walk round them {}: {:.0f} of 360 degrees", slower ? "more slowly" : "slowly",
                       std::fabs(result.turned_deg));
  if (!slower && !has(result.guidance, Guidance::turn_on)) return "";
  return fmt::format("please turn {}, once all round: {:.0f} of 360 degrees", slower ? "more slowly" : "slowly",
                     std::fabs(result.turned_deg));
}

std::string state_words(const EngineResult& result, int frames_wanted) {
  std::string words = fmt::format("{:<11}", name_of(result.state));
  if (result.user != 0) words += fmt::format("  user {}  {}", result.user, name_of(result.view));
  if (result.state == SessionState::tracking)
    words += fmt::format("  {} of {} good frames", result.frames_used, frames_wanted);
  if (result.state == SessionState::turning && is_all_round(result.turn))
    words += fmt::format("  turned {:.0f} of 360 degrees", std::fabs(result.turned_deg));
  else if (result.state == SessionState::turning)
    words += fmt::format("  {} of {} good frames of the back", result.frames_back, frames_wanted);
  return words;
}

PreviewRenderer::PreviewRenderer(PreviewRendererOptions options, const Intrinsics& intrinsics, int frames_wanted)
    : options_(std::move(options)), intrinsics_(intrinsics), frames_wanted_(frames_wanted) {
  if (options_.view) view_ = std::make_unique<TerminalView>();
}

void PreviewRenderer::see(const FrameSeen& frame) {
  const std::uint64_t index = frames_++;
  if (!options_.overlay.empty() && !error_ && index % static_cast<std::uint64_t>(options_.overlay_every) == 0)
    write_picture(frame);
  if (view_ == nullptr) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - shown_ < kShowPeriod) return;
  shown_ = now;
  show_picture(frame);
}

void PreviewRenderer::write_picture(const FrameSeen& frame) {
  PreviewInput input = preview_of(frame, intrinsics_);
  input.captions = {upper(state_words(frame.result, frames_wanted_))};
  if (frame.result.guidance != 0)
    input.captions.push_back(upper(guidance_words(frame.result.guidance, frame.result.arms_close)));
  const auto png = draw_preview(input, kPictureHeightPx).png();
  if (!png) {
    error_ = png.error();
    return;
  }
  const std::string path = fmt::format("{}/{:06}.png", options_.overlay, frame.info.sequence);
  if (const auto written = write_file_atomically(path, *png, Readable::by_owner); !written)
    error_ = written.error();
  else
    ++pictures_;
}

void PreviewRenderer::show_picture(const FrameSeen& frame) {
  const PreviewInput input = preview_of(frame, intrinsics_);
  const int height = view_->picture_height(intrinsics_.width, intrinsics_.height, kLineCount);
  const bool measured = frame.result.state == SessionState::measured;
  std::string needed = "needed: " + guidance_words(frame.result.guidance, frame.result.arms_close);
  if (const std::string turn = turn_words(frame.result); !turn.empty()) needed = turn + "; " + needed;
  if (measured) needed = "measured: please step out of the picture";
  view_->show(draw_preview(input, height, false), {state_words(frame.result, frames_wanted_), needed, last_word_});
}

}  // namespace im2fit::apps
