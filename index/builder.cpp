// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numeric>

#include "base/container.h"
#include "base/rng.h"
#include "index/answering.h"
#include "index/calibration.h"
#include "index/format.h"
#include "index/index.h"
#include "index/ridge.h"
#include "index/tuner.h"

namespace im2fit::index {
namespace {

constexpr std::size_t kSubjectMin = 20;
constexpr std::size_t kStrangersMin = 200;  // fewer say too little about 2.5 % quantiles
constexpr std::size_t kBlockSamples = 1024;
constexpr double kVarianceMin = 1e-10;  // relative to the mean's square: below it a feature is a constant
constexpr int kLatentMax = kTargetMax - kTargetMin;
constexpr double kLatentExplained = 0.1;  // a latent whose regression explains less than this is dropped

Error invalid(const std::string& why) {
  return {ErrorCode::invalid_argument, "index: " + why};
}

template <class T>
std::span<const T> view(const std::vector<T>& v) {
  return v;
}

}  // namespace

std::vector<FeatureGroup> default_groups(std::size_t feature_size) {
  const auto size = static_cast<std::uint32_t>(feature_size);
  if (size < 501) return {{"all", size}};
  std::vector<FeatureGroup> groups = {{"lengths", 4}, {"ratios", 2}, {"fpfh", 495}};
  if (size > 501) groups.push_back({"profile", size - 501});
  return groups;
}

struct IndexBuilder::Impl {
  BuildOptions options;
  std::string complaint;  // of the first bad sample
  std::size_t feature_size = 0;
  std::size_t body_size = 0;
  std::vector<std::vector<float>> blocks;  // kBlockSamples features each: no second copy while growing
  std::size_t sample_count = 0;
  std::map<std::uint64_t, std::uint32_t> subject_index;
  std::vector<std::uint32_t> subject;    // of each sample
  std::vector<MeasurementValues> truth;  // of each subject, as all below
  std::vector<bool> woman;
  std::vector<float> body;

  std::vector<Sample> strangers;  // calibrate_only

  std::vector<FeatureGroup> groups;
  std::vector<float> feature_mean;
  std::vector<float> feature_scale;
  TrainingRows rows;
  Eigen::MatrixXd entry_targets;
  std::vector<double> target_mean;
  std::vector<double> target_scale;
  RidgeTrainer::Choice choice;

