// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <future>
#include <system_error>

#include "apps/im2fit/session.h"
#include "body/measure.h"
#include "core/file.h"
#include "garment/drape/wear.h"
#include "person/dressing.h"
#include "report/full_result.h"
#include "report/measurement_file.h"
#include "report/overlay.h"
#include "report/text_table.h"
#include "report/vrm_avatar.h"

namespace im2fit::apps {
namespace {

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return c == '_' ? ' ' : static_cast<char>(std::toupper(c)); });
  return text;
}

// Where the answered body is measured, as heights above the floor.
std::vector<SectionLine> section_lines(const SessionOutcome& outcome) {
  std::vector<SectionLine> lines;
  if (!outcome.avatar) return lines;
  const body::BodyModel& model = *outcome.data.body_model;
  body::Measurer measurer(model);
  measurer.measure_rest_mesh(outcome.avatar->figure.rest, outcome.avatar->avatar.params.gender);
  const std::span<const Vec3f> relaxed = measurer.posed();
  float lowest = relaxed[0].y;
  for (int i = 0; i < model.body_vertex_count(); ++i)
    lowest = std::min(lowest, relaxed[static_cast<std::size_t>(i)].y);
  for (const body::Section& section : measurer.sections()) {
    if (section.hull.empty() || section.id == Measurement::shoulder_girth) continue;
    SectionLine line;
    const std::size_t id = measurement_index(section.id);
    line.label = fmt::format("{} {:.0f} MM", upper(std::string(kMeasurementTable[id].id)),
                             outcome.person.result.answer.measurements[id].value);
    float width = 0;
    for (const Vec3f& p : section.hull) {
      line.height_mm += (p.y - lowest) / static_cast<float>(section.hull.size());
      width = std::max(width, std::abs(p.x));
    }
    line.half_width_mm = 1.15F * width + 15.0F;
    lines.push_back(line);
  }
  return lines;
}

Status write_overlay(const SessionOutcome& outcome, const std::string& path) {
  const EngineResult& result = outcome.person.result;
  OverlayInput overlay;
  overlay.intrinsics = outcome.person.source.intrinsics;
  overlay.frame = outcome.shown->depth();
  overlay.fused_q4 = outcome.engine->fused_depth_q4();
  overlay.mask = outcome.engine->fused_mask();
  overlay.has_joints = result.measured || result.has_joints;
  overlay.joints = result.measured ? result.measured_joints : result.joints;
  overlay.floor = result.floor;
  overlay.sections = section_lines(outcome);
  if (result.measured) {
    const auto& stature = result.answer.measurements[measurement_index(Measurement::stature)];
    const auto& weight = result.answer.measurements[measurement_index(Measurement::weight)];
    overlay.captions = {fmt::format("STATURE {:.0f} MM", stature.value),
                        fmt::format("WEIGHT {:.1f} KG", weight.value)};
    if (outcome.person.size) overlay.captions.push_back("SIZE " + outcome.person.size->best);
  } else {
    overlay.captions = {"NOT MEASURED", upper(guidance_words(reported_guidance(result), reported_arms(result)))};
  }
  const auto png = draw_overlay(overlay).png();
  if (!png) return png.error();
  return write_file_atomically(path, *png, Readable::by_owner);
}

}  // namespace

namespace {

Status make_avatar(SessionOutcome& outcome) {
  const auto& body = outcome.person.body;
  if (!body || outcome.avatar) return Ok{};
  MeasuredAvatar made;
  made.avatar = {outcome.data.body_model.get(), body->params, body->pose};
  auto figure = body::make_figure(made.avatar, body->rest);
  if (!figure) return figure.error();
  made.figure = std::move(*figure);
  outcome.avatar = std::move(made);
  return Ok{};
}

}  // namespace

Status dress(SessionOutcome& outcome) {
  if (auto made = make_avatar(outcome); !made) return made;
  if (!outcome.avatar || !outcome.avatar->glb.empty()) return Ok{};
  auto& [avatar, figure, glb] = *outcome.avatar;
  const Wardrobe& wardrobe = builtin_wardrobe();
  const bool woman = outcome.person.result.answer.female > 0.5F;
  const auto worn = everyday_clothes(wardrobe, outcome.person.fits);
  const auto outfit = im2fit::dress(wardrobe, *avatar.model, figure.rest, figure.skeleton, avatar.pose, woman, worn);
  if (!outfit) return outfit.error();
  std::vector<body::ClothLook> looks;
  looks.reserve(worn.size());
  for (const Worn& one : worn) looks.push_back({one.pattern->id, one.pattern->colour});
  body::wear(avatar, **outfit, looks);
  glb = body::glb_of(avatar, figure);
  return Ok{};
}

