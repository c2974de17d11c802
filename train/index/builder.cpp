// SPDX-License-Identifier: Apache-2.0
#include "train/index/builder.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/container.h"
#include "index/answering.h"
#include "index/format.h"
#include "train/index/calibration.h"
#include "train/index/densify.h"
#include "train/index/encoder.h"
#include "train/index/learning.h"
#include "train/index/refinement_builder.h"
#include "train/index/ridge.h"
#include "train/index/tree_packing.h"
#include "train/index/tuner.h"

namespace im2fit::index {
namespace {

constexpr std::size_t kSubjectMin = 20;
constexpr std::size_t kOodMax = 8192;
constexpr std::ptrdiff_t kBlockRows = 512;
constexpr double kLatentExplained = 0.1;  // a latent whose regression explains less than this is dropped

Error invalid(const std::string& why) {
  return {ErrorCode::invalid_argument, "index: " + why};
}

template <class T>
std::span<const T> view(const std::vector<T>& v) {
  return v;
}

Status check_options(const BuildOptions& o) {
  if (o.dimensions < 0 || o.dimensions > kDimensionMax)
    return invalid("dimensions is " + std::to_string(o.dimensions) + ", expected 0 (chosen) to " +
                   std::to_string(kDimensionMax));
  if (!(o.held_out_fraction >= 0.05 && o.held_out_fraction <= 0.5))
    return invalid("held_out_fraction must be within 0.05 .. 0.5");
  if (o.provenance.size() > kProvenanceMax) return invalid("provenance is longer than 64 KiB");
  if (o.chosen_on < kSubjectMin) return invalid("chosen_on must be at least " + std::to_string(kSubjectMin));
  if (o.densify_to > kEntryMax) return invalid("densify_to is more than " + std::to_string(kEntryMax));
  return Ok{};
}

class Builder {
 public:
  Builder(const BuildOptions& options, const SampleSource& source) : options_(options), source_(source) {}
  Result<std::vector<std::byte>> run();

 private:
  Status check_sample(const Sample& sample, std::size_t number) const;
  Status check_set() const;
  Status read_chosen();
  Status read_moments();
  Status read_entries();
  void regress();
  std::vector<std::ptrdiff_t> drop_weak_latents(const Eigen::MatrixXd& regressed) const;
  void densify();
  ReportRecord make_report(const IntervalModel& intervals) const;
  std::vector<GroupRecord> group_records() const;
  std::vector<HeldOut> answer_ood(std::span<const std::byte> file) const;
  std::vector<std::byte> write(const PackedTree& tree, const IntervalModel& intervals) const;
  void tell(const char* stage, std::size_t samples) const {
    if (options_.progress && samples % 1024 == 0) options_.progress(stage, samples);
  }

  const BuildOptions& options_;
  const SampleSource& source_;
  std::vector<FeatureGroup> groups_;
  std::vector<Sample> chosen_;       // to learn scales from; emptied then
  std::vector<Sample> ood_samples_;  // calibrate_only
  std::size_t feature_size_ = 0, body_size_ = 0;
  FitLayout fit_layout_;
  std::size_t sample_count_ = 0, subject_count_ = 0;
  int fold_count_ = 2;

