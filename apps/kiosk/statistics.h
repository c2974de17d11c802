// SPDX-License-Identifier: Apache-2.0
// What a shop may know of its visits without knowing anybody: how many a day, how many of them were measured, and a
// month's sizes and reasons why people were not measured. One CSV file, which is also what the owner exports:
//
//   period,what,name,count
//   2026-11-30,visits,,14
//   2026-11-30,measured,,11
//   2026-11,size,M,5
//   2026-11,not_measured,MOVING,2
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <tuple>

#include "core/status.h"

namespace im2fit::apps {

std::string local_day();  // "2026-11-30"

// Any thread may call anything. `day`: as local_day().
class Statistics {
 public:
  // Goes on with the file's counts; it need not exist. Errors: as read_file; corrupt, with the line; io, when the
  // file cannot be written.
  static Result<std::unique_ptr<Statistics>> open(const std::string& path);
  // The counts of a file's text, as open() but that nothing is read or written yet.
  static Result<std::unique_ptr<Statistics>> parse(const std::string& text, const std::string& path);

  void visit(const std::string& day);
  // `size`: as the chart names it; "": the chart has none.
  void measured(const std::string& day, const std::string& size);
  // `reason`: a guidance code, or LEFT.
  void not_measured(const std::string& day, const std::string& reason);
  std::string csv() const;
  // Writes the file if something was counted since. Error: io; the counts stay, for the next call.
  Status flush();

 private:
  explicit Statistics(std::string path) : path_(std::move(path)) {}
  Status read(const std::string& text);
  void add(std::string period, const char* what, const std::string& name);

  const std::string path_;
  mutable std::mutex mutex_;
  std::map<std::tuple<std::string, std::string, std::string>, std::uint64_t> counts_;  // period, what, name
  bool changed_ = false;
};

}  // namespace im2fit::apps
