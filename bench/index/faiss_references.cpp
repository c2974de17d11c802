// SPDX-License-Identifier: Apache-2.0
#include <faiss/IVFlib.h>
#include <faiss/IndexHNSW.h>
#include <faiss/IndexIVFPQ.h>
#include <faiss/IndexPreTransform.h>
#include <faiss/VectorTransform.h>
#include <faiss/index_factory.h>
#include <omp.h>

#include <algorithm>
#include <chrono>

#include "bench/index/reference.h"

namespace im2fit::bench {
namespace {

constexpr int kBuildThreads = 2;
constexpr std::size_t kBlockRows = 65536;
constexpr std::size_t kTransformed = 64;  // values after PCA or OPQ

std::uint32_t nearest(const faiss::Index& index, std::span<const float> raw) {
  float distance = 0;
  faiss::Index::idx_t found = -1;
  index.search(1, raw.data(), 1, &distance, &found);
  return found < 0 ? 0 : static_cast<std::uint32_t>(found);
}

// FAISS turns fifty times over 65,536 vectors to find a rotation: minutes, for a hundredth of recall.
void shorten_rotation(faiss::Index& index) {
  auto* chain = dynamic_cast<faiss::IndexPreTransform*>(&index);
  if (chain == nullptr) return;
  for (faiss::VectorTransform* step : chain->chain) {
    auto* rotation = dynamic_cast<faiss::OPQMatrix*>(step);
    if (rotation == nullptr) continue;
    rotation->niter = 5;
    rotation->max_train_points = 10'240;
  }
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double add_all(faiss::Index& index, const Models& models) {
  return models.each_block(kBlockRows, [&](std::size_t, std::span<const float> block) {
    index.add(static_cast<faiss::Index::idx_t>(block.size() / kRawSize), block.data());
  });
}

class FaissIvfPq : public Reference {
 public:
  std::string name() const override { return "FAISS IVF-PQ"; }
  std::string note() const override { return note_; }
  double build(const Models& models) override {
    size_ = models.size();
    // np: no annealing of codes for polysemous search, which is not used here.
    // Lists as their makers advise (4 sqrt N and a power of two), PCA instead of a learned rotation where that would
    // take longer than all the rest.
    std::string recipe = "PCA64,IVF64,PQ32np";
    std::size_t lists = 64, probes = 8;
    if (size_ >= 1'000'000) {
      recipe = "PCA64,IVF4096,PQ32np";
      lists = 4096;
      probes = 64;
    } else if (size_ >= 200'000) {
      recipe = "PCA64,IVF1024,PQ32np";
      lists = 1024;
      probes = 32;
    } else if (size_ >= 20'000) {
      recipe = "OPQ32_64,IVF256,PQ32np";
      lists = 256;
      probes = 16;
    }
    note_ = recipe + " np" + std::to_string(probes);
    // Tables of 256 by 2 values: threads would only wait for each other.
    omp_set_num_threads(1);
    const std::vector<float> training = models.some(std::max<std::size_t>(lists * 40, 10'240));
    const auto start = std::chrono::steady_clock::now();
    index_.reset(faiss::index_factory(static_cast<int>(kRawSize), recipe.c_str()));
    shorten_rotation(*index_);
    // It warns of every table that is fitted to fewer than 39 models a code.
    auto* ivf = faiss::ivflib::extract_index_ivf(index_.get());
    ivf->cp.min_points_per_centroid = 1;
    if (auto* pq = dynamic_cast<faiss::IndexIVFPQ*>(ivf)) pq->pq.cp.min_points_per_centroid = 1;
    index_->train(static_cast<faiss::Index::idx_t>(training.size() / kRawSize), training.data());
    omp_set_num_threads(kBuildThreads);
    const double making = add_all(*index_, models);
    const double spent = seconds_since(start) - making;
    ivf->nprobe = probes;
    omp_set_num_threads(1);
    transform_bytes_ = 4.0 * static_cast<double>((kRawSize + lists + 256) * kTransformed);
    return spent;
  }
  Reply ask(const Question& question) override { return {nearest(*index_, question.raw), {}, {}}; }
  double bytes() const override {
    const auto* ivf = faiss::ivflib::extract_index_ivf(index_.get());
    return static_cast<double>(size_) * static_cast<double>(ivf->code_size + sizeof(faiss::Index::idx_t)) +
           transform_bytes_;
  }

 private:
  std::size_t size_ = 0;
  double transform_bytes_ = 0;
  std::string note_;
  std::unique_ptr<faiss::Index> index_;
};

class FaissHnsw : public Reference {
 public:
  std::string name() const override { return "FAISS HNSW32 ef32"; }
  double build(const Models& models) override {
    omp_set_num_threads(kBuildThreads);
    const auto start = std::chrono::steady_clock::now();
    index_ = std::make_unique<faiss::IndexHNSWFlat>(static_cast<int>(kRawSize), 32);
    index_->hnsw.efSearch = 32;
    const double making = add_all(*index_, models);
    const double spent = seconds_since(start) - making;
    omp_set_num_threads(1);
    return spent;
  }
  Reply ask(const Question& question) override { return {nearest(*index_, question.raw), {}, {}}; }
  double bytes() const override {
    const faiss::HNSW& graph = index_->hnsw;
    return static_cast<double>(index_->ntotal) * 4.0 * kRawSize +
           static_cast<double>(graph.neighbors.size() * sizeof(graph.neighbors[0]) +
                               graph.offsets.size() * sizeof(graph.offsets[0]) +
                               graph.levels.size() * sizeof(graph.levels[0]));
  }

 private:
  std::unique_ptr<faiss::IndexHNSWFlat> index_;
};

}  // namespace

std::unique_ptr<Reference> make_faiss_ivf_pq() {
  return std::make_unique<FaissIvfPq>();
}

std::unique_ptr<Reference> make_faiss_hnsw() {
  return std::make_unique<FaissHnsw>();
}

}  // namespace im2fit::bench
