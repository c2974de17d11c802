// SPDX-License-Identifier: Apache-2.0
#include "train/dataset/dataset_shard.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "body/params_vector.h"
#include "core/container.h"
#include "core/file.h"
#include "perception/observe/observe.h"

namespace im2fit::lab {
namespace {

constexpr char kMagic[] = "I2DS";
constexpr std::uint32_t kVersion = 9;
constexpr char kEnding[] = ".i2d";

struct Head {
  RunKey run;
  SubjectRange range;
  ChunkCounts counts;
};
static_assert(std::is_trivially_copyable_v<Head> && std::has_unique_object_representations_v<SubjectRange>);

struct Row {
  std::uint64_t subject = 0;
  std::uint16_t frame_count = 0;
  std::uint16_t back_frame_count = 0;  // 0 unless turned
  std::uint16_t flags = 0;  // 1 woman, 2 calibrate_only, 4 turned, 8 clothed, 16 again, 32 times the clothes' kind
  std::uint16_t body_values = 0;  // other than zero
  std::uint16_t distance_mm = 0;
  std::uint16_t back_distance_mm = 0;  // 0 unless turned
  std::uint32_t reserved = 0;
};
static_assert(sizeof(Row) == 24);
constexpr std::uint16_t kWoman = 1;
constexpr std::uint16_t kCalibrateOnly = 2;
constexpr std::uint16_t kTurned = 4;  // has a view from behind and fits, in the order of rows
constexpr std::uint16_t kClothed = 8;
constexpr std::uint16_t kAgain = 16;
constexpr int kClothesShift = 5;

template <class Visit>
void visit_fields(const RunKey& r, const Visit& visit) {
  visit("dataset_version", r.dataset_version);
  visit("input_key", r.input_key);
  visit("seed", r.seed);
  visit("family", std::uint64_t{r.family});
  visit("captures_per_subject", std::uint64_t{r.captures_per_subject});
  visit("frames_min", std::uint64_t{r.frames_min});
  visit("frames_max", std::uint64_t{r.frames_max});
  visit("wide_share", r.wide_share);
  visit("landscape_share", r.landscape_share);
  visit("anywhere_share", r.anywhere_share);
  visit("other_sensor_share", r.other_sensor_share);
  visit("plain", std::uint64_t{r.plain});
  visit("ood_every", std::uint64_t{r.ood_every});
  visit("feature_size", std::uint64_t{r.feature_size});
  visit("body_size", std::uint64_t{r.body_size});
  visit("turn_every", std::uint64_t{r.turn_every});
  visit("fit_shapes", std::uint64_t{r.fit.shapes});
  visit("shape_key", std::uint64_t{r.shape_key});
  visit("turn_below", std::uint64_t{r.turn_below});
  visit("clothed_every", std::uint64_t{r.clothed_every});
  visit("ood_below", std::uint64_t{r.ood_below});
  visit("fit_patches", std::uint64_t{r.fit.patches});
  visit("fit_limbs", std::uint64_t{r.fit.limbs});
  visit("again_below", std::uint64_t{r.again_below});
}

std::string text_of(const std::string& name, std::uint64_t value) {
  char text[24];
  std::snprintf(text, sizeof text, name == "input_key" ? "%016llx" : "%llu", static_cast<unsigned long long>(value));
  return name + " " + text;
}
std::string text_of(const std::string& name, double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return name + " " + text;
}

std::vector<std::string> lines_of(const RunKey& run) {
  std::vector<std::string> lines;
  visit_fields(run, [&](const char* name, auto value) { lines.push_back(text_of(name, value)); });
  return lines;
}

std::string words(const SubjectRange& range) {
  return "subjects " + std::to_string(range.first) + " to " + std::to_string(range.end() - 1);
}

Error wrong(const std::string& path, const std::string& why) {
  return {ErrorCode::invalid_argument, path + ": " + why};
}
Error damaged(const std::string& path, const std::string& why) {
  return {ErrorCode::corrupt, path + ": " + why + "; delete it and make it again with im2fit-lab dataset"};
}

struct OpenShard {
  MappedFile file;
  ContainerReader container;
  Head head;
};

Result<OpenShard> open_shard(const std::string& path, bool check_sections) {
  auto file = MappedFile::open(path);
  if (!file) return file.error();
  auto container = ContainerReader::parse(file->bytes(), kMagic, kVersion, path, check_sections);
  if (!container) return container.error();
  const auto head = container->array<Head>("head", 1);
  if (!head) return head.error();
  return OpenShard{std::move(*file), std::move(*container), (*head)[0]};
}

}  // namespace

std::uint64_t RunKey::hash() const {
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a over words
  visit_fields(*this, [&](const char*, auto value) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3ULL;
    hash ^= hash >> 29;
  });
  return hash;
}

