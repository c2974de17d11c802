// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/contact_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "report/drawn_bones.h"

namespace im2fit::lab {
namespace {

constexpr int kPictureSide = 380;  // px, the longer side
constexpr int kCaptionHeight = 40;
constexpr int kGap = 6;
constexpr int kColumns = 5;
constexpr Rgb kTruth{70, 220, 90};
constexpr Rgb kLeft{255, 140, 60};
constexpr Rgb kRight{90, 160, 255};
constexpr Rgb kMiddle{255, 255, 255};
constexpr Rgb kOutline{255, 230, 0};
constexpr Rgb kInk{235, 235, 235};

Rgb colour_of(Joint j) {
  return is_left(j) ? kLeft : is_right(j) ? kRight : kMiddle;
}

class Drawing {
 public:
  Drawing(const Intrinsics& k, DepthView depth, MaskView mask)
      : k_(k),
        depth_(depth),
        mask_(mask),
        scale_(static_cast<float>(kPictureSide) / static_cast<float>(std::max(k.width, k.height))),
        canvas_(static_cast<int>(std::lround(scale_ * static_cast<float>(k.width))),
                static_cast<int>(std::lround(scale_ * static_cast<float>(k.height)))) {}

  void paint() {
    for (int y = 0; y < canvas_.height(); ++y)
      for (int x = 0; x < canvas_.width(); ++x) paint_pixel(x, y);
  }
  void bones(const JointSet& joints, bool true_ones) {
    for (const auto& [from, to, coloured_as] : kDrawnBones) {
      const auto [x0, y0] = project(joints[from]);
      const auto [x1, y1] = project(joints[to]);
      canvas_.line(x0, y0, x1, y1, true_ones ? 3.5F : 1.8F, true_ones ? kTruth : colour_of(coloured_as));
    }
    for (const Vec3f& p : joints.position_mm) {
      const auto [x, y] = project(p);
      canvas_.disc(x, y, true_ones ? 2.5F : 2.0F, true_ones ? kTruth : kMiddle);
    }
  }
  Canvas take() { return std::move(canvas_); }

 private:
  int u_of(int x) const { return std::min(k_.width - 1, static_cast<int>(static_cast<float>(x) / scale_)); }
  int v_of(int y) const { return std::min(k_.height - 1, static_cast<int>(static_cast<float>(y) / scale_)); }
  bool in_mask(int x, int y) const {
    if (mask_.pixels == nullptr || x < 0 || y < 0 || x >= canvas_.width() || y >= canvas_.height()) return false;
    return mask_.at(u_of(x), v_of(y)) != 0;
  }
  void paint_pixel(int x, int y) {
    const float z = depth_.at(u_of(x), v_of(y));
    // Fixed range, so that greys compare from cell to cell: 0.5 m light, 5 m dark; no data stays black.
    const float near = z > 0 ? 1 - std::clamp((z - 500) / 4500, 0.0F, 0.85F) : 0.0F;
    const auto grey = static_cast<std::uint8_t>(std::lround(200 * near));
    canvas_.set(x, y, {grey, grey, grey});
    const bool inside = in_mask(x, y);
    if (inside) canvas_.set(x, y, kOutline, 0.12F);
    if (inside && !(in_mask(x - 1, y) && in_mask(x + 1, y) && in_mask(x, y - 1) && in_mask(x, y + 1)))
      canvas_.set(x, y, kOutline);
  }
  std::pair<float, float> project(Vec3f p) const {
    if (p.z <= 1) return {NAN, NAN};
    return {(p.x * k_.fx / p.z + k_.cx + 0.5F) * scale_, (p.y * k_.fy / p.z + k_.cy + 0.5F) * scale_};
  }

  Intrinsics k_;
  DepthView depth_;
  MaskView mask_;
  float scale_;
  Canvas canvas_;
};

std::string capitals(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(c == '_' ? '-' : std::toupper(c)); });
  return text;
}

