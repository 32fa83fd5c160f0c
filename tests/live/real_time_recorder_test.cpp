#include "mimbre/real_time_recorder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <filesystem>

#include "mimbre/results.h"
#include "support/clocked.h"
#include "support/models.h"
#include "support/simulate.h"

namespace mimbre::test::real_time_recorder_test {
namespace {

namespace fs = std::filesystem;

std::string fresh(const std::string& name) {
  const fs::path folder = fs::path(testing::TempDir()) / "real_time_recorder";
  fs::create_directories(folder);
  for (const char* suffix : {"", "-2", "-3"}) fs::remove(folder / (name + suffix + ".h5"));
  return (folder / (name + ".h5")).string();
}

std::vector<float> column(const std::string& file, const std::string& name) {
  const hid_t f = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t data = H5Dopen2(f, name.c_str(), H5P_DEFAULT), space = H5Dget_space(data);
  std::vector<float> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  H5Dread(data, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Sclose(space);
  H5Dclose(data);
  H5Fclose(f);
  return values;
}

TEST(RealTimeRecorder, HasTheRowsOfARunAndTheTimesOfEachStep) {
  const std::string file = fresh("rows");
  Simulation clocked = simulation_of(controlled_four_bar(), Formulation::relative, 0.005),
             plain = simulation_of(controlled_four_bar(), Formulation::relative, 0.005);
  RealTimeLoop loop(clocked, quick_loop());
  RealTimeRecorder recorder(file, clocked, "{}", 0.01);
  loop.add(recorder);
  loop.run();
  recorder.finish(loop, "{}");
  EXPECT_EQ(recorder.lost_rows(), 0);
  const Results results = read_results(file);
  ASSERT_EQ(results.time.size(), 51);
  ResultsRow row;
  for (int k = 0; k <= 50; ++k) {
    plain.sample(row);
    EXPECT_EQ(results.time[k], row.time);
    for (Eigen::Index c = 0; c < row.channels.size(); ++c)
      EXPECT_TRUE(results.channels(k, c) == row.channels[c] || std::isnan(row.channels[c]))
          << results.header.channels[static_cast<std::size_t>(c)].name << " at " << row.time;
    for (int i = 0; i < 2; ++i) plain.step();
  }
  const std::vector<float> computation = column(file, "/realtime/computation"),
                           latency = column(file, "/realtime/latency");
  ASSERT_EQ(computation.size(), 100u);
  ASSERT_EQ(latency.size(), 100u);
  for (const float t : computation) EXPECT_GT(t, 0);
  EXPECT_FLOAT_EQ(*std::max_element(computation.begin(), computation.end()),
                  static_cast<float>(loop.monitor().computation.worst()));
}

TEST(RealTimeRecorder, ATimeThatGoesBackBeginsAnotherFile) {
  const std::string file = fresh("takes");
  Simulation simulation = simulation_of(controlled_four_bar(), Formulation::relative, 0.005);
  RealTimeLoop loop(simulation, quick_loop());
  RealTimeRecorder recorder(file, simulation, "{}", 0);
  struct Back : RealTimePart {
    RealTimeLoop* loop = nullptr;
    int steps = 0;
    void timed(const StepTiming&) override {
      if (++steps == 40) loop->request({RealTimeRequest::Kind::reset});
    }
  } back;
  back.loop = &loop;
  loop.add(recorder);
  loop.add(back);
  loop.run();
  recorder.finish(loop, "{}");
  const std::string second = file.substr(0, file.size() - 3) + "-2.h5";
  EXPECT_EQ(recorder.path(), second);
  EXPECT_EQ(read_results(file).time.size(), 41);
  const Results rest = read_results(second);
  EXPECT_EQ(rest.time.size(), 60);
  EXPECT_DOUBLE_EQ(rest.time[0], 0.005);
}

/// What is recorded after a reset that nobody recorded is another drive, though its time is later.
TEST(RealTimeRecorder, AMoveWhileItIsOffBeginsAnotherFileToo) {
  const std::string file = fresh("moved");
  Simulation simulation = simulation_of(controlled_four_bar(), Formulation::relative, 0.005);
  RealTimeLoop loop(simulation, quick_loop());
  RealTimeRecorder recorder(file, simulation, "{}", 0);
  struct Off : RealTimePart {
    RealTimeLoop* loop = nullptr;
    RealTimeRecorder* recorder = nullptr;
    int steps = 0;
    void timed(const StepTiming&) override {
      ++steps;
      if (steps == 20) recorder->record(false);
      if (steps == 30) loop->request({RealTimeRequest::Kind::reset});
      if (steps == 60) recorder->record(true);
    }
  } off;
  off.loop = &loop;
  off.recorder = &recorder;
  loop.add(recorder);
  loop.add(off);
  loop.run();
  recorder.finish(loop, "{}");
  EXPECT_EQ(read_results(file).time.size(), 21);
  const Results rest = read_results(recorder.path());
  EXPECT_NE(recorder.path(), file);
  EXPECT_EQ(rest.time.size(), 40);
  EXPECT_NEAR(rest.time[0], 31 * 0.005, 1e-9);
}

TEST(RealTimeRecorder, CanBeSwitchedOff) {
  const std::string file = fresh("off");
  Simulation simulation = simulation_of(controlled_four_bar(), Formulation::relative, 0.005);
  RealTimeLoop loop(simulation, quick_loop());
  RealTimeRecorder recorder(file, simulation, "{}", 0);
  recorder.record(false);
  EXPECT_FALSE(recorder.recording());
  loop.add(recorder);
  loop.run();
  recorder.finish(loop, "{}");
  EXPECT_EQ(read_results(file).time.size(), 1);  // where it began
}

TEST(RealTimeRecorder, AFileThatCannotBeWrittenIsToldAtOnce) {
  Simulation simulation = simulation_of(controlled_four_bar(), Formulation::relative, 0.005);
  EXPECT_THROW(RealTimeRecorder("/nowhere/at/all.h5", simulation, "{}", 0), std::runtime_error);
}

}  // namespace
}  // namespace mimbre::test::real_time_recorder_test
