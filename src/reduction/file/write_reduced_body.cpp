#include <fmt/format.h>

#include <algorithm>

#include "base/checksums.h"
#include "base/output_place.h"
#include "reduction/file/reduced_body_file.h"

namespace mimbre {
namespace {

using hdf5::Handle;
using namespace reduced_body_file;

Handle dataspace(const Shape& shape) {
  return opened(shape.empty() ? H5Screate(H5S_SCALAR)
                              : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                "cannot describe an array");
}

/// Row-major entries of a column-major matrix.
template <typename Derived>
void append_rows(std::vector<double>& buffer, const Eigen::MatrixBase<Derived>& matrix) {
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) buffer.push_back(matrix(i, j));
}

/// A creation property list without time stamps, so that the same body gives the same bytes.
Handle without_times(hid_t property_class) {
  const hid_t list = checked(H5Pcreate(property_class), "cannot create a property list");
  H5Pset_obj_track_times(list, false);
  return opened(list, {});
}

void write_data(hid_t place, const std::string& name, const Shape& shape, hid_t file_type, hid_t memory_type,
                const void* data) {
  const std::string problem = fmt::format("cannot write '{}'", name);
  const Handle space = dataspace(shape);
  const Handle creation = without_times(H5P_DATASET_CREATE);
  const Handle set = opened(
      H5Dcreate2(place, name.c_str(), file_type, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
      problem);
  if (element_count(shape) > 0)
    checked(H5Dwrite(set.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), problem);
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
  const Handle attribute =
      opened(H5Acreate2(place, name.c_str(), file_type, space.get(), H5P_DEFAULT, H5P_DEFAULT), problem);
  checked(H5Awrite(attribute.get(), memory_type, data), problem);
}

void write_text_attribute(hid_t place, const std::string& name, std::string text) {
  const Handle type = hdf5::text_type(text.size());
  text.resize(std::max<std::size_t>(text.size(), 1));
  write_attribute(place, name, type.get(), type.get(), text.data());
}

void write_texts(hid_t place, const std::string& name, const std::vector<std::string>& texts) {
  const hdf5::PackedTexts packed = hdf5::packed(texts);
  const Handle type = hdf5::text_type(packed.length);
  write_data(place, name, {texts.size()}, type.get(), type.get(), packed.bytes.data());
}

Handle create_group(hid_t place, const std::string& name) {
  const Handle creation = without_times(H5P_GROUP_CREATE);
  return opened(H5Gcreate2(place, name.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                fmt::format("cannot create group '{}'", name));
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
  write_text_attribute(group.get(), "name", frame.name);
  write_matrix(group.get(), "position", frame.position);
  write_matrix(group.get(), "rotation", frame.rotation);
  write_matrix(group.get(), "X", frame.X);
  write_matrix(group.get(), "X_theta", frame.X_theta);
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
  write_integers(group.get(), "places", {values.size(), 2}, places);
  write_doubles(group.get(), "values", {values.size()}, values);
}

void write_mesh(hid_t file, const MeshInertia& mesh) {
  const Handle group = create_group(file, "mesh_inertia");
  write_attribute(group.get(), "dofs_per_node", H5T_STD_I32LE, H5T_NATIVE_INT, &mesh.dofs_per_node);
  write_sparse(group.get(), "mass", mesh.mass);
  if (mesh.nodal_mass.size() > 0) write_sparse(group.get(), "nodal_mass", mesh.nodal_mass);
  write_matrix(group.get(), "shapes", mesh.shapes.transpose());
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
  write_integers(group.get(), "loads", {geometric.loads.size()},
                 {geometric.loads.begin(), geometric.loads.end()});
  const Eigen::Index modes = geometric.boundary_loads.cols();
  write_stack(group.get(), "stiffness", geometric.stiffness, modes, modes);
  write_matrix(group.get(), "boundary_loads", geometric.boundary_loads);
}

void write_stretching(hid_t file, const Stretching& stretching) {
  const Handle group = create_group(file, "stretching");
  const Eigen::Index size = stretching.forms.empty() ? 0 : stretching.forms.front().rows();
  write_stack(group.get(), "forms", stretching.forms, size, size);
  write_matrix(group.get(), "places", stretching.places);
  write_matrix(group.get(), "stiffness", stretching.stiffness);
  write_integers(group.get(), "place_of_frame", {stretching.place_of_frame.size()},
                 {stretching.place_of_frame.begin(), stretching.place_of_frame.end()});
}

void write_second_order(hid_t file, const SecondOrder& second) {
  const Handle group = create_group(file, "second_order");
  std::vector<std::int32_t> products;
  for (const auto& product : second.products) products.insert(products.end(), product.begin(), product.end());
  write_integers(group.get(), "products", {second.products.size(), 2}, products);
  write_integrals(group.get(), second);
  write_matrix(group.get(), "mass_matrix", second.mass_matrix);
  write_matrix(group.get(), "stiffness", second.stiffness);
  write_stack(group.get(), "frame_shapes", second.frame_shapes, 3, second.S.cols());
  write_node_field(group.get(), "node_shapes", second.node_shapes, 3);
  if (second.mesh_shapes.size() > 0) write_matrix(group.get(), "mesh_shapes", second.mesh_shapes.transpose());
}

void write_body(hid_t file, const ReducedBody& body) {
  write_text_attribute(file, "format", format);
  write_text_attribute(file, "name", body.name);
  write_attribute(file, "modes", H5T_STD_I32LE, H5T_NATIVE_INT, &body.modes);
  write_attribute(file, "mass", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &body.mass);
  write_attribute(file, "line_radius", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &body.line_radius);
  write_texts(file, "mode_names", body.mode_names);
  if (!body.checks.empty()) write_checks(file, body.checks);
  if (body.boundary_rotation != BoundaryRotation::exponential)
    write_texts(file, "boundary_rotation", {rotations[static_cast<std::size_t>(body.boundary_rotation)]});
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
  for (std::size_t k = 0; k < body.frames.size(); ++k)
    write_frame(frames.get(), std::to_string(k), body.frames[k]);
  if (body.mesh_inertia) write_mesh(file, *body.mesh_inertia);
  if (body.geometric) write_geometric_stiffness(file, *body.geometric);
  if (body.stretching) write_stretching(file, *body.stretching);
  if (body.second_order) write_second_order(file, *body.second_order);
}

/// The file's bytes.
std::string image(const ReducedBody& body, const std::string& path) {
  const Handle creation = without_times(H5P_FILE_CREATE);
  const Handle file = hdf5::create_in_memory(path, creation.get());
  if (!file.valid()) throw FileProblem("there is no room for it in memory: " + hdf5::last_error());
  write_body(file.get(), body);
  const Handle root = opened(H5Gopen2(file.get(), "/", H5P_DEFAULT), "cannot open its root group");
  hdf5::seal_below(root.get());
  hdf5::seal(root.get());
  return hdf5::image(file.get());
}

}  // namespace

void save(const ReducedBody& body, const std::string& path) {
  throw_if_unsound(body, fmt::format("cannot save reduced body '{}': ", path));
  if (body.ancf)
    throw InputError({}, fmt::format("cannot save reduced body '{}': the format has no place for beams by "
                                     "absolute nodal coordinates",
                                     path));
  const hdf5::Quiet silent;
  try {
    OutputPlace place(path);
    if (!place.plain()) throw FileProblem("it is not a plain file");
    place.write(image(body, path));
    place.commit();
  } catch (const std::runtime_error& problem) {
    throw std::runtime_error(fmt::format("cannot write '{}': {}", path, problem.what()));
  }
}

}  // namespace mimbre
