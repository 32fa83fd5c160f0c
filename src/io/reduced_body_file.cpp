#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <new>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "mimbre/diagnostics.h"
#include "mimbre/reduced_body.h"

// The layout is in docs/reduced-body-format.md. Arrays go through row-major buffers because HDF5 is
// row-major.

namespace mimbre {
namespace {

constexpr const char* kFormat = "mimbre-reduced-body-1";
/// In the order of BoundaryRotation.
const std::array<std::string, 3> kRotations{"exponential", "successive", "infinitesimal"};
/// More than any real body has: a damaged or hostile file must not make us ask for all of the memory.
constexpr std::uint64_t kMaxElements = std::uint64_t{1} << 27;

using Shape = std::vector<hsize_t>;

/// What goes wrong inside; save and load turn it into an InputError with the file's name.
struct FileProblem : std::runtime_error {
  using std::runtime_error::runtime_error;
};

hid_t checked(hid_t id, const std::string& problem) {
  if (id < 0) throw FileProblem(problem);
  return id;
}

/// Owns one HDF5 identifier.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t), const std::string& problem)
      : id_(checked(id, problem)), close_(close) {}
  ~Handle() { close_(id_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// Keeps HDF5 from printing its error stack while it lives: we report errors ourselves.
class SilentErrors {
 public:
  SilentErrors() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~SilentErrors() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  SilentErrors(const SilentErrors&) = delete;
  SilentErrors& operator=(const SilentErrors&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

std::uint64_t element_count(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::uint64_t{1}, std::multiplies<>());
}

std::string to_string(const Shape& shape) { return fmt::format("{}", fmt::join(shape, " x ")); }

Handle dataspace(const Shape& shape) {
  return {shape.empty() ? H5Screate(H5S_SCALAR)
                        : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
          H5Sclose, "cannot describe an array"};
}

/// Row-major entries of a column-major matrix.
template <typename Derived>
void append_rows(std::vector<double>& buffer, const Eigen::MatrixBase<Derived>& matrix) {
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) buffer.push_back(matrix(i, j));
}

// ----------------------------------------------------------------------------------------------------
// writing

/// A creation property list without time stamps, so that the same body gives the same bytes.
Handle without_times(hid_t property_class) {
  const hid_t list = checked(H5Pcreate(property_class), "cannot create a property list");
  H5Pset_obj_track_times(list, false);
  return {list, H5Pclose, {}};
}

void write_data(hid_t place, const std::string& name, const Shape& shape, hid_t file_type, hid_t memory_type,
                const void* data) {
  const std::string problem = fmt::format("cannot write '{}'", name);
  const Handle space = dataspace(shape);
  const Handle creation = without_times(H5P_DATASET_CREATE);
  const Handle set(H5Dcreate2(place, name.c_str(), file_type, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                   H5Dclose, problem);
  if (element_count(shape) > 0)
    checked(H5Dwrite(set, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), problem);
}

void write_doubles(hid_t place, const std::string& name, const Shape& shape,
                   const std::vector<double>& data) {
  write_data(place, name, shape, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, data.data());
}

template <typename Derived>
void write_matrix(hid_t place, const std::string& name, const Eigen::MatrixBase<Derived>& matrix) {
  std::vector<double> buffer;
  append_rows(buffer, matrix);
  Shape shape{static_cast<hsize_t>(matrix.rows())};
  if constexpr (Derived::ColsAtCompileTime != 1) shape.push_back(static_cast<hsize_t>(matrix.cols()));
  write_doubles(place, name, shape, buffer);
}

void write_attribute(hid_t place, const std::string& name, hid_t file_type, hid_t memory_type,
                     const void* data) {
  const std::string problem = fmt::format("cannot write attribute '{}'", name);
  const Handle space = dataspace({});
  const Handle attribute(H5Acreate2(place, name.c_str(), file_type, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose, problem);
  checked(H5Awrite(attribute, memory_type, data), problem);
}

/// UTF-8 text of fixed length, filled up with zeros: variable-length text would put its bytes into a shared
/// heap.
Handle text_type(std::size_t size) {
  const hid_t type = checked(H5Tcopy(H5T_C_S1), "cannot create a text type");
  H5Tset_size(type, std::max<std::size_t>(size, 1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return {type, H5Tclose, {}};
}

void write_text_attribute(hid_t place, const std::string& name, std::string text) {
  const Handle type = text_type(text.size());
  text.resize(std::max<std::size_t>(text.size(), 1));
  write_attribute(place, name, type, type, text.data());
}

void write_texts(hid_t place, const std::string& name, const std::vector<std::string>& texts) {
  std::size_t size = 1;
  for (const std::string& text : texts) size = std::max(size, text.size());
  std::string buffer;
  for (const std::string& text : texts) buffer += text + std::string(size - text.size(), '\0');
  const Handle type = text_type(size);
  write_data(place, name, {texts.size()}, type, type, buffer.data());
}

Handle create_group(hid_t place, const std::string& name) {
  const Handle creation = without_times(H5P_GROUP_CREATE);
  return {H5Gcreate2(place, name.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose,
          fmt::format("cannot create group '{}'", name)};
}

/// Each line's name, "passed" or "failed", and detail.
void write_checks(hid_t place, const std::vector<Check>& checks) {
  std::vector<std::string> texts;
  for (const Check& c : checks) {
    texts.push_back(c.name);
    texts.push_back(c.passed ? "passed" : "failed");
    texts.push_back(c.detail);
  }
  write_texts(place, "checks", texts);
}

void write_frame(hid_t place, const std::string& name, const BodyFrame& frame) {
  const Handle group = create_group(place, name);
  write_text_attribute(group, "name", frame.name);
  write_matrix(group, "position", frame.position);
  write_matrix(group, "rotation", frame.rotation);
  write_matrix(group, "X", frame.X);
  write_matrix(group, "X_theta", frame.X_theta);
}

void write_integers(hid_t place, const std::string& name, const Shape& shape,
                    const std::vector<std::int32_t>& data) {
  write_data(place, name, shape, H5T_STD_I32LE, H5T_NATIVE_INT32, data.data());
}

/// Lines, or triangles.
template <std::size_t Corners>
void write_tuples(hid_t file, const std::string& name, const std::vector<std::array<int, Corners>>& tuples) {
  std::vector<std::int32_t> buffer;
  for (const auto& tuple : tuples) buffer.insert(buffer.end(), tuple.begin(), tuple.end());
  write_integers(file, name, {tuples.size(), Corners}, buffer);
}

/// Entries in the order of columns, then rows.
void write_sparse(hid_t place, const std::string& name, const Eigen::SparseMatrix<double>& matrix) {
  std::vector<std::int32_t> places;
  std::vector<double> values;
  for (int c = 0; c < matrix.outerSize(); ++c)
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, c); it; ++it) {
      places.insert(places.end(), {static_cast<std::int32_t>(it.row()), c});
      values.push_back(it.value());
    }
  const Handle group = create_group(place, name);
  write_integers(group, "places", {values.size(), 2}, places);
  write_doubles(group, "values", {values.size()}, values);
}

void write_mesh(hid_t file, const MeshInertia& mesh) {
  const Handle group = create_group(file, "mesh_inertia");
  write_attribute(group, "dofs_per_node", H5T_STD_I32LE, H5T_NATIVE_INT, &mesh.dofs_per_node);
  write_sparse(group, "mass", mesh.mass);
  if (mesh.nodal_mass.size() > 0) write_sparse(group, "nodal_mass", mesh.nodal_mass);
  write_matrix(group, "shapes", mesh.shapes.transpose());
}

/// S, S_position and S_modes, of the modes or of the extended amplitudes.
template <typename Body>
void write_integrals(hid_t place, const Body& body) {
  const auto modes = static_cast<hsize_t>(body.S.cols());
  write_matrix(place, "S", body.S);
  std::vector<double> positions;
  std::vector<double> pairs;
  for (int i = 0; i < 3; ++i) {
    append_rows(positions, body.S_position[i]);
    for (int j = 0; j < 3; ++j) append_rows(pairs, body.S_modes[i][j]);
  }
  write_doubles(place, "S_position", {3, 3, modes}, positions);
  write_doubles(place, "S_modes", {3, 3, modes, modes}, pairs);
}

/// modes × nodes × components: the transpose of the matrix, whose rows run over nodes, then components.
void write_node_field(hid_t place, const std::string& name, const Eigen::MatrixXd& field, int components) {
  std::vector<double> values;
  append_rows(values, field.transpose());
  write_doubles(place, name,
                {static_cast<hsize_t>(field.cols()), static_cast<hsize_t>(field.rows() / components),
                 static_cast<hsize_t>(components)},
                values);
}

/// Matrices of the same shape one after the other.
template <typename Matrices>
void write_stack(hid_t place, const std::string& name, const Matrices& matrices, Eigen::Index rows,
                 Eigen::Index columns) {
  std::vector<double> buffer;
  for (const auto& matrix : matrices) append_rows(buffer, matrix);
  write_doubles(place, name, {matrices.size(), static_cast<hsize_t>(rows), static_cast<hsize_t>(columns)},
                buffer);
}

void write_geometric_stiffness(hid_t file, const GeometricStiffness& geometric) {
  const Handle group = create_group(file, "geometric_stiffness");
  write_integers(group, "loads", {geometric.loads.size()}, {geometric.loads.begin(), geometric.loads.end()});
  const Eigen::Index modes = geometric.boundary_loads.cols();
  write_stack(group, "stiffness", geometric.stiffness, modes, modes);
  write_matrix(group, "boundary_loads", geometric.boundary_loads);
}

void write_second_order(hid_t file, const SecondOrder& second) {
  const Handle group = create_group(file, "second_order");
  std::vector<std::int32_t> products;
  for (const auto& product : second.products) products.insert(products.end(), product.begin(), product.end());
  write_integers(group, "products", {second.products.size(), 2}, products);
  write_integrals(group, second);
  write_matrix(group, "mass_matrix", second.mass_matrix);
  write_matrix(group, "stiffness", second.stiffness);
  write_stack(group, "frame_shapes", second.frame_shapes, 3, second.S.cols());
  write_node_field(group, "node_shapes", second.node_shapes, 3);
  if (second.mesh_shapes.size() > 0) write_matrix(group, "mesh_shapes", second.mesh_shapes.transpose());
}

void write_body(hid_t file, const ReducedBody& body) {
  write_text_attribute(file, "format", kFormat);
  write_text_attribute(file, "name", body.name);
  write_attribute(file, "modes", H5T_STD_I32LE, H5T_NATIVE_INT, &body.modes);
  write_attribute(file, "mass", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &body.mass);
  write_attribute(file, "line_radius", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &body.line_radius);
  write_texts(file, "mode_names", body.mode_names);
  if (!body.checks.empty()) write_checks(file, body.checks);
  if (body.boundary_rotation != BoundaryRotation::exponential)
    write_texts(file, "boundary_rotation", {kRotations[static_cast<std::size_t>(body.boundary_rotation)]});
  write_matrix(file, "first_moment", body.first_moment);
  write_matrix(file, "second_moment", body.second_moment);
  write_integrals(file, body);
  write_matrix(file, "mass_matrix", body.mass_matrix);
  write_matrix(file, "stiffness", body.stiffness);
  write_matrix(file, "damping", body.damping);
  write_matrix(file, "user_from_modal", body.user_from_modal);
  write_matrix(file, "eigenfrequencies", body.eigenfrequencies);
  write_matrix(file, "nodes", body.nodes.transpose());
  write_node_field(file, "node_shapes", body.node_shapes, 3);
  write_tuples(file, "lines", body.lines);
  if (!body.triangles.empty()) write_tuples(file, "triangles", body.triangles);
  if (!body.node_labels.empty())
    write_data(file, "node_labels", {body.node_labels.size()}, H5T_STD_I64LE, H5T_NATIVE_INT64,
               body.node_labels.data());
  if (body.stress.size() > 0) write_node_field(file, "stress", body.stress, 6);
  if (body.strain.size() > 0) write_node_field(file, "strain", body.strain, 6);
  const Handle frames = create_group(file, "frames");
  for (std::size_t k = 0; k < body.frames.size(); ++k) write_frame(frames, std::to_string(k), body.frames[k]);
  if (body.mesh_inertia) write_mesh(file, *body.mesh_inertia);
  if (body.geometric) write_geometric_stiffness(file, *body.geometric);
  if (body.second_order) write_second_order(file, *body.second_order);
}

// ----------------------------------------------------------------------------------------------------
// reading

/// The dataset's shape, after a check that it is one and of a size that can be read.
Shape shape_of(hid_t set, const std::string& name) {
  const Handle space(H5Dget_space(set), H5Sclose, fmt::format("'{}' has no shape", name));
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 0) throw FileProblem(fmt::format("'{}' has no shape", name));
  Shape shape(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space, shape.data(), nullptr);
  std::uint64_t count = 1;
  for (hsize_t extent : shape) {
    if (extent > kMaxElements || (count *= extent) > kMaxElements)
      throw FileProblem(fmt::format("'{}' is too large: {}", name, to_string(shape)));
  }
  return shape;
}

Handle open_dataset(hid_t place, const std::string& name) {
  return {H5Dopen2(place, name.c_str(), H5P_DEFAULT), H5Dclose, fmt::format("dataset '{}' is missing", name)};
}

constexpr hsize_t kAny = std::numeric_limits<hsize_t>::max();

/// Compares with `expected`, where kAny stands for any extent.
void require_shape(const std::string& name, const Shape& shape, const Shape& expected) {
  bool same = shape.size() == expected.size();
  for (std::size_t i = 0; same && i < shape.size(); ++i)
    same = expected[i] == kAny || shape[i] == expected[i];
  if (same) return;
  std::vector<std::string> words;
  for (hsize_t extent : expected) words.push_back(extent == kAny ? "any" : std::to_string(extent));
  throw FileProblem(fmt::format("dataset '{}' must be {}, is {}", name, fmt::join(words, " x "),
                                shape.empty() ? "a single value" : to_string(shape)));
}

template <typename Number>
std::pair<std::vector<Number>, Shape> read_numbers(hid_t place, const std::string& name,
                                                   const Shape& expected, hid_t memory_type) {
  const Handle set = open_dataset(place, name);
  const Shape shape = shape_of(set, name);
  require_shape(name, shape, expected);
  std::vector<Number> data(element_count(shape));
  if (!data.empty())
    checked(H5Dread(set, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()),
            fmt::format("dataset '{}' cannot be read as numbers", name));
  return {std::move(data), shape};
}

std::vector<double> read_doubles(hid_t place, const std::string& name, const Shape& expected) {
  return read_numbers<double>(place, name, expected, H5T_NATIVE_DOUBLE).first;
}

Eigen::MatrixXd from_rows(const double* data, Eigen::Index rows, Eigen::Index columns) {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  return Eigen::Map<const RowMajor>(data, rows, columns);
}

Eigen::MatrixXd read_matrix(hid_t place, const std::string& name, hsize_t rows, hsize_t columns) {
  const std::vector<double> data = read_doubles(place, name, {rows, columns});
  return from_rows(data.data(), static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
}

Handle open_attribute(hid_t place, const std::string& name) {
  return {H5Aopen(place, name.c_str(), H5P_DEFAULT), H5Aclose,
          fmt::format("attribute '{}' is missing", name)};
}

/// Before reading into one value's memory.
void require_single(hid_t attribute, const std::string& name) {
  const Handle space(H5Aget_space(attribute), H5Sclose, fmt::format("attribute '{}' has no shape", name));
  if (H5Sget_simple_extent_npoints(space) != 1)
    throw FileProblem(fmt::format("attribute '{}' must be a single value", name));
}

template <typename Number>
Number read_number_attribute(hid_t place, const std::string& name, hid_t memory_type) {
  const Handle attribute = open_attribute(place, name);
  require_single(attribute, name);
  Number value{};
  checked(H5Aread(attribute, memory_type, &value), fmt::format("attribute '{}' must be a number", name));
  return value;
}

/// Bytes of one fixed-length text; other writers' variable-length ones are refused with a clear message.
std::size_t text_size(hid_t type, const std::string& name) {
  if (H5Tget_class(type) != H5T_STRING) throw FileProblem(fmt::format("'{}' must be text", name));
  if (H5Tis_variable_str(type) > 0) throw FileProblem(fmt::format("'{}' must be text of fixed length", name));
  const std::size_t size = H5Tget_size(type);
  if (size > 65536) throw FileProblem(fmt::format("text '{}' is too long", name));
  return size;
}

std::string without_padding(const std::string& text) { return text.substr(0, text.find('\0')); }

std::string read_text_attribute(hid_t place, const std::string& name) {
  const Handle attribute = open_attribute(place, name);
  require_single(attribute, name);
  const Handle type(H5Aget_type(attribute), H5Tclose, fmt::format("attribute '{}' has no type", name));
  std::string text(text_size(type, name), '\0');
  checked(H5Aread(attribute, type, text.data()), fmt::format("attribute '{}' cannot be read", name));
  return without_padding(text);
}

std::vector<std::string> read_texts(hid_t place, const std::string& name, hsize_t count) {
  const Handle set = open_dataset(place, name);
  require_shape(name, shape_of(set, name), {count});
  const Handle type(H5Dget_type(set), H5Tclose, fmt::format("dataset '{}' has no type", name));
  const std::size_t size = text_size(type, name);
  if (size * count > kMaxElements) throw FileProblem(fmt::format("'{}' is too large", name));
  std::string buffer(size * count, '\0');
  if (count > 0)
    checked(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, buffer.data()),
            fmt::format("dataset '{}' cannot be read", name));
  std::vector<std::string> texts;
  for (hsize_t i = 0; i < count; ++i) texts.push_back(without_padding(buffer.substr(i * size, size)));
  return texts;
}

BoundaryRotation read_rotation(hid_t place) {
  const std::string name = read_texts(place, "boundary_rotation", 1).front();
  const auto found = std::find(kRotations.begin(), kRotations.end(), name);
  if (found == kRotations.end())
    throw FileProblem(
        fmt::format("'boundary_rotation' is '{}', expected exponential, successive or infinitesimal", name));
  return static_cast<BoundaryRotation>(found - kRotations.begin());
}

std::vector<Check> read_checks(hid_t place) {
  const std::vector<hsize_t> shape = shape_of(open_dataset(place, "checks"), "checks");
  if (shape.size() != 1 || shape[0] % 3 != 0) throw FileProblem("'checks' must have three texts per line");
  const std::vector<std::string> texts = read_texts(place, "checks", shape[0]);
  std::vector<Check> checks;
  for (std::size_t k = 0; k < texts.size(); k += 3)
    checks.push_back({texts[k], texts[k + 1] == "passed", texts[k + 2]});
  return checks;
}

BodyFrame read_frame(hid_t place, const std::string& name, hsize_t modes) {
  const Handle group(H5Gopen2(place, name.c_str(), H5P_DEFAULT), H5Gclose,
                     fmt::format("group 'frames/{}' is missing", name));
  try {
    BodyFrame frame;
    frame.name = read_text_attribute(group, "name");
    frame.position = Eigen::Vector3d(read_doubles(group, "position", {3}).data());
    frame.rotation = read_matrix(group, "rotation", 3, 3);
    frame.X = read_matrix(group, "X", 3, modes);
    frame.X_theta = read_matrix(group, "X_theta", 3, modes);
    return frame;
  } catch (const FileProblem& problem) {
    throw FileProblem(fmt::format("group 'frames/{}': {}", name, problem.what()));
  }
}

std::vector<BodyFrame> read_frames(hid_t file, hsize_t modes) {
  const Handle group(H5Gopen2(file, "frames", H5P_DEFAULT), H5Gclose, "group 'frames' is missing");
  H5G_info_t info{};
  checked(H5Gget_info(group, &info), "group 'frames' cannot be read");
  std::vector<BodyFrame> frames;
  for (hsize_t k = 0; k < info.nlinks; ++k) frames.push_back(read_frame(group, std::to_string(k), modes));
  return frames;
}

template <std::size_t Corners>
std::vector<std::array<int, Corners>> read_tuples(hid_t file, const std::string& name) {
  const auto [data, shape] = read_numbers<int>(file, name, {kAny, Corners}, H5T_NATIVE_INT);
  std::vector<std::array<int, Corners>> tuples(shape[0]);
  for (std::size_t i = 0; i < data.size(); ++i) tuples[i / Corners][i % Corners] = data[i];
  return tuples;
}

bool has_link(hid_t place, const std::string& name) {
  return H5Lexists(place, name.c_str(), H5P_DEFAULT) > 0;
}

Handle open_group(hid_t place, const std::string& name) {
  return {H5Gopen2(place, name.c_str(), H5P_DEFAULT), H5Gclose, fmt::format("group '{}' is missing", name)};
}

Eigen::SparseMatrix<double> read_sparse(hid_t place, const std::string& name, Eigen::Index size) {
  const Handle group = open_group(place, name);
  const auto [places, shape] = read_numbers<std::int64_t>(group, "places", {kAny, 2}, H5T_NATIVE_INT64);
  const std::vector<double> values = read_doubles(group, "values", {shape[0]});
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(values.size());
  for (std::size_t k = 0; k < values.size(); ++k) {
    const std::int64_t row = places[2 * k], column = places[2 * k + 1];
    if (row < 0 || row >= size || column < 0 || column >= size)
      throw FileProblem(
          fmt::format("'{}' has an entry at ({}, {}), outside of {} x {}", name, row, column, size, size));
    entries.emplace_back(static_cast<int>(row), static_cast<int>(column), values[k]);
  }
  Eigen::SparseMatrix<double> matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

MeshInertia read_mesh(hid_t file, Eigen::Index nodes, Eigen::Index modes) {
  const Handle group = open_group(file, "mesh_inertia");
  try {
    MeshInertia mesh;
    mesh.dofs_per_node = read_number_attribute<int>(group, "dofs_per_node", H5T_NATIVE_INT);
    if (mesh.dofs_per_node != 3 && mesh.dofs_per_node != 6)
      throw FileProblem(fmt::format("attribute 'dofs_per_node' must be 3 or 6, is {}", mesh.dofs_per_node));
    const Eigen::Index dofs = mesh.dofs_per_node * nodes;
    mesh.mass = read_sparse(group, "mass", dofs);
    if (has_link(group, "nodal_mass")) mesh.nodal_mass = read_sparse(group, "nodal_mass", nodes);
    mesh.shapes =
        read_matrix(group, "shapes", static_cast<hsize_t>(modes), static_cast<hsize_t>(dofs)).transpose();
    return mesh;
  } catch (const FileProblem& problem) {
    throw FileProblem(fmt::format("group 'mesh_inertia': {}", problem.what()));
  }
}

template <typename Body>
void read_integrals(hid_t place, Eigen::Index n, Body& body) {
  const auto modes = static_cast<hsize_t>(n);
  body.S = read_matrix(place, "S", 3, modes);
  const std::vector<double> positions = read_doubles(place, "S_position", {3, 3, modes});
  const std::vector<double> pairs = read_doubles(place, "S_modes", {3, 3, modes, modes});
  for (int i = 0; i < 3; ++i) {
    body.S_position[i] = from_rows(positions.data() + 3 * n * i, 3, n);
    for (int j = 0; j < 3; ++j) body.S_modes[i][j] = from_rows(pairs.data() + n * n * (3 * i + j), n, n);
  }
}

Eigen::MatrixXd read_node_field(hid_t place, const std::string& name, Eigen::Index modes, Eigen::Index points,
                                int components) {
  const std::vector<double> values = read_doubles(
      place, name,
      {static_cast<hsize_t>(modes), static_cast<hsize_t>(points), static_cast<hsize_t>(components)});
  return from_rows(values.data(), modes, components * points).transpose();
}

/// What write_stack wrote.
template <typename Matrix>
std::vector<Matrix> read_stack(hid_t place, const std::string& name, std::size_t count, Eigen::Index rows,
                               Eigen::Index columns) {
  const std::vector<double> data =
      read_doubles(place, name, {count, static_cast<hsize_t>(rows), static_cast<hsize_t>(columns)});
  std::vector<Matrix> matrices;
  for (std::size_t k = 0; k < count; ++k)
    matrices.push_back(from_rows(data.data() + static_cast<Eigen::Index>(k) * rows * columns, rows, columns));
  return matrices;
}

GeometricStiffness read_geometric_stiffness(hid_t file, Eigen::Index modes) {
  const Handle group = open_group(file, "geometric_stiffness");
  try {
    GeometricStiffness geometric;
    geometric.loads = read_numbers<int>(group, "loads", {kAny}, H5T_NATIVE_INT).first;
    geometric.stiffness =
        read_stack<Eigen::MatrixXd>(group, "stiffness", geometric.loads.size(), modes, modes);
    const auto [rows, shape] =
        read_numbers<double>(group, "boundary_loads", {kAny, static_cast<hsize_t>(modes)}, H5T_NATIVE_DOUBLE);
    geometric.boundary_loads = from_rows(rows.data(), static_cast<Eigen::Index>(shape[0]), modes);
    return geometric;
  } catch (const FileProblem& problem) {
    throw FileProblem(fmt::format("group 'geometric_stiffness': {}", problem.what()));
  }
}

/// Of a body whose frames, nodes and mesh are known.
SecondOrder read_second_order(hid_t file, const ReducedBody& body) {
  const Handle group = open_group(file, "second_order");
  try {
    SecondOrder second;
    const auto [products, shape] = read_numbers<int>(group, "products", {kAny, 2}, H5T_NATIVE_INT);
    for (hsize_t k = 0; k < shape[0]; ++k) second.products.push_back({products[2 * k], products[2 * k + 1]});
    const Eigen::Index n = body.modes + static_cast<Eigen::Index>(shape[0]);
    const auto extended = static_cast<hsize_t>(n);
    read_integrals(group, n, second);
    second.mass_matrix = read_matrix(group, "mass_matrix", extended, extended);
    second.stiffness = read_matrix(group, "stiffness", extended, extended);
    second.frame_shapes = read_stack<Eigen::Matrix3Xd>(group, "frame_shapes", body.frames.size(), 3, n);
    second.node_shapes = read_node_field(group, "node_shapes", n, body.nodes.cols(), 3);
    if (body.mesh_inertia)
      second.mesh_shapes =
          read_matrix(group, "mesh_shapes", extended, static_cast<hsize_t>(body.mesh_inertia->mass.rows()))
              .transpose();
    return second;
  } catch (const FileProblem& problem) {
    throw FileProblem(fmt::format("group 'second_order': {}", problem.what()));
  }
}

ReducedBody read_body(hid_t file) {
  if (const std::string format = read_text_attribute(file, "format"); format != kFormat)
    throw FileProblem(fmt::format("its format is '{}', expected '{}'", format, kFormat));
  ReducedBody body;
  body.name = read_text_attribute(file, "name");
  body.modes = read_number_attribute<int>(file, "modes", H5T_NATIVE_INT);
  if (body.modes < 0)
    throw FileProblem(fmt::format("attribute 'modes' must not be negative, is {}", body.modes));
  body.mass = read_number_attribute<double>(file, "mass", H5T_NATIVE_DOUBLE);
  body.line_radius = read_number_attribute<double>(file, "line_radius", H5T_NATIVE_DOUBLE);

  const auto modes = static_cast<hsize_t>(body.modes);
  const Eigen::Index n = body.modes;
  body.mode_names = read_texts(file, "mode_names", modes);
  if (has_link(file, "checks")) body.checks = read_checks(file);
  if (has_link(file, "boundary_rotation")) body.boundary_rotation = read_rotation(file);
  body.first_moment = Eigen::Vector3d(read_doubles(file, "first_moment", {3}).data());
  body.second_moment = read_matrix(file, "second_moment", 3, 3);
  read_integrals(file, n, body);
  body.mass_matrix = read_matrix(file, "mass_matrix", modes, modes);
  body.stiffness = read_matrix(file, "stiffness", modes, modes);
  body.damping = read_matrix(file, "damping", modes, modes);
  body.user_from_modal = read_matrix(file, "user_from_modal", modes, modes);
  const std::vector<double> frequencies = read_doubles(file, "eigenfrequencies", {kAny});
  body.eigenfrequencies = from_rows(frequencies.data(), static_cast<Eigen::Index>(frequencies.size()), 1);

  const auto [nodes, nodes_shape] = read_numbers<double>(file, "nodes", {kAny, 3}, H5T_NATIVE_DOUBLE);
  const auto points = static_cast<Eigen::Index>(nodes_shape[0]);
  body.nodes = from_rows(nodes.data(), points, 3).transpose();
  body.node_shapes = read_node_field(file, "node_shapes", n, points, 3);
  body.lines = read_tuples<2>(file, "lines");
  if (has_link(file, "triangles")) body.triangles = read_tuples<3>(file, "triangles");
  if (has_link(file, "node_labels"))
    body.node_labels = read_numbers<std::int64_t>(file, "node_labels", {kAny}, H5T_NATIVE_INT64).first;
  if (has_link(file, "stress")) body.stress = read_node_field(file, "stress", n, points, 6);
  if (has_link(file, "strain")) body.strain = read_node_field(file, "strain", n, points, 6);
  body.frames = read_frames(file, modes);
  if (has_link(file, "mesh_inertia")) body.mesh_inertia = read_mesh(file, points, n);
  if (has_link(file, "geometric_stiffness")) body.geometric = read_geometric_stiffness(file, n);
  if (has_link(file, "second_order")) body.second_order = read_second_order(file, body);
  return body;
}

void throw_if_unsound(const ReducedBody& body, const std::string& prefix) {
  std::vector<Diagnostic> diagnostics;
  for (const std::string& message : check(body)) diagnostics.push_back({Mark{}, prefix + message});
  if (!diagnostics.empty()) throw InputError(std::move(diagnostics));
}

}  // namespace

void save(const ReducedBody& body, const std::string& path) {
  throw_if_unsound(body, fmt::format("cannot save reduced body '{}': ", path));
  if (body.ancf)
    throw InputError({}, fmt::format("cannot save reduced body '{}': the format has no place for beams by "
                                     "absolute nodal coordinates",
                                     path));
  const SilentErrors silent;
  try {
    const Handle creation = without_times(H5P_FILE_CREATE);
    const Handle file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, H5P_DEFAULT), H5Fclose,
                      "the file cannot be created");
    write_body(file, body);
    checked(H5Fflush(file, H5F_SCOPE_LOCAL), "the file cannot be written");
  } catch (const FileProblem& problem) {
    throw InputError(Mark{}, fmt::format("cannot save reduced body '{}': {}", path, problem.what()));
  }
}

ReducedBody load_reduced_body(const std::string& path) {
  const SilentErrors silent;
  const std::string prefix = fmt::format("cannot load reduced body '{}': ", path);
  try {
    const Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose,
                      "no such file, or not a complete HDF5 file");
    ReducedBody body = read_body(file);
    throw_if_unsound(body, prefix);
    return body;
  } catch (const FileProblem& problem) {
    throw InputError(Mark{}, prefix + problem.what());
  } catch (const std::bad_alloc&) {
    throw InputError(Mark{}, prefix + "it is too large for the memory");
  }
}

}  // namespace mimbre
