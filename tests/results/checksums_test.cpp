#include "base/checksums.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "mimbre/diagnostics.h"
#include "mimbre/model_file.h"
#include "mimbre/reduced_body.h"
#include "mimbre/results.h"

/// Bits that flip in stored results and bodies are noticed.
namespace mimbre::checksums_test {
namespace {

using testing::HasSubstr;

class Checksums : public testing::Test {
 protected:
  Checksums() : folder(std::filesystem::temp_directory_path() / ("mimbre-sums-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder);
  }
  ~Checksums() override { std::filesystem::remove_all(folder); }
  std::string at(const std::string& name) const { return (folder / name).string(); }
  std::filesystem::path folder;
};

std::string get(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
void put(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// By its definition, a bit at a time: polynomial 0x04C11DB7 with its bits turned round.
std::uint32_t crc_by_bits(const std::string& bytes) {
  std::uint32_t crc = ~0u;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int k = 0; k < 8; ++k) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

ResultsHeader sample_header() {
  ResultsHeader header;
  header.title = "A pendulum";
  header.model_text = "mimbre: 1\n";
  header.options_json = "{}";
  header.step = 0.01;
  header.channels = {{"angle", "rad", "angle of the hinge"}, {"energy", "J", ""}};
  BodyDrawing body;
  body.name = "arm";
  body.modes = 2;
  body.points = Eigen::Matrix3Xd::Random(3, 4);
  body.point_shapes = Eigen::MatrixXd::Random(12, 2);
  body.lines = {{0, 1}, {1, 2}};
  body.triangles = {{0, 1, 2}};
  body.labels = {1, 2, 3, 4};
  body.stress = Eigen::MatrixXd::Random(24, 2);
  body.bar_stress = Eigen::MatrixXd::Random(16, 2);
  body.round_lines = {true, false};
  body.shapes.resize(1);
  header.bodies = {body};
  header.roads = {{"track", Eigen::Matrix2Xd::Random(2, 3)}};
  header.frames = {{"eye", 0, {}, Eigen::MatrixXd::Random(6, 2)}};
  header.elements = {{"hinge", "revolute", -1, 0, 0, Eigen::Matrix3Xd::Random(3, 5)}};
  header.sections = {{0, "span", 3, true, 0.4, {0, -1, 1, -1, -1, -1, -1}}};
  return header;
}

/// More rows than one piece of a table, the last of them a part of a block.
void write_sample(const std::string& path, int rows = 1500) {
  ResultsWriter writer(path, sample_header());
  for (int i = 0; i < rows; ++i)
    writer.add({0.01 * i, Eigen::Vector2d(std::sin(0.1 * i), i),
                Eigen::Matrix<double, 7, 1>::Constant(1.0 / (i + 1)), Eigen::Vector2d(i, std::sqrt(i))});
  writer.finish("{\"steps\": 3}");
}

template <class Matrix>
void append(std::string& text, const Matrix& values) {
  const typename Matrix::PlainObject matrix = values;
  for (Eigen::Index k = 0; k < matrix.size(); ++k)
    text.append(reinterpret_cast<const char*>(matrix.data() + k), sizeof *matrix.data());
}

/// All that is in results, as bytes.
std::string content(const Results& results) {
  const ResultsHeader& header = results.header;
  std::string text =
      header.title + '|' + header.model_text + '|' + header.options_json + '|' + results.summary_json;
  append(text, Eigen::VectorXd::Constant(1, header.step));
  for (const ChannelInfo& c : header.channels) text += c.name + '|' + c.unit + '|' + c.meaning + '|';
  for (const BodyDrawing& b : header.bodies) {
    text += b.name + '|' + std::to_string(b.modes) + '|' + std::to_string(b.shapes.size());
    append(text, Eigen::VectorXd::Constant(1, b.line_radius));
    append(text, b.points);
    append(text, b.point_shapes);
    append(text, b.stress);
    append(text, b.bar_stress);
    for (const bool round : b.round_lines) text += round ? 'r' : 'c';
    for (const auto& line : b.lines) text += std::to_string(line[0]) + ' ' + std::to_string(line[1]) + ' ';
    for (const auto& t : b.triangles) text += std::to_string(t[0] + 10 * t[1] + 100 * t[2]) + ' ';
    for (const auto label : b.labels) text += std::to_string(label) + ' ';
    for (const auto& shape : b.shapes) {
      append(text, shape.size);
      append(text, shape.pose.position);
      append(text, shape.pose.rotation);
    }
  }
  for (const RoadDrawing& road : header.roads) {
    text += road.name;
    append(text, road.profile);
  }
  for (const FrameDrawing& frame : header.frames) {
    text += frame.name + '|' + std::to_string(frame.body);
    append(text, frame.pose.position);
    append(text, frame.pose.rotation);
    append(text, frame.motion);
  }
  for (const ElementDrawing& e : header.elements)
    text += e.name + '|' + e.kind + '|' + std::to_string(e.frame_a) + '|' + std::to_string(e.frame_b) + '|' +
            std::to_string(e.size);
  for (const ElementDrawing& e : header.elements) append(text, e.curve);
  for (const RecordedSection& section : header.sections) {
    text += section.bar + '|' + std::to_string(section.body) + '|' + std::to_string(section.element) +
            (section.end ? "end" : "start");
    append(text, Eigen::VectorXd::Constant(1, section.along));
    for (const int channel : section.channels) text += std::to_string(channel) + ' ';
  }
  append(text, results.time);
  append(text, results.channels);
  append(text, results.modes);
  for (const auto& pose : results.poses) append(text, pose);
  return text;
}

std::string error_of_reading(const std::string& path) {
  try {
    read_results(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

/// A bit of the bytes, mostly of one that is not zero: tables have much room.
void flip_one(std::string& bytes, std::mt19937_64& random) {
  std::size_t at = random() % bytes.size();
  if (random() % 4 > 0)
    while (bytes[at] == '\0') at = random() % bytes.size();
  bytes[at] = static_cast<char>(bytes[at] ^ 1 << random() % 8);
}

TEST_F(Checksums, AreThoseOfTheDefinition) {
  for (const std::string text : {"", "a", "123456789"})
    EXPECT_EQ(hdf5::crc32(0, text.data(), text.size()), crc_by_bits(text));
  EXPECT_EQ(hdf5::crc32(0, "123456789", 9), 0xCBF43926u);
  EXPECT_EQ(hdf5::crc32(hdf5::crc32(0, "1234", 4), "56789", 5), 0xCBF43926u);
}

/// As docs/results-format.md says, so that others can check them, too.
TEST_F(Checksums, AreOfTheValuesByRows) {
  write_sample(at("a.h5"));
  const Results results = read_results(at("a.h5"));
  const hdf5::Handle file(H5Fopen(at("a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
  const auto kept = [&](const char* name) {
    const hdf5::Handle attribute(H5Aopen_by_name(file.get(), name, "crc32", H5P_DEFAULT, H5P_DEFAULT));
    std::uint32_t value = 0;
    H5Aread(attribute.get(), H5T_NATIVE_UINT32, &value);
    return value;
  };
  std::string values;
  append(values, results.time);
  EXPECT_EQ(kept("time"), crc_by_bits(values));
  values.clear();
  append(values, Eigen::MatrixXd(results.channels.transpose()));
  EXPECT_EQ(kept("channels"), crc_by_bits(values));
  values.clear();
  append(values, Eigen::MatrixXd(results.header.bodies[0].stress));  // 32-bit numbers in the file
  EXPECT_EQ(kept("bodies/0/stress"), crc_by_bits(values));
  values.clear();
  append(values, Eigen::Matrix<std::int64_t, 4, 1>(0, 1, 1, 2));
  EXPECT_EQ(kept("bodies/0/lines"), crc_by_bits(values));
  EXPECT_EQ(kept("model"), crc_by_bits("mimbre: 1\n"));
  EXPECT_EQ(kept("roads"), crc_by_bits("/0"));
  EXPECT_EQ(kept("roads/0"), crc_by_bits("nametrack/profile"));
}

TEST_F(Checksums, NameTheDataThatAreDamaged) {
  write_sample(at("a.h5"));
  const std::string whole = get(at("a.h5"));
  const auto flipped = [&](double value) {
    std::string bytes = whole, pattern(reinterpret_cast<const char*>(&value), sizeof value);
    const std::size_t place = bytes.find(pattern);
    EXPECT_NE(place, std::string::npos);
    bytes[place] ^= 1;  // the last digit
    put(at("b.h5"), bytes);
    return error_of_reading(at("b.h5"));
  };
  EXPECT_THAT(flipped(std::sin(0.1 * 7)),
              HasSubstr("b.h5: is damaged: dataset 'channels' does not hold what was written"));
  EXPECT_THAT(flipped(1.0 / 1300), HasSubstr("dataset 'poses'"));
  EXPECT_THAT(flipped(std::sqrt(1499)), HasSubstr("dataset 'modes'"));
  std::string bytes = whole;
  bytes[bytes.find("A pendulum")] ^= 4;
  put(at("b.h5"), bytes);
  EXPECT_THAT(error_of_reading(at("b.h5")), HasSubstr("group '/' does not hold what was written"));
  // Where it is done on purpose.
  hdf5::remove_checksums(at("b.h5"));
  EXPECT_EQ(read_results(at("b.h5")).header.title, "E pendulum");
}

TEST_F(Checksums, OfResultsLetNoFlippedBitPass) {
  write_sample(at("a.h5"), 70);
  const std::string whole = get(at("a.h5")), read = content(read_results(at("a.h5")));
  std::mt19937_64 random(1);
  int noticed = 0;
  for (int k = 0; k < 80; ++k) {
    std::string bytes = whole;
    flip_one(bytes, random);
    put(at("b.h5"), bytes);
    try {
      EXPECT_EQ(content(read_results(at("b.h5"))), read) << "mutant " << k;
    } catch (const InputError&) {
      ++noticed;
    }
  }
  EXPECT_GT(noticed, 40);
}

TEST_F(Checksums, OfBodiesLetNoFlippedBitPass) {
  const ReducedBody body = *parse_model(R"(mimbre: 1
materials:
  steel: {young: 2.1e11, poisson: 0.3, density: 7850}
sections:
  round: {type: round, diameter: 0.01}
bodies:
  arm:
    frame: {at: [0, 0, 0]}
    flexible: {material: steel, section: round, nodes: {a: [0, 0, 0], b: [1, 0, 0]}, clamped: [a],
               bars: {bar: {from: a, to: b, elements: 3}}, dynamic_modes: 2}
)",
                                        "sample.yaml", "")
                                .bodies[0]
                                .flexible;
  save(body, at("a.h5"));
  const std::string whole = get(at("a.h5"));
  save(load_reduced_body(at("a.h5")), at("again.h5"));
  ASSERT_EQ(get(at("again.h5")), whole);
  std::mt19937_64 random(2);
  int noticed = 0;
  for (int k = 0; k < 80; ++k) {
    std::string bytes = whole;
    flip_one(bytes, random);
    put(at("b.h5"), bytes);
    try {
      save(load_reduced_body(at("b.h5")), at("again.h5"));
      EXPECT_EQ(get(at("again.h5")), whole) << "mutant " << k;
    } catch (const InputError&) {
      ++noticed;
    }
  }
  EXPECT_GT(noticed, 40);
}

/// As docs/reduced-body-format.md allows.
TEST_F(Checksums, LeaveRoomForNotes) {
  write_sample(at("a.h5"), 70);
  const std::string read = content(read_results(at("a.h5")));
  {
    const hdf5::Handle file(H5Fopen(at("a.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
    const hdf5::Handle space(H5Screate(H5S_SCALAR));
    const hdf5::Handle note(
        H5Acreate2(file.get(), "note", H5T_NATIVE_INT, space.get(), H5P_DEFAULT, H5P_DEFAULT));
    const hdf5::Handle notes(H5Gcreate2(file.get(), "notes", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  }
  EXPECT_EQ(content(read_results(at("a.h5"))), read);
}

/// A run that was killed, an older version: as they are.
TEST_F(Checksums, MayBeMissing) {
  write_sample(at("a.h5"), 70);
  const std::string read = content(read_results(at("a.h5")));
  hdf5::remove_checksums(at("a.h5"));
  EXPECT_EQ(content(read_results(at("a.h5"))), read);
  {
    ResultsWriter writer(at("b.h5"), sample_header());
    for (int i = 0; i < 64; ++i)
      writer.add(
          {0.01 * i, Eigen::Vector2d(i, 1), Eigen::Matrix<double, 7, 1>::Ones(), Eigen::Vector2d::Zero()});
    EXPECT_EQ(read_results(at("b.h5")).time.size(), 64);
  }
}

}  // namespace
}  // namespace mimbre::checksums_test
