#include "base/rehearsal.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <stdexcept>
#include <vector>

#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

using testing::HasSubstr;

std::string refusal(const std::function<void()>& work) {
  try {
    rehearse("/dev/null", work);
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(Rehearsal, LetsPassWhatComesToItsEnd) {
  int done = 0;
  EXPECT_EQ(refusal([&] { done = 1; }), "none");
  EXPECT_EQ(done, 0) << "the caller's memory is its own";
  EXPECT_EQ(refusal([] { throw std::runtime_error("thrown again by the caller"); }), "none");
}

TEST(Rehearsal, HandsOnWhatIsRefused) {
  try {
    rehearse("/dev/null", [] { throw InputError({{{"a.h5", 3, 7}, "wrong"}, {{}, "bad\ntoo"}}); });
    FAIL() << "nothing thrown";
  } catch (const InputError& error) {
    ASSERT_EQ(error.diagnostics().size(), 2u);
    EXPECT_EQ(error.diagnostics()[0].mark.file, "a.h5");
    EXPECT_EQ(error.diagnostics()[0].mark.line, 3);
    EXPECT_EQ(error.diagnostics()[0].mark.column, 7);
    EXPECT_EQ(error.diagnostics()[1].message, "bad\ntoo");
  }
}

TEST(Rehearsal, RefusesWhatCrashesOrTakesAllMemory) {
  EXPECT_THAT(refusal([] { std::abort(); }),
              HasSubstr("/dev/null: is damaged: it cannot be read to its end"));
  EXPECT_THAT(refusal([] {
                std::vector<std::vector<char>> all;
                for (;;) all.emplace_back(100'000'000, 'x');
              }),
              HasSubstr("needs more memory"));
}

}  // namespace
}  // namespace mimbre
