// SPDX-License-Identifier: Apache-2.0
#include "tests/golden/golden_run.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <span>
#include <string_view>

#include "body/fit/measurement_fit.h"
#include "body/measure.h"
#include "body/model_data.h"
#include "core/crc32c.h"
#include "engine/engine.h"
#include "hal/folder/depth_folder.h"
#include "kernels/normals/normals.h"
#include "kernels/unproject/unproject.h"
#include "person/size_chart.h"
#include "report/result_json.h"

namespace im2fit::golden {
namespace {

// NaN has many bit patterns and one meaning.
std::uint32_t checksum(std::span<const float> values, std::uint32_t previous = 0) {
  for (const float v : values) {
    const std::uint32_t bits = std::isnan(v) ? 0x7FC00000U : std::bit_cast<std::uint32_t>(v);
    previous = crc32c(std::as_bytes(std::span(&bits, 1)), previous);
  }
  return previous;
}
template <class T>
std::uint32_t checksum(ImageView<T> image) {
  std::uint32_t crc = 0;
  for (int v = 0; v < image.height; ++v)
    crc = crc32c(std::as_bytes(std::span(image.row(v), static_cast<std::size_t>(image.width))), crc);
  return crc;
}
std::uint32_t checksum(const JointSet& joints) {
  std::uint32_t crc = checksum(joints.confidence);
  for (const Vec3f& p : joints.position_mm) crc = checksum(std::array{p.x, p.y, p.z}, crc);
  return crc;
}

class Lines {
 public:
  __attribute__((format(printf, 2, 3))) void add(const char* format, ...) {
    char line[256];
    va_list words;
    va_start(words, format);
    std::vsnprintf(line, sizeof line, format, words);
    va_end(words);
    text_ += line;
    text_ += '\n';
  }
  void add_checksum(const char* stage, std::uint32_t crc) { add("%s %08x", stage, static_cast<unsigned>(crc)); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// %.9g gives every float its own text.
double exact(float value) {
  return static_cast<double>(value);
}

void add_frame(Lines& lines, std::size_t frame, const Detection& detection, MaskView mask) {
  const Person& p = detection.person;
  lines.add("frame %zu mask %08x of %d pixels", frame, static_cast<unsigned>(checksum(mask)), p.pixel_count);
  lines.add("frame %zu person box %d %d %d %d centroid %.9g %.9g %.9g", frame, p.u_min, p.v_min, p.u_max, p.v_max,
            exact(p.centroid_mm.x), exact(p.centroid_mm.y), exact(p.centroid_mm.z));
  lines.add("frame %zu floor %d up %.9g %.9g %.9g camera %.9g", frame, p.floor.known ? 1 : 0, exact(p.floor.up.x),
            exact(p.floor.up.y), exact(p.floor.up.z), exact(p.floor.camera_height_mm));
  lines.add("frame %zu joints %08x guidance %x", frame, static_cast<unsigned>(checksum(detection.joints)),
            static_cast<unsigned>(detection.guidance));
}

// Points and normals of the whole fused picture: the production path downsamples it first, so these name the two
// kernels.
void add_cloud(Lines& lines, const Intrinsics& k, DepthView fused_q4) {
  const auto size = static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
  std::vector<float> values(6 * size);
  const auto plane = [&](std::size_t i) { return std::span(values).subspan(i * size, size); };
  RayTable rays(k.width, k.height);
  rays.set(k);
  unproject_portable(fused_q4, 4, rays, plane(0).data(), plane(1).data(), plane(2).data());
  lines.add_checksum("fused points", checksum(std::span(values).first(3 * size)));
  fastest(kNormalsKernels)(k, plane(0).data(), plane(1).data(), plane(2).data(), 2, 30, plane(3).data(),
                           plane(4).data(), plane(5).data());
  lines.add_checksum("fused normals", checksum(std::span(values).last(3 * size)));
}

void add_description(Lines& lines, const Fuser& fuser, const Fuser::Description& d) {
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const Vec3f& p = d.joints.position_mm[j];
    lines.add("fused joint %s %.9g %.9g %.9g confidence %.9g", std::string(kJointNames[j]).c_str(), exact(p.x),
              exact(p.y), exact(p.z), exact(d.joints.confidence[j]));
  }
  lines.add_checksum("fused depth", checksum(fuser.depth_q4()));
  lines.add_checksum("fused mask", checksum(fuser.mask()));
  const MeasurementValues paper = to_values(d.paper);
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    if (std::isfinite(paper[i]))
      lines.add("paper %s %.9g", std::string(kMeasurementTable[i].id).c_str(), exact(paper[i]));
  const auto feature = std::span<const float>(d.feature);
  lines.add_checksum("feature fpfh", checksum(feature.subspan(6, kPaperFeatureSize - 6)));
  lines.add_checksum("feature profile", checksum(feature.subspan(kPaperFeatureSize, kProfileSize)));
  lines.add_checksum("feature sensor", checksum(feature.last(kSensorTraits)));
  lines.add_checksum("feature", checksum(feature));
}

void add_answer(Lines& lines, const index::Index& index, std::span<const float> feature, int frame_count,
                int distance_mm) {
  const auto scratch = index.make_scratch();
  index::QueryOptions options;
  options.frame_count = frame_count;
  options.distance_mm = distance_mm;
  const index::Answer answer = *index.query(feature, options, *scratch);
  for (std::size_t i = 0; i < kMeasurementCount; ++i) {
    const index::IntervalEstimate& e = answer.measurements[i];
    lines.add("answer %s %.9g interval %.9g %.9g", std::string(kMeasurementTable[i].id).c_str(), exact(e.value),
              exact(e.low), exact(e.high));
  }
  lines.add("answer female %.9g", exact(answer.female));
  lines.add("answer entry %u distance %.9g", static_cast<unsigned>(answer.nearest), exact(answer.nearest_distance));
  lines.add_checksum("answer entry values", checksum(answer.nearest_values));
  lines.add("answer person %llu", static_cast<unsigned long long>(index.person_of(answer.nearest)->number));
}

// A person to begin with, and how far from their own measurements the goals are; in the order of ids.
struct BodyCase {
  const char* name;
  float gender, age_years, muscle, weight, height;
  MeasurementValues more;
  bool seen = false;  // beside a body seen
};
constexpr BodyCase kBodyCases[] = {
    {"man", 1, 40, 0.45F, 0.6F, 0.5F, {30, 10, 15, 5, 8, 20, -25, 30, 18, 12, 4}},
    {"heavy woman", 0, 61, 0.2F, 1, 0.5F, {-40, -12, -30, -4, 15, 30, 50, 60, -20, -28, 5}},
    {"slim woman", 0.04F, 22, 0.4F, 0.3F, 0.55F, {12, -15, 10, 8, -6, -30, -20, -35, -25, 14, -4}},
    {"impossible", 1, 30, 0.5F, 0.5F, 0.5F, {0, 0, 0, 0, 0, 0, 0, 900, 0, -300, 0}},
    {"seen man", 1, 40, 0.45F, 0.6F, 0.5F, {30, 10, 15, 5, 8, 20, -25, 30, 18, 12, 4}, true},
    {"seen woman", 0, 61, 0.2F, 1, 0.5F, {-40, -12, -30, -4, 15, 30, 50, 60, -20, -28, 5}, true},
};

void add_body(Lines& lines, const body::BodyModel& model, const BodyCase& person) {
  body::Params params;
  params.gender = person.gender;
  params.age_years = person.age_years;
  params.muscle = person.muscle;
  params.weight = person.weight;
  params.height = person.height;
  const MeasurementValues own = body::measure_person(model, params);
  lines.add_checksum((std::string(person.name) + " before").c_str(), checksum(own));
  body::MeasurementGoals goals;
  for (std::size_t i = 0; i < kMeasurementCount; ++i) goals[i] = {own[i] + person.more[i], 0.01F * own[i]};
  body::SeenBody seen;
  seen.valid = true;
  for (std::size_t k = 0; k < seen.shape.size(); ++k)
    seen.shape[k] = 0.25F * static_cast<float>(static_cast<int>(7 * k % 5) - 2);
  const body::MeasurementFit fit = body::MeasurementFitter(model).run(params, goals, person.seen ? &seen : nullptr);
  lines.add("%s fitted in %d steps, distance %.9g, height %.9g weight %.9g warp %08x modifiers %08x", person.name,
            fit.steps, exact(fit.distance), exact(params.height), exact(params.weight),
            static_cast<unsigned>(checksum(params.warp.values)), static_cast<unsigned>(checksum(params.modifiers)));
  for (std::size_t i = 0; i < kMeasurementCount; ++i)
    lines.add("%s %s %.9g residual %.9g", person.name, std::string(kMeasurementTable[i].id).c_str(),
              exact(fit.values[i]), exact(fit.residual[i]));
}

EngineSettings settings_of(const Intrinsics& intrinsics, bool single_thread) {
  EngineSettings settings;
  settings.width = intrinsics.width;
  settings.height = intrinsics.height;
  settings.intrinsics = intrinsics;
  settings.frames_wanted = kFramesWanted;
  settings.single_thread = single_thread;
  return settings;
}

}  // namespace

Result<Data> Data::load(const std::string& directory) {
  Data data;
  data.directory_ = directory;
  auto bytes = read_file(directory + "/tracker.i2t");
  if (!bytes) return bytes.error();
  data.tracker_bytes_ = std::move(*bytes);
  auto tracker = JointModel::parse(data.tracker_bytes_, directory + "/tracker.i2t");
  if (!tracker) return tracker.error();
  data.tracker_.emplace(std::move(*tracker));
  auto index = index::Index::open(directory + "/index.i2f");
  if (!index) return index.error();
  data.index_.emplace(std::move(*index));
  if (data.index_->feature_size() != kFeatureSize)
    return Error{ErrorCode::unsupported, directory + "/index.i2f is of another feature: scripts/golden --remake"};
  if (const auto loaded = data.load_clip(); !loaded) return loaded.error();
  return data;
}

Status Data::load_clip() {
  auto source = hal::FolderSource::open(directory_ + "/clip");
  if (!source) return source.error();
  if (auto started = (*source)->start(); !started) return started;
  intrinsics_ = (*source)->info().intrinsics;
  const auto size = static_cast<std::size_t>(intrinsics_.width) * static_cast<std::size_t>(intrinsics_.height);
  for (;;) {
    std::vector<std::uint16_t> pixels(size);
    const auto frame = (*source)->next({pixels.data(), intrinsics_.width, intrinsics_.height}, 1000);
    if (!frame && frame.error().code == ErrorCode::end_of_stream) return Ok{};
    if (!frame) return frame.error();
    frames_.push_back(std::move(pixels));
  }
}

Result<std::string> stages(const Data& data) {
  const Intrinsics& k = data.intrinsics();
  PersonDetector sensor(k.width, k.height, data.tracker());
  Fuser fuser(k.width, k.height);
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  const MaskImage mask_image(mask.data(), k.width, k.height);
  Lines lines;
  for (std::size_t i = 0; i < data.frames().size(); ++i) {
    const DepthView depth(data.frames()[i].data(), k.width, k.height);
    const Detection detection = sensor.sense(depth, k, mask_image);
    add_frame(lines, i, detection, mask_image);
    if (detection.guidance != 0 || fuser.frame_count() == kFramesWanted) continue;
    const GuidanceSet refusal = fuser.add(depth, mask_image, k, detection);
    lines.add("frame %zu fused, refusal %x", i, static_cast<unsigned>(refusal));
  }
  const Fuser::Description& description = fuser.describe();
  if (!description.valid) return Error{ErrorCode::invalid_argument, "no frame of the clip was accepted"};
  add_description(lines, fuser, description);
  add_cloud(lines, k, fuser.depth_q4());
  add_answer(lines, data.index(), description.feature, fuser.frame_count(), description.distance_mm);
  return lines.text();
}

Result<std::string> result(const Data& data, const std::string& directory, bool single_thread) {
  auto source = hal::FolderSource::open(directory + "/clip");
  if (!source) return source.error();
  auto engine =
      Engine::create(settings_of((*source)->info().intrinsics, single_thread), data.tracker(), data.index());
  if (!engine) return engine.error();
  if (const auto ran = run(**engine, **source, true); !ran) return ran.error();
  hal::SourceInfo info = (*source)->info();
  info.uri = info.name = "clip";  // wherever the checkout lies
  const auto person = measurement_of(**engine, {&data.index(), nullptr, &builtin_size_system(), nullptr}, info);
  if (!person) return person.error();
  if (!person->result.measured) return Error{ErrorCode::invalid_argument, "the engine did not measure the clip"};
  return result_json(*person);
}

Result<std::string> bodies(const std::string& body_path) {
  const auto model = body::BodyModel::load(body_path);
  if (!model) return model.error();
  const body::BodyModel::Data& d = model->data();
  std::uint32_t crc = crc32c(std::as_bytes(d.base));
  crc = crc32c(std::as_bytes(d.deltas), crc);
  crc = crc32c(std::as_bytes(d.skin), crc);
  crc = crc32c(std::as_bytes(std::span(d.shape_space.point_basis)), crc);
  Lines lines;
  lines.add_checksum("body file", crc);
  for (const BodyCase& person : kBodyCases) add_body(lines, *model, person);
  return lines.text();
}

std::string first_difference(const std::string& expected, const std::string& found) {
  std::string_view a = expected, b = found;
  for (int number = 1; !a.empty() || !b.empty(); ++number) {
    const auto take_line = [](std::string_view& text) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      const std::string line(text.substr(0, end));
      text.remove_prefix(std::min(end + 1, text.size()));
      return line;
    };
    const bool last_of_either = a.empty() || b.empty();
    const std::string line_a = take_line(a), line_b = take_line(b);
    if (line_a != line_b || last_of_either)
      return "line " + std::to_string(number) + ": expected \"" + line_a + "\", found \"" + line_b + "\"";
  }
  return expected == found ? "" : "the line ends differ";
}

}  // namespace im2fit::golden
