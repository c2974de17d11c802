// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <stdexcept>

#include "bench/index/reference.h"
#include "index/index.h"
#include "train/index/builder.h"

namespace im2fit::bench {
namespace {

class Ours : public Reference {
 public:
  Ours(const People& people, bool raw_only)
      : groups_(raw_only ? index::default_groups(kRawSize) : people.groups), raw_only_(raw_only) {}
  std::string name() const override {
    return std::string("im2fit") + (raw_only_ ? ", 501 features" : "") + (exhaustive_ ? ", exhaustive" : "");
  }
  std::string note() const override { return note_; }
  std::size_t method_count() const override { return raw_only_ ? 1 : 2; }
  void use_method(std::size_t method) override { exhaustive_ = method == 1; }

  double build(const Models& models) override {
    const auto start = std::chrono::steady_clock::now();
    index::BuildOptions options;
    options.groups = groups_;
    if (models.densified_count() > 0) options.densify_to = models.size();
    auto bytes = index::build_index(options, [&](const std::function<bool(const index::Sample&)>& take) {
      for (const index::Sample& sample : models.real()) {
        if (!raw_only_) {
          if (!take(sample)) break;
          continue;
        }
        index::Sample part = sample;
        part.feature.resize(kRawSize);
        for (auto* further : {&part.fit, &part.back, &part.fit_both}) further->clear();
        if (!take(part)) break;
      }
      return Status(Ok{});
    });
    if (!bytes) throw std::runtime_error(bytes.error().message);
    file_ = std::move(*bytes);
    auto index = index::Index::parse(file_, "the new index");
    if (!index) throw std::runtime_error(index.error().message);
    index_.emplace(std::move(*index));
    scratch_.emplace(index_->make_scratch());
    note_ = std::to_string(index_->dimensions()) + " dimensions, " + std::to_string(index_->info().neighbour_count) +
            " neighbours";
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  Reply ask(const Question& question) override { return query(question, exhaustive_); }
  std::optional<Reply> ask_exhaustively(const Question& question) override { return query(question, true); }
  double bytes() const override { return static_cast<double>(file_.size()); }
  std::span<const std::byte> file() const override { return file_; }

 private:
  Reply query(const Question& question, bool exhaustive) {
    index::QueryOptions options;
    options.exhaustive = exhaustive;
    const auto feature = raw_only_ ? question.feature.first(kRawSize) : question.feature;
    auto answered = index_->query(feature, options, **scratch_);
    if (!answered) throw std::runtime_error(answered.error().message);
    const index::Answer& answer = *answered;
    MeasurementValues values{};
    for (std::size_t m = 0; m < kMeasurementCount; ++m) values[m] = answer.measurements[m].value;
    return {answer.nearest, values, answer.nearest_values};
  }

  std::vector<index::FeatureGroup> groups_;
  bool raw_only_, exhaustive_ = false;
  std::vector<std::byte> file_;
  std::string note_;
  std::optional<index::Index> index_;
  std::optional<decltype(index_->make_scratch())> scratch_;
};

}  // namespace

std::unique_ptr<Reference> make_ours(const People& people, bool raw_only) {
  return std::make_unique<Ours>(people, raw_only);
}

}  // namespace im2fit::bench