  const float* features_of(std::size_t sample) const {
    return blocks[sample / kBlockSamples].data() + sample % kBlockSamples * feature_size;
  }
  Status check() const;
  void standardise_features();
  void make_targets();
  Eigen::MatrixXd body_latents(const Eigen::MatrixXd& targets) const;
  void make_folds();
  std::vector<std::ptrdiff_t> drop_weak_latents(Eigen::MatrixXd& regressed);
  ReportRecord make_report(const Tuner& tuner, const Eigen::MatrixXd& regressed,
                           const IntervalModel& intervals) const;
  std::vector<GroupRecord> group_records() const;
  void add_body(ContainerWriter& out) const;
  std::vector<HeldOut> answer_strangers(std::span<const std::byte> file) const;
  std::vector<std::byte> write(const Tuner& tuner, const RidgeFit& fit, const IntervalModel& intervals,
                               const ReportRecord& report) const;
};

IndexBuilder::IndexBuilder(const BuildOptions& options) : impl_(std::make_unique<Impl>()) {
  impl_->options = options;
}
IndexBuilder::~IndexBuilder() = default;
std::size_t IndexBuilder::sample_count() const {
  return impl_->sample_count;
}

void IndexBuilder::add(const Sample& sample) {
  Impl& d = *impl_;
  if (!d.complaint.empty()) return;
  if (d.sample_count == 0 && d.strangers.empty()) {
    d.feature_size = sample.feature.size();
    d.body_size = sample.body.size();
  }
  const std::string which = "sample " + std::to_string(d.sample_count);
  if (sample.feature.size() != d.feature_size || sample.body.size() != d.body_size) {
    d.complaint = which + " has " + std::to_string(sample.feature.size()) + " features and " +
                  std::to_string(sample.body.size()) + " body parameters, the first had " +
                  std::to_string(d.feature_size) + " and " + std::to_string(d.body_size);
    return;
  }
  const auto finite = [](float v) { return std::isfinite(v); };
  if (!std::all_of(sample.truth.begin(), sample.truth.end(), finite) ||
      !std::all_of(sample.body.begin(), sample.body.end(), finite)) {
    d.complaint = which + " has a truth or body parameter that is not finite";
    return;
  }
  if (sample.calibrate_only) {
    d.strangers.push_back(sample);
    return;
  }
  const auto [it, fresh] = d.subject_index.emplace(sample.subject, static_cast<std::uint32_t>(d.truth.size()));
  if (fresh) {
    d.truth.push_back(sample.truth);
    d.woman.push_back(sample.woman);
    d.body.insert(d.body.end(), sample.body.begin(), sample.body.end());
  }
  if (d.sample_count % kBlockSamples == 0) d.blocks.emplace_back().reserve(kBlockSamples * d.feature_size);
  d.blocks.back().insert(d.blocks.back().end(), sample.feature.begin(), sample.feature.end());
  d.subject.push_back(it->second);
  d.rows.frame_count.push_back(std::max(sample.frame_count, 1));
  ++d.sample_count;
}

Status IndexBuilder::Impl::check() const {
  if (!complaint.empty()) return invalid(complaint);
  if (sample_count == 0) return invalid("no samples; render a dataset first");
  if (truth.size() < kSubjectMin)
    return invalid("only " + std::to_string(truth.size()) + " subjects; at least " + std::to_string(kSubjectMin) +
                   " are needed to hold some out, and thousands for useful answers");
  if (feature_size == 0 || feature_size > kFeatureMax)
    return invalid("features have " + std::to_string(feature_size) + " values, expected 1 to " +
                   std::to_string(kFeatureMax));
  if (body_size > kBodyMax)
    return invalid("bodies have " + std::to_string(body_size) + " parameters, at most " + std::to_string(kBodyMax));
  if (sample_count > kEntryMax) return invalid("more than " + std::to_string(kEntryMax) + " samples");
  if (options.dimensions < 0 || options.dimensions > kDimensionMax)
    return invalid("dimensions is " + std::to_string(options.dimensions) + ", expected 0 (chosen) to " +
                   std::to_string(kDimensionMax));
  if (!(options.held_out_fraction >= 0.05 && options.held_out_fraction <= 0.5))
    return invalid("held_out_fraction must be within 0.05 .. 0.5");
  if (options.provenance.size() > kProvenanceMax) return invalid("provenance is longer than 64 KiB");
  std::size_t covered = 0;
  for (const auto& g : groups) covered += g.count;
  if (covered != feature_size || groups.size() > kGroupMax)
    return invalid("the feature groups cover " + std::to_string(covered) + " values in " +
                   std::to_string(groups.size()) + " groups, the feature has " + std::to_string(feature_size) +
                   " and at most 16 groups");
  return Ok{};
}

// Mean and spread of what was measured; what was not becomes the mean.
void IndexBuilder::Impl::standardise_features() {
  std::vector<double> count(feature_size), sum(feature_size), square(feature_size);
  for (std::size_t s = 0; s < sample_count; ++s) {
    const float* x = features_of(s);
    for (std::size_t i = 0; i < feature_size; ++i)
      if (std::isfinite(x[i])) {
        count[i] += 1;
        sum[i] += static_cast<double>(x[i]);
      }
  }
  feature_mean.assign(feature_size, 0);
  for (std::size_t i = 0; i < feature_size; ++i)
    if (count[i] > 0) feature_mean[i] = static_cast<float>(std::clamp(sum[i] / count[i], -1e9, 1e9));
  for (std::size_t s = 0; s < sample_count; ++s) {
    const float* x = features_of(s);
    for (std::size_t i = 0; i < feature_size; ++i)
      if (std::isfinite(x[i])) {
        const double d = static_cast<double>(x[i]) - static_cast<double>(feature_mean[i]);
        square[i] += d * d;
      }
  }
  feature_scale.assign(feature_size, 0);
  for (std::size_t i = 0; i < feature_size; ++i) {
    if (count[i] < 2) continue;
    const double variance = square[i] / count[i];
    const auto mean = static_cast<double>(feature_mean[i]);
    if (variance > kVarianceMin * (mean * mean + 1e-8))
      feature_scale[i] = static_cast<float>(1 / std::sqrt(variance));
    if (!(feature_scale[i] < 1e9F)) feature_scale[i] = 0;
  }
  rows.features.resize(static_cast<std::ptrdiff_t>(sample_count), static_cast<std::ptrdiff_t>(feature_size));
  for (std::size_t s = 0; s < sample_count; ++s) {
    standardise({features_of(s), feature_size}, feature_mean, feature_scale,
                {rows.features.data() + s * feature_size, feature_size});
    if ((s + 1) % kBlockSamples == 0) std::vector<float>().swap(blocks[s / kBlockSamples]);
  }
  blocks.clear();
}

// Directions of the body that measurements and sex leave open, strongest first, unit variance.
Eigen::MatrixXd IndexBuilder::Impl::body_latents(const Eigen::MatrixXd& targets) const {
  const auto n = targets.rows();
  const auto b = static_cast<std::ptrdiff_t>(body_size);
  if (b == 0 || n < 200) return Eigen::MatrixXd(n, 0);
  Eigen::MatrixXd x(n, b);
  for (std::ptrdiff_t i = 0; i < n; ++i)
    for (std::ptrdiff_t j = 0; j < b; ++j) x(i, j) = static_cast<double>(body[static_cast<std::size_t>(i * b + j)]);
  x.rowwise() -= x.colwise().mean().eval();
  for (std::ptrdiff_t j = 0; j < b; ++j) {
    const double sd = std::sqrt(x.col(j).squaredNorm() / static_cast<double>(n));
    x.col(j) *= sd > 1e-6 ? 1 / sd : 0.0;
  }
  Eigen::MatrixXd a = targets.transpose() * targets;
  a.diagonal().array() += 1e-3 * static_cast<double>(n);
  x -= targets * a.llt().solve(targets.transpose() * x);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(x.transpose() * x / static_cast<double>(n));
  const std::ptrdiff_t count = std::min<std::ptrdiff_t>(b, kLatentMax);
  Eigen::MatrixXd out(n, count);
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    // The sign of an eigenvector is the solver's whim: fix it by the largest coefficient.
    Eigen::VectorXd v = eigen.eigenvectors().col(b - 1 - k);
    std::ptrdiff_t largest = 0;
    v.cwiseAbs().maxCoeff(&largest);
    if (v(largest) < 0) v = -v;
    out.col(k) = x * v / std::sqrt(std::max(eigen.eigenvalues()(b - 1 - k), 1e-12));
  }
  return out;
}