std::string RunKey::text() const {
  std::string text;
  for (const std::string& line : lines_of(*this)) text += line + "\n";
  return text;
}

std::string RunKey::difference(const RunKey& other) const {
  const auto mine = lines_of(*this), theirs = lines_of(other);
  for (std::size_t i = 0; i < mine.size(); ++i)
    if (mine[i] != theirs[i]) return mine[i] + ", not " + theirs[i].substr(theirs[i].find(' ') + 1);
  return {};
}

void fit_to_shard(index::Sample& sample) {
  for (std::vector<float>* feature : {&sample.feature, &sample.back})
    for (std::size_t i = 0; i < feature->size(); ++i) {
      const int exponent = feature_exponent(i);
      float& value = (*feature)[i];
      const float rounded = std::ldexp(float_of(half_of(std::ldexp(value, -exponent))), exponent);
      if (std::isfinite(rounded) || !std::isfinite(value)) value = rounded;  // else write_shard() reports it
    }
}

int feature_exponent(std::size_t feature) {
  constexpr std::size_t kArea = kPaperFeatureSize + ProfileLayout::kSceneValues + 1;
  return feature == kArea ? 10 : 0;
}

std::string shard_name(const RunKey& run, const SubjectRange& range) {
  char name[80];
  std::snprintf(name, sizeof name, "samples-%08llx-%012llu-%llu%s", static_cast<unsigned long long>(run.hash() >> 32),
                static_cast<unsigned long long>(range.first), static_cast<unsigned long long>(range.count), kEnding);
  return name;
}

Status write_shard(const std::string& path, const RunKey& run, const SubjectRange& range, const Chunk& chunk) {
  Head head{run, range, chunk.counts};
  std::vector<std::int8_t> exponents;
  for (std::size_t i = 0; i < run.feature_size; ++i)
    exponents.push_back(static_cast<std::int8_t>(feature_exponent(i)));
  std::vector<Row> rows;
  std::vector<std::uint16_t> features, backs, body_columns;
  std::vector<float> body_values, truths, fits;
  features.reserve(chunk.samples.size() * run.feature_size);
  for (const index::Sample& s : chunk.samples) {
    if (s.feature.size() != run.feature_size || s.body.size() != run.body_size)
      return wrong(path, "a sample is not of the run's sizes");
    Row row;
    row.subject = s.subject;
    row.frame_count = static_cast<std::uint16_t>(s.frame_count);
    row.back_frame_count = static_cast<std::uint16_t>(s.back_frame_count);
    row.distance_mm = static_cast<std::uint16_t>(s.distance_mm);
    row.back_distance_mm = static_cast<std::uint16_t>(s.back_distance_mm);
    row.flags = static_cast<std::uint16_t>((s.woman ? kWoman : 0) | (s.calibrate_only ? kCalibrateOnly : 0) |
                                           (s.refines() ? kTurned : 0) | (s.clothed ? kClothed : 0) |
                                           (s.again ? kAgain : 0) | s.clothes_kind << kClothesShift);
    if (s.refines() &&
        (s.fit.size() != run.fit.size() || s.fit_both.size() != run.fit.size() || s.back.size() != run.feature_size))
      return wrong(path, "a sample's view from behind is not of the run's sizes");
    for (std::size_t i = 0; i < s.body.size(); ++i) {
      if (std::bit_cast<std::uint32_t>(s.body[i]) == 0) continue;
      body_columns.push_back(static_cast<std::uint16_t>(i));
      body_values.push_back(s.body[i]);
      ++row.body_values;
    }
    rows.push_back(row);
    for (const auto& [feature, half_floats] : {std::pair(&s.feature, &features), std::pair(&s.back, &backs)})
      for (std::size_t i = 0; i < feature->size(); ++i) {
        const float value = (*feature)[i];
        half_floats->push_back(half_of(std::ldexp(value, -exponents[i])));
        if (std::isfinite(value) && !std::isfinite(float_of(half_floats->back())))
          return wrong(path, "feature " + std::to_string(i) + " is " + std::to_string(value) +
                                 ", beyond half precision; give it a feature_exponent");
      }
    fits.insert(fits.end(), s.fit.begin(), s.fit.end());
    fits.insert(fits.end(), s.fit_both.begin(), s.fit_both.end());
    truths.insert(truths.end(), s.truth.begin(), s.truth.end());
  }
  const std::string about = "im2fit dataset shard\n" + words(range) + "\n" + run.text();
  ContainerWriter out(kMagic, kVersion);
  out.add_array("about", std::span<const char>(about));
  out.add_array("head", std::span<const Head>(&head, 1));
  out.add_array("rows", std::span<const Row>(rows));
  out.add_array("exponents", std::span<const std::int8_t>(exponents));
  out.add_array("features", std::span<const std::uint16_t>(features));
  out.add_array("truths", std::span<const float>(truths));
  out.add_array("backs", std::span<const std::uint16_t>(backs));
  out.add_array("fits", std::span<const float>(fits));
  out.add_array("body_columns", std::span<const std::uint16_t>(body_columns));
  out.add_array("body_values", std::span<const float>(body_values));
  return write_file_atomically(path, out.finish());
}