  std::optional<FeatureScale> features_;
  std::optional<TargetSpace> targets_;
  std::optional<FoldMoments> moments_;
  TrainingRows rows_;  // of the samples choices are made on
  RidgeTrainer::Choice choice_;
  std::vector<RidgeFit> fold_fits_;
  RidgeFit fit_;
  Eigen::MatrixXd regressed_;
  std::optional<Tuner> tuner_;
  RefinementBuilder refinements_;
  std::optional<Entries> entries_;
  std::vector<std::uint32_t> person_;
  std::vector<std::uint8_t> age_;  // as the file has it
  // Of the real entries, only when they are to be mixed.
  std::vector<Position> regressed_places_, true_places_;
  std::array<std::vector<std::uint32_t>, 2> of_sex_;
};

Status Builder::check_sample(const Sample& sample, std::size_t number) const {
  const std::string which = "sample " + std::to_string(number);
  if (sample.feature.size() != feature_size_ || sample.body.size() != body_size_)
    return invalid(which + " has " + std::to_string(sample.feature.size()) + " features and " +
                   std::to_string(sample.body.size()) + " body parameters, the first had " +
                   std::to_string(feature_size_) + " and " + std::to_string(body_size_));
  const auto finite = [](float v) { return std::isfinite(v); };
  if (!std::all_of(sample.truth.begin(), sample.truth.end(), finite) ||
      !std::all_of(sample.body.begin(), sample.body.end(), finite) || !finite(sample.age_years))
    return invalid(which + " has a truth, age or body parameter that is not finite");
  const bool all = sample.fit_layout.shapes > 0 && sample.fit.size() == sample.fit_layout.size() &&
                   sample.fit_both.size() == sample.fit.size() && sample.fit.size() <= kFitMax &&
                   sample.back.size() == feature_size_ &&
                   (fit_layout_.size() == 0 || sample.fit_layout == fit_layout_);
  const bool none = sample.fit.empty() && sample.fit_both.empty() && sample.back.empty();
  if (!all && !none) return invalid(which + " has a fit or a back of another size than expected");
  if (sample.subject > 0xFFFFFFFFU) return invalid(which + " has a subject number of 2^32 or more");
  return Ok{};
}

// The first samples, and the subjects among them.
Status Builder::read_chosen() {
  Status status = Ok{};
  std::size_t number = 0;
  Status read = source_([&](const Sample& sample) {
    if (number == 0) {
      feature_size_ = sample.feature.size();
      body_size_ = sample.body.size();
    }
    if (fit_layout_.size() == 0 && sample.refines()) fit_layout_ = sample.fit_layout;
    status = check_sample(sample, number++);
    if (status && sample.is_entry()) chosen_.push_back(sample);
    return static_cast<bool>(status) && chosen_.size() < options_.chosen_on;
  });
  if (!read) return read;
  return status;
}

Status Builder::check_set() const {
  if (chosen_.empty()) return invalid("no samples; render a dataset first");
  std::size_t subjects = 0;
  for (std::size_t i = 0; i < chosen_.size(); ++i)
    subjects += i == 0 || chosen_[i].subject != chosen_[i - 1].subject ? 1 : 0;
  if (subjects < kSubjectMin)
    return invalid("only " + std::to_string(subjects) + " subjects; at least " + std::to_string(kSubjectMin) +
                   " are needed to hold some out, and thousands for useful answers");
  if (feature_size_ == 0 || feature_size_ > kFeatureMax)
    return invalid("features have " + std::to_string(feature_size_) + " values, expected 1 to " +
                   std::to_string(kFeatureMax));
  std::size_t covered = 0;
  for (const auto& g : groups_) covered += g.count;
  if (covered != feature_size_ || groups_.size() > kGroupMax)
    return invalid("the feature groups cover " + std::to_string(covered) + " values in " +
                   std::to_string(groups_.size()) + " groups, the feature has " + std::to_string(feature_size_) +
                   " and at most 16 groups");
  return Ok{};
}

// Every sample into the moments; the rows choices are made on are kept.
Status Builder::read_moments() {
  features_.emplace(chosen_);
  targets_.emplace(chosen_);
  const auto kept = static_cast<std::ptrdiff_t>(chosen_.size());
  std::vector<Sample>().swap(chosen_);
  fold_count_ = std::clamp(static_cast<int>(std::lround(1 / options_.held_out_fraction)), 2, 10);
  moments_.emplace(static_cast<std::ptrdiff_t>(feature_size_), targets_->size(), fold_count_);
  rows_.features.resize(kept, static_cast<std::ptrdiff_t>(feature_size_));
  rows_.targets.resize(kept, targets_->size());
  rows_.fold_count = fold_count_;
  FoldDealer dealer(options_.seed, fold_count_);
  std::vector<float> z(feature_size_);
  Status status = Ok{};
  std::size_t number = 0;
  std::uint64_t last = 0;
  Status read = source_([&](const Sample& sample) {
    status = check_sample(sample, number++);
    if (!status) return false;
    if (fit_layout_.size() == 0 && sample.refines()) fit_layout_ = sample.fit_layout;
    refinements_.add(sample);
    if (!sample.is_entry()) {
      if (!sample.clothed && !sample.again && ood_samples_.size() < kOodMax) ood_samples_.push_back(sample);
      return true;
    }
    if (sample_count_ == kEntryMax) {
      status = invalid("more than " + std::to_string(kEntryMax) + " samples");
      return false;
    }
    const int fold = dealer.fold_of(sample.subject);
    features_->standardise(sample.feature, z);
    const Eigen::VectorXd y = (*targets_)(sample);
    moments_->add(fold, z, y);
    if (sample_count_ == 0 || sample.subject != last) ++subject_count_;
    last = sample.subject;
    const auto row = static_cast<std::ptrdiff_t>(sample_count_);
    if (row < kept) {
      rows_.features.row(row) = Eigen::Map<const Eigen::RowVectorXf>(z.data(), static_cast<std::ptrdiff_t>(z.size()));
      rows_.targets.row(row) = y.transpose();
      rows_.subject.push_back(static_cast<std::uint32_t>(sample.subject));
      rows_.frame_count.push_back(std::max(sample.frame_count, 1));
      rows_.distance_mm.push_back(sample.distance_mm);
      rows_.fold.push_back(fold);
    }
    tell("learning", ++sample_count_);
    return true;
  });
  if (!read) return read;
  return status;
}

void Builder::regress() {
  std::vector<std::uint32_t> sizes;
  for (const auto& g : groups_) sizes.push_back(g.count);
  RidgeTrainer trainer(rows_, moments_->folds(), sizes);
  choice_ = trainer.choose(kTargetMin);
  const Eigen::MatrixXd all = trainer.cross_fitted(choice_.penalty);
  const auto kept = drop_weak_latents(all);
  const auto columns = static_cast<std::ptrdiff_t>(kept.size());
  Eigen::MatrixXd truth(all.rows(), columns);
  regressed_.resize(all.rows(), columns);
  for (std::ptrdiff_t k = 0; k < columns; ++k) {
    regressed_.col(k) = all.col(kept[static_cast<std::size_t>(k)]);
    truth.col(k) = rows_.targets.col(kept[static_cast<std::size_t>(k)]);
  }
  rows_.targets = truth;
  targets_->keep(kept);
  for (int f = 0; f < fold_count_; ++f) fold_fits_.push_back(trainer.fit(choice_.penalty, f).of_targets(kept));
  fit_ = trainer.fit(choice_.penalty, -1).of_targets(kept);
  moments_.reset();
}

// A latent the features do not show would only blur the metric. Returns the targets kept.
std::vector<std::ptrdiff_t> Builder::drop_weak_latents(const Eigen::MatrixXd& regressed) const {
  std::vector<std::ptrdiff_t> kept;
  for (std::ptrdiff_t t = 0; t < regressed.cols(); ++t) {
    const double error = (rows_.targets.col(t) - regressed.col(t)).squaredNorm();
    if (t < kTargetMin || error < (1 - kLatentExplained) * rows_.targets.col(t).squaredNorm()) kept.push_back(t);
  }
  return kept;
}

// Every sample to an entry, by the regression that did not see its subject.
Status Builder::read_entries() {
  entries_.emplace(tuner_->encoder);
  FoldDealer dealer(options_.seed, fold_count_);
  RowMatrixF block(kBlockRows, static_cast<std::ptrdiff_t>(feature_size_));
  std::vector<Targets> truth;
  std::vector<int> fold;
  std::vector<float> z(feature_size_);
  const bool mixed_later = options_.densify_to > sample_count_;
  const auto flush = [&] {
    const auto count = static_cast<std::ptrdiff_t>(fold.size());
    if (count == 0) return;
    std::vector<RowMatrixF> by_fold;
    for (const RidgeFit& fit : fold_fits_) by_fold.push_back(fit.predict(block.topRows(count)));
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      Targets regressed{};
      for (std::ptrdiff_t t = 0; t < targets_->size(); ++t)
        regressed[static_cast<std::size_t>(t)] =
            static_cast<double>(by_fold[static_cast<std::size_t>(fold[at])](i, t));
      const Position place = tuner_->encoder.place_of(regressed), true_place = tuner_->encoder.place_of(truth[at]);
      entries_->add(place, true_place);
      if (!mixed_later) continue;
      regressed_places_.push_back(place);
      true_places_.push_back(true_place);
    }
    fold.clear();
    truth.clear();
  };
  Status read = source_([&](const Sample& sample) {
    if (!sample.is_entry()) return true;
    features_->standardise(sample.feature, z);
    block.row(static_cast<std::ptrdiff_t>(fold.size())) =
        Eigen::Map<const Eigen::RowVectorXf>(z.data(), static_cast<std::ptrdiff_t>(z.size()));
    const Eigen::VectorXd y = (*targets_)(sample);
    Targets t{};
    std::copy(y.begin(), y.end(), t.begin());
    truth.push_back(t);
    fold.push_back(dealer.fold_of(sample.subject));
    if (mixed_later) of_sex_[sample.woman ? 1 : 0].push_back(static_cast<std::uint32_t>(person_.size()));
    person_.push_back(static_cast<std::uint32_t>(sample.subject));
    age_.push_back(age_step(sample.age_years));
    if (fold.size() == static_cast<std::size_t>(kBlockRows)) flush();
    tell("encoding", person_.size());
    return person_.size() <= sample_count_;
  });
  if (!read) return read;
  flush();
  if (person_.size() != sample_count_) return invalid("the samples changed while they were read");
  return Ok{};
}

void Builder::densify() {
  const std::size_t real = person_.size();
  if (options_.densify_to <= real) return;
  std::array<Position, 2> regressed_mean{}, true_mean{};
  std::vector<int> sex(real);
  for (std::size_t s = 0; s < 2; ++s) {
    const auto count = static_cast<double>(std::max<std::size_t>(of_sex_[s].size(), 1));
    for (const std::uint32_t i : of_sex_[s]) {
      sex[i] = static_cast<int>(s);
      for (std::size_t d = 0; d < kDimensionMax; ++d) {
        regressed_mean[s][d] += regressed_places_[i][d] / count;
        true_mean[s][d] += true_places_[i][d] / count;
      }
    }
  }
  const Densifier densifier(of_sex_, options_.seed);
  for (std::uint64_t n = 0; person_.size() < options_.densify_to; ++n) {
    const Mix mix = densifier.mix(n);
    const auto s = static_cast<std::size_t>(sex[mix.first]);
    const auto mixed = [&](const std::vector<Position>& of, const Position& mean) {
      Position out{};
      for (std::size_t d = 0; d < kDimensionMax; ++d)
        out[d] = mean[d] + mix.first_share * (of[mix.first][d] - mean[d]) +
                 mix.second_share * (of[mix.second][d] - mean[d]);
      return out;
    };
    entries_->add(mixed(regressed_places_, regressed_mean[s]), mixed(true_places_, true_mean[s]));
    person_.push_back(person_[mix.first]);
    age_.push_back(age_[mix.first]);
    tell("densifying", person_.size());
  }
}

ReportRecord Builder::make_report(const IntervalModel& intervals) const {
  const Tuner& tuner = *tuner_;
  ReportRecord report;
  report.dimension_bits = tuner.dimension_bits;
  for (std::size_t d = tuner.meta.dimensions; d < report.dimension_bits.size(); ++d) report.dimension_bits[d] = 0;
  report.error_with_all = static_cast<float>(choice_.error);
  report.coverage = intervals.coverage;
  const auto n = static_cast<double>(tuner.held_out.size());
  double right = 0;
  std::array<double, kMeasurementCount> answer{}, prior{};
  for (const HeldOut& row : tuner.held_out) {
    for (std::size_t m = 0; m < kMeasurementCount; ++m) {
      answer[m] += std::abs(row.answer[m] - row.truth[m]) / n;
      prior[m] += std::abs(row.truth[m]) / n;
    }
    const double mean = targets_->mean(kSexTarget);
    const double scale = targets_->scale(kSexTarget);
    right += (mean + scale * row.answer[kSexTarget] > 0) == (mean + scale * row.truth[kSexTarget] > 0) ? 1 / n : 0;
  }
  report.sex_accuracy = static_cast<float>(right);
  for (std::size_t m = 0; m < kMeasurementCount; ++m) {
    const auto t = static_cast<std::ptrdiff_t>(m);
    report.answer_mae[m] = static_cast<float>(targets_->scale(m) * answer[m]);
    report.prior_mae[m] = static_cast<float>(targets_->scale(m) * prior[m]);
    report.nearest_mae[m] = static_cast<float>(targets_->scale(m) * static_cast<double>(tuner.nearest_error[m]));
    report.ridge_mae[m] =
        static_cast<float>(targets_->scale(m) * (rows_.targets.col(t) - regressed_.col(t)).cwiseAbs().mean());
  }
  return report;
}

std::vector<GroupRecord> Builder::group_records() const {
  double lightest = choice_.penalty.group[0];
  for (const double p : choice_.penalty.group) lightest = std::min(lightest, p);
  std::vector<GroupRecord> out;
  std::uint32_t first = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    GroupRecord record;
    groups_[g].name.copy(record.name, sizeof record.name - 1);
    record.first = first;
    record.count = groups_[g].count;
    // Scaling a group by w is the same as dividing its penalty by w^2.
    const double weight = std::sqrt(lightest / choice_.penalty.group[g]);
    record.weight = static_cast<float>(choice_.penalty.group[g] > 1e6 ? 0 : weight);
    record.error_without = static_cast<float>(choice_.error_without[g]);
    out.push_back(record);
    first += groups_[g].count;
  }
  return out;
}

