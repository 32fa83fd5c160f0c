#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <stdexcept>

#include "base/checksums.h"
#include "base/flush_clock.h"
#include "base/hdf5.h"
#include "base/output_place.h"
#include "mimbre/build.h"
#include "mimbre/results.h"
#include "results/results_layout.h"
#include "results/superseded_parts.h"

namespace mimbre {

namespace {

using hdf5::Handle;

constexpr std::size_t rows_per_flush = 64;
constexpr hsize_t chunk_bytes = 65536;  ///< about: few index nodes, and yet a small file for a short run
/// What HDF5 may need besides the data itself: index nodes of all tables, headers.
constexpr hsize_t metadata_block_bytes = 64 * 1024;
constexpr hsize_t metadata_bytes = 1024 * 1024;

/// Creation properties without time stamps: identical rows give identical bytes.
Handle creation_properties(hid_t property_class) {
  Handle properties(H5Pcreate(property_class));
  H5Pset_obj_track_times(properties.get(), false);
  return properties;
}

/// Every call that returns an identifier or a status passes here.
hid_t checked(hid_t result) {
  if (result < 0) throw std::runtime_error(hdf5::last_error());
  return result;
}
void check(herr_t status) {
  if (status < 0) throw std::runtime_error(hdf5::last_error());
}

/// HDF5 has no room for more in an attribute; no name is that long.
constexpr std::size_t longest_attribute = 60'000;

void write_attribute(hid_t object, const char* name, const std::string& text) {
  std::string fitting = text.substr(0, longest_attribute);
  if (fitting.empty()) fitting.resize(1);
  const Handle type = hdf5::text_type(fitting.size()), space(checked(H5Screate(H5S_SCALAR)));
  const Handle attribute(
      checked(H5Acreate2(object, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT)));
  check(H5Awrite(attribute.get(), type.get(), fitting.data()));
}

void write_attribute(hid_t object, const char* name, double value) {
  const Handle space(checked(H5Screate(H5S_SCALAR)));
  const Handle attribute(
      checked(H5Acreate2(object, name, H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT)));
  check(H5Awrite(attribute.get(), H5T_NATIVE_DOUBLE, &value));
}

void write_attribute(hid_t object, const char* name, int value) {
  const Handle space(checked(H5Screate(H5S_SCALAR)));
  const Handle attribute(
      checked(H5Acreate2(object, name, H5T_STD_I32LE, space.get(), H5P_DEFAULT, H5P_DEFAULT)));
  check(H5Awrite(attribute.get(), H5T_NATIVE_INT, &value));
}

void write_array(hid_t parent, const char* name, const std::vector<hsize_t>& shape, hid_t file_type,
                 hid_t memory_type, const void* values) {
  const Handle space(checked(shape.empty()
                                 ? H5Screate(H5S_SCALAR)
                                 : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr)));
  const Handle properties = creation_properties(H5P_DATASET_CREATE);
  const Handle data(
      checked(H5Dcreate2(parent, name, file_type, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT)));
  const bool empty = std::find(shape.begin(), shape.end(), 0u) != shape.end();
  if (!empty) check(H5Dwrite(data.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
}

void write_texts(hid_t parent, const char* name, const std::vector<hsize_t>& shape,
                 std::span<const std::string> texts) {
  const hdf5::PackedTexts packed = hdf5::packed(texts);
  const Handle type = hdf5::text_type(packed.length);
  write_array(parent, name, shape, type.get(), type.get(), packed.bytes.data());
}

void write_text(hid_t parent, const char* name, const std::string& text) {
  write_texts(parent, name, {}, {&text, 1});
}

void write_array(hid_t parent, const char* name, const std::vector<hsize_t>& shape, const double* values) {
  write_array(parent, name, shape, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values);
}

hsize_t size_of(Eigen::Index count) { return static_cast<hsize_t>(count); }
Eigen::Index size_in(std::size_t count) { return static_cast<Eigen::Index>(count); }

Handle create_group(hid_t parent, const std::string& name) {
  const Handle properties = creation_properties(H5P_GROUP_CREATE);
  return Handle(checked(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, properties.get(), H5P_DEFAULT)));
}

void write_body(hid_t bodies, const std::string& key, const BodyDrawing& body) {
  if (body.point_shapes.cols() > 0 && body.point_shapes.rows() != 3 * body.points.cols())
    throw std::invalid_argument(fmt::format("body '{}': {} points need mode shapes of {} rows, not {}",
                                            body.name, body.points.cols(), 3 * body.points.cols(),
                                            body.point_shapes.rows()));
  if (body.stress.size() > 0 && body.stress.rows() != 6 * body.points.cols())
    throw std::invalid_argument(fmt::format("body '{}': {} points need stress of {} rows, not {}", body.name,
                                            body.points.cols(), 6 * body.points.cols(), body.stress.rows()));
  if (body.bar_stress.rows() != size_in(8 * body.round_lines.size()) ||
      (!body.round_lines.empty() && body.round_lines.size() != body.lines.size()))
    throw std::invalid_argument(fmt::format("body '{}': {} lines need stress of {} rows, not {}", body.name,
                                            body.lines.size(), 8 * body.lines.size(),
                                            body.bar_stress.rows()));
  const Handle group = create_group(bodies, key);
  write_attribute(group.get(), "name", body.name);
  write_attribute(group.get(), "modes", body.modes);
  write_attribute(group.get(), "line_radius", body.line_radius);
  // Eigen stores by columns, the file by rows: column k of the matrix is row k of the dataset.
  write_array(group.get(), "points", {size_of(body.points.cols()), 3}, body.points.data());
  write_array(group.get(), "point_shapes",
              {size_of(body.point_shapes.cols()), size_of(body.points.cols()), 3}, body.point_shapes.data());
  write_array(group.get(), "lines", {body.lines.size(), 2}, H5T_STD_I32LE, H5T_NATIVE_INT, body.lines.data());
  if (!body.triangles.empty())
    write_array(group.get(), "triangles", {body.triangles.size(), 3}, H5T_STD_I32LE, H5T_NATIVE_INT,
                body.triangles.data());
  if (!body.labels.empty())
    write_array(group.get(), "labels", {body.labels.size()}, H5T_STD_I64LE, H5T_NATIVE_INT64,
                body.labels.data());
  // Seven digits of stress are enough, and it is the largest of a file's arrays.
  if (body.stress.size() > 0)
    write_array(group.get(), "stress", {size_of(body.stress.cols()), size_of(body.points.cols()), 6},
                H5T_IEEE_F32LE, H5T_NATIVE_DOUBLE, body.stress.data());

  if (!body.round_lines.empty()) {
    const std::vector<int> round(body.round_lines.begin(), body.round_lines.end());
    write_array(group.get(), "round_lines", {round.size()}, H5T_STD_I32LE, H5T_NATIVE_INT, round.data());
    write_array(group.get(), "bar_stress", {size_of(body.bar_stress.cols()), 2 * round.size(), 4},
                H5T_IEEE_F32LE, H5T_NATIVE_DOUBLE, body.bar_stress.data());
  }

  std::vector<double> shapes;
  for (const spec::Shape& shape : body.shapes) {
    shapes.push_back(static_cast<double>(shape.kind));
    shapes.insert(shapes.end(), shape.size.begin(), shape.size.end());
    shapes.insert(shapes.end(), shape.pose.position.begin(), shape.pose.position.end());
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) shapes.push_back(shape.pose.rotation(row, column));
  }
  write_array(group.get(), "shapes", {body.shapes.size(), results_layout::numbers_per_shape}, shapes.data());
}

/// Frames and elements as one table each: a mechanism has hundreds, and a group is a kilobyte.
void write_elements(hid_t root, const ResultsHeader& header) {
  std::vector<std::string> names, kinds;
  std::vector<int> bodies, ends, counts;
  std::vector<double> poses, motions, sizes, curves;
  for (const FrameDrawing& frame : header.frames) {
    names.push_back(frame.name);
    bodies.push_back(frame.body);
    poses.insert(poses.end(), frame.pose.position.begin(), frame.pose.position.end());
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 3; ++column) poses.push_back(frame.pose.rotation(row, column));
    const auto motion = frame.motion.reshaped();
    motions.insert(motions.end(), motion.begin(), motion.end());
  }
  const Handle frames = create_group(root, "frames");
  write_texts(frames.get(), "names", {names.size()}, names);
  write_array(frames.get(), "body", {bodies.size()}, H5T_STD_I32LE, H5T_NATIVE_INT, bodies.data());
  write_array(frames.get(), "pose", {bodies.size(), results_layout::numbers_per_pose}, poses.data());
  write_array(frames.get(), "motion", {motions.size() / 6, 6}, motions.data());

