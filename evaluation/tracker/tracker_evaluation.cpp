// SPDX-License-Identifier: Apache-2.0
#include "evaluation/tracker/tracker_evaluation.h"

#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/file.h"
#include "core/rng.h"
#include "evaluation/tracker/guidance_trials.h"
#include "evaluation/tracker/room_trials.h"
#include "evaluation/tracker/scene_trials.h"
#include "report/canvas.h"
#include "report/drawn_bones.h"

namespace im2fit::lab {
namespace {

struct SheetCell {
  Canvas picture;
  std::vector<std::string> captions;  // two lines at most are shown
};

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

// Depth in grey (near is light), the mask's outline in yellow, true bones green; found bones orange (person's left),
// blue (right) and white. True joints of no confidence belong to no person shown.
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

// The frame, its error and its classes; or the guidance raised.
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

// Five cells a row.
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

constexpr std::size_t kSheetPictures = 20;
constexpr std::uint64_t kRandomStream = 0x5A3B1E;

// A frame's badness: the mean error of its joints; not found, or another taken, is worse than any joint.
double badness_mm(const JointFrame& frame) {
  if (frame.finding == Finding::other) return 3e4;
  if (frame.finding == Finding::none) return 2e4;
  double sum = 0;
  int count = 0;
  for (std::size_t j = 0; j < kJointCount; ++j)
    if (frame.in_picture[j]) sum += frame.error_mm[j], ++count;
  return count > 0 ? sum / count : 0;
}

std::vector<const TrialOutcome*> worst_of(const std::vector<TrialOutcome>& trials, TrialCondition condition) {
  std::vector<const TrialOutcome*> sorted;
  for (const TrialOutcome& trial : trials)
    if (trial.trial.condition == condition) sorted.push_back(&trial);
  std::stable_sort(sorted.begin(), sorted.end(), [](const TrialOutcome* a, const TrialOutcome* b) {
    return badness_mm(a->converged) > badness_mm(b->converged);
  });
  // A scene once, at its worse resolution.
  std::set<std::pair<std::uint64_t, int>> seen;
  std::erase_if(sorted, [&](const TrialOutcome* t) {
    return !seen.insert({t->trial.subject, t->trial.scene}).second;
  });
  sorted.resize(std::min(sorted.size(), kSheetPictures));
  return sorted;
}

std::vector<const TrialOutcome*> random_of(const std::vector<TrialOutcome>& trials, std::uint64_t seed) {
  std::vector<const TrialOutcome*> all;
  all.reserve(trials.size());
  for (const TrialOutcome& trial : trials) all.push_back(&trial);
  Rng rng = Rng::for_item(seed, kRandomStream, 0);
  const std::size_t count = std::min(all.size(), kSheetPictures);
  for (std::size_t i = 0; i < count; ++i)
    std::swap(all[i], all[i + static_cast<std::size_t>(rng.index(static_cast<int>(all.size() - i)))]);
  all.resize(count);
  return all;
}

Result<Canvas> sheet_of(const body::BodyModel& model, const JointModel& joint_model, const TrialOptions& options,
                        const std::vector<const TrialOutcome*>& trials) {
  std::vector<SheetCell> cells;
  cells.reserve(trials.size());
  for (const TrialOutcome* trial : trials)
    cells.push_back(trial_cell(picture_of(model, joint_model, options, trial->trial, true), *trial));
  return contact_sheet(cells);
}

Result<Canvas> sheet_of(const body::BodyModel& model, const JointModel& joint_model, const GuidanceOptions& options,
                        const std::vector<const GuidanceOutcome*>& scenes) {
  std::vector<SheetCell> cells;
  cells.reserve(scenes.size());
  for (const GuidanceOutcome* scene : scenes) {
    const auto picture = picture_of(model, joint_model, options, *scene);
    if (!picture) return picture.error();
    cells.push_back(guidance_cell(*picture, *scene));
  }
  return contact_sheet(cells);
}

// Of each kind the first `count` that are wrong, or simply the first.
std::vector<const GuidanceOutcome*> some_of_each_kind(const std::vector<GuidanceOutcome>& scenes, int count,
                                                      bool wrong_only) {
  std::vector<const GuidanceOutcome*> out;
  std::map<std::string, int> taken;
  for (const GuidanceOutcome& scene : scenes)
    if (!(wrong_only && scene.right()) && taken[scene.kind]++ < count) out.push_back(&scene);
  return out;
}

Result<Canvas> sheet_of(const body::BodyModel& model, const JointModel& joint_model, const RoomTrialOptions& options,
                        const std::vector<const RoomOutcome*>& rooms) {
  std::vector<SheetCell> cells;
  cells.reserve(rooms.size());
  for (const RoomOutcome* room : rooms)
    cells.push_back(room_cell(picture_of(model, joint_model, options, *room), *room));
  return contact_sheet(cells);
}

std::vector<const RoomOutcome*> with_false_users(const std::vector<RoomOutcome>& rooms) {
  std::vector<const RoomOutcome*> out;
  for (const RoomOutcome& room : rooms)
    if (room.false_users > 0 && out.size() < kSheetPictures) out.push_back(&room);
  return out;
}

// Where sheets go, and the first error met.
class Sheets {
 public:
  explicit Sheets(std::string folder) : folder_(std::move(folder)), status_(make_directory(folder_)) {}
  template <class Options, class Outcome>
  void add(const std::string& name, const body::BodyModel& model, const JointModel& joint_model,
           const Options& options, const std::vector<const Outcome*>& outcomes) {
    if (!status_ || outcomes.empty()) return;
    const auto sheet = sheet_of(model, joint_model, options, outcomes);
    if (!sheet) {
      status_ = sheet.error();
      return;
    }
    const auto png = sheet->png();
    status_ = png ? write_file_atomically(std::filesystem::path(folder_) / name, *png) : png.error();
  }
  const Status& status() const { return status_; }

