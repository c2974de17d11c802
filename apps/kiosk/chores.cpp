// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/chores.h"

#include <exception>
#include <string>
#include <utility>

namespace im2fit::apps {

void LaterAnswer::give(PageAnswer answer) {
  const std::lock_guard lock(mutex_);
  answer_ = std::move(answer);
}

std::optional<PageAnswer> LaterAnswer::given() const {
  const std::lock_guard lock(mutex_);
  return answer_;
}

Chores::~Chores() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

PageAnswer Chores::run(std::function<PageAnswer()> work) {
  PageAnswer answer;
  const auto later = std::make_shared<LaterAnswer>();
  answer.later = later;
  Chore chore{std::move(work), later};
  std::unique_lock lock(mutex_);
  try {
    if (!thread_.joinable()) thread_ = std::thread([this] { do_all(); });
    waiting_.emplace_back();
  } catch (const std::exception&) {  // no thread is left, or no memory
    lock.unlock();
    do_one(std::move(chore));
    return answer;
  }
  waiting_.back() = std::move(chore);
  lock.unlock();
  changed_.notify_all();
  return answer;
}

void Chores::do_one(Chore chore) {
  PageAnswer answer;
  try {
    answer = chore.work();
  } catch (const std::exception& fault) {  // it would end the program
    answer = {500, nullptr, std::string("this failed: ") + fault.what()};
  }
  chore.work = nullptr;  // with what it holds, before anybody is told
  chore.answer->give(std::move(answer));
}

void Chores::do_all() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    Chore next = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    do_one(std::move(next));
    lock.lock();
  }
}

}  // namespace im2fit::apps