  names.clear();
  for (const ElementDrawing& element : header.elements) {
    names.push_back(element.name);
    kinds.push_back(element.kind);
    ends.insert(ends.end(), {element.frame_a, element.frame_b});
    sizes.push_back(element.size);
    counts.push_back(static_cast<int>(element.curve.cols()));
    const auto points = element.curve.reshaped();
    curves.insert(curves.end(), points.begin(), points.end());
  }
  const Handle elements = create_group(root, "elements");
  write_texts(elements.get(), "names", {names.size()}, names);
  write_texts(elements.get(), "kinds", {kinds.size()}, kinds);
  write_array(elements.get(), "frames", {names.size(), 2}, H5T_STD_I32LE, H5T_NATIVE_INT, ends.data());
  write_array(elements.get(), "size", {names.size()}, sizes.data());
  if (curves.empty()) return;
  write_array(elements.get(), "curve_points", {counts.size()}, H5T_STD_I32LE, H5T_NATIVE_INT, counts.data());
  write_array(elements.get(), "curves", {curves.size() / 3, 3}, curves.data());
}

/// Likewise the sections of bars of which something is recorded.
void write_sections(hid_t root, const std::vector<RecordedSection>& recorded) {
  if (recorded.empty()) return;
  std::vector<std::string> bars;
  std::vector<int> places, channels;
  std::vector<double> along;
  for (const RecordedSection& section : recorded) {
    bars.push_back(section.bar);
    places.insert(places.end(), {section.body, section.element, section.end ? 1 : 0});
    along.push_back(section.along);
    channels.insert(channels.end(), section.channels.begin(), section.channels.end());
  }
  const Handle sections = create_group(root, "sections");
  write_texts(sections.get(), "bars", {bars.size()}, bars);
  write_array(sections.get(), "place", {bars.size(), 3}, H5T_STD_I32LE, H5T_NATIVE_INT, places.data());
  write_array(sections.get(), "along", {bars.size()}, along.data());
  write_array(sections.get(), "channels", {bars.size(), results_layout::numbers_per_section}, H5T_STD_I32LE,
              H5T_NATIVE_INT, channels.data());
}