void IndexBuilder::Impl::make_targets() {
  const auto n = static_cast<std::ptrdiff_t>(truth.size());
  Eigen::MatrixXd y(n, kTargetMin);
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const auto s = static_cast<std::size_t>(i);
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      y(i, static_cast<std::ptrdiff_t>(m)) = static_cast<double>(truth[s][m]);
    y(i, kSexTarget) = woman[s] ? 1 : -1;
  }
  for (int t = 0; t < kTargetMin; ++t) {
    const double mean = y.col(t).mean();
    y.col(t).array() -= mean;
    const double sd = std::sqrt(y.col(t).squaredNorm() / static_cast<double>(n));
    const double scale = sd > 1e-6 * (std::abs(mean) + 1e-3) ? sd : 0.0;
    if (scale > 0)
      y.col(t) /= scale;
    else
      y.col(t).setZero();
    target_mean.push_back(mean);
    target_scale.push_back(scale);
  }
  const Eigen::MatrixXd latents = body_latents(y);
  entry_targets.resize(n, kTargetMin + latents.cols());
  entry_targets << y, latents;
  for (std::ptrdiff_t k = 0; k < latents.cols(); ++k) {
    target_mean.push_back(0);
    target_scale.push_back(1);
  }
  rows.targets.resize(static_cast<std::ptrdiff_t>(sample_count), entry_targets.cols());
  for (std::size_t s = 0; s < sample_count; ++s)
    rows.targets.row(static_cast<std::ptrdiff_t>(s)) = entry_targets.row(subject[s]);
}