Result<Chunk> read_shard(const std::string& path, const RunKey& run, const SubjectRange& range) {
  const auto shard = open_shard(path, true);
  if (!shard) return shard.error();
  if (!(shard->head.run == run))
    return wrong(path, "of another run: " + shard->head.run.difference(run) +
                           "; make the samples again with im2fit-lab dataset");
  if (!(shard->head.range == range))
    return wrong(path, "holds " + words(shard->head.range) + ", not " + words(range));
  const auto& sections = shard->container;
  const auto rows = sections.array<Row>("rows");
  if (!rows) return rows.error();
  const std::size_t n = rows->size();
  const auto features = sections.array<std::uint16_t>("features", n * run.feature_size);
  if (!features) return features.error();
  const auto exponents = sections.array<std::int8_t>("exponents", run.feature_size);
  if (!exponents) return exponents.error();
  const auto truths = sections.array<float>("truths", n * kMeasurementCount);
  if (!truths) return truths.error();
  const auto turned = static_cast<std::size_t>(
      std::count_if(rows->begin(), rows->end(), [](const Row& row) { return (row.flags & kTurned) != 0; }));
  const auto backs = sections.array<std::uint16_t>("backs", turned * run.feature_size);
  if (!backs) return backs.error();
  const std::size_t fit_size = run.fit.size();
  const auto fits = sections.array<float>("fits", turned * 2 * fit_size);
  if (!fits) return fits.error();
  const auto columns = sections.array<std::uint16_t>("body_columns");
  if (!columns) return columns.error();
  const auto values = sections.array<float>("body_values", columns->size());
  if (!values) return values.error();

  Chunk chunk;
  chunk.counts = shard->head.counts;
  if (n != static_cast<std::size_t>(std::max(0, chunk.counts.samples)))
    return damaged(path, "another number of rows than its head states");
  std::size_t at = 0, turn = 0;
  const auto read_feature = [&](std::span<const std::uint16_t> all, std::size_t which, std::vector<float>& out) {
    const auto half_floats = all.subspan(which * run.feature_size, run.feature_size);
    out.reserve(half_floats.size());
    for (std::size_t f = 0; f < half_floats.size(); ++f)
      out.push_back(std::ldexp(float_of(half_floats[f]), (*exponents)[f]));
  };
  for (std::size_t i = 0; i < n; ++i) {
    const Row& row = (*rows)[i];
    if (row.subject < range.first || row.subject >= range.end()) return damaged(path, "a subject out of its range");
    if (row.reserved != 0 || row.flags >= index::kClothesKindMax << kClothesShift)
      return damaged(path, "a row with unknown flags");
    if (columns->size() - at < row.body_values) return damaged(path, "bodies cut short");
    index::Sample s;
    s.subject = row.subject;
    s.frame_count = row.frame_count;
    s.back_frame_count = row.back_frame_count;
    s.distance_mm = row.distance_mm;
    s.back_distance_mm = row.back_distance_mm;
    s.woman = (row.flags & kWoman) != 0;
    s.calibrate_only = (row.flags & kCalibrateOnly) != 0;
    s.clothed = (row.flags & kClothed) != 0;
    s.again = (row.flags & kAgain) != 0;
    s.clothes_kind = static_cast<std::uint8_t>(row.flags >> kClothesShift);
    read_feature(*features, i, s.feature);
    if ((row.flags & kTurned) != 0) {
      read_feature(*backs, turn, s.back);
      s.fit_layout = run.fit;
      const auto both = fits->subspan(2 * turn++ * fit_size, 2 * fit_size);
      s.fit.assign(both.begin(), both.begin() + static_cast<std::ptrdiff_t>(fit_size));
      s.fit_both.assign(both.begin() + static_cast<std::ptrdiff_t>(fit_size), both.end());
    }
    std::copy_n(truths->begin() + static_cast<std::ptrdiff_t>(i * kMeasurementCount), kMeasurementCount,
                s.truth.begin());
    s.body.assign(run.body_size, 0.0F);
    for (const std::size_t end = at + row.body_values; at < end; ++at) {
      if ((*columns)[at] >= run.body_size) return damaged(path, "a body value out of its row");
      s.body[(*columns)[at]] = (*values)[at];
    }
    s.age_years = s.body.size() > body::kAgeParam ? s.body[body::kAgeParam] : 0;
    chunk.samples.push_back(std::move(s));
  }
  return chunk;
}