void write_channel_info(hid_t root, const std::vector<ChannelInfo>& infos) {
  std::vector<std::string> names, units, meanings;
  for (const ChannelInfo& info : infos) {
    names.push_back(info.name);
    units.push_back(info.unit);
    meanings.push_back(info.meaning);
  }
  write_texts(root, "channel_names", {names.size()}, names);
  write_texts(root, "channel_units", {units.size()}, units);
  write_texts(root, "channel_meanings", {meanings.size()}, meanings);
}

/// A dataset that grows by rows, with the rows that are not written yet.
class Table {
 public:
  /// With one axis (time) or two; `columns` may be 0.
  static void create(hid_t file, const char* name, int axes, std::size_t columns) {
    const hsize_t now[2] = {0, columns};
    // HDF5 wants chunks within a fixed size, and none is smaller than 1: no columns must be able to become
    // one.
    const hsize_t most[2] = {H5S_UNLIMITED, columns ? columns : H5S_UNLIMITED};
    const hsize_t chunk[2] = {rows_per_chunk(columns), std::max<hsize_t>(columns, 1)};
    const Handle space(checked(H5Screate_simple(axes, now, most)));
    const Handle properties = creation_properties(H5P_DATASET_CREATE);
    check(H5Pset_chunk(properties.get(), axes, chunk));
    check(H5Pset_alloc_time(properties.get(), H5D_ALLOC_TIME_EARLY));
    check(H5Pset_fill_time(properties.get(), H5D_FILL_TIME_NEVER));
    const Handle data(checked(
        H5Dcreate2(file, name, H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, properties.get(), H5P_DEFAULT)));
  }