// Whole subjects go to a fold, in an order drawn from the seed, so that the folds are equally large.
void IndexBuilder::Impl::make_folds() {
  rows.subject = subject;
  rows.fold_count = std::clamp(static_cast<int>(std::lround(1 / options.held_out_fraction)), 2, 10);
  std::vector<std::uint32_t> order(truth.size());
  std::iota(order.begin(), order.end(), 0U);
  Rng rng = Rng::for_item(options.seed, 0x1dec5, 0);
  for (std::size_t i = order.size() - 1; i > 0; --i)
    std::swap(order[i], order[static_cast<std::size_t>(rng.index(static_cast<int>(i + 1)))]);
  std::vector<int> fold_of(truth.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    fold_of[order[i]] = static_cast<int>(i % static_cast<std::size_t>(rows.fold_count));
  rows.fold.clear();
  for (const std::uint32_t s : subject) rows.fold.push_back(fold_of[s]);
}

// A latent the features do not show would only blur the metric. Returns the targets kept.
std::vector<std::ptrdiff_t> IndexBuilder::Impl::drop_weak_latents(Eigen::MatrixXd& regressed) {
  std::vector<std::ptrdiff_t> kept;
  for (std::ptrdiff_t t = 0; t < rows.targets.cols(); ++t) {
    const double error = (rows.targets.col(t) - regressed.col(t)).squaredNorm();
    if (t < kTargetMin || error < (1 - kLatentExplained) * rows.targets.col(t).squaredNorm()) kept.push_back(t);
  }
  const auto keep = [&](Eigen::MatrixXd& m) {
    Eigen::MatrixXd out(m.rows(), static_cast<std::ptrdiff_t>(kept.size()));
    for (std::size_t k = 0; k < kept.size(); ++k) out.col(static_cast<std::ptrdiff_t>(k)) = m.col(kept[k]);
    m = out;
  };
  keep(rows.targets);
  keep(entry_targets);
  keep(regressed);
  target_mean.resize(kept.size());  // latents all have mean 0 and scale 1
  target_scale.resize(kept.size());
  return kept;
}

ReportRecord IndexBuilder::Impl::make_report(const Tuner& tuner, const Eigen::MatrixXd& regressed,
                                             const IntervalModel& intervals) const {
  ReportRecord report;
  report.dimension_bits = tuner.dimension_bits;
  for (std::size_t d = tuner.meta.dimensions; d < report.dimension_bits.size(); ++d) report.dimension_bits[d] = 0;
  report.error_with_all = static_cast<float>(choice.error);
  report.coverage = intervals.coverage;
  const auto n = static_cast<double>(tuner.held_out.size());
  double right = 0;
  std::array<double, kMeasurementCount> answer{}, prior{};
  for (const HeldOut& row : tuner.held_out) {
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      answer[m] += std::abs(row.answer[m] - row.truth[m]) / n;
      prior[m] += std::abs(row.truth[m]) / n;
    }
    const double mean = target_mean[kSexTarget];
    const double scale = target_scale[kSexTarget];
    right += (mean + scale * row.answer[kSexTarget] > 0) == (mean + scale * row.truth[kSexTarget] > 0) ? 1 / n : 0;
  }
  report.sex_accuracy = static_cast<float>(right);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const auto t = static_cast<std::ptrdiff_t>(m);
    report.answer_mae[m] = static_cast<float>(target_scale[m] * answer[m]);
    report.prior_mae[m] = static_cast<float>(target_scale[m] * prior[m]);
    report.nearest_mae[m] = static_cast<float>(target_scale[m] * static_cast<double>(tuner.nearest_error[m]));
    report.ridge_mae[m] =
        static_cast<float>(target_scale[m] * (rows.targets.col(t) - regressed.col(t)).cwiseAbs().mean());
  }
  return report;
}

