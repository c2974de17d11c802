// SPDX-License-Identifier: Apache-2.0
#include "index/index.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/file.h"
#include "index/answering.h"
#include "index/format.h"

namespace im2fit::index {
namespace {

std::string describe_method(const MetaRecord& meta) {
  std::string text = "ridge";
  if (meta.quadratic != 0) text += " + quadratic";
  if (meta.local_method == static_cast<std::uint32_t>(LocalMethod::mean)) text += " + mean residual of neighbours";
  if (meta.local_method == static_cast<std::uint32_t>(LocalMethod::linear)) text += " + local linear residual";
  return text;
}

Info make_info(const Contents& c) {
  Info info;
  info.provenance.assign(c.provenance.begin(), c.provenance.end());
  info.subject_count = c.meta.entry_count;
  info.sample_count = c.meta.point_count;
  for (const GroupRecord& g : c.groups)
    info.groups.push_back(
        {std::string(g.name, strnlen(g.name, sizeof g.name)), g.first, g.count, g.weight, g.error_without});
  info.error_with_all = c.report.error_with_all;
  info.dimension_bits.assign(c.report.dimension_bits.begin(), c.report.dimension_bits.begin() + c.meta.dimensions);
  info.method = describe_method(c.meta);
  info.neighbour_count = static_cast<int>(c.meta.neighbour_count);
  info.prior_mae = c.report.prior_mae;
  info.ridge_mae = c.report.ridge_mae;
  info.nearest_mae = c.report.nearest_mae;
  info.answer_mae = c.report.answer_mae;
  info.coverage = c.report.coverage;
  info.sex_accuracy = c.report.sex_accuracy;
  return info;
}

}  // namespace

struct Index::Data {
  std::vector<std::byte> memory;  // one of the two holds the bytes
  MappedFile file;
  Contents contents;
  Info info;
  std::unique_ptr<Answerer> answerer;
};

class Index::Scratch {
 public:
  explicit Scratch(const Answerer& answerer) : work(answerer) {}
  Answerer::Workspace work;
};

Index::Index() : data_(std::make_unique<Data>()) {}
Index::Index(Index&&) noexcept = default;
Index& Index::operator=(Index&&) noexcept = default;
Index::~Index() = default;

namespace {

Status load(Index::Data& data, std::span<const std::byte> bytes, const std::string& what) {
  auto contents = parse_contents(bytes, what);
  if (!contents) return contents.error();
  data.contents = *contents;
  data.info = make_info(*contents);
  data.answerer = std::make_unique<Answerer>(*contents);
  return Ok{};
}

}  // namespace

Result<Index> Index::open(const std::string& path) {
  auto file = MappedFile::open(path);
  if (!file) return file.error();
  Index index;
  index.data_->file = std::move(*file);
  if (auto s = load(*index.data_, index.data_->file.bytes(), path); !s) return s.error();
  return index;
}

Result<Index> Index::parse(std::vector<std::byte> bytes, const std::string& what) {
  Index index;
  index.data_->memory = std::move(bytes);
  if (auto s = load(*index.data_, index.data_->memory, what); !s) return s.error();
  return index;
}

std::size_t Index::size() const {
  return data_->contents.meta.entry_count;
}
int Index::dimensions() const {
  return static_cast<int>(data_->contents.meta.dimensions);
}
std::size_t Index::feature_size() const {
  return data_->contents.meta.feature_size;
}
std::size_t Index::body_size() const {
  return data_->contents.meta.body_size;
}
const Info& Index::info() const {
  return data_->info;
}

std::unique_ptr<Index::Scratch, void (*)(Index::Scratch*)> Index::make_scratch() const {
  return {new Scratch(*data_->answerer), [](Scratch* s) { delete s; }};
}

Answer Index::query(std::span<const float> feature, const QueryOptions& options, Scratch& scratch) const {
  const Answerer& answerer = *data_->answerer;
  return answerer.answer(answerer.regressed(feature, scratch.work), options, scratch.work);
}

std::vector<float> Index::body_for(std::span<const float> feature, const QueryOptions& options,
                                   Scratch& scratch) const {
  std::vector<float> out(body_size());
  const Answerer& answerer = *data_->answerer;
  answerer.body(answerer.regressed(feature, scratch.work), options, scratch.work, out);
  return out;
}

std::vector<float> Index::body_of(std::uint32_t entry) const {
  const Contents& c = data_->contents;
  std::vector<float> out;
  if (entry >= c.meta.entry_count) return out;
  out.resize(c.meta.body_size);
  const std::int16_t* row = c.body.data() + static_cast<std::size_t>(entry) * c.meta.body_size;
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = c.body_offset[i] + c.body_scale[i] * static_cast<float>(row[i]);
  return out;
}

MeasurementValues Index::measurements_of(std::uint32_t entry) const {
  MeasurementValues out{};
  const auto row = data_->contents.entry_truth.subspan(static_cast<std::size_t>(entry) * kMeasurementCount);
  std::copy_n(row.begin(), kMeasurementCount, out.begin());
  return out;
}

}  // namespace im2fit::index
