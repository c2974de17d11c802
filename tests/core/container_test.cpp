// SPDX-License-Identifier: Apache-2.0
#include "core/container.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>

#include "core/crc32c.h"

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

TEST(Crc32c, GoesOnFromASumBefore) {
  const std::string text = "123456789";
  const auto bytes = std::as_bytes(std::span(text));
  for (std::size_t part = 0; part <= bytes.size(); ++part)
    EXPECT_EQ(crc32c(bytes.subspan(part), crc32c(bytes.first(part))), 0xE3069283U) << part;
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

// Sections that are checked by page, before and behind others and across pages of the file.
struct Paged {
  std::vector<std::byte> small = std::vector<std::byte>(10, std::byte{7});
  std::vector<std::byte> large = std::vector<std::byte>(9001);
  std::vector<std::byte> file;
  Paged() {
    for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<std::byte>(i * i % 251);
    ContainerWriter writer("I2TS", 3);
    writer.add("before", {100, std::byte{1}});
    writer.add("small", small, Checked::by_page);
    writer.add("large", large, Checked::by_page);
    writer.add("none", {}, Checked::by_page);
    writer.add("behind", {100, std::byte{2}});
    file = writer.finish();
  }
  std::size_t begin_of(const char* name) const {
    return static_cast<std::size_t>(ContainerReader::parse(file, "I2TS", 3, "test")->entries().at(name).offset);
  }
};

TEST(PagedSection, GivesBackWhatWasPutIn) {
  const Paged p;
  const auto reader = ContainerReader::parse(p.file, "I2TS", 3, "test");
  ASSERT_TRUE(reader) << reader.error().message;
  const auto pages = reader->paged("large");
  ASSERT_TRUE(pages);
  EXPECT_TRUE(std::equal(p.large.begin(), p.large.end(), pages->bytes().begin(), pages->bytes().end()));
  EXPECT_EQ(pages->pages_seen(), 0U);
  EXPECT_TRUE(pages->intact({p.large.size() - 1, 1}));
  EXPECT_EQ(pages->pages_seen(), 1U);
  const PagedBytes copy = *pages;
  EXPECT_TRUE(copy.intact({0, p.large.size()}));
  const std::size_t begin = p.begin_of("large");
  EXPECT_EQ(pages->pages_seen(), (begin + p.large.size() - 1) / 4096 - begin / 4096 + 1) << "copies share";
  EXPECT_TRUE(reader->paged("none")->intact({0, 0}));
  EXPECT_TRUE(reader->section("large"));
  EXPECT_EQ(reader->section("small")->size(), p.small.size());
  EXPECT_FALSE(reader->paged("absent"));
}

// A flipped byte spoils its own page and no other.
TEST(PagedSection, EveryFlippedByteIsFoundWhereItIsRead) {
  const Paged p;
  const std::size_t begin = p.begin_of("large");
  for (std::size_t at = 0; at < p.large.size(); at += 13) {
    auto bad = p.file;
    bad[begin + at] ^= std::byte{0x20};
    const auto reader = ContainerReader::parse(bad, "I2TS", 3, "bodies.i2f");
    ASSERT_TRUE(reader) << "what is checked by page does not keep a file from being opened";
    EXPECT_FALSE(reader->section("large"));
    const auto pages = reader->paged("large");
    for (std::size_t read = 0; read < p.large.size(); read += 97)
      ASSERT_EQ(pages->intact({read, 1}), (begin + read) / 4096 != (begin + at) / 4096) << at << ", read " << read;
    EXPECT_FALSE(pages->intact({0, p.large.size()}));
    const auto all = pages->check_all();
    ASSERT_FALSE(all);
    EXPECT_EQ(all.error().code, ErrorCode::corrupt);
    for (const char* expected : {"bodies.i2f", "'large'"})
      EXPECT_NE(all.error().message.find(expected), std::string::npos) << all.error().message;
    EXPECT_TRUE(reader->section("small"));
  }
}

TEST(PagedSection, ADamagedOrCutListIsRefused) {
  const Paged p;
  const auto end = (p.begin_of("large") + p.large.size() + 63) / 64 * 64;
  for (std::size_t at = end; at < end + 3 * 4; ++at) {
    auto bad = p.file;
    bad[at] ^= std::byte{1};
    const auto reader = ContainerReader::parse(bad, "I2TS", 3, "test");
    ASSERT_FALSE(reader) << at;
    EXPECT_NE(reader.error().message.find("'large'"), std::string::npos);
  }
  for (std::size_t size = 0; size < p.file.size(); ++size)
    ASSERT_FALSE(ContainerReader::parse(std::span(p.file).first(size), "I2TS", 3, "test")) << size;
}

// Of the third section; behind a right checksum of the table.
TEST(PagedSection, HostileTablesAreRefused) {
  const Paged p;
  constexpr std::size_t kRow = 32 + 2 * 40;
  const auto opens = [&](std::size_t at, auto value) {
    auto bad = p.file;
    std::memcpy(bad.data() + at, &value, sizeof value);
    const std::uint32_t sum = crc32c(std::span(bad).subspan(32, 5 * 40));
    std::memcpy(bad.data() + 24, &sum, sizeof sum);
    return static_cast<bool>(ContainerReader::parse(bad, "I2TS", 3, "test", false));
  };
  ASSERT_TRUE(opens(kRow + 24, std::uint64_t{9001}));
  for (const std::uint32_t page : {1U, 64U, 4095U, 8192U, 0xFFFFFFFFU}) EXPECT_FALSE(opens(kRow + 36, page)) << page;
  const std::uint64_t left = p.file.size() - p.begin_of("large");
  for (const std::uint64_t size : {left, left - 1, left - 63, std::uint64_t{0} - 1, std::uint64_t{1} << 63})
    EXPECT_FALSE(opens(kRow + 24, size)) << size;  // no room for the list
}

TEST(PagedSection, ThreadsAgree) {
  const Paged p;
  auto bad = p.file;
  bad[p.begin_of("large") + 4500] ^= std::byte{1};
  for (int round = 0; round < 20; ++round) {
    const auto reader = ContainerReader::parse(bad, "I2TS", 3, "test");
    const auto pages = reader->paged("large");
    std::atomic<int> wrong{0};
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        for (std::size_t i = 0; i < p.large.size(); i += 7) {
          const std::size_t read = (i + t * 2000) % p.large.size();
          const std::size_t begin = p.begin_of("large");
          if (pages->intact({read, 1}) != ((begin + read) / 4096 != (begin + 4500) / 4096)) ++wrong;
          i += 500;
        }
      });
    for (auto& thread : threads) thread.join();
    ASSERT_EQ(wrong, 0);
  }
}

}  // namespace
}  // namespace im2fit
