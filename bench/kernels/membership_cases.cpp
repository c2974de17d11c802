// SPDX-License-Identifier: Apache-2.0
// A person's cells and those beside them. Most cells lie inside and one comparison decides their pixels.
#include "bench/kernels/cases.h"
#include "bench/kernels/room_picture.h"
#include "kernels/membership/membership.h"
#include "kernels/sample/sample.h"
#include "tests/kernels/ref/kernel_refs.h"

namespace im2fit::bench {

void add_membership_cases(Cases& cases) {
  constexpr int kStep = 4, kWidth = 160, kHeight = 120, kStride = kWidth + 2;
  struct Data {
    std::shared_ptr<const RoomPicture> room = room_picture(640, 480);
    std::vector<std::uint16_t> person = std::vector<std::uint16_t>(kStride * (kHeight + 2), kNoSurface),
                               other = person;
    std::vector<std::uint32_t> list;
    std::vector<std::uint8_t> mask = std::vector<std::uint8_t>(room->depth.size());
    MembershipCells cells() const {
      return {person.data() + kStride + 1, other.data() + kStride + 1, kStride, kWidth, kHeight, kStep};
    }
  };
  const auto data = std::make_shared<Data>();
  std::vector<std::uint16_t> depth(kWidth * kHeight);
  sample(data->room->view(), kStep, depth.data());
  const auto mine = [&](int c, int r) {
    return c >= 0 && r >= 0 && c < kWidth && r < kHeight &&
           data->room->mask[static_cast<std::size_t>((r * kStep + 2) * 640 + c * kStep + 2)] != 0;
  };
  for (int r = 0; r < kHeight; ++r) {
    for (int c = 0; c < kWidth; ++c) {
      const std::uint16_t z = depth[static_cast<std::size_t>(r * kWidth + c)];
      if (z != 0) (mine(c, r) ? data->person : data->other)[static_cast<std::size_t>((r + 1) * kStride + c + 1)] = z;
      if (mine(c, r) || mine(c - 1, r) || mine(c + 1, r) || mine(c, r - 1) || mine(c, r + 1))
        data->list.push_back(static_cast<std::uint32_t>(r << 16 | c));
    }
  }
  const auto count = static_cast<double>(data->list.size());
  const Floor floor = {count * 20 / 2.5e3,
                       "a cell of 16 pixels: nine cells around read twice and compared, 20 cycles"};
  add_variants(cases, "membership/640x480", kMembershipWithRef, count * 16, "px", floor, true, [&](auto* function) {
    return [data, function] {
      function(data->room->view(), data->cells(), data->list.data(), static_cast<int>(data->list.size()),
               {data->mask.data(), 640, 480});
      keep(data->mask[0]);
    };
  });
}

}  // namespace im2fit::bench
