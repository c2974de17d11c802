// SPDX-License-Identifier: Apache-2.0
#include "apps/kiosk/chores.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <chrono>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace im2fit {
namespace {

using apps::PageAnswer;

PageAnswer wait_for(const PageAnswer& answer) {
  for (int i = 0; i < 2000; ++i) {
    if (auto given = answer.later->given()) return *given;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ADD_FAILURE() << "no answer came";
  return {};
}

TEST(Chores, AnAnswerComesWhenTheWorkIsDone) {
  apps::Chores chores;
  std::promise<void> go;
  const auto held = std::make_shared<int>(1);
  const PageAnswer later = chores.run([&, held, gate = go.get_future().share()]() -> PageAnswer {
    gate.wait();
    return {404, nullptr, "gone"};
  });
  ASSERT_TRUE(later.later);
  EXPECT_FALSE(later.later->given());
  go.set_value();
  const PageAnswer given = wait_for(later);
  EXPECT_EQ(given.status, 404U);
  EXPECT_EQ(given.text, "gone");
  EXPECT_EQ(held.use_count(), 1) << "what the work held is gone before the answer is there";
}

TEST(Chores, WorkIsDoneInOrderAndAllOfIt) {
  std::vector<int> done;
  {
    apps::Chores chores;
    for (int i = 0; i < 20; ++i)
      chores.run([&done, i]() -> PageAnswer {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        done.push_back(i);
        return {};
      });
  }
  ASSERT_EQ(done.size(), 20U);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

TEST(Chores, AFaultIsAnAnswer) {
  apps::Chores chores;
  const PageAnswer failed = chores.run([]() -> PageAnswer { throw std::runtime_error("the disk is full"); });
  EXPECT_EQ(wait_for(failed).status, 500U);
  EXPECT_NE(wait_for(failed).text.find("the disk is full"), std::string::npos);
  EXPECT_EQ(wait_for(chores.run([]() -> PageAnswer { return {200, nullptr, "next"}; })).text, "next");
}

#ifdef __GLIBC__
// A machine out of threads: their stacks are larger here than any memory.
TEST(Chores, WorkIsDoneAlsoWhenNoThreadCanBeMade) {
  pthread_attr_t before, huge;
  ASSERT_EQ(::pthread_getattr_default_np(&before), 0);
  ASSERT_EQ(::pthread_attr_init(&huge), 0);
  ASSERT_EQ(::pthread_attr_setstacksize(&huge, std::size_t{1} << (sizeof(std::size_t) * 8 - 2)), 0);
  apps::Chores chores;
  bool deleted = false;
  const auto work = [&]() -> PageAnswer {
    deleted = true;
    return {200, nullptr, "deleted"};
  };
  const int set = ::pthread_setattr_default_np(&huge);
  const PageAnswer answer = chores.run(work);
  const bool at_once = deleted;
  ASSERT_EQ(::pthread_setattr_default_np(&before), 0);
  ASSERT_EQ(set, 0);
  EXPECT_TRUE(at_once);
  ASSERT_TRUE(answer.later);
  EXPECT_EQ(wait_for(answer).text, "deleted");
  deleted = false;
  EXPECT_EQ(wait_for(chores.run(work)).status, 200U);
  EXPECT_TRUE(deleted) << "threads are there again";
  ::pthread_attr_destroy(&before);
  ::pthread_attr_destroy(&huge);
}
#endif

}  // namespace
}  // namespace im2fit
