// SPDX-License-Identifier: Apache-2.0
#include "train/index/refinement_builder.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/rng.h"
#include "index/format.h"
#include "train/common/linear_algebra.h"
#include "train/common/parallel.h"
#include "train/index/ridge.h"

namespace im2fit::index {
namespace {

constexpr std::uint64_t kClothingStream = 0xC107;
// Times the penalty of a map: a fit's coefficients have been shrunk to the population once, by the fit; histograms of
// FPFH are many and noisy; the frames stand for themselves, as does what kind of sensor they are of
// (docs/formats-index.md).
constexpr double kFitPenalty = 0.03, kHistogramPenalty = 3, kFramesPenalty = 0.1, kSensorPenalty = 0.1;
// A row weighs 1 / (1 + this times the square of its distance's share beyond kWellSeenMm).
constexpr double kFarVariance = 11;

// The penalty of each value in those of others, by where refined_values() puts it.
Eigen::VectorXd penalty_shares(Refinement kind, std::size_t feature_size, const FitLayout& fit) {
  Eigen::VectorXd shares = Eigen::VectorXd::Ones(static_cast<std::ptrdiff_t>(refined_size(kind, feature_size, fit)));
  std::ptrdiff_t at = 0;
  const int views = sees_back(kind) ? 2 : 1;
  for (int v = 0; v < views; ++v)
    for (const FeatureGroup& group : default_groups(feature_size)) {
      if (group.name == "fpfh") shares.segment(at, group.count).setConstant(kHistogramPenalty);
      if (group.name == "sensor") shares.segment(at, group.count).setConstant(kSensorPenalty);
      at += group.count;
    }
  shares.segment(at, views * static_cast<std::ptrdiff_t>(fit.shapes)).setConstant(kFitPenalty);
  shares.tail(1).setConstant(kFramesPenalty);
  return shares;
}

double weight_at(int distance_mm) {
  const double beyond = std::max(distance_mm / kWellSeenMm - 1, 0.0);
  return 1 / (1 + kFarVariance * beyond * beyond);
}

// As ValueMap::novelty.
double novelty_of(const RowMatrixF& z, std::ptrdiff_t row) {
  const auto seen = (z.row(row).array() != 0).count();
  return seen > 0 ? z.row(row).cast<double>().squaredNorm() / static_cast<double>(seen) : 0;
}

// Estimates shrink to the mean, more so for people of another make: a slim or heavy person's would be too near it.
// `rows`: out-of-distribution people, left out of the fit of the answers. Returns the share of a difference in truth
// that the answer shows, by target; 1 where there are too few people to estimate it.
Eigen::VectorXd answered_share(const Eigen::MatrixXd& answer, const Eigen::MatrixXd& truth,
                               const std::vector<std::ptrdiff_t>& rows, Eigen::VectorXd& mean) {
  constexpr double kShareLeast = 0.85;  // a smaller share cannot be stretched to a sound estimate
  mean = Eigen::VectorXd::Zero(truth.cols());
  Eigen::VectorXd share = Eigen::VectorXd::Ones(truth.cols());
  if (rows.size() < kOodMin) return share;
  const Eigen::MatrixXd y = truth(rows, Eigen::all), z = answer(rows, Eigen::all);
  mean = y.colwise().mean().transpose();
  for (std::ptrdiff_t t = 0; t < y.cols(); ++t) {
    const Eigen::VectorXd off = y.col(t).array() - mean(t);
    share(t) = std::clamp(off.dot(z.col(t)) / std::max(off.squaredNorm(), 1e-12), kShareLeast, 1.0);
  }
  return share;
}

}  // namespace

void RefinementBuilder::add(const Sample& sample) {
  Rows& rows = rows_[sample.clothed ? 1 : 0];
  if (!sample.refines() || rows.size() >= kSampleMax) return;
  fit_ = sample.fit_layout;
  feature_size_ = sample.feature.size();
  Row& row = rows.emplace_back();
  row.subject = sample.subject;
  // As the device counts them: with both sides seen, the fewer of the two and the farther.
  row.frame_count = {std::max(sample.frame_count, 1),
                     std::max(std::min(sample.frame_count, sample.back_frame_count), 1)};
  row.distance_mm = {sample.distance_mm, std::max(sample.distance_mm, sample.back_distance_mm)};
  row.ood = sample.calibrate_only;
  row.woman = sample.woman;
  row.clothes_kind = sample.clothes_kind;
  row.truth = sample.truth;
  Seen seen{sample.feature, sample.fit, sample.back, sample.fit_both, ClothingGiven::unknown, 0};
  for (const Refinement kind : {Refinement::fitted, Refinement::turned}) {
    seen.frame_count = row.frame_count[sees_back(kind) ? 1 : 0];
    auto& values = row.values[sees_back(kind) ? 1 : 0];
    values.resize(refined_size(kind, sample.feature.size(), fit_));
    refined_values(kind, seen, fit_, values);
  }
}

void RefinementBuilder::learn(const TargetSpace& targets, const PlainAnswers& plain, const Settings& settings) {
  // Those that take longest first: of most values, and among them of people in clothes, who are answered once more by
  // regressions that met none of their kind.
  struct Task {
    Refinement kind;
    bool tells_clothes;
  };
  std::vector<Task> tasks;
  const bool has_both = rows_[0].size() >= kSampleMin && rows_[1].size() >= kSampleMin;
  for (const bool back : {true, false}) {
    for (const bool clothed : {true, false})
      for (const Refinement kind : kRefinements)
        if (is_of_clothed(kind) == clothed && sees_back(kind) == back && rows_[clothed ? 1 : 0].size() >= kSampleMin)
          tasks.push_back({kind, false});
    for (const Refinement view : kClothingViews)
      if (has_both && sees_back(view) == back) tasks.push_back({view, true});
  }
  lab::for_each_item(tasks.size(), settings.threads, [&](std::size_t i) {
    const auto [kind, tells_clothes] = tasks[i];
    if (tells_clothes) {
      const auto at = std::find(kClothingViews.begin(), kClothingViews.end(), kind) - kClothingViews.begin();
      clothing_[static_cast<std::size_t>(at)] = learn_clothing(kind, settings.seed);
      return;
    }
    auto& learned = learned_[static_cast<std::size_t>(kind)];
    learned = learn_one(kind, rows_[is_of_clothed(kind) ? 1 : 0], targets, plain, settings);
    learned->record.fit = fit_;
    learned->record.shape_key = settings.shape_key;
  });
  for (Rows& rows : rows_)
    for (Row& row : rows) row.values = {};
}

RefinementBuilder::Learned RefinementBuilder::learn_one(Refinement kind, const Rows& people,
                                                        const TargetSpace& targets, const PlainAnswers& plain,
                                                        const Settings& settings) const {
  const auto count = static_cast<std::ptrdiff_t>(people.size());
  std::vector<const std::vector<float>*> values;
  std::vector<int> fold_of_row, kind_of_row;
  Repeats repeats;
  Eigen::MatrixXd y(count, kTargetMin);
  Eigen::VectorXd weights(count);
  FoldDealer dealer(settings.seed, kRefinementFolds);
  for (const Row& row : people) {
    const auto at = static_cast<std::ptrdiff_t>(values.size());
    y.row(at) = targets.measured(row.truth, row.woman).transpose();
    weights(at) = weight_at(row.distance_mm[sees_back(kind) ? 1 : 0]);
    values.push_back(&row.values[sees_back(kind) ? 1 : 0]);
    fold_of_row.push_back(dealer.fold_of(row.subject));
    kind_of_row.push_back(row.clothes_kind);
    if (at > 0 && people[static_cast<std::size_t>(at - 1)].subject == row.subject) repeats.push_back({at - 1, at});
  }
  RefinementTable table(values, std::move(y), std::move(weights), fold_of_row);
  table.unlike = table.unlike_of(repeats);
  const Eigen::VectorXd shares = penalty_shares(kind, feature_size_, fit_);
  CrossFit cross = choose_penalty(table, shares);

  Learned out;
  out.record.sample_count = static_cast<std::uint32_t>(count);
  out.record.penalty_millionths = static_cast<std::uint32_t>(std::lround(cross.penalty * 1e6));
  // By regressions trained on other people, out-of-distribution ones among them, as the one in the file is.
  std::vector<std::ptrdiff_t> ordinary, ood;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Row& row = people[static_cast<std::size_t>(i)];
    if (is_of_clothed(kind) || plain.contains(row.subject)) (row.ood ? ood : ordinary).push_back(i);
  }
  LinearFit fit = solve(table.all, table.unlike, cross.penalty * shares);
  Learned::Answers answers;
  if (is_of_clothed(kind)) {
    answers.of_unknown_clothes =
        answer_unknown_clothes(table, kind_of_row, repeats, cross.penalty * shares, answers.met_none);
    for (std::ptrdiff_t i = 0; i < count; ++i) answers.novelty.push_back(novelty_of(table.z, i));
  }
  Eigen::VectorXd mean;
  const Eigen::VectorXd share_answered = answered_share(cross.answer, table.y, ood, mean);
  for (std::ptrdiff_t t = 0; t < static_cast<std::ptrdiff_t>(kMeasurementCount); ++t) {
    const double stretch = 1 / share_answered(t);
    cross.answer.col(t) = (cross.answer.col(t).array() - mean(t)) * stretch + mean(t);
    if (is_of_clothed(kind))
      answers.of_unknown_clothes.col(t) = (answers.of_unknown_clothes.col(t).array() - mean(t)) * stretch + mean(t);
    fit.weights.col(t) *= stretch;
    fit.bias(t) = (fit.bias(t) - mean(t)) * stretch + mean(t);
  }
  out.map = LearnedMap(table.scale, fit);