std::vector<GroupRecord> IndexBuilder::Impl::group_records() const {
  double lightest = choice.penalty.group[0];
  for (const double p : choice.penalty.group) lightest = std::min(lightest, p);
  std::vector<GroupRecord> out;
  std::uint32_t first = 0;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    GroupRecord record;
    groups[g].name.copy(record.name, sizeof record.name - 1);
    record.first = first;
    record.count = groups[g].count;
    // Scaling a group by w is the same as dividing its penalty by w^2.
    const double weight = std::sqrt(lightest / choice.penalty.group[g]);
    record.weight = static_cast<float>(choice.penalty.group[g] > 1e6 ? 0 : weight);
    record.error_without = static_cast<float>(choice.error_without[g]);
    out.push_back(record);
    first += groups[g].count;
  }
  return out;
}

void IndexBuilder::Impl::add_body(ContainerWriter& out) const {
  std::vector<float> offset(body_size), scale(body_size);
  std::vector<std::int16_t> values(body.size());
  const std::size_t n = truth.size();
  for (std::size_t j = 0; j < body_size; ++j) {
    float low = std::numeric_limits<float>::max();
    float high = std::numeric_limits<float>::lowest();
    for (std::size_t i = 0; i < n; ++i) {
      low = std::min(low, body[i * body_size + j]);
      high = std::max(high, body[i * body_size + j]);
    }
    const double middle = 0.5 * (static_cast<double>(low) + static_cast<double>(high));
    const double unit = std::max((static_cast<double>(high) - static_cast<double>(low)) / 65534, 1e-30);
    offset[j] = static_cast<float>(middle);
    scale[j] = static_cast<float>(unit);
    for (std::size_t i = 0; i < n; ++i) {
      const double q = (static_cast<double>(body[i * body_size + j]) - middle) / unit;
      values[i * body_size + j] = static_cast<std::int16_t>(std::lround(std::clamp(q, -32767.0, 32767.0)));
    }
  }
  out.add_array("body", view(values));
  out.add_array("body.offset", view(offset));
  out.add_array("body.scale", view(scale));
}

