#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include "base/checksums.h"
#include "base/file_format.h"
#include "base/rehearsal.h"
#include "reduction/file/reduced_body_file.h"

namespace mimbre {
namespace {

using hdf5::Handle;
using namespace reduced_body_file;

/// More than any real body has: a damaged or hostile file must not make us ask for all of the memory.
constexpr std::uint64_t max_elements = std::uint64_t{1} << 27;

std::string to_string(const Shape& shape) { return fmt::format("{}", fmt::join(shape, " x ")); }

double file_bytes(hid_t object) {
  const Handle file(H5Iget_file_id(object));
  hsize_t bytes = 0;
  return H5Fget_filesize(file.get(), &bytes) >= 0 ? static_cast<double>(bytes) : 0;
}

/// The dataset's shape, after a check that it is one and of a size that can be read.
Shape shape_of(hid_t set, const std::string& name) {
  const Handle space = opened(H5Dget_space(set), fmt::format("'{}' has no shape", name));
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 0) throw FileProblem(fmt::format("'{}' has no shape", name));
  Shape shape(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space.get(), shape.data(), nullptr);
  std::uint64_t count = 1;
  for (hsize_t extent : shape) {
    if (extent > max_elements || (count *= extent) > max_elements)
      throw FileProblem(fmt::format("'{}' is too large: {}", name, to_string(shape)));
  }
  if (!hdf5::can_hold(file_bytes(set), set, static_cast<double>(count)))
    throw FileProblem(fmt::format("'{}' announces more than the file can hold: {}", name, to_string(shape)));
  return shape;
}

Handle open_group(hid_t place, const std::string& name) {
  Handle group = hdf5::open_group(place, name);
  if (!group.valid()) throw FileProblem(fmt::format("group '{}' is missing", name));
  return group;
}

Handle open_dataset(hid_t place, const std::string& name) {
  Handle set = hdf5::open_dataset(place, name);
  if (!set.valid()) throw FileProblem(fmt::format("dataset '{}' is missing, or lies in another file", name));
  return set;
}

constexpr hsize_t any_extent = std::numeric_limits<hsize_t>::max();

/// Compares with `expected`, where any_extent stands for any extent.
void require_shape(const std::string& name, const Shape& shape, const Shape& expected) {
  bool same = shape.size() == expected.size();
  for (std::size_t i = 0; same && i < shape.size(); ++i)
    same = expected[i] == any_extent || shape[i] == expected[i];
  if (same) return;
  std::vector<std::string> words;
  for (hsize_t extent : expected) words.push_back(extent == any_extent ? "any" : std::to_string(extent));
  throw FileProblem(fmt::format("dataset '{}' must be {}, is {}", name, fmt::join(words, " x "),
                                shape.empty() ? "a single value" : to_string(shape)));
}

template <typename Number>
std::pair<std::vector<Number>, Shape> read_numbers(hid_t place, const std::string& name,
                                                   const Shape& expected, hid_t memory_type) {
  const Handle set = open_dataset(place, name);
  const Shape shape = shape_of(set.get(), name);
  require_shape(name, shape, expected);
  std::vector<Number> data(element_count(shape));
  if (!data.empty())
    checked(H5Dread(set.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()),
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
  return opened(H5Aopen(place, name.c_str(), H5P_DEFAULT), fmt::format("attribute '{}' is missing", name));
}

/// Before reading into one value's memory.
void require_single(hid_t attribute, const std::string& name) {
  const Handle space = opened(H5Aget_space(attribute), fmt::format("attribute '{}' has no shape", name));
  if (H5Sget_simple_extent_npoints(space.get()) != 1)
    throw FileProblem(fmt::format("attribute '{}' must be a single value", name));
}

template <typename Number>
Number read_number_attribute(hid_t place, const std::string& name, hid_t memory_type) {
  const Handle attribute = open_attribute(place, name);
  require_single(attribute.get(), name);
  Number value{};
  checked(H5Aread(attribute.get(), memory_type, &value),
          fmt::format("attribute '{}' must be a number", name));
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
  require_single(attribute.get(), name);
  const Handle type = opened(H5Aget_type(attribute.get()), fmt::format("attribute '{}' has no type", name));
  std::string text(text_size(type.get(), name), '\0');
  checked(H5Aread(attribute.get(), type.get(), text.data()),
          fmt::format("attribute '{}' cannot be read", name));
  return without_padding(text);
}

std::vector<std::string> read_texts(hid_t place, const std::string& name, hsize_t count) {
  const Handle set = open_dataset(place, name);
  require_shape(name, shape_of(set.get(), name), {count});
  const Handle type = opened(H5Dget_type(set.get()), fmt::format("dataset '{}' has no type", name));
  const std::size_t size = text_size(type.get(), name);
  if (size * count > max_elements) throw FileProblem(fmt::format("'{}' is too large", name));
  std::string buffer(size * count, '\0');
  if (count > 0)
    checked(H5Dread(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, buffer.data()),
            fmt::format("dataset '{}' cannot be read", name));
  std::vector<std::string> texts;
  for (hsize_t i = 0; i < count; ++i) texts.push_back(without_padding(buffer.substr(i * size, size)));
  return texts;
}

BoundaryRotation read_rotation(hid_t place) {
  const std::string name = read_texts(place, "boundary_rotation", 1).front();
  const auto found = std::find(rotations.begin(), rotations.end(), name);
  if (found == rotations.end())
    throw FileProblem(
        fmt::format("'boundary_rotation' is '{}', expected exponential, successive or infinitesimal", name));
  return static_cast<BoundaryRotation>(found - rotations.begin());
}

std::vector<Check> read_checks(hid_t place) {
  const std::vector<hsize_t> shape = shape_of(open_dataset(place, "checks").get(), "checks");
  if (shape.size() != 1 || shape[0] % 3 != 0) throw FileProblem("'checks' must have three texts per line");
  const std::vector<std::string> texts = read_texts(place, "checks", shape[0]);
  std::vector<Check> checks;
  for (std::size_t k = 0; k < texts.size(); k += 3)
    checks.push_back({texts[k], texts[k + 1] == "passed", texts[k + 2]});
  return checks;
}

BodyFrame read_frame(hid_t place, const std::string& name, hsize_t modes) {
  const Handle group = hdf5::open_group(place, name);
  if (!group.valid()) throw FileProblem(fmt::format("group 'frames/{}' is missing", name));
  try {
    BodyFrame frame;
    frame.name = read_text_attribute(group.get(), "name");
    frame.position = Eigen::Vector3d(read_doubles(group.get(), "position", {3}).data());
    frame.rotation = read_matrix(group.get(), "rotation", 3, 3);
    frame.X = read_matrix(group.get(), "X", 3, modes);
    frame.X_theta = read_matrix(group.get(), "X_theta", 3, modes);
    return frame;
  } catch (const FileProblem& problem) {
    throw FileProblem(fmt::format("group 'frames/{}': {}", name, problem.what()));
  }
}

std::vector<BodyFrame> read_frames(hid_t file, hsize_t modes) {
  const Handle group = open_group(file, "frames");
  H5G_info_t info{};
  checked(H5Gget_info(group.get(), &info), "group 'frames' cannot be read");
  std::vector<BodyFrame> frames;
  for (hsize_t k = 0; k < info.nlinks; ++k)
    frames.push_back(read_frame(group.get(), std::to_string(k), modes));
  return frames;
}

template <std::size_t Corners>
std::vector<std::array<int, Corners>> read_tuples(hid_t file, const std::string& name) {
  const auto [data, shape] = read_numbers<int>(file, name, {any_extent, Corners}, H5T_NATIVE_INT);
  std::vector<std::array<int, Corners>> tuples(shape[0]);
  for (std::size_t i = 0; i < data.size(); ++i) tuples[i / Corners][i % Corners] = data[i];
  return tuples;
}

Eigen::SparseMatrix<double> read_sparse(hid_t place, const std::string& name, Eigen::Index size) {
  const Handle group = open_group(place, name);
  const auto [places, shape] =
      read_numbers<std::int64_t>(group.get(), "places", {any_extent, 2}, H5T_NATIVE_INT64);
  const std::vector<double> values = read_doubles(group.get(), "values", {shape[0]});
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
    mesh.dofs_per_node = read_number_attribute<int>(group.get(), "dofs_per_node", H5T_NATIVE_INT);
    if (mesh.dofs_per_node != 3 && mesh.dofs_per_node != 6)
      throw FileProblem(fmt::format("attribute 'dofs_per_node' must be 3 or 6, is {}", mesh.dofs_per_node));
    const Eigen::Index dofs = mesh.dofs_per_node * nodes;
    mesh.mass = read_sparse(group.get(), "mass", dofs);
    if (hdf5::has_link(group.get(), "nodal_mass"))
      mesh.nodal_mass = read_sparse(group.get(), "nodal_mass", nodes);
    mesh.shapes = read_matrix(group.get(), "shapes", static_cast<hsize_t>(modes), static_cast<hsize_t>(dofs))
                      .transpose();
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
    geometric.loads = read_numbers<int>(group.get(), "loads", {any_extent}, H5T_NATIVE_INT).first;
    geometric.stiffness =
        read_stack<Eigen::MatrixXd>(group.get(), "stiffness", geometric.loads.size(), modes, modes);
    const auto [rows, shape] = read_numbers<double>(
        group.get(), "boundary_loads", {any_extent, static_cast<hsize_t>(modes)}, H5T_NATIVE_DOUBLE);
    geometric.boundary_loads = from_rows(rows.data(), static_cast<Eigen::Index>(shape[0]), modes);
    return geometric;
  } catch (const FileProblem& problem) {
    throw FileProblem(fmt::format("group 'geometric_stiffness': {}", problem.what()));
  }
}

Stretching read_stretching(hid_t file, const ReducedBody& body) {
  const Handle group = open_group(file, "stretching");
  try {
    Stretching stretching;
    const auto [places, shape] =
        read_numbers<double>(group.get(), "places", {any_extent, any_extent}, H5T_NATIVE_DOUBLE);
    const auto motions = static_cast<Eigen::Index>(shape[1]);
    stretching.places = from_rows(places.data(), static_cast<Eigen::Index>(shape[0]), motions);
    stretching.forms =
        read_stack<Eigen::MatrixXd>(group.get(), "forms", shape[0], body.modes + 3, body.modes + 3);
    stretching.stiffness = read_matrix(group.get(), "stiffness", shape[1], shape[1]);
    stretching.place_of_frame =
        read_numbers<int>(group.get(), "place_of_frame", {body.frames.size()}, H5T_NATIVE_INT).first;
    return stretching;
  } catch (const FileProblem& problem) {
    throw FileProblem(fmt::format("group 'stretching': {}", problem.what()));
  }
}

/// Of a body whose frames, nodes and mesh are known.
SecondOrder read_second_order(hid_t file, const ReducedBody& body) {
  const Handle group = open_group(file, "second_order");
  try {
    SecondOrder second;
    const auto [products, shape] =
        read_numbers<int>(group.get(), "products", {any_extent, 2}, H5T_NATIVE_INT);
    for (hsize_t k = 0; k < shape[0]; ++k) second.products.push_back({products[2 * k], products[2 * k + 1]});
    const Eigen::Index n = body.modes + static_cast<Eigen::Index>(shape[0]);
    const auto extended = static_cast<hsize_t>(n);
    read_integrals(group.get(), n, second);
    second.mass_matrix = read_matrix(group.get(), "mass_matrix", extended, extended);
    second.stiffness = read_matrix(group.get(), "stiffness", extended, extended);
    second.frame_shapes = read_stack<Eigen::Matrix3Xd>(group.get(), "frame_shapes", body.frames.size(), 3, n);
    second.node_shapes = read_node_field(group.get(), "node_shapes", n, body.nodes.cols(), 3);
    if (body.mesh_inertia)
      second.mesh_shapes = read_matrix(group.get(), "mesh_shapes", extended,
                                       static_cast<hsize_t>(body.mesh_inertia->mass.rows()))
                               .transpose();
    return second;
  } catch (const FileProblem& problem) {
    throw FileProblem(fmt::format("group 'second_order': {}", problem.what()));
  }
}

ReducedBody read_body(hid_t file) {
  if (const std::string found = read_text_attribute(file, "format"); found != reduced_body_file::format)
    throw FileProblem(fmt::format("its format is '{}', expected '{}'", found, reduced_body_file::format));
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
  if (hdf5::has_link(file, "checks")) body.checks = read_checks(file);
  if (hdf5::has_link(file, "boundary_rotation")) body.boundary_rotation = read_rotation(file);
  body.first_moment = Eigen::Vector3d(read_doubles(file, "first_moment", {3}).data());
  body.second_moment = read_matrix(file, "second_moment", 3, 3);
  read_integrals(file, n, body);
  body.mass_matrix = read_matrix(file, "mass_matrix", modes, modes);
  body.stiffness = read_matrix(file, "stiffness", modes, modes);
  body.damping = read_matrix(file, "damping", modes, modes);
  body.user_from_modal = read_matrix(file, "user_from_modal", modes, modes);
  const std::vector<double> frequencies = read_doubles(file, "eigenfrequencies", {any_extent});
  body.eigenfrequencies = from_rows(frequencies.data(), static_cast<Eigen::Index>(frequencies.size()), 1);

  const auto [nodes, nodes_shape] = read_numbers<double>(file, "nodes", {any_extent, 3}, H5T_NATIVE_DOUBLE);
  const auto points = static_cast<Eigen::Index>(nodes_shape[0]);
  body.nodes = from_rows(nodes.data(), points, 3).transpose();
  body.node_shapes = read_node_field(file, "node_shapes", n, points, 3);
  body.lines = read_tuples<2>(file, "lines");
  if (hdf5::has_link(file, "triangles")) body.triangles = read_tuples<3>(file, "triangles");
  if (hdf5::has_link(file, "node_labels"))
    body.node_labels = read_numbers<std::int64_t>(file, "node_labels", {any_extent}, H5T_NATIVE_INT64).first;
  if (hdf5::has_link(file, "stress")) body.stress = read_node_field(file, "stress", n, points, 6);
  if (hdf5::has_link(file, "strain")) body.strain = read_node_field(file, "strain", n, points, 6);
  body.frames = read_frames(file, modes);
  if (hdf5::has_link(file, "mesh_inertia")) body.mesh_inertia = read_mesh(file, points, n);
  if (hdf5::has_link(file, "geometric_stiffness")) body.geometric = read_geometric_stiffness(file, n);
  if (hdf5::has_link(file, "stretching")) body.stretching = read_stretching(file, body);
  if (hdf5::has_link(file, "second_order")) body.second_order = read_second_order(file, body);
  return body;
}

std::string prefix(const std::string& path) { return fmt::format("cannot load reduced body '{}': ", path); }

enum class Checksums { checked, ignored };

ReducedBody read_file(const std::string& path, Checksums checksums) {
  try {
    if (!hdf5::is_hdf5(path)) throw FileProblem("no such file, or not a complete HDF5 file");
    const Handle access(H5Pcreate(H5P_FILE_ACCESS));
    // Some network file systems cannot lock.
    H5Pset_file_locking(access.get(), false, true);
    const Handle file = opened(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access.get()),
                               "no such file, or not a complete HDF5 file");
    ReducedBody body = read_body(file.get());
    if (checksums == Checksums::checked)
      if (const std::string damaged = hdf5::first_damaged(file.get()); !damaged.empty())
        throw FileProblem(hdf5::damage_message(damaged));
    return body;
  } catch (const FileProblem& problem) {
    throw InputError(Mark{}, prefix(path) + problem.what());
  } catch (const std::bad_alloc&) {
    throw InputError(Mark{}, prefix(path) + "it is too large for the memory");
  }
}

}  // namespace

ReducedBody load_reduced_body(const std::string& path) {
  const hdf5::Quiet silent;
  const bool were_right = hdf5::is_hdf5(path) && rehearse("body", path);
  ReducedBody body = read_file(path, were_right ? Checksums::ignored : Checksums::checked);
  throw_if_unsound(body, prefix(path));
  return body;
}

bool is_reduced_body(const std::string& path) {
  return hdf5::file_format(path).starts_with("mimbre-reduced-body-");
}

}  // namespace mimbre