  const bool many = ood.size() >= kOodMin;
  std::vector<std::ptrdiff_t> judged = ordinary;
  if (many) {
    const double share = kRefinedOodShare[static_cast<std::size_t>(kind)];
    for (const std::size_t i : ood_beside(ordinary.size(), ood.size(), share)) judged.push_back(ood[i]);
  } else {
    judged.insert(judged.end(), ood.begin(), ood.end());
  }
  answers.truth = table.y;
  answers.answered = std::move(cross.answer);
  if (!judged.empty())
    out.judge(kind, people, judged, many ? ood : judged, targets, plain, answers, settings.for_unknown_makes);
  return out;
}

RefinementBuilder::LearnedMap::LearnedMap(const FeatureScale& values, const LinearFit& fit) {
  for (const float m : values.mean) mean.push_back(upper_of_float(m));
  for (const float v : values.scale) scale.push_back(upper_of_float(v));
  const RowMatrixF rows = fit.weights.transpose().cast<float>();
  weights =
      round_weights({rows.data(), static_cast<std::size_t>(rows.size())}, static_cast<std::size_t>(rows.cols()));
  for (std::ptrdiff_t t = 0; t < fit.bias.size(); ++t) bias.push_back(static_cast<float>(fit.bias(t)));
}

// Bare and dressed people, with equal total weight. Neither the shape nor the sex of a person may stand for clothes:
// most subjects are seen both ways, so that the two differ by the clothes alone.
RefinementBuilder::LearnedClothing RefinementBuilder::learn_clothing(Refinement view, std::uint64_t seed) const {
  const auto count = static_cast<std::ptrdiff_t>(rows_[0].size() + rows_[1].size());
  std::vector<const std::vector<float>*> values;
  std::vector<int> fold_of_row;
  std::vector<bool> dressed;
  Eigen::MatrixXd y(count, 1);
  Eigen::VectorXd weights(count);
  for (const bool is_dressed : {false, true}) {
    const Rows& people = rows_[is_dressed ? 1 : 0];
    for (const Row& row : people) {
      const auto at = static_cast<std::ptrdiff_t>(values.size());
      y(at, 0) = is_dressed ? 1 : -1;
      weights(at) = weight_at(row.distance_mm[sees_back(view) ? 1 : 0]) / static_cast<double>(people.size());
      values.push_back(&row.values[sees_back(view) ? 1 : 0]);
      // Not dealt in turn: a subject's rows, bare and dressed, belong in one fold.
      fold_of_row.push_back(Rng::for_item(seed, kClothingStream, row.subject).index(kRefinementFolds));
      dressed.push_back(is_dressed);
    }
  }
  weights *= static_cast<double>(count) / weights.sum();
  const RefinementTable table(values, std::move(y), std::move(weights), fold_of_row);
  const Eigen::VectorXd shares = penalty_shares(view, feature_size_, fit_);
  const CrossFit cross = choose_penalty(table, shares);
  LearnedClothing out;
  out.record.fit = fit_;
  out.record.sample_count = static_cast<std::uint32_t>(count);
  out.record.penalty_millionths = static_cast<std::uint32_t>(std::lround(cross.penalty * 1e6));
  out.map = LearnedMap(table.scale, solve(table.all, table.unlike, cross.penalty * shares));
  std::vector<LabelledScore> scores;
  double right[2] = {0, 0};
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const bool label = dressed[static_cast<std::size_t>(i)];
    scores.push_back({cross.answer(i, 0), label});
    if ((cross.answer(i, 0) > 0) == label) right[label ? 1 : 0] += 1;
  }
  out.record.right_share = static_cast<float>(
      0.5 * (right[0] / static_cast<double>(rows_[0].size()) + right[1] / static_cast<double>(rows_[1].size())));
  out.table = calibrate_probability(scores);
  return out;
}