void copy(const Canvas& from, int x0, int y0, Canvas& to) {
  for (int y = 0; y < from.height(); ++y)
    for (int x = 0; x < from.width(); ++x) to.set(x0 + x, y0 + y, from.at(x, y));
}

// What fits into a cell's width, in lines.
std::vector<std::string> wrapped(const std::vector<std::string>& words) {
  const auto width = static_cast<std::size_t>(kPictureSide / Canvas::text_width("M", 1));
  std::vector<std::string> lines(1);
  for (const std::string& word : words) {
    if (!lines.back().empty() && lines.back().size() + 2 + word.size() > width) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : ", ") + word;
  }
  return lines;
}

}  // namespace

Canvas draw_judged(const JudgedPicture& picture) {
  const Intrinsics& k = picture.intrinsics;
  Drawing drawing(k, DepthView(picture.depth.data(), k.width, k.height),
                  MaskView(picture.mask.data(), k.width, k.height));
  drawing.paint();
  if (picture.truth.confidence[0] > 0) drawing.bones(picture.truth, true);
  if (picture.found) drawing.bones(picture.joints, false);
  return drawing.take();
}

SheetCell guidance_cell(const JudgedPicture& picture, const GuidanceOutcome& outcome) {
  const std::string raised = fmt::format("{}", fmt::join(names_of(outcome.raised), " "));
  return {draw_judged(picture),
          wrapped({fmt::format("{} scene {}", outcome.kind, outcome.scene), outcome.right() ? "right" : "wrong",
                   "raised " + (raised.empty() ? "nothing" : raised)})};
}

SheetCell room_cell(const JudgedPicture& picture, const RoomOutcome& outcome) {
  return {draw_judged(picture),
          wrapped({fmt::format("room {}", outcome.room), outcome.kind,
                   fmt::format("false users in {} of {} frames", outcome.false_users, outcome.frames)})};
}

SheetCell trial_cell(const JudgedPicture& picture, const TrialOutcome& outcome) {
  SheetCell cell{draw_judged(picture), {}};
  const JointFrame& frame = outcome.converged;
  JointTally tally;
  tally.add(frame);
  std::string verdict = "no person found";
  if (frame.finding == Finding::other) verdict = "something else taken";
  if (frame.finding == Finding::person) verdict = fmt::format("mean {:.0f} mm", tally.summary().mean_mm);
  std::vector<std::string> words = {verdict,
                                    fmt::format("person {} scene {}", outcome.trial.subject, outcome.trial.scene),
                                    name_of(outcome.trial.condition)};
  if (outcome.trial.condition != TrialCondition::bare)
    words.push_back(fmt::format("IoU {:.2f}", outcome.iou_converged.clear));
  for (const auto& [dimension, value] : outcome.labels)
    if (dimension != kPoseGroup)
      words.push_back(value == "none" || value == "some" ? dimension + " " + value : value);
  cell.captions = wrapped(words);
  return cell;
}

Canvas contact_sheet(const std::vector<SheetCell>& cells) {
  const int rows = (static_cast<int>(cells.size()) + kColumns - 1) / kColumns;
  const int cell_height = kPictureSide + kCaptionHeight;
  Canvas sheet(kColumns * (kPictureSide + kGap) + kGap, std::max(1, rows) * (cell_height + kGap) + kGap);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const int x = kGap + static_cast<int>(i) % kColumns * (kPictureSide + kGap);
    const int y = kGap + static_cast<int>(i) / kColumns * (cell_height + kGap);
    const Canvas& picture = cells[i].picture;
    copy(picture, x + (kPictureSide - picture.width()) / 2, y + kCaptionHeight, sheet);
    int line_y = y + 2;
    for (const std::string& line : cells[i].captions) {
      if (line_y + Canvas::text_height(1) > y + kCaptionHeight) break;
      sheet.text(x, line_y, capitals(line), 1, kInk);
      line_y += Canvas::text_height(1) + 5;
    }
  }
  return sheet;
}

}  // namespace im2fit::lab