std::vector<std::byte> Builder::write(const PackedTree& tree, const IntervalModel& intervals) const {
  const Tuner& tuner = *tuner_;
  const auto targets = static_cast<std::size_t>(targets_->size());
  MetaRecord meta = tuner.meta;
  meta.feature_size = static_cast<std::uint32_t>(feature_size_);
  meta.target_count = static_cast<std::uint32_t>(targets);
  meta.entry_count = static_cast<std::uint32_t>(person_.size());
  meta.subject_count = static_cast<std::uint32_t>(subject_count_);
  meta.leaf_count = static_cast<std::uint32_t>(tree.view().leaf_count());
  meta.group_count = static_cast<std::uint32_t>(groups_.size());
  meta.interval_kind = static_cast<std::uint32_t>(intervals.kind);
  meta.noise = intervals.noise;
  meta.population_seed = options_.population_seed;
  meta.population_version = options_.population_version;
  meta.densified_count = static_cast<std::uint32_t>(person_.size() - sample_count_);
  meta.tracker_key = options_.tracker_key;
  const std::vector<float> mean(targets_->means().begin(), targets_->means().end());
  const std::vector<float> scale(targets_->scales().begin(), targets_->scales().end());
  const ReportRecord report = make_report(intervals);
  const std::uint32_t last = *std::max_element(person_.begin(), person_.end());
  const int person_bytes = last < 1U << 16 ? 2 : last < 1U << 24 ? 3 : 4;
  std::vector<std::uint8_t> person;
  person.reserve(tree.order.size() * static_cast<std::size_t>(person_bytes));
  for (const std::uint32_t row : tree.order)
    for (int byte = 0; byte < person_bytes; ++byte)
      person.push_back(static_cast<std::uint8_t>(person_[row] >> 8 * byte));
  std::vector<std::uint8_t> age;
  age.reserve(tree.order.size());
  for (const std::uint32_t row : tree.order) age.push_back(age_[row]);

  ContainerWriter out(kMagic, kVersion);
  out.add_array("meta", std::span<const MetaRecord>(&meta, 1));
  out.add_array("report", std::span<const ReportRecord>(&report, 1));
  out.add_array("groups", view(group_records()));
  out.add_array("provenance", std::span<const char>(options_.provenance));
  out.add_array("feature.mean", view(features_->mean));
  out.add_array("feature.scale", view(features_->scale));
  const RoundedWeights ridge = round_weights({fit_.weights.data(), targets * feature_size_}, feature_size_);
  out.add_array("ridge", view(ridge.weights));
  out.add_array("ridge.unit", view(ridge.unit));
  out.add_array("ridge.bias", std::span<const float>(fit_.bias.data(), targets));
  out.add_array("target.mean", view(mean));
  out.add_array("target.scale", view(scale));
  out.add_array("projection", view(tuner.encoder.projection));
  out.add_array("code.step", std::span<const std::int32_t>(tuner.encoder.steps));
  out.add_array("code.spread", view(tuner.encoder.inverse_spread));
  out.add_array("quadratic", view(tuner.quadratic));
  out.add_array("error.map", view(tuner.error_map));
  out.add_array("place.map", view(tuner.place_map));
  out.add_array("residual.scale", view(tuner.encoder.residual_scale));
  out.add_array("interval", std::span<const float>(intervals.quantiles));
  out.add_array("spread.floor", std::span<const float>(intervals.spread_floor));
  out.add_array("sex.table",
                view(calibrate_sex(tuner.held_out, targets_->mean(kSexTarget), targets_->scale(kSexTarget))));
  out.add_array("group.box", view(tree.group_boxes));
  out.add_array("leaf.box", view(tree.leaf_boxes));
  out.add_array("leaf", view(tree.leaf_first));
  out.add_array("code", view(tree.blocks), Checked::by_page);
  out.add_array("residual", view(in_order(entries_->residuals, tree.dimension_count, tree.order)), Checked::by_page);
  out.add_array("person", view(person), Checked::by_page);
  out.add_array("age", view(age), Checked::by_page);
  refinements_.write(out);
  return out.finish();
}