namespace {

Status write_avatar(const SessionOutcome& outcome, const std::string& directory, const WantedFiles& wanted) {
  if (!outcome.avatar) return Ok{};
  const auto& [avatar, figure, dressed] = *outcome.avatar;
  const std::string name = directory + "/avatar";
  if (wanted.bvh)
    if (auto written = body::write_bvh(figure, name + ".bvh"); !written) return written;
  if (wanted.glb()) {
    const auto glb = wanted.clothes ? dressed : body::glb_of(avatar, figure);
    if (auto written = write_file_atomically(name + ".glb", glb, Readable::by_owner); !written) return written;
  }
  return wanted.obj ? body::write_textured_obj(avatar, figure, name + ".obj") : Ok{};
}

Status write_result(const SessionOutcome& outcome, const std::string& directory) {
  return write_file_atomically(directory + "/result.json",
                               full_result_json(outcome.person, outcome.data, outcome.timing), Readable::by_owner);
}

}  // namespace

// The answer first: a few kilobytes, which fit where the body's megabytes do not, and nothing of the clothes loses
// it. The overlay is drawn while the body is dressed: on another thread where there is one to have.
Status write_outputs(SessionOutcome& outcome, const std::string& directory, const WantedFiles& wanted) {
  if (wanted.result)
    if (auto written = write_result(outcome, directory); !written) return written;
  if (wanted.body())
    if (auto made = make_avatar(outcome); !made) return made;
  std::future<Status> overlay;
  if (wanted.overlay && outcome.shown->depth().pixels != nullptr)
    overlay = std::async([&outcome, path = directory + "/overlay.png"] { return write_overlay(outcome, path); });
  Status dressed = wanted.clothes ? dress(outcome) : Ok{};
  if (overlay.valid())
    if (auto drawn = overlay.get(); !drawn) return drawn;
  if (!dressed) return dressed;
  return write_avatar(outcome, directory, wanted);
}

Status rewrite_outputs(SessionOutcome& outcome, const std::string& directory, const WantedFiles& wanted) {
  if (wanted.overlay) {
    std::error_code fault;
    std::filesystem::remove(directory + "/overlay.png", fault);
    if (fault) return Error{ErrorCode::io, "cannot delete " + directory + "/overlay.png: " + fault.message()};
  }
  WantedFiles again = wanted;
  again.overlay = false;
  return write_outputs(outcome, directory, again);
}

namespace {

// "LK, RK", "" for none.
std::string joint_names(JointFlags joints) {
  std::string names;
  for (std::size_t j = 0; j < kJointCount; ++j)
    if ((joints & joint_bit(j)) != 0) names += (names.empty() ? "" : ", ") + std::string(kJointNames[j]);
  return names;
}

}  // namespace

Result<std::string> write_motion(const MotionRecording& motion, const std::string& path, const body::BodyModel& model,
                                 const std::optional<AnsweredBody>& body) {
  body::Avatar avatar;
  avatar.model = &model;
  if (body) avatar.params = body->params;
  if (const auto written = motion.write(path, avatar); !written) return written.error();
  if (const std::string joints = joint_names(motion.hardly_seen()); !joints.empty() && !path.ends_with(".csv"))
    print_error(path + ": " + joints + " were not seen in most frames: their motion is inferred");
  return fmt::format("{}: {} frames{}\n", path, motion.frame_count(),
                     motion.left_out() > 0 ? fmt::format(", {} more after an hour left out", motion.left_out()) : "");
}

Result<int> report_motion(const SessionOutcome& outcome, const SessionOptions& options, Result<int> code) {
  if (!code || outcome.motion == nullptr) return code;
  const auto moved = write_motion(*outcome.motion, options.motion, *outcome.data.body_model, outcome.person.body);
  if (!moved && *code != kExitOk) return code;  // no person was there: already reported
  if (!moved) return moved.error();
  if (!options.json) fmt::print("{}", *moved);
  return code;
}

// What was known of the person and what became of it.
std::string known_words(const EngineResult& result) {
  const KnownOutcome& outcome = result.known_outcome;
  std::string text;
  if (outcome.used != 0) {
    const auto of = [](const auto& all, Measurement m) { return all[measurement_index(m)].value; };
    text += fmt::format(
        "known {}; without it chest {:.0f} mm, waist {:.0f} mm, hip {:.0f} mm\n",
        fmt::join(names_of_facts(outcome.used), ", "), of(result.unconditioned, Measurement::chest_girth),
        of(result.unconditioned, Measurement::waist_girth), of(result.unconditioned, Measurement::hip_girth));
  }
  if (outcome.doubted != 0)
    text += fmt::format("doubted and not used: {}; it does not fit what the camera saw: check it\n",
                        fmt::join(names_of_facts(outcome.doubted), ", "));
  return text;
}

