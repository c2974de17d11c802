// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/board.h"

namespace im2fit::apps {

void Board::publish(const std::string& kind, std::string message) {
  {
    const std::lock_guard lock(mutex_);
    messages_[kind] = {++published_, std::move(message)};
  }
  news_.notify_all();
}

std::string Board::wait(std::uint64_t& seen, std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  news_.wait_for(lock, patience, [&] { return closed_ || published_ > seen; });
  if (closed_) return "";
  std::map<std::uint64_t, const std::string*> fresh;
  for (const auto& [kind, message] : messages_)
    if (message.first > seen) fresh[message.first] = &message.second;
  std::string text;
  for (const auto& [number, message] : fresh) text += "data: " + *message + "\n\n";
  seen = published_;
  return text;
}

std::uint64_t Board::await(std::uint64_t known, std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  news_.wait_for(lock, patience, [&] { return closed_ || published_ > known; });
  return published_;
}

void Board::put(const std::string& path, PageFile file) {
  auto held = std::make_shared<const PageFile>(std::move(file));
  const std::lock_guard lock(mutex_);
  files_[path] = std::move(held);
}

void Board::withdraw(std::initializer_list<const char*> kinds, std::initializer_list<const char*> paths) {
  const std::lock_guard lock(mutex_);
  for (const char* kind : kinds) messages_.erase(kind);
  for (const char* path : paths) files_.erase(path);
}

std::shared_ptr<const PageFile> Board::file(const std::string& path) const {
  const std::lock_guard lock(mutex_);
  const auto found = files_.find(path);
  return found == files_.end() ? nullptr : found->second;
}

void Board::close() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
  }
  news_.notify_all();
}

bool Board::closed() const {
  const std::lock_guard lock(mutex_);
  return closed_;
}

}  // namespace im2fit::apps