  /// One that was created so.
  Table(hid_t file, const char* name, int axes, std::size_t columns)
      : data_(checked(H5Dopen2(file, name, H5P_DEFAULT))), axes_(axes), columns_(columns) {
    buffer_.reserve(rows_per_flush * columns);
  }

  hid_t id() const { return data_.get(); }
  void add(const double* values) { buffer_.insert(buffer_.end(), values, values + columns_); }

  /// Room in the file that writing `rows` more can take.
  hsize_t bytes_for(hsize_t rows) const {
    const hsize_t chunk = rows_per_chunk(columns_);
    return (rows / chunk + 2) * chunk * 8 * columns_;
  }

  /// Room for rows up to `rows`, allocated at once; or no more than them.
  void resize(hsize_t rows) {
    const hsize_t size[2] = {rows, columns_};
    check(H5Dset_extent(data_.get(), size));
  }

  /// With that of all that was written.
  void seal() const { hdf5::seal(data_.get(), checksum_); }

  /// What was added, into room that there is.
  void write(hsize_t rows) {
    const hsize_t start[2] = {written_, 0}, count[2] = {rows, columns_};
    if (columns_ > 0) {
      const Handle file_space(checked(H5Dget_space(data_.get())));
      const Handle memory_space(checked(H5Screate_simple(axes_, count, nullptr)));
      check(H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, start, nullptr, count, nullptr));
      check(H5Dwrite(data_.get(), H5T_NATIVE_DOUBLE, memory_space.get(), file_space.get(), H5P_DEFAULT,
                     buffer_.data()));
      checksum_ = hdf5::crc32(checksum_, buffer_.data(), buffer_.size() * sizeof(double));
    }
    written_ += rows;
    buffer_.clear();
  }

 private:
  static hsize_t rows_per_chunk(hsize_t columns) {
    return std::clamp<hsize_t>(chunk_bytes / (8 * std::max<hsize_t>(columns, 1)), 16, 1024);
  }

  Handle data_;
  int axes_;
  hsize_t columns_;
  hsize_t written_ = 0;
  std::uint32_t checksum_ = 0;
  std::vector<double> buffer_;
};

}  // namespace

/// The file begins with a header that is made in memory, written at once and then called by the file's name.
/// It grows in two steps: first the operating system reserves the room, then HDF5 writes into it. So a full
/// disk is found before anything in the file has changed, and whatever is killed when, the file is whole.
struct ResultsWriter::Impl {
  std::string path, model_text, options_json;
  OutputPlace place;
  Handle file;
  std::vector<Table> tables;  ///< time, channels, poses, modes
  std::size_t channel_count = 0, body_count = 0, mode_count = 0;
  std::size_t waiting = 0;  ///< rows in the buffers
  int rows = 0;             ///< in the file
  std::size_t room = 0;     ///< rows that the tables have, whole blocks
  FlushClock clock;         ///< since they were last written
  hsize_t reserved = 0;     ///< bytes of the file on disk
  std::string failure;      ///< of the first error; nothing is written after it
  std::vector<ResultsWriter::Group> groups;

