// SPDX-License-Identifier: Apache-2.0
#include "evaluation/measurements/runtime.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "body/export/export.h"
#include "evaluation/measurements/error_statistics.h"
#include "formats/json_file.h"
#include "garment/drape/wear.h"
#include "person/avatar.h"
#include "person/data_files.h"
#include "person/dressing.h"
#include "train/common/stopwatch.h"

namespace im2fit::lab {
namespace {

constexpr int kPeople = 6, kTriedMost = 30;
constexpr double kQuerySecondsMost = 1.0;
constexpr std::size_t kQueriesMost = 5000;

struct Asker {
  Feature feature;
  JointSet joints;
  int frames = 0, distance_mm = 0;
  double describe_ms = 0;
};

std::vector<Asker> askers(const SessionModels& models, const EvaluationOptions& options) {
  std::vector<Asker> people;
  CaptureRig rig(models.body, models.joints);
  for (int i = 0; i < kTriedMost && people.size() < kPeople; ++i) {
    HeldOutPerson person = draw_person(models.body, options, static_cast<std::uint64_t>(i));
    person.capture.frame_count = std::max(person.capture.frame_count, kCaptureFramesMin);
    const double before = rig.cost.describe;
    const Capture& capture = rig.run(person.subject, person.capture);
    if (capture.valid)
      people.push_back({capture.feature, capture.joints, capture.frame_count, capture.distance_mm,
                        1e3 * (rig.cost.describe - before)});
  }
  return people;
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return quantile(values, 0.5);
}

Status time_queries(const index::Index& index, const std::vector<Asker>& people, RuntimeRow& row) {
  const auto scratch = index.make_scratch();
  std::vector<double> spent_ms;
  double sum_s = 0;
  for (std::size_t i = 0; i < kQueriesMost && sum_s < kQuerySecondsMost; ++i) {
    const Asker& asker = people[i % people.size()];
    index::QueryOptions options;
    options.frame_count = asker.frames;
    options.distance_mm = asker.distance_mm;
    Stopwatch watch;
    const auto answer = index.query(asker.feature, options, *scratch);
    const double seconds = watch.lap();
    if (!answer) return answer.error();
    sum_s += seconds;
    if (i >= people.size()) spent_ms.push_back(1e3 * seconds);  // the first round wakes the file's pages
  }
  std::sort(spent_ms.begin(), spent_ms.end());
  if (spent_ms.empty()) return Ok{};
  row.query_p50_ms = quantile(spent_ms, 0.5);
  row.query_p99_ms = quantile(spent_ms, 0.99);
  return Ok{};
}

// From an answer to a body in a file.
Status time_bodies(const SessionModels& models, const index::Index& index, const std::vector<Asker>& people,
                   RuntimeRow& row) {
  const auto scratch = index.make_scratch();
  const std::string path =
      (std::filesystem::temp_directory_path() / ("im2fit-eval-" + std::to_string(::getpid()) + ".glb")).string();
  std::vector<double> naked_ms, clothed_ms;
  for (const Asker& asker : people) {
    const auto answer = index.query(asker.feature, {}, *scratch);
    if (!answer) return answer.error();
    std::array<double, 2> spent_ms{};
    for (const bool garment : {false, true}) {
      Stopwatch watch;
      body::MeasurementFitter fitter(models.body);
      const auto body = body_of_answer(fitter, *answer, asker.joints, FloorPlane{});
      if (!body) return body.error();
      body::Avatar avatar{&models.body, body->params, body->pose};
      std::unique_ptr<body::Outfit> outfit;
      if (garment) {
        auto dressed = dress_everyday(builtin_wardrobe(), builtin_size_system(), models.body, body->params,
                                      body->pose, answer->female);
        if (!dressed) return dressed.error();
        outfit = std::move(*dressed);
        body::wear(avatar, *outfit);
      }
      const auto written = body::write_glb(avatar, path);
      spent_ms[garment ? 1 : 0] = 1e3 * watch.lap();
      if (!written) return written.error();
    }
    naked_ms.push_back(spent_ms[0]);
    clothed_ms.push_back(spent_ms[1]);
  }
  std::error_code ignored;
  std::filesystem::remove(path, ignored);
  row.naked_ms = row.measurements_ms + median_of(naked_ms);
  row.clothed_ms = row.measurements_ms + median_of(clothed_ms);
  return Ok{};
}

Result<RuntimeRow> runtime_of(const SessionModels& models, const index::Index& index, const std::string& file,
                              const std::vector<Asker>& people) {
  RuntimeRow row;
  row.file = file;
  row.models = index.size();
  if (people.empty()) return Error{ErrorCode::invalid_argument, "runtime: no person could be described"};
  if (index.feature_size() != people[0].feature.size())
    return Error{ErrorCode::unsupported, file + ": made for " + std::to_string(index.feature_size()) +
                                             " features, these programs compute " +
                                             std::to_string(people[0].feature.size())};
  if (auto timed = time_queries(index, people, row); !timed) return timed.error();
  std::vector<double> describe_ms;
  describe_ms.reserve(people.size());
  for (const Asker& asker : people) describe_ms.push_back(asker.describe_ms);
  row.measurements_ms = median_of(describe_ms) + row.query_p50_ms;
  // Entries of indexes made to measure speed name no person that could be drawn.
  if (const auto timed = time_bodies(models, index, people, row);
      !timed && timed.error().code != ErrorCode::unsupported)
    return timed.error();
  return row;
}

}  // namespace

Result<std::vector<RuntimeRow>> measure_runtime(const SessionModels& models, const std::string& name,
                                                const std::vector<std::string>& files,
                                                const EvaluationOptions& options) {
  const std::vector<Asker> people = askers(models, options);
  std::vector<RuntimeRow> rows;
  auto first = runtime_of(models, models.index, name, people);
  if (!first) return first.error();
  rows.push_back(*first);
  for (const std::string& file : files) {
    const auto index = load_index(file);
    if (!index) return index.error();
    auto row = runtime_of(models, *index, file, people);
    if (!row) return row.error();
    rows.push_back(*row);
  }
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.models < b.models; });
  return rows;
}

Result<std::vector<ReferenceLine>> read_index_references(const std::string& path) {
  const auto read = read_json(path);
  if (!read) return read.error();
  const nlohmann::json& json = *read;
  if (!json.is_object() || !json.contains("rows") || !json["rows"].is_array())
    return Error{ErrorCode::corrupt, path + ": expected the JSON of bench/index/index_references, with `rows`"};
  std::vector<ReferenceLine> lines = {{"im2fit", {}}, {"brute force, 501 float", {}}};
  for (const auto& row : json["rows"])
    for (ReferenceLine& line : lines)
      if (row.value("peer", "") == line.name && row.contains("p50_us") && row.contains("p99_us"))
        line.points.push_back(
            {row.value("models", 0.0), row.value("p50_us", 0.0) / 1e3, row.value("p99_us", 0.0) / 1e3});
  return lines;
}

}  // namespace im2fit::lab