std::vector<std::byte> IndexBuilder::Impl::write(const Tuner& tuner, const RidgeFit& fit,
                                                 const IntervalModel& intervals, const ReportRecord& report) const {
  const auto targets = static_cast<std::size_t>(entry_targets.cols());
  MetaRecord meta = tuner.meta;
  meta.feature_size = static_cast<std::uint32_t>(feature_size);
  meta.target_count = static_cast<std::uint32_t>(targets);
  meta.entry_count = static_cast<std::uint32_t>(truth.size());
  meta.point_count = static_cast<std::uint32_t>(sample_count);
  meta.body_size = static_cast<std::uint32_t>(body_size);
  meta.group_count = static_cast<std::uint32_t>(groups.size());
  meta.interval_kind = static_cast<std::uint32_t>(intervals.kind);
  meta.frame_model = intervals.frame_model;
  meta.frame_noise = intervals.frame_noise;
  const std::vector<float> mean(target_mean.begin(), target_mean.end());
  const std::vector<float> scale(target_scale.begin(), target_scale.end());
  const auto ridge_size = targets * feature_size;

  ContainerWriter out(kMagic, kVersion);
  out.add_array("meta", std::span<const MetaRecord>(&meta, 1));
  out.add_array("report", std::span<const ReportRecord>(&report, 1));
  out.add_array("groups", view(group_records()));
  out.add_array("provenance", std::span<const char>(options.provenance));
  out.add_array("feature.mean", view(feature_mean));
  out.add_array("feature.scale", view(feature_scale));
  out.add_array("ridge", std::span<const float>(fit.weights.data(), ridge_size));
  out.add_array("ridge.bias", std::span<const float>(fit.bias.data(), targets));
  out.add_array("target.mean", view(mean));
  out.add_array("target.scale", view(scale));
  out.add_array("projection", view(tuner.projection));
  out.add_array("code.step", std::span<const std::int32_t>(tuner.steps));
  out.add_array("code.spread", view(tuner.inverse_spread));
  out.add_array("quadratic", view(tuner.quadratic));
  out.add_array("point.code", view(tuner.point_code));
  out.add_array("point.residual", view(tuner.point_residual));
  out.add_array("residual.scale", view(tuner.residual_scale));
  out.add_array("entry.code", view(tuner.entry_code));
  out.add_array("entry.truth", std::span<const float>(truth.front().data(), truth.size() * kMeasurementCount));
  add_body(out);
  out.add_array("interval", std::span<const float>(intervals.quantiles));
  out.add_array("spread.floor", std::span<const float>(intervals.spread_floor));
  out.add_array("sex.table", view(calibrate_sex(tuner.held_out, target_mean[kSexTarget], target_scale[kSexTarget])));
  return out.finish();
}

// The finished index, asked about people it was not made for.
std::vector<HeldOut> IndexBuilder::Impl::answer_strangers(std::span<const std::byte> file) const {
  std::vector<HeldOut> out;
  const auto contents = parse_contents(file, "index");
  if (!contents) return out;
  const Answerer answerer(*contents);
  Answerer::Workspace work(answerer);
  for (const Sample& s : strangers) {
    HeldOut row;
    row.subject = static_cast<std::uint32_t>(s.subject);
    row.frame_count = s.frame_count;
    row.answer = answerer.corrected(answerer.regressed(s.feature, work), {}, work, row.spread);
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      row.truth[m] = target_scale[m] > 0 ? (static_cast<double>(s.truth[m]) - target_mean[m]) / target_scale[m] : 0;
    out.push_back(row);
  }
  return out;
}

Result<std::vector<std::byte>> IndexBuilder::finish() {
  Impl& d = *impl_;
  d.groups = d.options.groups.empty() ? default_groups(d.feature_size) : d.options.groups;
  if (auto s = d.check(); !s) return s.error();
  d.standardise_features();
  d.make_targets();
  d.make_folds();
  std::vector<std::uint32_t> group_sizes;
  for (const auto& g : d.groups) group_sizes.push_back(g.count);
  RidgeTrainer trainer(d.rows, group_sizes);
  d.choice = trainer.choose(kTargetMin);
  Eigen::MatrixXd regressed = trainer.cross_fitted(d.choice.penalty);
  const auto kept = d.drop_weak_latents(regressed);
  const RidgeFit fit = trainer.fit(d.choice.penalty, -1).of_targets(kept);

  Tuner tuner(d.rows, regressed, d.entry_targets);
  tuner.run(d.options.dimensions);
  IntervalModel intervals = calibrate_intervals(tuner.held_out);
  const auto finished = [&] { return d.write(tuner, fit, intervals, d.make_report(tuner, regressed, intervals)); };
  std::vector<std::byte> file = finished();
  if (d.strangers.size() < kStrangersMin) return file;
  const std::vector<HeldOut> strangers = d.answer_strangers(file);
  if (strangers.empty()) return invalid("the new index cannot be read back");
  intervals = calibrate_intervals(strangers);
  return finished();
}

}  // namespace im2fit::index