  Impl(const std::string& file_path, const ResultsHeader& header)
      : path(file_path),
        model_text(header.model_text),
        options_json(header.options_json),
        place(file_path),
        channel_count(header.channels.size()),
        body_count(header.bodies.size()) {
    if (!place.plain()) throw std::runtime_error("it is not a plain file");
    for (const BodyDrawing& body : header.bodies) mode_count += static_cast<std::size_t>(body.modes);
    place.write(beginning(header));
    const Handle access(H5Pcreate(H5P_FILE_ACCESS));
    // Index nodes lie in blocks that the file already covers, so that hardly a kill can leave one outside.
    H5Pset_meta_block_size(access.get(), metadata_block_bytes);
    // A running simulation's file may be looked at; and some network file systems cannot lock.
    H5Pset_file_locking(access.get(), false, true);
    file = Handle(checked(H5Fopen(place.path().c_str(), H5F_ACC_RDWR, access.get())));
    for_tables([&](const char* name, int axes, std::size_t columns) {
      tables.emplace_back(file.get(), name, axes, columns);
    });
    place.show();
  }

  ~Impl() { close(); }

  int descriptor() const {
    void* handle = nullptr;
    check(H5Fget_vfd_handle(file.get(), H5P_DEFAULT, &handle));
    return *static_cast<int*>(handle);
  }

  hsize_t bytes_in_use() const {
    hsize_t bytes = 0;
    check(H5Fget_filesize(file.get(), &bytes));
    return bytes;
  }

  void reserve(hsize_t bytes) {
    const hsize_t needed = bytes_in_use() + bytes + metadata_bytes;
    if (needed <= reserved) return;
    const hsize_t wanted = needed + needed / 8;  // seldom rather than often
    int error = posix_fallocate(descriptor(), 0, static_cast<off_t>(wanted));
    if (error == 0) {
      reserved = wanted;
      return;
    }
    error = posix_fallocate(descriptor(), 0, static_cast<off_t>(needed));
    if (error != 0) throw std::runtime_error(std::strerror(error));
    reserved = needed;
  }

  /// Calls make(name, axes, columns).
  template <class Make>
  void for_tables(Make&& make) const {
    make("time", 1, std::size_t{1});
    make("channels", 2, channel_count);
    make("poses", 2, 7 * body_count);
    make("modes", 2, mode_count);
  }

  /// The bytes of a file without rows.
  std::string beginning(const ResultsHeader& header) const {
    const Handle creation = creation_properties(H5P_FILE_CREATE);
    // The oldest format, which is the default, has no "open for writing" mark, which would make the file of a
    // killed run unreadable, and no checksums that half a write breaks. It takes large index nodes: with 1024
    // chunks in each, a process that is killed hardly ever is splitting one.
    H5Pset_istore_k(creation.get(), 512);
    const Handle memory = hdf5::create_in_memory(path, creation.get());
    write_header(checked(memory.get()), header);
    return hdf5::image(memory.get());
  }

  void write_header(hid_t to, const ResultsHeader& header) const {
    const Handle root(checked(H5Gopen2(to, "/", H5P_DEFAULT)));
    write_attribute(root.get(), "format", std::string(results_layout::format));
    write_attribute(root.get(), "mimbre_version", build_info().version);
    write_attribute(root.get(), "compiler", build_info().compiler);
    write_attribute(root.get(), "instructions", build_info().instructions);
    write_attribute(root.get(), "title", header.title);
    write_attribute(root.get(), "step", header.step);
    write_attribute(root.get(), "complete", 0);
    write_attribute(root.get(), "rows", 0);
    write_text(root.get(), "model", header.model_text);
    write_text(root.get(), "options", header.options_json);

    const Handle bodies = create_group(root.get(), "bodies");
    for (std::size_t k = 0; k < header.bodies.size(); ++k)
      write_body(bodies.get(), std::to_string(k), header.bodies[k]);
    const Handle roads = create_group(root.get(), "roads");
    for (std::size_t k = 0; k < header.roads.size(); ++k) {
      const Handle road = create_group(roads.get(), std::to_string(k));
      write_attribute(road.get(), "name", header.roads[k].name);
      write_array(road.get(), "profile", {size_of(header.roads[k].profile.cols()), 2},
                  header.roads[k].profile.data());
    }

    write_elements(root.get(), header);
    write_sections(root.get(), header.sections);
    write_channel_info(root.get(), header.channels);
    hdf5::seal_below(root.get());

    // These, and the root itself, get their checksums when they are whole.
    for_tables([&](const char* name, int axes, std::size_t columns) {
      Table::create(root.get(), name, axes, columns);
    });
  }

