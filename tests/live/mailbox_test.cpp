#include "live/mailbox.h"

#include <gtest/gtest.h>

#include <array>
#include <thread>

namespace mimbre::live::mailbox_test {
namespace {

TEST(Newest, IsReadOnceAndStays) {
  Newest<int> newest(7);
  bool news = true;
  EXPECT_EQ(newest.read(news), 7);
  EXPECT_FALSE(news);
  newest.place() = 1;
  newest.publish();
  newest.place() = 2;
  newest.publish();
  EXPECT_EQ(newest.read(news), 2);
  EXPECT_TRUE(news);
  EXPECT_EQ(newest.read(news), 2);
  EXPECT_FALSE(news);
}

/// What is read is whole, and never older than what was read before.
TEST(Newest, IsWholeWhileItIsWritten) {
  using Thing = std::array<int, 64>;
  Newest<Thing> newest{Thing{}};
  std::atomic<bool> over{false};
  std::thread writer([&] {
    for (int k = 1; k <= 200'000; ++k) {
      newest.place().fill(k);
      newest.publish();
    }
    over = true;
  });
  int last = 0;
  for (bool ends = false; !ends;) {
    ends = over;
    bool news = false;
    const Thing& thing = newest.read(news);
    for (const int number : thing) ASSERT_EQ(number, thing[0]);
    ASSERT_GE(thing[0], last);
    last = thing[0];
  }
  writer.join();
  EXPECT_EQ(last, 200'000);
}

TEST(Queue, IsFullAndEmpty) {
  Queue<int> queue(2);
  EXPECT_EQ(queue.front(), nullptr);
  EXPECT_TRUE(queue.push(1));
  EXPECT_TRUE(queue.push(2));
  EXPECT_FALSE(queue.push(3));
  EXPECT_EQ(*queue.front(), 1);
  queue.pop();
  EXPECT_TRUE(queue.push(4));
  EXPECT_EQ(*queue.front(), 2);
  queue.pop();
  EXPECT_EQ(*queue.front(), 4);
  queue.pop();
  EXPECT_EQ(queue.front(), nullptr);
}

TEST(Queue, LosesNothingBetweenThreads) {
  constexpr int count = 500'000;
  Queue<int> queue(4096);
  std::thread writer([&] {
    for (int k = 0; k < count;)
      if (queue.push(k))
        ++k;
      else
        std::this_thread::yield();
  });
  for (int wanted = 0; wanted < count;)
    if (const int* const next = queue.front()) {
      ASSERT_EQ(*next, wanted++);
      queue.pop();
    } else {
      std::this_thread::yield();
    }
  writer.join();
}

}  // namespace
}  // namespace mimbre::live::mailbox_test