// Answers of the finished index to out-of-distribution subjects.
std::vector<HeldOut> Builder::answer_ood(std::span<const std::byte> file) const {
  std::vector<HeldOut> out;
  const auto contents = parse_contents(file, "index");
  if (!contents) return out;
  const Answerer answerer(*contents);
  Answerer::Workspace work(answerer);
  for (const Sample& s : ood_samples_) {
    HeldOut row;
    row.subject = static_cast<std::uint32_t>(s.subject);
    row.frame_count = s.frame_count;
    row.distance_mm = s.distance_mm;
    const auto corrected = answerer.corrected(answerer.regressed(s.feature, work), {}, work);
    if (!corrected) return out;
    row.answer = corrected->value;
    row.spread = corrected->spread;
    for (std::size_t m = 0; m < kMeasurementCount; ++m)
      row.truth[m] =
          targets_->scale(m) > 0 ? (static_cast<double>(s.truth[m]) - targets_->mean(m)) / targets_->scale(m) : 0;
    out.push_back(row);
  }
  return out;
}

Result<std::vector<std::byte>> Builder::run() {
  if (auto s = check_options(options_); !s) return s.error();
  if (auto s = read_chosen(); !s) return s.error();
  groups_ = options_.groups.empty() ? default_groups(feature_size_) : options_.groups;
  if (auto s = check_set(); !s) return s.error();
  if (auto s = read_moments(); !s) return s.error();
  regress();
  tuner_.emplace(rows_, regressed_);
  tuner_->run(options_.dimensions);
  if (auto s = read_entries(); !s) return s.error();
  densify();
  const PackedTree tree = pack_tree(entries_->codes, tuner_->encoder.dimensions, tuner_->encoder.steps);
  IntervalModel intervals = calibrate_intervals(tuner_->held_out);
  const std::vector<std::byte> file = write(tree, intervals);
  const std::vector<HeldOut> ood = answer_ood(file);
  if (ood.size() != ood_samples_.size()) return invalid("the new index cannot be read back");
  if (ood.size() >= kOodMin) {
    std::vector<HeldOut> judged = tuner_->held_out;
    for (const std::size_t i : ood_beside(judged.size(), ood.size(), kOodShare)) judged.push_back(ood[i]);
    intervals = calibrate_intervals(judged);
    if (options_.for_unknown_makes)
      widen(intervals.quantiles, kUnknownMakeWidening[static_cast<std::size_t>(Refinement::fitted)]);
  }
  RefinementBuilder::PlainAnswers plain;
  for (const std::vector<HeldOut>* answered : {&std::as_const(tuner_->held_out), &ood})
    for (const HeldOut& row : *answered) plain[row.subject] = row.answer;
  refinements_.learn(*targets_, plain,
                     {options_.seed, options_.shape_key, options_.for_unknown_makes, options_.threads});
  std::vector<std::byte> complete = write(tree, intervals);
  if (auto read = parse_contents(complete, "the new index"); !read) return read.error();
  return complete;
}

}  // namespace

Result<std::vector<std::byte>> build_index(const BuildOptions& options, const SampleSource& source) {
  return Builder(options, source).run();
}

}  // namespace im2fit::index