  void check_row(const ResultsRow& row) const {
    const auto expect = [](const char* what, Eigen::Index given, std::size_t wanted) {
      if (given != static_cast<Eigen::Index>(wanted))
        throw std::invalid_argument(fmt::format("a results row has {} {}, not {}", wanted, what, given));
    };
    expect("channels", row.channels.size(), channel_count);
    expect("poses", row.poses.cols(), body_count);
    expect("modes", row.modes.size(), mode_count);
  }

  /// Rows are written when a block of them is there, or have waited for long. Where they lie in the file must
  /// not depend on the clock: room is made for whole blocks.
  void flush() {
    clock.reset();
    if (waiting == 0) return;
    if (static_cast<std::size_t>(rows) + waiting > room) make_room();
    for (Table& table : tables) table.write(waiting);
    rows += static_cast<int>(waiting);
    waiting = 0;
    check(H5Fflush(file.get(), H5F_SCOPE_LOCAL));
    // Counted only once they are there: a process that is killed in between leaves rows that do not count.
    set_attribute("rows", rows);
    check(H5Fflush(file.get(), H5F_SCOPE_LOCAL));
  }

  void make_room() {
    hsize_t bytes = 0;
    for (const Table& table : tables) bytes += table.bytes_for(rows_per_flush);
    reserve(bytes);
    room += rows_per_flush;
    for (Table& table : tables) table.resize(room);
  }

  bool block_is_full() const { return (static_cast<std::size_t>(rows) + waiting) % rows_per_flush == 0; }

  void set_attribute(const char* name, int value) {
    const Handle attribute(checked(H5Aopen_by_name(file.get(), "/", name, H5P_DEFAULT, H5P_DEFAULT)));
    check(H5Awrite(attribute.get(), H5T_NATIVE_INT, &value));
  }

  void trim() {
    for (Table& table : tables) table.resize(static_cast<hsize_t>(rows));
  }

  /// Nothing changes after it.
  void seal() {
    for (const Table& table : tables) table.seal();
    const Handle root(checked(H5Gopen2(file.get(), "/", H5P_DEFAULT)));
    hdf5::seal(root.get());
  }

  void write_groups() {
    for (const ResultsWriter::Group& group : groups) {
      hsize_t bytes = metadata_bytes;
      for (const auto& [name, values] : group.columns) bytes += sizeof(float) * values.size();
      reserve(bytes);
      const Handle to = create_group(file.get(), group.name);
      for (const auto& [name, value] : group.attributes) write_attribute(to.get(), name.c_str(), value);
      for (const auto& [name, text] : group.texts) write_attribute(to.get(), name.c_str(), text);
      for (const auto& [name, values] : group.columns)
        write_array(to.get(), name.c_str(), {values.size()}, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, values.data());
      hdf5::seal_below(to.get());
      hdf5::seal(to.get());
    }
  }

  void mark_complete(const std::string& summary) {
    reserve(summary.size());
    write_text(file.get(), "summary", summary);
    const Handle written(checked(H5Dopen2(file.get(), "summary", H5P_DEFAULT)));
    hdf5::seal(written.get());
    set_attribute("complete", 1);
    check(H5Fflush(file.get(), H5F_SCOPE_LOCAL));
  }

