// SPDX-License-Identifier: Apache-2.0
#include "base/container.h"

#include <gtest/gtest.h>

#include <string>

#include "base/crc32c.h"

namespace im2fit {
namespace {

std::vector<std::byte> two_sections() {
  ContainerWriter writer("I2TS", 3);
  const std::vector<int> numbers = {1, 2, 3};
  writer.add_array<int>("numbers", numbers);
  writer.add("empty", {});
  return writer.finish();
}

TEST(Crc32c, MatchesTheRfc3720CheckValue) {
  const std::string text = "123456789";
  EXPECT_EQ(crc32c(std::as_bytes(std::span(text))), 0xE3069283U);
  const std::vector<std::byte> zeros(32);  // RFC 3720 B.4
  EXPECT_EQ(crc32c(zeros), 0x8A9136AAU);
}

TEST(Container, GivesBackWhatWasPutIn) {
  const auto bytes = two_sections();
  const auto reader = ContainerReader::parse(bytes, "I2TS", 3, "test");
  ASSERT_TRUE(reader) << reader.error().message;
  const auto numbers = reader->array<int>("numbers", 3);
  ASSERT_TRUE(numbers);
  EXPECT_EQ((*numbers)[2], 3);
  EXPECT_TRUE(reader->section("empty")->empty());
  EXPECT_FALSE(reader->section("absent"));
  EXPECT_FALSE(reader->array<int>("numbers", 4));
}

TEST(Container, EveryTruncationIsRefused) {
  const auto bytes = two_sections();
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(ContainerReader::parse(std::span(bytes).first(size), "I2TS", 3, "test")) << size;
}

TEST(Container, EveryFlippedByteThatMattersIsRefused) {
  const auto good = two_sections();
  const auto reader = ContainerReader::parse(good, "I2TS", 3, "test");
  const auto section = reader->section("numbers");
  const auto begin = static_cast<std::size_t>(section->data() - good.data());
  for (std::size_t i = 0; i < good.size(); ++i) {
    const bool matters = i < 28 || (i >= 32 && i < 32 + 80) || (i >= begin && i < begin + section->size());
    auto bad = good;
    bad[i] ^= std::byte{0x10};
    if (matters) {
      EXPECT_FALSE(ContainerReader::parse(bad, "I2TS", 3, "test")) << i;
    }
  }
}

TEST(Container, ErrorsNameTheFileAndTheSection) {
  auto bytes = two_sections();
  const auto reader = ContainerReader::parse(bytes, "I2TS", 3, "bodies.i2f");
  bytes[static_cast<std::size_t>(reader->section("numbers")->data() - bytes.data())] ^= std::byte{1};
  const auto damaged = ContainerReader::parse(bytes, "I2TS", 3, "bodies.i2f");
  ASSERT_FALSE(damaged);
  EXPECT_NE(damaged.error().message.find("bodies.i2f"), std::string::npos);
  EXPECT_NE(damaged.error().message.find("numbers"), std::string::npos);
}

}  // namespace
}  // namespace im2fit
