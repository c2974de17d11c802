// SPDX-License-Identifier: Apache-2.0
// The cells' surfaces, a wall's votes, the floor's equations, and the segmentation of one whole frame.
#include "bench/kernels/cases.h"
#include "bench/kernels/room_picture.h"
#include "kernels/components/links.h"
#include "kernels/floor_sums/floor_sums.h"
#include "kernels/sample/sample.h"
#include "perception/segment/segment.h"
#include "perception/segment/wall.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::bench {
namespace {

constexpr int kStep = 4, kWidth = 160, kHeight = 120, kCells = kWidth * kHeight;

struct CellData {
  std::shared_ptr<const RoomPicture> room = room_picture(640, 480);
  std::vector<std::uint16_t> depth = std::vector<std::uint16_t>(kCells), limit = depth;
  std::vector<std::uint8_t> links = std::vector<std::uint8_t>(kCells);
  CellData() {
    sample(room->view(), kStep, depth.data());
    for (std::size_t i = 0; i < kCells; ++i) limit[i] = depth[i] != 0 ? 60 : 0;
  }
};

void add_links(Cases& cases) {
  const auto data = std::make_shared<CellData>();
  const Floor floor = {kCells * 5 / 2.5e3 / 4, "six neighbours of 16 cells: 40 vector operations at two a cycle"};
  add_variants(cases, "segment.links/160x120", kLinksWithRef, kCells, "cell", floor, true, [&](auto* function) {
    return [data, function] {
      function({data->depth.data(), data->depth.data(), data->limit.data(), kWidth, kHeight}, data->links.data());
      keep(data->links[0]);
    };
  });
}

void add_votes(Cases& cases) {
  constexpr int kPoints = 400;
  struct Data {
    std::vector<float> x, y, z, near, far;
  };
  const auto data = std::make_shared<Data>();
  Rng rng(1);
  for (int i = 0; i < kPoints; ++i) {
    data->x.push_back(static_cast<float>(rng.uniform(-0.5, 0.5)));
    data->y.push_back(static_cast<float>(rng.uniform(-0.4, 0.4)));
    data->z.push_back(static_cast<float>(rng.uniform(2300, 3600)));
    data->near.push_back(50);
    data->far.push_back(60);
  }
  // A vector division of 8 floats every 5 cycles bounds it on most x86 cores.
  const Floor floor = {kPoints / 8.0 * 5 / 2.5e3, "one division of 8 every 5 cycles"};
  add_plain(cases, "segment.votes/400", kPoints, "point", floor, [data] {
    const float q[3] = {0, 0, -1.0F / 3500};
    keep(segment::count_votes(
        {data->x.data(), data->y.data(), data->z.data(), data->near.data(), data->far.data(), kPoints}, q));
  });
}

void add_floor_sums(Cases& cases) {
  struct Data {
    std::shared_ptr<const RoomPicture> room = room_picture(640, 480);
    std::vector<float> ray_x, ray_y, row_up;
    std::vector<FloorCell> cells;
    FloorGate gate() const { return {0, 1000, 12, 0.0023F, ray_x.data(), ray_y.data(), row_up.data()}; }
  };
  const auto data = std::make_shared<Data>();
  const Intrinsics& k = data->room->intrinsics;
  for (int u = 0; u < 640; ++u) data->ray_x.push_back((static_cast<float>(u) - k.cx) / k.fx);
  for (int v = 0; v < 480; ++v) {
    data->ray_y.push_back((static_cast<float>(v) - k.cy) / k.fy);
    data->row_up.push_back(-data->ray_y.back());
  }
  // The lower rows show the floor; near the feet every pixel counts.
  for (int r = 105; r < kHeight; ++r)
    for (int c = 0; c < kWidth; ++c)
      data->cells.push_back({static_cast<std::uint16_t>(4 * c), static_cast<std::uint16_t>(4 * r),
                             static_cast<std::uint16_t>(c > 50 && c < 110 ? 1 : 2), 1.0F});
  const auto count = static_cast<double>(data->cells.size());
  const Floor floor = {count * 4 * 4 / 2.5e3, "four rows a cell, each waiting 4 cycles for the last sum of doubles"};
  add_variants(cases, "segment.floor_sums/2400", kFloorSumsWithRef, count, "cell", floor, true, [&](auto* function) {
    return [data, function] {
      PlaneSums out;
      function(data->room->view(), 4, data->gate(), data->cells.data(), static_cast<int>(data->cells.size()), out);
      keep(out);
    };
  });
}

void add_frame(Cases& cases) {
  struct Data {
    std::shared_ptr<const RoomPicture> room = room_picture(640, 480);
    Segmenter segmenter{640, 480};
    PersonTracker people;
    std::vector<std::uint8_t> mask = std::vector<std::uint8_t>(room->depth.size());
  };
  const auto data = std::make_shared<Data>();
  Case whole;
  whole.kernel = "segment/640x480";
  whole.variant = "best";
  whole.items = 640.0 * 480;
  whole.item = "px";
  whole.floor = {640 * 480 * 4 / 11.6e3, "depth read and mask written, twice each, at 11.6 GB/s"};
  whole.run = [data] {
    const Person p =
        data->segmenter.run(data->room->view(), data->room->intrinsics, data->people, {data->mask.data(), 640, 480});
    keep(p);
  };
  cases.push_back(whole);
}

}  // namespace

void add_segment_cases(Cases& cases) {
  add_links(cases);
  add_votes(cases);
  add_floor_sums(cases);
  add_frame(cases);
}

}  // namespace im2fit::bench
