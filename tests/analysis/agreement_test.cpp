#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <limits>

#include "mimbre/verify.h"

namespace mimbre::agreement_test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Channel {
  std::string name, unit;
  std::function<double(double)> value;
};

/// The channels over 0..10 s, 101 instants.
Series series(const std::vector<Channel>& channels) {
  Series s;
  for (const Channel& c : channels) s.info.push_back({c.name, c.unit, ""});
  for (int k = 0; k <= 100; ++k) {
    s.time.push_back(0.1 * k);
    s.channels.emplace_back(static_cast<Eigen::Index>(channels.size()));
    for (std::size_t c = 0; c < channels.size(); ++c)
      s.channels.back()[static_cast<Eigen::Index>(c)] = channels[c].value(s.time.back());
  }
  return s;
}

Series sine(double amplitude, double error) {
  return series(
      {{"x", "m", [=](double t) { return amplitude * std::sin(t) + (t > 4.95 && t < 5.05 ? error : 0); }}});
}

/// A pair of runs that differ by `error` at t = 5 s.
std::vector<Apart> pair(double error) { return differences(sine(1, 0), sine(1, error)); }

TEST(VerifySeries, FindsTheLargestDifferenceAndItsTime) {
  const auto d = differences(sine(2, 0), sine(2, 0.25));
  ASSERT_EQ(d.size(), 1u);
  EXPECT_EQ(d[0].name, "x");
  EXPECT_EQ(d[0].unit, "m");
  EXPECT_DOUBLE_EQ(d[0].max_difference, 0.25);
  EXPECT_NEAR(d[0].time, 5, 1e-12);
  EXPECT_NEAR(d[0].range, 4, 0.3);
  EXPECT_DOUBLE_EQ(d[0].relative_difference, 0.25 / d[0].range);
}

TEST(VerifySeries, TheSameDiffersNowhere) {
  const auto constant = series({{"x", "m", [](double) { return 0.0; }}});
  const auto d = differences(constant, constant);
  EXPECT_EQ(d[0].max_difference, 0);
  EXPECT_EQ(d[0].relative_difference, 0);
  EXPECT_THAT(verdict(agreement(d, d)), HasSubstr("same numbers"));
}

TEST(VerifySeries, TheRootMeanSquareIsOverAllInstants) {
  const auto d = differences(sine(2, 0), sine(2, 0.25));
  EXPECT_DOUBLE_EQ(d[0].rms_difference, 0.25 / std::sqrt(101));
}

TEST(VerifySeries, ChannelsAreMatchedByNameAndTheIntegrationsOwnAreLeftOut) {
  const auto one = [](double) { return 1.0; };
  const auto two = [](double) { return 2.0; };
  const Series a = series({{"only.a", "m", one},
                           {"solver.iterations", "1", one},
                           {"energy.numerical", "J", one},
                           {"x", "m", one},
                           {"y", "m", two}});
  const Series b = series(
      {{"y", "m", two}, {"x", "m", one}, {"solver.iterations", "1", two}, {"energy.numerical", "J", two}});
  const auto d = differences(a, b);
  ASSERT_EQ(d.size(), 2u);
  EXPECT_EQ(d[0].name, "x");
  EXPECT_EQ(d[1].name, "y");
  EXPECT_EQ(d[0].max_difference, 0);
  EXPECT_EQ(d[1].max_difference, 0);
}

TEST(VerifySeries, RoundOffOfAChannelThatHardlyMovesIsNoDisagreement) {
  const auto noisy = [](double noise) {
    return series({{"forward", "m", [](double t) { return t; }},
                   {"sideways", "m", [=](double t) { return noise * std::sin(77 * t); }},
                   {"far", "rad", [=](double t) { return 1000 + noise * std::sin(55 * t); }}});
  };
  const auto d = differences(noisy(1e-9), noisy(-2e-9));
  EXPECT_LT(d[1].relative_difference, 1e-5);
  EXPECT_LT(d[2].relative_difference, 1e-5);
  EXPECT_TRUE(agreement(d, {}).agree);
  // In a unit of its own, with nothing beside it, a channel counts by what it does.
  const auto alone = differences(sine(1e-9, 0), sine(1e-9, 1e-9));
  EXPECT_NEAR(alone[0].relative_difference, 0.5, 0.05);
}