std::string result_table(const SessionOutcome& outcome, bool paper) {
  const EngineResult& result = outcome.person.result;
  const auto& truth = outcome.input.truth;
  std::vector<std::string> header = {"measurement", "value", "95 % interval"};
  if (truth) header.insert(header.end(), {"truth", "error"});
  if (paper) header.push_back("paper's");
  if (paper && truth) header.push_back("paper's error");
  TextTable table(header);
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const int decimals = i == measurement_index(Measurement::weight) ? 1 : 0;
    const index::IntervalEstimate& e = result.answer.measurements[i];
    std::vector<std::string> row = {fmt::format("{} {}", kMeasurementTable[i].id, kMeasurementTable[i].unit),
                                    number(e.value, decimals),
                                    number(e.low, decimals) + " .. " + number(e.high, decimals)};
    if (truth)
      row.insert(row.end(),
                 {number(truth->values[i], decimals), fmt::format("{:+.{}f}", e.value - truth->values[i], decimals)});
    if (paper) row.push_back(number(result.paper[i], decimals));
    if (paper && truth)
      row.push_back(
          std::isnan(result.paper[i]) ? "-" : fmt::format("{:+.{}f}", result.paper[i] - truth->values[i], decimals));
    table.add(row);
  }
  std::string text = table.text();
  text += fmt::format("\nsex   female with probability {:.2f}{}\n", result.answer.female,
                      truth ? (truth->woman ? " (truth: woman)" : " (truth: man)") : "");
  const index::IntervalEstimate& age = result.age.years;
  text += fmt::format("age   {:.0f} years, {:.0f} to {:.0f}\n", age.value, age.low, age.high);
  if (result.known.given() != 0) text += known_words(result);
  if (const auto& clothing = result.answer.clothing; std::isfinite(clothing.probability)) {
    text += fmt::format("clothes  probability {:.2f}, {:.0f} mm off the skin; measured as {}{}\n",
                        clothing.probability, clothing.ease_mm, result.answer.clothed ? "dressed" : "bare",
                        has(result.guidance, Guidance::clothed)
                            ? ": CLOTHED, but --clothing is bare; take off loose clothes, or give --clothing dressed"
                        : !result.answer.clothed && clothing.probability >= 0.5F
                            ? ": intervals are wider; for the body under clothes, give --clothing dressed"
                            : "");
  }
  if (outcome.person.size) {
    auto entries = outcome.person.size->entries;
    std::sort(entries.begin(), entries.end(),
              [](const auto& a, const auto& b) { return a.probability > b.probability; });
    text += fmt::format("size  {} ({}", outcome.person.size->best, outcome.person.size->chart);
    for (std::size_t i = 0; i < std::min<std::size_t>(2, entries.size()); ++i)
      text += fmt::format("{} {} {:.0f} %", i == 0 ? ":" : ",", entries[i].size, 100 * entries[i].probability);
    text += ")\n";
    if (outcome.person.size->reason)
      text += fmt::format("      {}\n", size_advice_words(*outcome.person.size->reason));
    for (const std::string& id : outcome.person.size->left_out)
      text += fmt::format("      {} was not measured and does not count\n", id);
  }
  text += fmt::format("{} frames seen, {} used", result.frames_seen, result.frames_used);
  if (result.views == AnswerViews::front_and_back)
    text += fmt::format(", {} of them of the back", result.frames_back);
  if (result.views == AnswerViews::around)
    text += fmt::format(", {} of them of a turn by {:.0f} degrees", result.frames_back, std::fabs(result.turned_deg));
  text += '\n';
  return text;
}