  /// Gives back reserved room and closes. True when all went well.
  bool close() {
    if (!file.valid()) return true;
    tables.clear();
    bool good = H5Fflush(file.get(), H5F_SCOPE_LOCAL) >= 0;
    void* handle = nullptr;
    hsize_t bytes = 0;
    if (good && H5Fget_filesize(file.get(), &bytes) >= 0 &&
        H5Fget_vfd_handle(file.get(), H5P_DEFAULT, &handle) >= 0)
      good = ftruncate(*static_cast<int*>(handle), static_cast<off_t>(bytes)) == 0;
    return file.reset() && good;
  }

  std::string cannot_write(const std::string& why) const {
    return fmt::format("cannot write results file '{}': {}", path, why);
  }

  /// Does one piece of work; when it fails, closes the file and reports it, now and for every later call.
  template <class Work>
  void guarded(Work&& work) {
    if (!failure.empty()) throw std::runtime_error(failure);
    const hdf5::Quiet quiet;
    try {
      work();
    } catch (const std::exception& error) {
      close();
      failure = fmt::format("{}; the first {} rows are kept in '{}'", cannot_write(error.what()), rows,
                            place.keep());
      throw std::runtime_error(failure);
    }
  }

  /// Writes what waits, does the last piece of work, and closes.
  template <class Work>
  void end(Work&& work) {
    if (failure.empty() && !file.valid()) throw std::logic_error("a results file can be finished once only");
    guarded([&] {
      flush();
      trim();
      write_groups();
      work();
      seal();
      if (!close()) throw std::runtime_error("the file could not be closed");
    });
  }

  void commit() {
    try {
      place.commit();
    } catch (const std::runtime_error& error) {
      failure = cannot_write(error.what());
      throw std::runtime_error(failure);
    }
  }
};

ResultsWriter::ResultsWriter(const std::string& path, const ResultsHeader& header) {
  const hdf5::Quiet quiet;
  try {
    impl_ = std::make_unique<Impl>(path, header);
  } catch (const std::invalid_argument&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("cannot write results file '{}': {}", path, error.what()));
  }
}

ResultsWriter::~ResultsWriter() {
  try {
    if (!impl_->file.valid()) return;
    impl_->end([] {});
    impl_->place.keep();
  } catch (const std::exception&) {
    // A destructor cannot report; what was flushed before stays readable.
  }
}

void ResultsWriter::add(const ResultsRow& row) {
  if (!impl_->failure.empty()) throw std::runtime_error(impl_->failure);
  if (!impl_->file.valid()) throw std::logic_error("a finished results file takes no more rows");
  impl_->check_row(row);
  impl_->tables[0].add(&row.time);
  impl_->tables[1].add(row.channels.data());
  impl_->tables[2].add(row.poses.data());
  impl_->tables[3].add(row.modes.data());
  ++impl_->waiting;
  if (impl_->block_is_full() || impl_->clock.due()) impl_->guarded([&] { impl_->flush(); });
}

void ResultsWriter::flush_if_due() {
  if (impl_->waiting > 0 && impl_->file.valid() && impl_->clock.due())
    impl_->guarded([&] { impl_->flush(); });
}

void ResultsWriter::flush() {
  if (impl_->file.valid()) impl_->guarded([&] { impl_->flush(); });
}

void ResultsWriter::add_group(Group group) { impl_->groups.push_back(std::move(group)); }

std::string ResultsWriter::path() const { return impl_->place.path(); }

void ResultsWriter::finish(const std::string& summary_json) {
  impl_->end([&] { impl_->mark_complete(summary_json); });
  impl_->commit();
  results::remove_superseded_results(impl_->path, impl_->model_text, impl_->options_json);
}

std::string ResultsWriter::keep(const std::string& summary_json) {
  impl_->end([&] { impl_->mark_complete(summary_json); });
  return impl_->place.keep();
}

std::int64_t ResultsWriter::rows() const { return impl_->rows; }

}  // namespace mimbre