Result<ShardAbout> about_shard(const std::string& path) {
  const auto shard = open_shard(path, false);
  if (!shard) return shard.error();
  if (shard->head.range.count == 0) return damaged(path, "holds no subjects");
  return ShardAbout{path, shard->head.run, shard->head.range, shard->head.counts};
}

Result<ShardSet> ShardSet::find(std::span<const std::string> folders) {
  ShardSet set;
  std::string names;
  for (const std::string& folder : folders) {
    names += (names.empty() ? "" : ", ") + folder;
    std::error_code code;
    for (std::filesystem::directory_iterator it(folder, code), end; !code && it != end; it.increment(code)) {
      if (it->path().extension() != kEnding) continue;
      auto about = about_shard(it->path().string());
      if (!about) return about.error();
      set.shards_.push_back(std::move(*about));
    }
    if (code) return Error{ErrorCode::io, folder + ": " + code.message()};
  }
  if (set.shards_.empty())
    return Error{ErrorCode::not_found, names + ": no shards (*.i2d); make some with im2fit-lab dataset"};
  std::sort(set.shards_.begin(), set.shards_.end(), [](const ShardAbout& a, const ShardAbout& b) {
    return a.range.first != b.range.first ? a.range.first < b.range.first : a.path < b.path;
  });
  for (std::size_t i = 1; i < set.shards_.size(); ++i) {
    const ShardAbout& before = set.shards_[i - 1];
    const ShardAbout& shard = set.shards_[i];
    if (!(shard.run == set.run()))
      return wrong(shard.path, "of another run than " + set.shards_[0].path + ": " + shard.run.difference(set.run()) +
                                   "; keep runs in folders of their own");
    if (shard.range.first < before.range.end())
      return wrong(shard.path, words(shard.range) + ", but " + before.path + " has " + words(before.range) +
                                   "; delete one of them");
    if (shard.range.first > before.range.end())
      return Error{ErrorCode::not_found, names + ": " +
                                             words({before.range.end(), shard.range.first - before.range.end()}) +
                                             " are missing; run im2fit-lab dataset again with the same options"};
  }
  return set;
}

SubjectRange ShardSet::range() const {
  return {shards_.front().range.first, shards_.back().range.end() - shards_.front().range.first};
}

Status ShardSet::expect(const SubjectRange& wanted) const {
  const SubjectRange found = range();
  if (found == wanted) return Ok{};
  return Error{ErrorCode::not_found, std::filesystem::path(shards_.front().path).parent_path().string() +
                                         ": shards of " + words(found) + ", expected " + words(wanted) +
                                         "; run im2fit-lab dataset again with the same options, all shards"};
}

Status ShardSet::read(const std::function<bool(const index::Sample&)>& take) const {
  for (const ShardAbout& shard : shards_) {
    const auto chunk = read_shard(shard.path, shard.run, shard.range);
    if (!chunk) return chunk.error();
    for (const index::Sample& s : chunk->samples)
      if (!take(s)) return Ok{};
  }
  return Ok{};
}

}  // namespace im2fit::lab