namespace {

// "2 damaged frames were left out; the first: ...", or "".
std::string damage_words(const SessionOutcome& outcome) {
  const std::uint64_t count = outcome.person.frames_damaged;
  if (count == 0) return "";
  std::string words = fmt::format("{} damaged frame{} left out", count, count == 1 ? " was" : "s were");
  if (const auto& first = outcome.tap->first_damage()) words += ": " + first->message;
  return words;
}

// Nothing is wrong with the frames: there are too few.
std::string wanted_words(const SessionOutcome& outcome, const SessionOptions& options) {
  const GuidanceSet guidance = reported_guidance(outcome.person);
  if (guidance != 0) return guidance_words(guidance, reported_arms(outcome.person.result));
  return fmt::format("more frames, at least {} good ones; record longer",
                     std::min(EngineSettings{}.frames_min, options.frames));
}

// What a code leaves open. Of frames in which no person was found: why one who is there is not, the kind of picture,
// when it cannot be a room in millimetres; else the requirement for one.
std::string depth_words(const SessionOutcome& outcome) {
  const GuidanceSet guidance = reported_guidance(outcome.person);
  if (has(guidance, Guidance::floor_bent))
    return "; the depth shows the floor curved: are these distances from the camera, or is the lens not undone?";
  if (has(guidance, Guidance::out_of_population))
    return fmt::format("; people of {:.2f} to {:.2f} m are measured", kSeenStatureMinMm / 1000,
                       kSeenStatureMaxMm / 1000);
  if (has(guidance, Guidance::depth_missing))
    return "; the legs give no depth: dark and shiny cloth swallows the light, matte and bright clothes help";
  if (has(guidance, Guidance::step_to_the_middle))
    return "; the person is one surface with a wall or a shelf: nothing may touch the person";
  if (!has(guidance, Guidance::no_person)) return "";
  const std::string& diagnosis = outcome.person.diagnosis.text;
  // Legs and hips may be furniture: without the chest no person is found.
  return "; " + (diagnosis.empty() ? "the picture must reach from the floor to above the head" : diagnosis);
}

}  // namespace

std::vector<std::string> session_notes(const SessionOutcome& outcome) {
  std::vector<std::string> notes;
  if (const std::string damage = damage_words(outcome); !damage.empty()) notes.push_back(damage);
  if (has(reported_guidance(outcome.person), Guidance::turn_round))
    notes.push_back(
        fmt::format("measured from the front alone: {} good frames of the back were seen, at least {} are needed",
                    outcome.person.result.frames_back, EngineSettings{}.frames_min));
  const EngineResult& result = outcome.person.result;
  const float turned = std::fabs(result.turned_deg);
  if (is_all_round(result.turn) && result.views == AnswerViews::front) {
    const std::string why =
        !result.front_measured
            ? "a turn is measured of people without loose clothes, with the floor in view, and with a "
              "camera whose driver does not blend edges"
        : result.turn == Turn::walk && turned == 0
            ? std::string("the source tells no poses of the camera; --around=camera needs them")
        : turned < kTurnEnoughDeg
            ? fmt::format("{} by {:.0f} degrees, {:.0f} are needed",
                          result.turn == Turn::walk ? "the camera was carried round" : "the person turned", turned,
                          kTurnEnoughDeg)
            : "no body fits the pictures of the turn";
    notes.push_back("measured from the front alone: " + why);
  }
  return notes;
}

namespace {

Status write_exports(SessionOutcome& outcome, const SessionOptions& options) {
  const LengthUnit unit = options.export_unit == "in"   ? LengthUnit::in
                          : options.export_unit == "cm" ? LengthUnit::cm
                                                        : LengthUnit::mm;
  for (const std::string& path : options.exports) {
    if (is_vrm_name(path)) {
      if (auto made = make_avatar(outcome); !made) return made;
      if (!outcome.avatar) return Error{ErrorCode::unsupported, path + ": no body was made; give --body"};
      const auto vrm = vrm_of(outcome.avatar->avatar, outcome.avatar->figure);
      if (!vrm) return vrm.error();
      if (auto written = write_file_atomically(path, *vrm, Readable::by_owner); !written) return written;
      continue;
    }
    const auto text = measurement_file(outcome.person, path, unit);
    if (!text) return text.error();
    if (auto written = write_file_atomically(path, *text, Readable::by_owner); !written) return written;
  }
  return Ok{};
}

}  // namespace

Result<int> report_session(SessionOutcome& outcome, const SessionOptions& options) {
  const EngineResult& result = outcome.person.result;
  if (!options.out.empty())
    if (const auto written = write_outputs(outcome, options.out, wanted_files(options)); !written)
      return written.error();
  if (options.json) fmt::print("{}", full_result_json(outcome.person, outcome.data, outcome.timing));
  if (const auto flushed = flush_output(); !flushed) return flushed.error();
  const std::string damage = damage_words(outcome);
  if (!result.measured) {
    print_error(fmt::format("no measurement after {} frames ({} good ones); needed: {}{}{}", result.frames_seen,
                            result.frames_used, wanted_words(outcome, options), depth_words(outcome),
                            damage.empty() ? "" : "; " + damage));
    return kExitNoMeasurement;
  }
  if (const auto written = write_exports(outcome, options); !written) return written.error();
  for (const std::string& note : session_notes(outcome)) print_error(note);
  if (const std::string note = body_note(outcome.person); !note.empty()) print_error(note);
  if (!options.json) {
    fmt::print("{}", result_table(outcome, options.paper));
    if (!options.out.empty()) fmt::print("written to {}\n", options.out);
    for (const std::string& path : options.exports) fmt::print("written to {}\n", path);
  }
  return kExitOk;
}

}  // namespace im2fit::apps