TEST(VerifySeries, WhatIsNotANumberIsTheWorst) {
  const auto broken = series(
      {{"x", "m", [](double t) { return t > 6.95 ? nan : t; }}, {"y", "m", [](double t) { return t; }}});
  const auto sound =
      series({{"x", "m", [](double t) { return t; }}, {"y", "m", [](double t) { return -t; }}});
  const auto d = differences(sound, broken);
  EXPECT_TRUE(std::isnan(d[0].max_difference));
  EXPECT_NEAR(d[0].time, 7, 1e-12);
  EXPECT_NEAR(d[0].range, 10, 1e-12);
  const Agreement both = agreement(d, d);
  EXPECT_FALSE(both.agree);
  EXPECT_EQ(both.channels[0].whole.name, "x");
  EXPECT_FALSE(both.channels[0].ratio());
  EXPECT_FALSE(both.ratio);
  EXPECT_THAT(verdict(both), HasSubstr("no number for 'x' at t = 7 s"));
  // Where neither is a number they agree.
  EXPECT_EQ(differences(broken, broken)[0].max_difference, 0);
}

TEST(VerifySeries, ASmallDifferenceAgreesWithoutHalfTheStep) {
  const Agreement a = agreement(pair(0.001), {});
  EXPECT_TRUE(a.agree);
  EXPECT_FALSE(a.ratio);
  EXPECT_THAT(verdict(a),
              HasSubstr("agree to 0.05 % of the range; the worst channel is 'x', 0.001 m at t = 5 s."));
  const Agreement b = agreement(pair(0.1), {});
  EXPECT_FALSE(b.agree);
  EXPECT_THAT(verdict(b), HasSubstr("disagree by 5 % of the range ('x', 0.1 m at t = 5 s)"));
  EXPECT_THAT(verdict(b), HasSubstr("not known whether"));
}

TEST(VerifySeries, TwoMethodsOfSecondOrderComeFourTimesNearer) {
  const Agreement small = agreement(pair(0.004), pair(0.001));
  EXPECT_TRUE(small.agree);
  ASSERT_TRUE(small.ratio);
  EXPECT_NEAR(*small.ratio, 4, 1e-9);
  EXPECT_NEAR(*small.channels[0].ratio(), 4, 1e-9);
  EXPECT_THAT(verdict(small),
              HasSubstr("4 times smaller (second order: 4 times): both solve the same equations"));
  // A large difference that falls is a matter of the step.
  const Agreement large = agreement(pair(0.4), pair(0.1));
  EXPECT_TRUE(large.agree);
  EXPECT_THAT(verdict(large),
              HasSubstr("come together as the step gets shorter: half of it leaves 5 % of the range"));
}

TEST(VerifySeries, ADifferenceThatStaysIsADisagreement) {
  const Agreement a = agreement(pair(0.1), pair(0.095));
  EXPECT_FALSE(a.agree);
  EXPECT_THAT(verdict(a), HasSubstr("disagree by 4.8 % of the range with half the step"));
  EXPECT_THAT(verdict(a), HasSubstr("only 1.05 times smaller"));
  EXPECT_THAT(verdict(agreement(pair(0.1), pair(0.2))), HasSubstr("2 times larger"));
  // A small one that stays agrees, but is not called a proof.
  const Agreement b = agreement(pair(0.001), pair(0.001));
  EXPECT_TRUE(b.agree);
  EXPECT_THAT(verdict(b), HasSubstr("and not 4 times"));
  EXPECT_THAT(verdict(b), Not(HasSubstr("same equations")));
}

