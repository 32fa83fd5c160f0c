#include "mimbre/results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "base/checksums.h"
#include "mimbre/diagnostics.h"

namespace mimbre::results_test {
namespace {

using testing::HasSubstr;

class Files : public testing::Test {
 protected:
  Files() : folder(std::filesystem::temp_directory_path() / ("mimbre_results_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder);
  }
  ~Files() override { std::filesystem::remove_all(folder); }
  std::string at(const std::string& name) const { return (folder / name).string(); }
  /// Of all files in the folder.
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      result.push_back(entry.path().filename().string());
    std::sort(result.begin(), result.end());
    return result;
  }
  std::filesystem::path folder;
};
using ResultsFile = Files;
using CsvFile = Files;

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

ResultsHeader sample_header() {
  ResultsHeader header;
  header.title = "A péndulo";
  header.model_text = "mimbre: 1\ntitle: A\n";
  header.options_json = R"({"set": {"length": 2}})";
  header.step = 0.01;
  header.channels = {{"arm.z", "m", "height of the arm"}, {"θ", "rad", "angle"}, {"energy", "J", ""}};
  BodyDrawing rigid;
  rigid.name = "block";
  spec::Shape box;
  box.kind = spec::Shape::Kind::cylinder;
  box.size = {0.1, 2, 0};
  box.pose.position = {1, 2, 3};
  box.pose.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  rigid.shapes = {box};
  BodyDrawing flexible;
  flexible.name = "arm";
  flexible.modes = 2;
  flexible.points = Eigen::Matrix3Xd::Random(3, 4);
  flexible.point_shapes = Eigen::MatrixXd::Random(12, 2);
  flexible.lines = {{0, 1}, {1, 2}, {2, 3}};
  flexible.triangles = {{0, 1, 2}, {1, 3, 2}};
  flexible.labels = {7, 8, 9, 5'000'000'000};
  flexible.stress = 1e8 * Eigen::MatrixXd::Random(24, 2);
  flexible.bar_stress = 1e8 * Eigen::MatrixXd::Random(24, 2);
  flexible.round_lines = {true, false, true};
  flexible.line_radius = 0.02;
  header.bodies = {rigid, flexible};
  RoadDrawing road;
  road.name = "track";
  road.profile = Eigen::Matrix2Xd::Random(2, 5);
  header.roads = {road};
  FrameDrawing pin{"pin", spec::ground, {{4, 5, 6}, box.pose.rotation}, Eigen::MatrixXd(6, 0)};
  FrameDrawing eye{"arm.eye", 1, {}, Eigen::MatrixXd::Random(6, 2)};
  header.frames = {pin, eye};
  header.elements = {{"hinge", "revolute", 0, 1, 0, {}}, {"wheel", "tyre", 1, -1, 0.3, {}}};
  header.elements.push_back({"wire", "on_curve", 0, 1, 0, Eigen::Matrix3Xd::Random(3, 7)});
  header.sections = {{1, "span", 1, false, 0, {0, -1, -1, -1, -1, -1, 2}},
                     {1, "span", 2, true, 0.75, {-1, -1, -1, -1, 1, -1, -1}}};
  return header;
}

ResultsRow sample_row(int i) {
  ResultsRow row;
  row.time = 0.01 * i;
  row.channels = Eigen::Vector3d(i, std::sin(0.1 * i), -1e-300 * i);
  row.poses = Eigen::Matrix<double, 7, 2>::Constant(i) + Eigen::Matrix<double, 7, 2>::Identity();
  row.modes = Eigen::Vector2d(2 * i, 3 * i);
  return row;
}

/// Of `path`, as far as it goes, and nothing else.
void expect_sample_rows(const Results& results, int count) {
  ASSERT_EQ(results.time.size(), count);
  ASSERT_EQ(results.channels.rows(), count);
  ASSERT_EQ(results.modes.rows(), count);
  ASSERT_EQ(results.poses.size(), static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const ResultsRow row = sample_row(i);
    ASSERT_EQ(results.time[i], row.time);
    ASSERT_EQ(results.channels.row(i).transpose(), row.channels);
    ASSERT_EQ(results.modes.row(i).transpose(), row.modes);
    ASSERT_EQ(results.poses[static_cast<std::size_t>(i)], row.poses);
  }
}

void write_sample(const std::string& path, int rows) {
  ResultsWriter writer(path, sample_header());
  for (int i = 0; i < rows; ++i) writer.add(sample_row(i));
  writer.finish("{\"steps\": 3}");
}

std::string reading_error(const std::string& path) {
  try {
    read_results(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

std::string writing_error(const std::string& path) {
  try {
    ResultsWriter writer(path, sample_header());
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "written";
}

/// Runs `work` in a child process, which must end by itself (or by the signal); returns its wait status.
template <class Work>
int in_child(Work&& work) {
  const pid_t child = fork();
  if (child == 0) {
    work();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

void wait_for(const std::string& path) {
  while (!std::filesystem::exists(path)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

TEST_F(ResultsFile, ComesBackAsWritten) {
  const ResultsHeader header = sample_header();
  write_sample(at("a.h5"), 0);  // is overwritten
  {
    ResultsWriter writer(at("a.h5"), header);
    for (int i = 0; i < 3000; ++i) writer.add(sample_row(i));
    writer.finish("{\"steps\": 3000}");
  }
  const Results results = read_results(at("a.h5"));
  EXPECT_EQ(results.summary_json, "{\"steps\": 3000}");
  EXPECT_EQ(results.header.title, header.title);
  EXPECT_EQ(results.header.model_text, header.model_text);
  EXPECT_EQ(results.header.options_json, header.options_json);
  EXPECT_EQ(results.header.step, 0.01);
  ASSERT_EQ(results.header.channels.size(), 3u);
  EXPECT_EQ(results.header.channels[1].name, "θ");
  EXPECT_EQ(results.header.channels[1].unit, "rad");
  EXPECT_EQ(results.header.channels[0].meaning, "height of the arm");
  ASSERT_EQ(results.header.bodies.size(), 2u);
  const BodyDrawing &rigid = results.header.bodies[0], &arm = results.header.bodies[1];
  EXPECT_EQ(rigid.name, "block");
  EXPECT_EQ(rigid.points.cols(), 0);
  ASSERT_EQ(rigid.shapes.size(), 1u);
  EXPECT_EQ(rigid.shapes[0].kind, spec::Shape::Kind::cylinder);
  EXPECT_EQ(rigid.shapes[0].size, header.bodies[0].shapes[0].size);
  EXPECT_EQ(rigid.shapes[0].pose.position, header.bodies[0].shapes[0].pose.position);
  EXPECT_EQ(rigid.shapes[0].pose.rotation, header.bodies[0].shapes[0].pose.rotation);
  EXPECT_EQ(arm.modes, 2);
  EXPECT_EQ(arm.line_radius, 0.02);
  EXPECT_EQ(arm.points, header.bodies[1].points);
  EXPECT_EQ(arm.point_shapes, header.bodies[1].point_shapes);
  EXPECT_EQ(arm.lines, header.bodies[1].lines);
  EXPECT_EQ(arm.triangles, header.bodies[1].triangles);
  EXPECT_EQ(arm.labels, header.bodies[1].labels);
  EXPECT_LT((arm.stress - header.bodies[1].stress).norm(), 1e-7 * arm.stress.norm());  // in single precision
  ASSERT_EQ(results.header.roads.size(), 1u);
  EXPECT_EQ(results.header.roads[0].name, "track");
  EXPECT_EQ(results.header.roads[0].profile, header.roads[0].profile);
  ASSERT_EQ(results.header.frames.size(), 2u);
  for (int k = 0; k < 2; ++k) {
    const FrameDrawing &frame = results.header.frames[k], &written = header.frames[k];
    EXPECT_EQ(frame.name, written.name);
    EXPECT_EQ(frame.body, written.body);
    EXPECT_EQ(frame.pose.position, written.pose.position);
    EXPECT_EQ(frame.pose.rotation, written.pose.rotation);
    EXPECT_EQ(frame.motion, written.motion);
  }
  EXPECT_LT((arm.bar_stress - header.bodies[1].bar_stress).norm(), 1e-7 * arm.bar_stress.norm());
  EXPECT_EQ(arm.round_lines, header.bodies[1].round_lines);
  ASSERT_EQ(results.header.sections.size(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    const RecordedSection &section = results.header.sections[k], &given = header.sections[k];
    EXPECT_EQ(section.body, 1);
    EXPECT_EQ(section.bar, "span");
    EXPECT_EQ(section.element, given.element);
    EXPECT_EQ(section.end, given.end);
    EXPECT_EQ(section.along, given.along);
    EXPECT_EQ(section.channels, given.channels);
  }
  ASSERT_EQ(results.header.elements.size(), 3u);
  EXPECT_EQ(results.header.elements[2].curve, header.elements[2].curve);
  EXPECT_EQ(results.header.elements[0].curve.cols(), 0);
  const ElementDrawing &hinge = results.header.elements[0], &wheel = results.header.elements[1];
  EXPECT_EQ(hinge.name, "hinge");
  EXPECT_EQ(hinge.kind, "revolute");
  EXPECT_EQ(hinge.frame_b, 1);
  EXPECT_EQ(wheel.frame_b, -1);
  EXPECT_EQ(wheel.size, 0.3);
  expect_sample_rows(results, 3000);
}

/// Files of earlier versions; a part that is on what is not there is refused.
TEST_F(ResultsFile, WorksWithoutElementsAndChecksThem) {
  const auto remove = [&](const char* name) {
    const hid_t file = H5Fopen(at("a.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    H5Ldelete(file, name, H5P_DEFAULT);
    H5Fclose(file);
  };
  write_sample(at("a.h5"), 10);
  remove("frames");
  EXPECT_THAT(reading_error(at("a.h5")), testing::HasSubstr("an element is at frame 0, of 0"));
  remove("elements");
  EXPECT_THAT(reading_error(at("a.h5")), testing::HasSubstr("group '/' does not hold what was written"));
  hdf5::remove_checksums(at("a.h5"));
  EXPECT_EQ(read_results(at("a.h5")).time.size(), 10);
  write_sample(at("a.h5"), 10);
  remove("bodies/1");
  EXPECT_THAT(reading_error(at("a.h5")), testing::HasSubstr("frame 1 is on body 1, of 1"));
}

TEST_F(ResultsFile, OfNothingIsStillAFile) {
  ResultsRow row;
  row.time = 1;
  row.poses.resize(7, 0);
  {
    ResultsWriter writer(at("empty.h5"), {});
    writer.finish("");
  }
  EXPECT_EQ(read_results(at("empty.h5")).time.size(), 0);
  {
    ResultsWriter writer(at("empty.h5"), {});
    for (int i = 0; i < 100; ++i) writer.add(row);
    writer.finish("{}");
  }
  const Results results = read_results(at("empty.h5"));
  EXPECT_EQ(results.time.size(), 100);
  EXPECT_EQ(results.channels.cols(), 0);
  EXPECT_EQ(results.poses.back().cols(), 0);
}

TEST_F(ResultsFile, HasTheDocumentedLayout) {
  write_sample(at("a.h5"), 10);
  const hid_t file = H5Fopen(at("a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  const auto shape = [&](const char* path) {
    const hid_t data = H5Dopen2(file, path, H5P_DEFAULT), space = H5Dget_space(data);
    std::vector<hsize_t> dims(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
    H5Sget_simple_extent_dims(space, dims.data(), nullptr);
    H5Sclose(space);
    H5Dclose(data);
    return dims;
  };
  using testing::ElementsAre;
  EXPECT_THAT(shape("/time"), ElementsAre(10));
  EXPECT_THAT(shape("/channels"), ElementsAre(10, 3));
  EXPECT_THAT(shape("/poses"), ElementsAre(10, 14));
  EXPECT_THAT(shape("/modes"), ElementsAre(10, 2));
  EXPECT_THAT(shape("/bodies/1/points"), ElementsAre(4, 3));
  EXPECT_THAT(shape("/bodies/1/point_shapes"), ElementsAre(2, 4, 3));
  EXPECT_THAT(shape("/bodies/1/lines"), ElementsAre(3, 2));
  EXPECT_THAT(shape("/bodies/0/shapes"), ElementsAre(1, 16));
  EXPECT_THAT(shape("/roads/0/profile"), ElementsAre(5, 2));
  EXPECT_THAT(shape("/frames/pose"), ElementsAre(2, 12));
  EXPECT_THAT(shape("/frames/motion"), ElementsAre(2, 6));
  EXPECT_THAT(shape("/elements/frames"), ElementsAre(3, 2));
  for (const char* name :
       {"format", "mimbre_version", "compiler", "instructions", "title", "step", "complete", "rows"})
    EXPECT_GT(H5Aexists(file, name), 0) << name;
  // Row-major: mode 1, point 2, y.
  double shapes[2][4][3];
  const hid_t data = H5Dopen2(file, "/bodies/1/point_shapes", H5P_DEFAULT);
  H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, shapes);
  H5Dclose(data);
  H5Fclose(file);
  const Results results = read_results(at("a.h5"));
  EXPECT_EQ(shapes[1][2][1], results.header.bodies[1].point_shapes(3 * 2 + 1, 1));
}

TEST_F(ResultsFile, HoldsThousandsOfChannels) {
  ResultsHeader header;
  for (int i = 0; i < 6000; ++i) header.channels.push_back({"channel " + std::to_string(i), "m", "meaning"});
  ResultsRow row;
  row.poses.resize(7, 0);
  row.channels = Eigen::VectorXd::LinSpaced(6000, 0, 5999);
  ResultsWriter writer(at("many.h5"), header);
  for (int i = 0; i < 70; ++i) writer.add(row);
  writer.finish("");
  const Results results = read_results(at("many.h5"));
  EXPECT_EQ(results.header.channels[5999].name, "channel 5999");
  EXPECT_EQ(results.channels(69, 5999), 5999);
}

TEST_F(ResultsFile, IsTheSameBytesForTheSameRows) {
  const ResultsHeader header = sample_header();
  const auto write = [&](const std::string& path, int pause_at) {
    ResultsWriter writer(path, header);
    for (int i = 0; i < 500; ++i) {
      if (i == pause_at) std::this_thread::sleep_for(std::chrono::milliseconds(1100));
      writer.add(sample_row(i));
    }
    writer.finish("{}");
  };
  // Time stamps count seconds; and after a pause the rows are written by the clock.
  write(at("a.h5"), -1);
  write(at("b.h5"), 101);
  EXPECT_TRUE(bytes_of(at("a.h5")) == bytes_of(at("b.h5")));  // too long to be printed
}

TEST_F(ResultsFile, IsLittleLargerThanItsContent) {
  write_sample(at("a.h5"), 2000);
  EXPECT_LT(std::filesystem::file_size(at("a.h5")), 2000u * 8 * (1 + 3 + 14 + 2) + 500000u);
}

TEST_F(ResultsFile, OfARunCutShortKeepsAllRowsWithoutSummary) {
  {
    ResultsWriter writer(at("a.h5"), sample_header());
    for (int i = 0; i < 100; ++i) writer.add(sample_row(i));
  }
  const Results results = read_results(at("a.h5"));
  EXPECT_EQ(results.summary_json, "");
  expect_sample_rows(results, 100);
}

TEST_F(ResultsFile, CanBeReadWhileAnotherProcessWritesIt) {
  const pid_t child = fork();
  if (child == 0) {
    ResultsWriter writer(at("a.h5"), sample_header());
    for (int i = 0; i < 130; ++i) writer.add(sample_row(i));
    std::ofstream(at("written"));
    for (;;) pause();
  }
  wait_for(at("written"));
  const Results results = read_results(at("a.h5"));
  EXPECT_GE(results.time.size(), 128);  // the rest with the clock
  expect_sample_rows(results, static_cast<int>(results.time.size()));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

TEST_F(ResultsFile, CanBeReadWhileThisProcessWritesIt) {
  ResultsWriter writer(at("a.h5"), sample_header());
  for (int i = 0; i < 130; ++i) writer.add(sample_row(i));
  ASSERT_GE(writer.rows(), 128);  // the rest with the clock
  expect_sample_rows(read_results(at("a.h5")), static_cast<int>(writer.rows()));
  for (int i = 130; i < 200; ++i) writer.add(sample_row(i));
  writer.finish("{}");
  expect_sample_rows(read_results(at("a.h5")), 200);
}

TEST_F(ResultsFile, OfAKilledRunIsReadable) {
  for (int trial = 0; trial < 20; ++trial) {
    std::filesystem::remove(at("a.h5"));
    const pid_t child = fork();
    if (child == 0) {
      ResultsWriter writer(at("a.h5"), sample_header());
      for (int i = 0;; ++i) {
        if (i == 64) std::ofstream(at("started"));
        writer.add(sample_row(i));
      }
    }
    wait_for(at("started"));
    std::this_thread::sleep_for(std::chrono::microseconds(3000 + 1700 * trial));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    std::filesystem::remove(at("started"));
    const Results results = read_results(at("a.h5"));
    EXPECT_EQ(results.summary_json, "");
    EXPECT_GE(results.time.size(), 64);
    expect_sample_rows(results, static_cast<int>(results.time.size()));
  }
}

TEST_F(ResultsFile, OnAFullDiskKeepsWhatWasWritten) {
  // Limits of many sizes, so that the disk is full at every stage of writing.
  int with_rows = 0;
  for (rlim_t limit = 300'000; limit < 2'000'000; limit += 97'331) {
    std::filesystem::remove(at("a.h5"));
    const int status = in_child([&] {
      const rlimit size{limit, limit};
      signal(SIGXFSZ, SIG_IGN);
      setrlimit(RLIMIT_FSIZE, &size);
      int added = 0;
      std::string message, again;
      try {
        ResultsWriter writer(at("a.h5"), sample_header());
        try {
          for (;; ++added) writer.add(sample_row(added));
        } catch (const std::runtime_error& error) {
          message = error.what();
        }
        try {
          writer.finish("");
        } catch (const std::runtime_error& error) {
          again = error.what();
        }
      } catch (const std::runtime_error& error) {  // not even the header had room
        _exit(std::filesystem::exists(at("a.h5")) ? 1 : 0);
      }
      if (message != again || message.find("cannot write results file") != 0) _exit(2);
      if (message.find("File too large") == std::string::npos) _exit(3);
      std::ofstream(at("added")) << added;
      _exit(4);
    });
    ASSERT_TRUE(WIFEXITED(status));
    if (WEXITSTATUS(status) == 0) continue;
    ASSERT_EQ(WEXITSTATUS(status), 4) << "limit " << limit;
    ++with_rows;
    int added = 0;
    std::ifstream(at("added")) >> added;
    const Results results = read_results(at("a.h5"));
    // Whole blocks; or more, where that took so long that the clock was due.
    const auto rows = static_cast<int>(results.time.size());
    EXPECT_GE(rows, added - added % 64);
    EXPECT_LE(rows, added);
    expect_sample_rows(results, rows);
    EXPECT_EQ(results.summary_json, "");
  }
  EXPECT_GT(with_rows, 5);
}

TEST_F(ResultsFile, RowsAreInTheFileAfterASecondHoweverFewTheyAre) {
  const auto begin = std::chrono::steady_clock::now();
  ResultsWriter writer(at("a.h5"), sample_header());
  writer.add(sample_row(0));
  writer.add(sample_row(1));
  const std::int64_t at_once = writer.rows();
  if (std::chrono::steady_clock::now() - begin < std::chrono::milliseconds(500)) {
    EXPECT_EQ(at_once, 0);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  writer.flush_if_due();
  EXPECT_EQ(writer.rows(), 2);
  expect_sample_rows(read_results(at("a.h5")), 2);
}

TEST_F(ResultsFile, AnOlderOneStandsUntilTheNewOneIsWhole) {
  write_sample(at("a.h5"), 3);
  {
    ResultsWriter writer(at("a.h5"), sample_header());
    for (int i = 0; i < 200; ++i) writer.add(sample_row(i));
    expect_sample_rows(read_results(at("a.h5")), 3);
    const std::string kept = writer.keep("{}");
    EXPECT_NE(kept, at("a.h5"));
    EXPECT_TRUE(kept.ends_with(".h5"));
    expect_sample_rows(read_results(kept), 200);
    std::filesystem::remove(kept);
  }
  expect_sample_rows(read_results(at("a.h5")), 3);
  write_sample(at("a.h5"), 5);
  expect_sample_rows(read_results(at("a.h5")), 5);
  EXPECT_THAT(names(), testing::ElementsAre("a.h5"));
}

TEST_F(ResultsFile, HasOneWriter) {
  ResultsWriter first(at("a.h5"), sample_header());
  EXPECT_THAT(writing_error(at("a.h5")), HasSubstr("another program is writing it"));
  first.add(sample_row(0));
  first.finish("");
  expect_sample_rows(read_results(at("a.h5")), 1);
}

/// What a file may not have: it is refused by name, whatever the rest is.
TEST_F(ResultsFile, PullsNothingFromOtherFiles) {
  std::ofstream(at("secret.txt")) << std::string(8000, 's');
  const auto changed = [&](const auto& change) {
    write_sample(at("a.h5"), 10);
    const hid_t file = H5Fopen(at("a.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    H5Ldelete(file, "model", H5P_DEFAULT);
    change(file);
    H5Fclose(file);
    return reading_error(at("a.h5"));
  };
  const hsize_t one = 1;
  const hid_t text = H5Tcopy(H5T_C_S1), space = H5Screate_simple(1, &one, nullptr);
  H5Tset_size(text, 100);
  EXPECT_THAT(changed([&](hid_t file) {
                const hid_t properties = H5Pcreate(H5P_DATASET_CREATE);
                H5Pset_external(properties, at("secret.txt").c_str(), 0, 100);
                H5Dclose(H5Dcreate2(file, "model", text, space, H5P_DEFAULT, properties, H5P_DEFAULT));
              }),
              HasSubstr("'model' is missing or damaged, or lies in another file"));
  write_sample(at("b.h5"), 10);
  EXPECT_THAT(changed([&](hid_t file) {
                H5Lcreate_external(at("b.h5").c_str(), "/model", file, "model", H5P_DEFAULT, H5P_DEFAULT);
              }),
              HasSubstr("'model' is missing or damaged, or lies in another file"));
  EXPECT_THAT(changed([&](hid_t file) {
                H5Tset_size(text, H5T_VARIABLE);
                H5Dclose(H5Dcreate2(file, "model", text, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
              }),
              HasSubstr("'model' is text of variable length"));
}

TEST_F(ResultsFile, AnnouncesNoMoreThanItHolds) {
  write_sample(at("a.h5"), 10);
  const hid_t file = H5Fopen(at("a.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  H5Ldelete(file, "bodies/1/points", H5P_DEFAULT);
  const hsize_t many[2] = {hsize_t{1} << 33, 3};
  const hid_t space = H5Screate_simple(2, many, nullptr);
  H5Dclose(H5Dcreate2(file, "bodies/1/points", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  H5Fclose(file);
  EXPECT_THAT(reading_error(at("a.h5")), HasSubstr("announces more data than the file can hold"));
}

TEST_F(ResultsFile, OfAPipeIsRefusedAtOnce) {
  ASSERT_EQ(mkfifo(at("pipe.h5").c_str(), 0600), 0);
  EXPECT_THAT(reading_error(at("pipe.h5")), HasSubstr("not a file"));
}

TEST_F(ResultsFile, ThatCannotBeWrittenSaysWhy) {
  EXPECT_EQ(writing_error(at("no/such/folder/a.h5")),
            "cannot write results file '" + at("no/such/folder/a.h5") + "': No such file or directory");
  EXPECT_THAT(writing_error(folder.string()), HasSubstr("Is a directory"));
}

TEST_F(ResultsFile, WriterRefusesMisuse) {
  ResultsWriter writer(at("a.h5"), sample_header());
  ResultsRow row = sample_row(0);
  row.channels.resize(2);
  EXPECT_THROW(writer.add(row), std::invalid_argument);
  row = sample_row(0);
  row.poses.resize(7, 1);
  EXPECT_THROW(writer.add(row), std::invalid_argument);
  writer.finish("");
  EXPECT_THROW(writer.add(sample_row(0)), std::logic_error);
  EXPECT_THROW(writer.finish(""), std::logic_error);
}

TEST_F(ResultsFile, BadOnesAreNamed) {
  EXPECT_EQ(reading_error(at("missing.h5")), at("missing.h5") + ": no such file");
  EXPECT_THAT(reading_error(folder.string()), HasSubstr("not a file"));
  std::ofstream(at("text.h5")) << "t,z\n0,1\n";
  EXPECT_THAT(reading_error(at("text.h5")), HasSubstr("not in HDF5 format"));
  std::ofstream(at("nothing.h5"));
  EXPECT_THAT(reading_error(at("nothing.h5")), HasSubstr("not in HDF5 format"));
  const hid_t other = H5Fcreate(at("other.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Fclose(other);
  EXPECT_THAT(reading_error(at("other.h5")), HasSubstr("attribute 'format' is missing"));
}

TEST_F(ResultsFile, OfAnotherFormatVersionIsNamed) {
  write_sample(at("a.h5"), 3);
  std::string bytes = bytes_of(at("a.h5"));
  const auto place = bytes.find("mimbre-results-2");
  ASSERT_NE(place, std::string::npos);
  bytes.replace(place, 16, "mimbre-results-7");
  std::ofstream(at("b.h5"), std::ios::binary) << bytes;
  EXPECT_THAT(reading_error(at("b.h5")), HasSubstr("has format 'mimbre-results-7', this version reads"));
}

TEST_F(ResultsFile, TruncatedAnywhereIsAnInputError) {
  write_sample(at("a.h5"), 200);
  const std::string bytes = bytes_of(at("a.h5"));
  for (std::size_t size = 0; size < bytes.size(); size += 1013) {
    std::ofstream(at("b.h5"), std::ios::binary) << bytes.substr(0, size);
    EXPECT_NE(reading_error(at("b.h5")), "read") << size << " of " << bytes.size() << " bytes";
  }
}

TEST_F(CsvFile, HasAHeaderAndShortestRoundTripNumbers) {
  {
    CsvWriter writer(at("a.csv"), {"arm.z", "a \"b\", c"});
    writer.add(0, Eigen::Vector2d(0.1, -1));
    writer.add(0.01, Eigen::Vector2d(1e-300, std::nan("")));
    EXPECT_FALSE(std::filesystem::exists(at("a.csv")));
    writer.finish();
    EXPECT_THROW(writer.add(1, Eigen::Vector2d(0, 0)), std::logic_error);
    EXPECT_THROW(writer.finish(), std::logic_error);
  }
  EXPECT_THAT(names(), testing::ElementsAre("a.csv"));
  EXPECT_EQ(bytes_of(at("a.csv")), "t,arm.z,\"a \"\"b\"\", c\"\n0,0.1,-1\n0.01,1e-300,nan\n");
}

/// Spreadsheets run a cell that begins like a formula; terminals obey escape sequences.
TEST_F(CsvFile, NamesAreHarmless) {
  CsvWriter writer(at("a.csv"), {"=cmd|' /C calc'!A0", "+x", "-x", "@x", "a-b=c", "\x1b[31mred", "L\xE4nge"});
  writer.finish();
  EXPECT_EQ(bytes_of(at("a.csv")), "t,'=cmd|' /C calc'!A0,'+x,'-x,'@x,a-b=c,\\x1b[31mred,L\xEF\xBF\xBDnge\n");
}

TEST_F(CsvFile, MayHaveALineOfUnits) {
  {
    CsvWriter writer(at("a.csv"), {"angle", "fz"}, {"rad", "N"});
    writer.add(0, Eigen::Vector2d(1, 2));
    writer.finish();
  }
  EXPECT_EQ(bytes_of(at("a.csv")), "t,angle,fz\ns,rad,N\n0,1,2\n");
}

TEST_F(CsvFile, NumbersComeBackExactly) {
  const double value = 1.0 / 3 * 1e17;
  {
    CsvWriter writer(at("a.csv"), {"x"});
    writer.add(std::nextafter(0.1, 1), Eigen::VectorXd::Constant(1, value));
    writer.finish();
  }
  std::ifstream file(at("a.csv"));
  std::string header, t, x;
  std::getline(file, header);
  std::getline(file, t, ',');
  std::getline(file, x);
  EXPECT_EQ(std::stod(t), std::nextafter(0.1, 1));
  EXPECT_EQ(std::stod(x), value);
}

TEST_F(CsvFile, CutShortIsKept) {
  {
    CsvWriter writer(at("a.csv"), {"x"});
    writer.add(0, Eigen::VectorXd::Constant(1, 5));
  }
  EXPECT_EQ(bytes_of(at("a.csv")), "t,x\n0,5\n");
}

TEST_F(CsvFile, RefusesRowsOfAnotherLength) {
  CsvWriter writer(at("a.csv"), {"x"});
  EXPECT_THROW(writer.add(0, Eigen::Vector2d(1, 2)), std::invalid_argument);
}

TEST_F(CsvFile, SaysWhyItCannotBeWritten) {
  try {
    CsvWriter writer(at("no/folder/a.csv"), {"x"});
    FAIL() << "written";
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()),
              "cannot write CSV file '" + at("no/folder/a.csv") + "': No such file or directory");
  }
}

TEST_F(CsvFile, OnAFullDiskFailsClearly) {
  std::filesystem::create_symlink("/dev/full", at("a.csv"));
  CsvWriter writer(at("a.csv"), {"x"});
  std::string message;
  try {
    for (int i = 0; i < 100000; ++i) writer.add(i, Eigen::VectorXd::Constant(1, 0.1));
    writer.finish();
  } catch (const std::runtime_error& error) {
    message = error.what();
  }
  EXPECT_THAT(message, HasSubstr("No space left on device"));
  EXPECT_TRUE(std::filesystem::is_symlink(at("a.csv")));
}

}  // namespace
}  // namespace mimbre::results_test
