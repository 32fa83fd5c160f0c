#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <new>

#include "base/checksums.h"
#include "base/hdf5.h"
#include "base/rehearsal.h"
#include "mimbre/diagnostics.h"
#include "mimbre/results.h"
#include "results/results_layout.h"

namespace mimbre {

namespace {

using hdf5::Handle;

/// Reads one results file; whatever is wrong with it becomes an InputError that names the file and the place.
class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {}

  /// Throws where something is not what was written.
  void check_sums() const {
    if (const std::string damaged = hdf5::first_damaged(file_.get()); !damaged.empty())
      refuse(hdf5::damage_message(damaged));
  }

  Results read() {
    open();
    Results results;
    const Handle root(H5Gopen2(file_.get(), "/", H5P_DEFAULT));
    if (!root.valid()) refuse("is damaged: it has no root group");
    check_format(root.get());
    ResultsHeader& header = results.header;
    header.title = text_attribute(root.get(), "/", "title");
    header.step = number_attribute(root.get(), "/", "step");
    header.model_text = text(file_.get(), "model");
    header.options_json = text(file_.get(), "options");
    if (exists(file_.get(), "summary")) results.summary_json = text(file_.get(), "summary");
    const Handle bodies = group(file_.get(), "bodies");
    for (int k = 0; exists(bodies.get(), std::to_string(k)); ++k)
      header.bodies.push_back(body(bodies.get(), k));
    const Handle roads = group(file_.get(), "roads");
    for (int k = 0; exists(roads.get(), std::to_string(k)); ++k) header.roads.push_back(road(roads.get(), k));
    // For pictures only; results are whole without them.
    if (exists(file_.get(), "frames")) read_frames(header);
    if (exists(file_.get(), "elements")) read_elements(header);
    read_rows(results, root.get());
    return results;
  }

 private:
  struct Array {
    std::vector<hsize_t> shape;
    std::vector<double> values;
  };

  [[noreturn]] void refuse(const std::string& why) const { throw InputError(Mark{path_, 0, 0}, why); }

  void open() {
    std::error_code error;
    file_bytes_ = static_cast<double>(std::filesystem::file_size(path_, error));
    if (error) refuse("cannot be read: " + error.message());
    const htri_t is_hdf5 = H5Fis_hdf5(path_.c_str());
    if (is_hdf5 < 0) refuse("cannot be read: " + hdf5::last_error());
    if (is_hdf5 == 0) refuse("not a results file (it is not in HDF5 format)");
    const Handle access(H5Pcreate(H5P_FILE_ACCESS));
    // Without a lock a file can be looked at while the run still writes it.
    H5Pset_file_locking(access.get(), false, true);
    file_ = Handle(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, access.get()));
    if (!file_.valid()) refuse("cannot be opened, it may be truncated: " + hdf5::last_error());
  }

  void check_format(hid_t root) const {
    const std::string expected = results_layout::format, stem = results_layout::format_stem;
    if (H5Aexists(root, "format") <= 0) refuse("not a results file (attribute 'format' is missing)");
    const std::string found = text_attribute(root, "/", "format");
    if (found == expected) return;
    if (found.starts_with(stem))
      refuse(fmt::format("has format '{}', this version reads '{}'", found, expected));
    refuse(fmt::format("not a results file (its format is '{}')", found));
  }

  static bool exists(hid_t parent, const std::string& name) { return hdf5::has_link(parent, name); }

  Handle group(hid_t parent, const std::string& name) const {
    Handle result = hdf5::open_group(parent, name);
    if (!result.valid()) refuse(fmt::format("group '{}' is missing", name));
    return result;
  }

  Handle dataset(hid_t parent, const std::string& name) const {
    Handle result = hdf5::open_dataset(parent, name);
    if (!result.valid())
      refuse(fmt::format("dataset '{}' is missing or damaged, or lies in another file", name));
    return result;
  }

  void require_text(const std::string& where, hid_t type) const {
    if (H5Tget_class(type) != H5T_STRING) refuse(fmt::format("{} is not text", where));
    if (H5Tis_variable_str(type) != 0)
      refuse(
          fmt::format("{} is text of variable length, as in files of version 1: this version reads '{}'; "
                      "run the model once more",
                      where, results_layout::format));
  }