TEST(VerifySeries, APeakThatOnlyShiftsIsNoDisagreement) {
  // One instant stays apart, all others come nearer.
  const auto pair_of = [](double everywhere, double peak) {
    const auto x = [](double t) { return std::sin(t); };
    const auto shifted = [=](double t) { return x(t) + (t > 4.95 && t < 5.05 ? peak : everywhere); };
    return differences(series({{"x", "m", x}}), series({{"x", "m", shifted}}));
  };
  EXPECT_TRUE(agreement(pair_of(0.08, 0.1), pair_of(0.02, 0.09)).agree);
  EXPECT_FALSE(agreement(pair_of(0.08, 0.1), pair_of(0.07, 0.09)).agree);
}

TEST(VerifySeries, RoundOffHasNoOrder) {
  const Agreement a = agreement(pair(1e-13), pair(1e-13));
  EXPECT_TRUE(a.agree);
  EXPECT_FALSE(a.ratio);
  EXPECT_THAT(verdict(a), HasSubstr("round-off"));
}

TEST(VerifySeries, TheWorstAtTheFinestStepComesFirst) {
  const auto of = [](double x, double y) {
    const auto zero = [](double t) { return std::sin(t); };
    return differences(series({{"x", "m", zero}, {"y", "m", zero}}),
                       series({{"x", "m", [=](double t) { return std::sin(t) + x; }},
                               {"y", "m", [=](double t) { return std::sin(t) + y; }}}));
  };
  const Agreement a = agreement(of(0.01, 0.004), of(0.001, 0.002));
  EXPECT_EQ(a.channels[0].whole.name, "y");
  // The ratio is that of the root mean squares of all.
  EXPECT_NEAR(*a.ratio, std::hypot(0.01, 0.004) / std::hypot(0.001, 0.002), 0.05);
}

/// Both formulations alike, and their own change from the step to its half and to its quarter, over all
/// instants.
Agreement alike(double change, double next) {
  const auto of = [](double apart) {
    return differences(series({{"x", "m", [](double t) { return std::sin(t); }}}),
                       series({{"x", "m", [=](double t) { return std::sin(t) + apart * std::sin(3 * t); }}}));
  };
  Comparison c;
  c.whole = c.half = c.quarter = of(0);
  c.step = {of(change), of(change)};
  c.half_step = {of(next), of(next)};
  return agreement(c);
}

TEST(VerifySeries, WhatAShorterStepChangesIsNotAgreedUpon) {
  EXPECT_TRUE(alike(0.01, 0.01).agree);
  EXPECT_TRUE(alike(0.2, 0.05).agree);
  EXPECT_FALSE(alike(0.2, 0.19).agree);
  // Another branch, on which only the longest step is.
  EXPECT_FALSE(alike(1.5, 0.001).agree);
  EXPECT_FALSE(alike(0.4, 0.001).agree);
  EXPECT_THAT(verdict(alike(0.2, 0.19)), HasSubstr("half of it changes 'x'"));
}

TEST(VerifySeries, WhatIsConstantIsMeasuredByItsValueWhereZeroMeansSomething) {
  const auto constant = [](double error) {
    return series({{"energy.kinetic", "J", [=](double t) { return 7 + error * t; }},
                   {"force", "N", [=](double) { return 500.0; }},
                   {"idle", "N", [=](double t) { return error * std::sin(t); }},
                   {"height", "m", [=](double t) { return 7 + error * t; }}});
  };
  const auto d = differences(constant(0), constant(4e-5));
  EXPECT_LT(d[0].relative_difference, 1e-2);
  EXPECT_LT(d[2].relative_difference, 1e-3);
  EXPECT_NEAR(d[3].relative_difference, 1, 1e-9);
  // A force that is off by a tenth of itself is off.
  EXPECT_GT(differences(constant(0), constant(10))[2].relative_difference, 0.5);
}

TEST(VerifySeries, AtRestWhatTheIterationsLeaveIsNoDisagreement) {
  const auto rest = [](double noise) {
    Series s = series({{"v", "m/s", [=](double t) { return noise * std::sin(9 * t); }}});
    s.step = 0.01;
    return s;
  };
  EXPECT_TRUE(agreement(differences(rest(1e-8), rest(-1e-8)), {}).agree);
  EXPECT_FALSE(agreement(differences(rest(1e-5), rest(-1e-5)), {}).agree);
}