HeldOut RefinementBuilder::Learned::held_out_of(Refinement kind, const Row& row, const Answers& answers,
                                                std::ptrdiff_t at, const Eigen::MatrixXd& answered,
                                                const PlainAnswers& plain) const {
  HeldOut h;
  h.subject = static_cast<std::uint32_t>(row.subject);
  h.frame_count = row.frame_count[sees_back(kind) ? 1 : 0];
  h.distance_mm = row.distance_mm[sees_back(kind) ? 1 : 0];
  if (is_of_clothed(kind)) h.novelty = answers.novelty[static_cast<std::size_t>(at)];
  for (std::size_t t = 0; t < kTargetMin; ++t) {
    const auto column = static_cast<std::ptrdiff_t>(t);
    h.truth[t] = answers.truth(at, column);
    h.answer[t] = answered(at, column);
    if (is_of_clothed(kind)) continue;
    const double before = plain.at(row.subject)[t];
    h.answer[t] = before + static_cast<double>(record.share[t]) * (h.answer[t] - before);
  }
  return h;
}

void RefinementBuilder::Learned::judge(Refinement kind, const Rows& people, const std::vector<std::ptrdiff_t>& judged,
                                       const std::vector<std::ptrdiff_t>& unlike, const TargetSpace& targets,
                                       const PlainAnswers& plain, const Answers& answers, bool for_unknown_makes) {
  // For people in clothes there is no plain answer to mix with.
  record.share.fill(1.0F);
  for (std::ptrdiff_t t = 0; !is_of_clothed(kind) && t < kTargetMin; ++t) {
    double change_square = 1e-12, change_right = 0;
    for (const std::ptrdiff_t i : unlike) {
      const double before = plain.at(people[static_cast<std::size_t>(i)].subject)[static_cast<std::size_t>(t)];
      const double change = answers.answered(i, t) - before;
      change_square += change * change;
      change_right += change * (answers.truth(i, t) - before);
    }
    record.share[static_cast<std::size_t>(t)] =
        static_cast<float>(std::clamp(change_right / change_square, 0.0, 1.0));
  }
  std::vector<HeldOut> held_out;
  for (const std::ptrdiff_t i : judged) {
    const Row& row = people[static_cast<std::size_t>(i)];
    const HeldOut& h = held_out.emplace_back(held_out_of(kind, row, answers, i, answers.answered, plain));
    for (std::size_t t = 0; t < kMeasurementCount; ++t)
      record.mae[t] += static_cast<float>(targets.scale(t) * std::abs(h.truth[t] - h.answer[t]) /
                                          static_cast<double>(judged.size()));
  }
  // As often as not a person is taken to wear what no training person wore.
  if (is_of_clothed(kind))
    for (const std::ptrdiff_t i : judged)
      if (answers.met_none[static_cast<std::size_t>(i)])
        held_out.push_back(
            held_out_of(kind, people[static_cast<std::size_t>(i)], answers, i, answers.of_unknown_clothes, plain));
  IntervalModel intervals = calibrate_intervals(held_out);
  if (for_unknown_makes) widen(intervals.quantiles, kUnknownMakeWidening[static_cast<std::size_t>(kind)]);
  record.interval_kind = static_cast<std::uint32_t>(intervals.kind);
  record.noise = intervals.noise;
  record.coverage = intervals.coverage;
  interval.assign(intervals.quantiles.begin(), intervals.quantiles.end());
  spread_floor.assign(intervals.spread_floor.begin(), intervals.spread_floor.end());
  sex_table = calibrate_sex(held_out, targets.mean(kSexTarget), targets.scale(kSexTarget));
}

