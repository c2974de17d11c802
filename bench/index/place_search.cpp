// SPDX-License-Identifier: Apache-2.0
#include <nanoflann.hpp>

#include "bench/index/search_alone.h"

namespace im2fit::bench {
namespace {

struct Places {
  std::vector<float> values;
  std::size_t dimensions = 0;
  std::size_t kdtree_get_point_count() const { return values.size() / dimensions; }
  float kdtree_get_pt(std::size_t point, std::size_t dimension) const {
    return values[point * dimensions + dimension];
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

class NanoflannPlaces : public PlaceSearch {
 public:
  std::string name() const override { return "nanoflann, float"; }
  void build(std::vector<float> places, std::size_t dimensions) override {
    places_ = {std::move(places), dimensions};
    tree_ = std::make_unique<Tree>(static_cast<int>(dimensions), places_,
                                   nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize));
  }
  void find(const float* place, std::span<std::uint32_t> nearest) override {
    distance_.resize(nearest.size());
    tree_->knnSearch(place, nearest.size(), nearest.data(), distance_.data());
  }
  double bytes() const override {
    return 4.0 * static_cast<double>(places_.values.size()) + static_cast<double>(tree_->usedMemory(*tree_));
  }

 private:
  static constexpr std::size_t kLeafSize = 16;
  using Tree =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Places>, Places, -1, std::uint32_t>;
  Places places_;
  std::unique_ptr<Tree> tree_;
  std::vector<float> distance_;
};

}  // namespace

std::unique_ptr<PlaceSearch> make_nanoflann_places() {
  return std::make_unique<NanoflannPlaces>();
}

}  // namespace im2fit::bench
