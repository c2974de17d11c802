// SPDX-License-Identifier: Apache-2.0
// Exact references over raw features, and plain principal components. Compiled for the machine this runs on, as a
// user of these headers would.
#include <chrono>
#include <limits>
#include <nanoflann.hpp>

#include "bench/index/plain_pca.h"
#include "bench/index/reference.h"

namespace im2fit::bench {
namespace {

constexpr std::size_t kBlockRows = 4096;
constexpr std::size_t kPcaRows = 20000;  // to fit on
constexpr std::size_t kReranked = 100;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

float distance_square(const float* a, const float* b) {
  float sum = 0;
  for (std::size_t i = 0; i < kRawSize; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

struct RawRows {
  std::vector<float> values;
  std::size_t kdtree_get_point_count() const { return values.size() / kRawSize; }
  float kdtree_get_pt(std::size_t point, std::size_t dimension) const { return values[point * kRawSize + dimension]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
  void fill(const Models& models) {
    values.reserve(models.size() * kRawSize);
    models.each_block(kBlockRows, [&](std::size_t, std::span<const float> block) {
      values.insert(values.end(), block.begin(), block.end());
    });
  }
  double bytes() const { return 4.0 * static_cast<double>(values.size()); }
};

class BruteForce : public Reference {
 public:
  std::string name() const override { return "brute force, 501 float"; }
  double build(const Models& models) override {
    rows_.fill(models);
    return 0;
  }
  Reply ask(const Question& question) override {
    Reply best;
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t n = 0; n < rows_.kdtree_get_point_count(); ++n) {
      const float d = distance_square(question.raw.data(), &rows_.values[n * kRawSize]);
      if (d >= least) continue;
      least = d;
      best.model = static_cast<std::uint32_t>(n);
    }
    return best;
  }
  double bytes() const override { return rows_.bytes(); }

 private:
  RawRows rows_;
};

class NanoflannRaw : public Reference {
 public:
  std::string name() const override { return "nanoflann, 501 float"; }
  double build(const Models& models) override {
    rows_.fill(models);
    const auto start = std::chrono::steady_clock::now();
    tree_ = std::make_unique<Tree>(static_cast<int>(kRawSize), rows_);
    return seconds_since(start);
  }
  Reply ask(const Question& question) override {
    Reply reply;
    float distance = 0;
    tree_->knnSearch(question.raw.data(), 1, &reply.model, &distance);
    return reply;
  }
  double bytes() const override { return rows_.bytes() + static_cast<double>(tree_->usedMemory(*tree_)); }

 private:
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Adaptor<float, RawRows>, RawRows, -1, std::uint32_t>;
  RawRows rows_;
  std::unique_ptr<Tree> tree_;
};

class NanoflannPca : public Reference {
 public:
  std::string name() const override {
    return "nanoflann, plain PCA-16 float" + (rerank_ == 0 ? "" : ", best " + std::to_string(rerank_) + " by raw L2");
  }
  std::string note() const override { return note_; }
  std::size_t method_count() const override { return 2; }
  void use_method(std::size_t method) override { rerank_ = method == 1 ? kReranked : 0; }
  double build(const Models& models) override {
    models_ = &models;
    const auto start = std::chrono::steady_clock::now();
    PlainPca pca = PlainPca::fit(models.some(kPcaRows), kRawSize, kPcaSize);
    note_ = std::to_string(static_cast<int>(100 * pca.explained())) + " % of the variance";
    nearest_ = std::make_unique<PcaNearest>(std::move(pca));
    const double making = models.each_block(kBlockRows, [&](std::size_t, std::span<const float> block) {
      for (std::size_t at = 0; at < block.size(); at += kRawSize) nearest_->add(block.subspan(at, kRawSize));
    });
    nearest_->build();
    return seconds_since(start) - making;
  }
  Reply ask(const Question& question) override {
    const auto found = nearest_->nearest(question.raw, std::max<std::size_t>(rerank_, 1));
    Reply best{found[0], {}, {}};
    if (rerank_ == 0) return best;
    float least = std::numeric_limits<float>::infinity();
    // Raw features are mixed on the way instead of fetched from where 10 GB of them would lie: two rows are read for
    // one.
    for (const std::uint32_t n : found) {
      models_->feature(n, row_.data());
      const float d = distance_square(question.raw.data(), row_.data());
      if (d >= least) continue;
      least = d;
      best.model = n;
    }
    return best;
  }
  std::optional<Reply> ask_exhaustively(const Question& question) override {
    if (rerank_ > 0) return std::nullopt;
    return Reply{nearest_->nearest_exhaustive(question.raw), {}, {}};
  }
  double bytes() const override {
    const double raw = rerank_ > 0 ? 4.0 * kRawSize * static_cast<double>(models_->size()) : 0;
    return raw + static_cast<double>(nearest_->bytes());
  }

 private:
  std::size_t rerank_ = 0;
  const Models* models_ = nullptr;
  std::unique_ptr<PcaNearest> nearest_;
  std::string note_;
  std::array<float, kRawSize> row_{};
};

}  // namespace

std::unique_ptr<Reference> make_brute_force() {
  return std::make_unique<BruteForce>();
}

std::unique_ptr<Reference> make_nanoflann_raw() {
  return std::make_unique<NanoflannRaw>();
}

std::unique_ptr<Reference> make_nanoflann_pca() {
  return std::make_unique<NanoflannPca>();
}

}  // namespace im2fit::bench
