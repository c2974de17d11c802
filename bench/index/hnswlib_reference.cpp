// SPDX-License-Identifier: Apache-2.0
#include <hnswlib/hnswlib.h>

#include <chrono>
#include <thread>

#include "bench/index/reference.h"
#include "bench/index/search_alone.h"

namespace im2fit::bench {
namespace {

constexpr std::size_t kLinks = 16, kEffortBuilding = 100, kEffort = 64;
constexpr std::size_t kBlockRows = 4096, kThreads = 2;

// Of the level everyone is on; the levels above add a link list to one model in sixteen.
double bytes_of(const hnswlib::HierarchicalNSW<float>& graph, std::size_t size) {
  const auto links = static_cast<double>(graph.size_links_per_element_) / static_cast<double>(kLinks - 1);
  return static_cast<double>(size) * (static_cast<double>(graph.size_data_per_element_) + links);
}

class Hnswlib : public Reference {
 public:
  std::string name() const override { return "hnswlib M16 ef64"; }
  double build(const Models& models) override {
    size_ = models.size();
    const auto start = std::chrono::steady_clock::now();
    graph_ = std::make_unique<hnswlib::HierarchicalNSW<float>>(&space_, size_, kLinks, kEffortBuilding);
    graph_->setEf(kEffort);
    const double making = models.each_block(kBlockRows, [&](std::size_t first, std::span<const float> block) {
      const auto add = [&](std::size_t part) {
        for (std::size_t k = part; k * kRawSize < block.size(); k += kThreads)
          graph_->addPoint(&block[k * kRawSize], first + k);
      };
      std::thread other(add, 1);
      add(0);
      other.join();
    });
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() - making;
  }
  Reply ask(const Question& question) override {
    const auto found = graph_->searchKnn(question.raw.data(), 1);
    return {static_cast<std::uint32_t>(found.top().second), {}, {}};
  }
  double bytes() const override { return bytes_of(*graph_, size_); }

 private:
  std::size_t size_ = 0;
  hnswlib::L2Space space_{kRawSize};
  std::unique_ptr<hnswlib::HierarchicalNSW<float>> graph_;
};

class HnswlibPlaces : public PlaceSearch {
 public:
  std::string name() const override { return "hnswlib M16 ef64, float"; }
  void build(std::vector<float> places, std::size_t dimensions) override {
    size_ = places.size() / dimensions;
    space_ = std::make_unique<hnswlib::L2Space>(dimensions);
    graph_ = std::make_unique<hnswlib::HierarchicalNSW<float>>(space_.get(), size_, kLinks, kEffortBuilding);
    graph_->setEf(kEffort);
    const auto add = [&](std::size_t part) {
      for (std::size_t n = part; n < size_; n += kThreads) graph_->addPoint(&places[n * dimensions], n);
    };
    std::thread other(add, 1);
    add(0);
    other.join();
  }
  void find(const float* place, std::span<std::uint32_t> nearest) override {
    auto found = graph_->searchKnn(place, nearest.size());
    for (std::size_t k = nearest.size(); k > 0; found.pop())
      nearest[--k] = static_cast<std::uint32_t>(found.top().second);
  }
  double bytes() const override { return bytes_of(*graph_, size_); }

 private:
  std::size_t size_ = 0;
  std::unique_ptr<hnswlib::L2Space> space_;
  std::unique_ptr<hnswlib::HierarchicalNSW<float>> graph_;
};

}  // namespace

std::unique_ptr<PlaceSearch> make_hnswlib_places() {
  return std::make_unique<HnswlibPlaces>();
}

std::unique_ptr<Reference> make_hnswlib() {
  return std::make_unique<Hnswlib>();
}

}  // namespace im2fit::bench