  std::string text_attribute(hid_t object, const std::string& owner, const char* name) const {
    const std::string where = fmt::format("attribute '{}' of '{}'", name, owner);
    const Handle attribute(H5Aopen(object, name, H5P_DEFAULT));
    if (!attribute.valid()) refuse(where + " is missing");
    const Handle type(H5Aget_type(attribute.get())), space(H5Aget_space(attribute.get()));
    require_text(where, type.get());
    const std::size_t size = H5Tget_size(type.get());
    if (H5Sget_simple_extent_npoints(space.get()) != 1 || size == 0 || size > longest_attribute)
      refuse(where + " is not one text");
    std::string text(size, '\0');
    if (H5Aread(attribute.get(), type.get(), text.data()) < 0)
      refuse(fmt::format("{} cannot be read: {}", where, hdf5::last_error()));
    return text.substr(0, text.find('\0'));
  }

  double number_attribute(hid_t object, const std::string& owner, const char* name) const {
    const Handle attribute(H5Aopen(object, name, H5P_DEFAULT));
    if (!attribute.valid()) refuse(fmt::format("attribute '{}' of '{}' is missing", name, owner));
    const Handle space(H5Aget_space(attribute.get()));
    double value = 0;
    if (H5Sget_simple_extent_npoints(space.get()) != 1 ||
        H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &value) < 0)
      refuse(fmt::format("attribute '{}' of '{}' is not one number", name, owner));
    return value;
  }

  /// Of a dataset with one axis or none.
  std::vector<std::string> texts(hid_t parent, const std::string& name) const {
    const std::string where = fmt::format("dataset '{}'", name);
    const Handle data = dataset(parent, name);
    const Handle type(H5Dget_type(data.get())), space(H5Dget_space(data.get()));
    require_text(where, type.get());
    const hssize_t points = H5Sget_simple_extent_npoints(space.get());
    const std::size_t size = H5Tget_size(type.get());
    if (points < 0 || size == 0 || !hdf5::can_hold(file_bytes_, data.get(), static_cast<double>(points)))
      refuse(fmt::format("{} is damaged", where));
    const auto count = static_cast<std::size_t>(points);
    std::string all(size * count, '\0');
    if (count > 0 && H5Dread(data.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data()) < 0)
      refuse(fmt::format("{} cannot be read: {}", where, hdf5::last_error()));
    std::vector<std::string> result;
    for (std::size_t i = 0; i < count; ++i) {
      const std::string_view one = std::string_view(all).substr(i * size, size);
      result.emplace_back(one.substr(0, one.find('\0')));
    }
    return result;
  }

  std::string text(hid_t parent, const std::string& name) const {
    std::vector<std::string> all = texts(parent, name);
    if (all.size() != 1) refuse(fmt::format("dataset '{}' is not one text", name));
    return std::move(all[0]);
  }

  /// `shape`: what is expected along each axis, or `any`. At most `most_rows` along the first are read.
  Array array(hid_t parent, const std::string& owner, const std::string& name,
              const std::vector<hsize_t>& shape, hsize_t most_rows = any) const {
    const std::string where = fmt::format("dataset '{}{}'", owner, name);
    const Handle data = dataset(parent, name);
    const Handle space(H5Dget_space(data.get()));
    const int rank = H5Sget_simple_extent_ndims(space.get());
    if (rank != static_cast<int>(shape.size()))
      refuse(fmt::format("{} has {} axes instead of {}", where, rank, shape.size()));
    Array result;
    result.shape.resize(shape.size());
    H5Sget_simple_extent_dims(space.get(), result.shape.data(), nullptr);
    result.shape[0] = std::min(result.shape[0], most_rows);
    double count = 1;
    for (std::size_t axis = 0; axis < shape.size(); ++axis) {
      if (shape[axis] != any && result.shape[axis] != shape[axis])
        refuse(fmt::format("{} has {} instead of {} along axis {}", where, result.shape[axis], shape[axis],
                           axis + 1));
      count *= static_cast<double>(result.shape[axis]);
    }
    if (!hdf5::can_hold(file_bytes_, data.get(), count))
      refuse(fmt::format("{} announces more data than the file can hold", where));
    result.values.resize(static_cast<std::size_t>(count));
    if (count == 0) return result;
    const std::vector<hsize_t> start(shape.size(), 0);
    const Handle memory_space(H5Screate_simple(rank, result.shape.data(), nullptr));
    H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, result.shape.data(), nullptr);
    if (H5Dread(data.get(), H5T_NATIVE_DOUBLE, memory_space.get(), space.get(), H5P_DEFAULT,
                result.values.data()) < 0)
      refuse(fmt::format("{} cannot be read: {}", where, hdf5::last_error()));
    return result;
  }

  BodyDrawing body(hid_t bodies, int k) const {
    const std::string owner = fmt::format("bodies/{}/", k);
    const Handle place = group(bodies, std::to_string(k));
    BodyDrawing result;
    result.name = text_attribute(place.get(), owner, "name");
    result.line_radius = number_attribute(place.get(), owner, "line_radius");
    const double modes = number_attribute(place.get(), owner, "modes");
    if (!(modes >= 0 && modes <= std::numeric_limits<int>::max()))
      refuse(fmt::format("'{}' announces {} modes", owner, modes));
    result.modes = static_cast<int>(modes);

    const Array points = array(place.get(), owner, "points", {any, 3});
    result.points = Eigen::Map<const Eigen::Matrix3Xd>(points.values.data(), 3, index(points.shape[0]));
    const Array shapes = array(place.get(), owner, "point_shapes", {any, points.shape[0], 3});
    result.point_shapes = Eigen::Map<const Eigen::MatrixXd>(shapes.values.data(), 3 * index(points.shape[0]),
                                                            index(shapes.shape[0]));
    result.lines = tuples<2>(place.get(), owner, "lines", points.shape[0]);
    if (exists(place.get(), "triangles"))
      result.triangles = tuples<3>(place.get(), owner, "triangles", points.shape[0]);
    if (exists(place.get(), "labels"))
      for (const double label : array(place.get(), owner, "labels", {points.shape[0]}).values)
        result.labels.push_back(static_cast<std::int64_t>(label));
    if (exists(place.get(), "stress")) {
      const Array stress = array(place.get(), owner, "stress", {any, points.shape[0], 6});
      result.stress = Eigen::Map<const Eigen::MatrixXd>(stress.values.data(), 6 * index(points.shape[0]),
                                                        index(stress.shape[0]));
      if (result.stress.cols() > result.modes)
        refuse(fmt::format("'{}' has stress by {} modes, of {}", owner, result.stress.cols(), result.modes));
    }
    if (exists(place.get(), "bar_stress")) {
      const hsize_t lines = result.lines.size();
      const Array round = array(place.get(), owner, "round_lines", {lines});
      result.round_lines.assign(round.values.begin(), round.values.end());
      const Array stress = array(place.get(), owner, "bar_stress", {any, 2 * lines, 4});
      result.bar_stress =
          Eigen::Map<const Eigen::MatrixXd>(stress.values.data(), 8 * index(lines), index(stress.shape[0]));
      if (result.bar_stress.cols() > result.modes)
        refuse(fmt::format("'{}' has stress of bars by {} modes, of {}", owner, result.bar_stress.cols(),
                           result.modes));
    }
    const Array solids = array(place.get(), owner, "shapes", {any, results_layout::numbers_per_shape});
    for (hsize_t s = 0; s < solids.shape[0]; ++s)
      result.shapes.push_back(shape(&solids.values[s * results_layout::numbers_per_shape], owner));
    return result;
  }

  template <std::size_t Corners>
  std::vector<std::array<int, Corners>> tuples(hid_t place, const std::string& owner, const char* name,
                                               hsize_t points) const {
    const Array read = array(place, owner, name, {any, Corners});
    std::vector<std::array<int, Corners>> result(read.values.size() / Corners);
    for (std::size_t i = 0; i < read.values.size(); ++i) {
      const double point = read.values[i];
      if (!(point >= 0 && point < static_cast<double>(points)))
        refuse(fmt::format("one of the {} of '{}' ends at point {}, of {}", name, owner, point, points));
      result[i / Corners][i % Corners] = static_cast<int>(point);
    }
    return result;
  }

  spec::Shape shape(const double* numbers, const std::string& owner) const {
    const double kind = numbers[0];
    if (kind != 0 && kind != 1 && kind != 2)
      refuse(fmt::format("'{}' has a shape of unknown kind {}", owner, kind));
    spec::Shape result;
    result.kind = static_cast<spec::Shape::Kind>(static_cast<int>(kind));
    result.size = Eigen::Map<const Eigen::Vector3d>(numbers + 1);
    result.pose.position = Eigen::Map<const Eigen::Vector3d>(numbers + 4);
    result.pose.rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers + 7);
    return result;
  }

  RoadDrawing road(hid_t roads, int k) const {
    const std::string owner = fmt::format("roads/{}/", k);
    const Handle place = group(roads, std::to_string(k));
    RoadDrawing result;
    result.name = text_attribute(place.get(), owner, "name");
    const Array profile = array(place.get(), owner, "profile", {any, 2});
    result.profile = Eigen::Map<const Eigen::Matrix2Xd>(profile.values.data(), 2, index(profile.shape[0]));
    return result;
  }

  void read_frames(ResultsHeader& header) const {
    const std::string owner = "frames/";
    const Handle place = group(file_.get(), "frames");
    const std::vector<std::string> names = texts(place.get(), "names");
    const Array bodies = array(place.get(), owner, "body", {names.size()});
    const Array poses = array(place.get(), owner, "pose", {names.size(), results_layout::numbers_per_pose});
    const Array motions = array(place.get(), owner, "motion", {any, 6});
    const auto body_count = static_cast<double>(header.bodies.size());
    hsize_t at = 0;
    for (std::size_t k = 0; k < names.size(); ++k) {
      const double body = bodies.values[k];
      if (!(body >= spec::ground && body < body_count))
        refuse(fmt::format("frame {} is on body {}, of {}", k, body, body_count));
      const double* const pose = &poses.values[k * results_layout::numbers_per_pose];
      FrameDrawing frame{names[k], static_cast<int>(body), {}, {}};
      frame.pose.position = Eigen::Map<const Eigen::Vector3d>(pose);
      frame.pose.rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose + 3);
      const int modes = frame.body < 0 ? 0 : header.bodies[static_cast<std::size_t>(frame.body)].modes;
      if (static_cast<hsize_t>(modes) > motions.shape[0] - at)
        refuse(
            fmt::format("dataset 'frames/motion' has {} modes, which end at frame {}", motions.shape[0], k));
      frame.motion = Eigen::Map<const Eigen::MatrixXd>(motions.values.data() + 6 * at, 6, modes);
      at += static_cast<hsize_t>(modes);
      header.frames.push_back(std::move(frame));
    }
  }

  void read_elements(ResultsHeader& header) const {
    const std::string owner = "elements/";
    const Handle place = group(file_.get(), "elements");
    const std::vector<std::string> names = texts(place.get(), "names");
    const std::vector<std::string> kinds = texts(place.get(), "kinds");
    if (kinds.size() != names.size())
      refuse(fmt::format("group 'elements' has {} names and {} kinds", names.size(), kinds.size()));
    const Array ends = array(place.get(), owner, "frames", {names.size(), 2});
    const Array sizes = array(place.get(), owner, "size", {names.size()});
    const auto frame = [&](double end) {
      if (!(end >= -1 && end < static_cast<double>(header.frames.size())))
        refuse(fmt::format("an element is at frame {}, of {}", end, header.frames.size()));
      return static_cast<int>(end);
    };
    for (std::size_t k = 0; k < names.size(); ++k)
      header.elements.push_back({names[k],
                                 kinds[k],
                                 frame(ends.values[2 * k]),
                                 frame(ends.values[2 * k + 1]),
                                 sizes.values[k],
                                 {}});
    if (exists(place.get(), "curves")) read_curves(place.get(), header);
  }

  void read_curves(hid_t elements, ResultsHeader& header) const {
    const std::string owner = "elements/";
    const Array counts = array(elements, owner, "curve_points", {header.elements.size()});
    const Array points = array(elements, owner, "curves", {any, 3});
    hsize_t at = 0;
    for (std::size_t k = 0; k < header.elements.size(); ++k) {
      const double count = counts.values[k];
      if (!(count >= 0 && count <= static_cast<double>(points.shape[0] - at)))
        refuse(fmt::format("a curve has {} points, of {} that are left", count, points.shape[0] - at));
      header.elements[k].curve = Eigen::Map<const Eigen::Matrix3Xd>(points.values.data() + 3 * at, 3,
                                                                    static_cast<Eigen::Index>(count));
      at += static_cast<hsize_t>(count);
    }
  }

  void read_sections(ResultsHeader& header) const {
    const std::string owner = "sections/";
    const Handle group_of_all = group(file_.get(), "sections");
    const std::vector<std::string> bars = texts(group_of_all.get(), "bars");
    const hsize_t count = bars.size(), columns = results_layout::numbers_per_section;
    const Array places = array(group_of_all.get(), owner, "place", {count, 3});
    const Array along = array(group_of_all.get(), owner, "along", {count});
    const Array channels = array(group_of_all.get(), owner, "channels", {count, columns});
    const auto within = [&](double number, double least, std::size_t end, const char* what) {
      if (!(number >= least && number < static_cast<double>(end)))
        refuse(fmt::format("a section has {} {}, of {}", what, number, end));
      return static_cast<int>(number);
    };
    for (std::size_t k = 0; k < count; ++k) {
      const double* const place = &places.values[3 * k];
      RecordedSection section;
      section.body = within(place[0], 0, header.bodies.size(), "body");
      section.bar = bars[k];
      section.element = within(place[1], 1, std::numeric_limits<int>::max(), "element");
      section.end = place[2] != 0;
      section.along = along.values[k];
      for (std::size_t c = 0; c < columns; ++c)
        section.channels[c] = within(channels.values[columns * k + c], -1, header.channels.size(), "channel");
      header.sections.push_back(std::move(section));
    }
  }

  std::vector<ChannelInfo> channel_infos() const {
    const std::vector<std::string> names = texts(file_.get(), "channel_names");
    const std::vector<std::string> units = texts(file_.get(), "channel_units");
    const std::vector<std::string> meanings = texts(file_.get(), "channel_meanings");
    if (units.size() != names.size() || meanings.size() != names.size())
      refuse(fmt::format("has {} names of channels, {} units and {} meanings", names.size(), units.size(),
                         meanings.size()));
    std::vector<ChannelInfo> result;
    for (std::size_t i = 0; i < names.size(); ++i) result.push_back({names[i], units[i], meanings[i]});
    return result;
  }

  void read_rows(Results& results, hid_t root) const {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    ResultsHeader& header = results.header;
    header.channels = channel_infos();
    if (exists(file_.get(), "sections")) read_sections(header);
    hsize_t mode_count = 0;
    for (const BodyDrawing& one : header.bodies) mode_count += static_cast<hsize_t>(one.modes);
    const hsize_t pose_numbers = 7 * header.bodies.size();

    // A run that was killed while it wrote may have announced more rows than it counted.
    const double counted = number_attribute(root, "/", "rows");
    if (!(counted >= 0 && counted <= std::numeric_limits<int>::max()))
      refuse(fmt::format("announces {} rows", counted));
    const auto rows = static_cast<hsize_t>(counted);
    const Array time = array(file_.get(), "", "time", {any}, rows);
    const Array channels = array(file_.get(), "", "channels", {any, header.channels.size()}, rows);
    const Array poses = array(file_.get(), "", "poses", {any, pose_numbers}, rows);
    const Array modes = array(file_.get(), "", "modes", {any, mode_count}, rows);
    for (const Array* one : {&time, &channels, &poses, &modes})
      if (one->shape[0] != rows) refuse(fmt::format("holds {} rows where it counts {}", one->shape[0], rows));

    results.time = Eigen::Map<const Eigen::VectorXd>(time.values.data(), index(rows));
    results.channels =
        Eigen::Map<const RowMajor>(channels.values.data(), index(rows), index(header.channels.size()));
    results.modes = Eigen::Map<const RowMajor>(modes.values.data(), index(rows), index(mode_count));
    for (hsize_t row = 0; row < rows; ++row)
      results.poses.emplace_back(Eigen::Map<const Eigen::Matrix<double, 7, Eigen::Dynamic>>(
          poses.values.data() + row * pose_numbers, 7, index(header.bodies.size())));
  }

  static Eigen::Index index(hsize_t count) { return static_cast<Eigen::Index>(count); }

  static constexpr hsize_t any = std::numeric_limits<hsize_t>::max();
  static constexpr std::size_t longest_attribute = 65'536;

  std::string path_;
  Handle file_;
  double file_bytes_ = 0;
};

/// Before anything opens it: a pipe would wait for ever.
void require_plain_file(const std::string& path) {
  const auto refuse = [&](const std::string& why) { throw InputError(Mark{path, 0, 0}, why); };
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status))
    refuse(error && error != std::errc::no_such_file_or_directory ? "cannot be read: " + error.message()
                                                                  : "no such file");
  if (!std::filesystem::is_regular_file(status)) refuse("not a file");
}

}  // namespace

Results read_results(const std::string& path) {
  const hdf5::Quiet quiet;
  try {
    require_plain_file(path);
    const bool sums_were_right = rehearse("results", path);
    Reader reader(path);
    Results results = reader.read();
    if (!sums_were_right) reader.check_sums();
    return results;
  } catch (const std::bad_alloc&) {
    throw InputError(Mark{path, 0, 0}, "needs more memory than there is");
  }
}

}  // namespace mimbre