 private:
  std::string folder_;
  Status status_;
};

}  // namespace

Result<TrackerOutcomes> evaluate_tracker(const body::BodyModel& model, const JointModel& joint_model,
                                         const TrackerEvaluationOptions& options) {
  TrackerOutcomes outcomes;
  const TrackerSections& wanted = options.sections;
  if (wanted.joints || wanted.segmentation || wanted.confidence)
    outcomes.trials = run_trials(model, joint_model, options.trials);
  if (wanted.people) outcomes.clips = run_clips(model, joint_model, options.clips);
  if (wanted.empty) outcomes.rooms = run_rooms(model, joint_model, options.rooms);
  if (wanted.guidance) {
    auto guidance = run_guidance(model, joint_model, options.guidance);
    if (!guidance) return guidance.error();
    outcomes.guidance = std::move(*guidance);
  }
  return outcomes;
}

Status write_pictures(const body::BodyModel& model, const JointModel& joint_model,
                      const TrackerEvaluationOptions& options, const TrackerOutcomes& outcomes,
                      const std::string& folder) {
  Sheets sheets(folder);
  if (outcomes.trials) {
    for (std::size_t c = 0; c < kConditionCount; ++c) {
      const auto condition = static_cast<TrialCondition>(c);
      const std::string name =
          condition == TrialCondition::full ? "worst.png" : fmt::format("worst-{}.png", name_of(condition));
      sheets.add(name, model, joint_model, options.trials, worst_of(*outcomes.trials, condition));
    }
    sheets.add("random.png", model, joint_model, options.trials, random_of(*outcomes.trials, options.trials.seed));
  }
  if (outcomes.rooms)
    sheets.add("false-users.png", model, joint_model, options.rooms, with_false_users(*outcomes.rooms));
  if (outcomes.guidance) {
    sheets.add("guidance.png", model, joint_model, options.guidance, some_of_each_kind(*outcomes.guidance, 1, false));
    sheets.add("guidance-wrong.png", model, joint_model, options.guidance,
               some_of_each_kind(*outcomes.guidance, 3, true));
  }
  return sheets.status();
}

}  // namespace im2fit::lab
