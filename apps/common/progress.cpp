// SPDX-License-Identifier: Apache-2.0
#include "apps/common/progress.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>

namespace im2fit {
namespace {

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string duration(double seconds) {
  const auto whole = std::lround(seconds);
  return whole < 60 ? fmt::format("{} s", whole) : fmt::format("{} min {:02} s", whole / 60, whole % 60);
}

}  // namespace

Progress::Progress(std::string what, std::uint64_t total)
    : what_(std::move(what)), total_(total), terminal_(isatty(STDERR_FILENO) == 1), started_s_(now_s()) {}

Progress::~Progress() {
  if (terminal_ && shown_s_ > 0) fmt::print(stderr, "\r\033[K");
}

void Progress::update(std::uint64_t done, const std::string& note) {
  const double now = now_s();
  if (!terminal_ || (now - shown_s_ < 0.2 && done != total_)) return;
  shown_s_ = now;
  const double elapsed = std::max(1e-3, now - started_s_);
  const double rate = static_cast<double>(done) / elapsed;
  std::string line = total_ > 0 ? fmt::format("{}: {}/{}", what_, done, total_) : fmt::format("{}: {}", what_, done);
  line += fmt::format(", {:.1f}/s", rate);
  if (total_ > done && rate > 0) line += ", " + duration(static_cast<double>(total_ - done) / rate) + " left";
  if (!note.empty()) line += ", " + note;
  fmt::print(stderr, "\r\033[K{}", line);
  std::fflush(stderr);
}

std::function<void(std::uint64_t)> show_progress(const std::string& what, std::uint64_t total) {
  auto progress = std::make_shared<Progress>(what, total);
  return [progress](std::uint64_t done) { progress->update(done); };
}

}  // namespace im2fit