void RefinementBuilder::write(ContainerWriter& out) const {
  const auto add = [&](const std::string& name, const auto& values) {
    using Value = typename std::decay_t<decltype(values)>::value_type;
    out.add_array(name, std::span<const Value>(values));
  };
  const auto add_map = [&](const auto& name, const LearnedMap& map) {
    add(name("mean"), map.mean);
    add(name("scale"), map.scale);
    add(name("weights"), map.weights.weights);
    add(name("unit"), map.weights.unit);
    add(name("bias"), map.bias);
  };
  for (const Refinement kind : kRefinements) {
    const auto& learned = learned_[static_cast<std::size_t>(kind)];
    if (!learned || learned->sex_table.empty()) continue;  // no person to judge it on
    const auto name = [&](const char* part) { return section_of(kind, part); };
    out.add_array(name("about"), std::span<const RefinementRecord>(&learned->record, 1));
    add_map(name, learned->map);
    add(name("interval"), learned->interval);
    add(name("spread"), learned->spread_floor);
    add(name("sex"), learned->sex_table);
  }
  for (std::size_t v = 0; v < kClothingViews.size(); ++v) {
    const auto& learned = clothing_[v];
    if (!learned) continue;
    const auto name = [&](const char* part) { return clothing_section_of(kClothingViews[v], part); };
    out.add_array(name("about"), std::span<const ClothingRecord>(&learned->record, 1));
    add_map(name, learned->map);
    add(name("table"), learned->table);
  }
}

}  // namespace im2fit::index