/// Where nothing moves, what the start leaves in lengths, angles and quaternions is no disagreement; a tenth
/// of a millionth of the mechanism is one.
TEST(VerifySeries, WhatTheStartLeavesIsNoDisagreement) {
  const auto still = [](double by) {
    Series s = series({{"x", "m", [=](double) { return 2 + 2 * by; }},
                       {"angle", "rad", [=](double) { return by; }},
                       {"rotation.y", "1", [=](double) { return by; }}});
    s.info[2].alike = ChannelInfo::Alike::sign;
    s.length = 2;
    return s;
  };
  EXPECT_TRUE(agreement(differences(still(0), still(5e-10)), {}).agree);
  const Agreement apart = agreement(differences(still(0), still(1e-7)), {});
  for (const Refined& channel : apart.channels) EXPECT_FALSE(channel.agrees()) << channel.whole.name;
  // What moves by more is measured by that.
  const auto moves = [](double by) {
    Series s = series({{"x", "m", [=](double t) { return 1e-6 * (1 + by) * std::sin(t); }}});
    s.length = 2;
    return s;
  };
  EXPECT_FALSE(agreement(differences(moves(0), moves(0.1)), {}).agree);
}

/// Quaternions count as the angles do that move beside them.
TEST(VerifySeries, RoundOffOfAQuaternionIsNoDisagreement) {
  const auto turning = [](double noise) {
    Series s = series({{"angle", "rad", [](double t) { return t; }},
                       {"rotation.y", "1", [=](double t) { return noise * std::sin(77 * t); }}});
    s.info[1].alike = ChannelInfo::Alike::sign;
    return s;
  };
  EXPECT_TRUE(agreement(differences(turning(1e-9), turning(-2e-9)), {}).agree);
  EXPECT_FALSE(agreement(differences(turning(1e-2), turning(-2e-2)), {}).agree);
}

/// A body that does not turn: of its quaternion only w is not round-off.
TEST(VerifySeries, OfABodyThatDoesNotTurnTheQuaternionAgrees) {
  const auto upright = [](double noise) {
    Series s = series({{"joint.a.rotation.w", "1", [](double) { return 1; }},
                       {"joint.a.rotation.z", "1", [=](double t) { return noise * std::sin(9 * t); }}});
    for (ChannelInfo& info : s.info) info.alike = ChannelInfo::Alike::sign;
    s.step = 0.005;
    return s;
  };
  EXPECT_TRUE(agreement(differences(upright(5e-19), upright(-9e-19)), {}).agree);
  EXPECT_FALSE(agreement(differences(upright(1e-3), upright(-3e-3)), {}).agree);
}

TEST(VerifySeries, EachThatDisagreesIsNamed) {
  const auto of = [](double x, double y) {
    const auto zero = [](double t) { return std::sin(t); };
    return differences(series({{"x", "m", zero}, {"y", "m", zero}, {"z", "m", zero}}),
                       series({{"x", "m", [=](double t) { return std::sin(t) + x; }},
                               {"y", "m", [=](double t) { return std::sin(t) + y; }},
                               {"z", "m", zero}}));
  };
  const Agreement a = agreement(of(0.5, 0.3), of(0.5, 0.3));
  EXPECT_THAT(verdict(a), HasSubstr("2 channels do not agree: 'x', 'y'."));
  EXPECT_FALSE(a.channels[1].agrees());
  EXPECT_TRUE(a.channels[2].agrees());
}

TEST(VerifySeries, NoChannelIsNoDisagreement) {
  const Agreement none = agreement({}, {});
  EXPECT_TRUE(none.agree);
  EXPECT_THAT(verdict(none), HasSubstr("no channel"));
}

}  // namespace
}  // namespace mimbre::agreement_test
