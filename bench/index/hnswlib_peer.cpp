// SPDX-License-Identifier: Apache-2.0
#include <hnswlib/hnswlib.h>

#include <chrono>
#include <thread>

#include "bench/index/peer.h"

namespace im2fit::bench {
namespace {

constexpr std::size_t kLinks = 16, kEffortBuilding = 100, kEffort = 64;
constexpr std::size_t kBlockRows = 4096, kThreads = 2;

class Hnswlib : public Peer {
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
  // Of the level everyone is on; the levels above add a link list to one model in sixteen.
  double bytes() const override {
    const auto links = static_cast<double>(graph_->size_links_per_element_) / static_cast<double>(kLinks - 1);
    return static_cast<double>(size_) * (static_cast<double>(graph_->size_data_per_element_) + links);
  }

 private:
  std::size_t size_ = 0;
  hnswlib::L2Space space_{kRawSize};
  std::unique_ptr<hnswlib::HierarchicalNSW<float>> graph_;
};

}  // namespace

std::unique_ptr<Peer> make_hnswlib() {
  return std::make_unique<Hnswlib>();
}

}  // namespace im2fit::bench
