#pragma once
#include <optional>
#include <string>
#include <vector>

#include "mimbre/diagnostics.h"
#include "mimbre/fe_mesh.h"
#include "mimbre/fe_reduce.h"
#include "mimbre/reduced_body.h"

/// Finite-element models from other programs' files, and reduced bodies to and from the exchange formats of
/// multibody programs. Text is read line by line: a file may be larger than the memory that it fills. All
/// functions throw InputError with file, line, what is wrong and what would be right.
namespace mimbre::fe {

/// What one unit of the file's numbers is in SI, {1, 1, 1} for files in SI units; {1e-3, 1e3, 1} for the
/// common mm–tonne–second system (N, MPa).
struct FileUnits {
  double length = 1;  ///< m
  double mass = 1;    ///< kg
  double time = 1;    ///< s
};

struct ImportedMesh {
  SolidMesh mesh;
  std::vector<Diagnostic> warnings;  ///< what the file has beyond the mesh and is not taken
};

/// Matrices made elsewhere, with the nodes that they belong to; the mesh has elements only where the node
/// file is a CalculiX or Abaqus input or a Gmsh mesh.
struct ImportedMatrices {
  SolidMesh mesh;
  FeMatrices matrices;
  /// Of the rows in the order of the file (`matrices` has them by nodes); empty: the file has no such order.
  std::vector<Dof> file_dofs;
  std::vector<Diagnostic> warnings;  ///< such as matrices that hold the body
};

/// Gmsh .msh, versions 2.x and 4.1, ASCII. Physical groups become node sets (of the same name; the tag where
/// there is no name), those of the volumes also element groups. Surface elements are shells where the file
/// has no volume elements, else only node sets; lines and points are only node sets.
ImportedMesh read_gmsh(const std::string& path, const FileUnits& units = {});

/// The mesh of a CalculiX or Abaqus input file (.inp): nodes, elements C3D4, C3D10, C3D8, C3D20, C3D6, C3D15,
/// S3, S4, S6, S8 (also with the suffixes I, R, H, M), B31 and B32 with sections RECT, CIRC, PIPE, BOX, point
/// masses, springs, sets, surfaces (as node sets), elastic materials with orientations, sections, rigid
/// bodies, couplings, equations, ties, includes. Sections make the element groups. Every element set is a
/// node set too. Steps are skipped, plane elements and trusses only make node sets; boundary conditions,
/// loads and the rest are left out with a warning.
ImportedMesh read_inp(const std::string& path, const FileUnits& units = {});

/// A mesh by its file's ending: .msh (read_gmsh), .inp (read_inp), .unv (universal files of I-DEAS, Salome,
/// Gmsh: data sets 2411, 781 and 15, 2412, permanent groups. Groups become node sets; the first one that
/// lists a solid or shell element names its element group, else its property does. Surface elements are
/// shells where the file has no solids).
ImportedMesh read_mesh(const std::string& path, const FileUnits& units = {});
/// A line of each of these formats, for people.
std::string mesh_formats_help();

/// Nodes of a file that is a mesh (as of read_mesh) or a table: CSV (comma, semicolon, tab or blanks) with
/// the columns label, x, y, z, with or without a heading.
ImportedMesh read_nodes(const std::string& path, const FileUnits& units = {});

/// What CalculiX writes for *FREQUENCY, SOLVER=MATRIXSTORAGE: JOB.sti, JOB.mas, JOB.dof beside JOB.inp. The
/// model must have no *BOUNDARY, no cyclic symmetry, and no elements to which CalculiX adds nodes (shells,
/// beams, C3D8I).
ImportedMatrices read_calculix_matrices(const std::string& inp_path, const FileUnits& units = {});

/// Minus what CalculiX writes for *BUCKLE, SOLVER=MATRIXSTORAGE: the geometric stiffness of the static load
/// before it (of the step's load), lower triangle, in the rows of `matrices`, which come from the same mesh.
/// `dof_path` is the .dof file written with it.
Eigen::SparseMatrix<double> read_calculix_geometric_stiffness(const std::string& str_path,
                                                              const std::string& dof_path,
                                                              const ImportedMatrices& matrices,
                                                              const FileUnits& units = {});

/// What Abaqus writes for *MATRIX GENERATE and *MATRIX OUTPUT: lines `row node, dof, column node, dof, value`
/// of one triangle, or, in its coordinate form, `row column value`, for which the dofs must be specified as
/// in read_sparse_matrices. `nodes` as for read_nodes.
ImportedMatrices read_abaqus_matrices(const std::string& stiffness_path, const std::string& mass_path,
                                      const std::string& nodes_path, const std::string& dofs_path = "",
                                      const FileUnits& units = {});

/// The mesh of a Nastran deck: bulk data in small, large and free field with its includes; case control
/// chooses the MPC. Solids CTETRA, CHEXA, CPENTA, CPYRAM; shells CQUAD4, CQUADR, CQUAD8, CTRIA3, CTRIAR,
/// CTRIA6 with PSHELL or a symmetric PCOMP; CBAR, CBEAM, CROD, CTUBE, CONROD; CELAS, CBUSH, CMASS, CONM1,
/// CONM2; RBE1, RBE2, RBE3, RBAR, RROD, MPC; MAT1, MAT2, MAT8, MAT9, MAT11; all CORD systems, of positions
/// and displacements. Properties, ties and sets of nodes become node sets (PSHELL:3, RBE2:7, SPC:1, SET:4).
/// Loads, constraints to the ground, contact and dampers are left out; elements that are not read are
/// refused, each by its card and line. Nothing: the deck has no elements but matrices (read_nastran_dmig).
std::optional<ImportedMesh> read_nastran(const std::string& path, const FileUnits& units = {});

/// Nastran and OptiStruct: DMIG cards (small, large and free field; square or symmetric, real) of a punch
/// file and GRID cards of the same file or of `bulk_path`. An empty name means the only matrix whose name
/// begins with K or M. Positions and displacements may be in any system; the matrices come in basic axes.
ImportedMatrices read_nastran_dmig(const std::string& punch_path, const std::string& bulk_path = "",
                                   const std::string& stiffness_name = "", const std::string& mass_name = "",
                                   const FileUnits& units = {});

/// Matrix Market (.mtx, coordinate, real or integer, symmetric or general) or SciPy's save_npz (.npz: CSR,
/// CSC, COO), with the nodes as for read_nodes. `dofs_path`: CSV with the columns row (counted from 0 or from
/// 1), node label, direction (1–6, or x y z rx ry rz). Without it rows are 3 or 6 per node, in the order of
/// the node file.
ImportedMatrices read_sparse_matrices(const std::string& stiffness_path, const std::string& mass_path,
                                      const std::string& nodes_path, const std::string& dofs_path = "",
                                      const FileUnits& units = {});

/// A model ready to be reduced, whatever it was read from.
struct FeModel {
  SolidMesh mesh;
  FeMatrices matrices;
  std::vector<Dof> file_dofs;  ///< as in ImportedMatrices
  std::vector<Diagnostic> warnings;
};

struct NamedNumber {
  std::string name;
  double value = 0;
};

/// The torsion constant of the beams of an .inp file.
enum class BeamTorsion {
  section,  ///< of the section
  /// Of one quadratic brick across the section, into which CalculiX expands a beam. Along the beam it warps
  /// by c y z only. The c of least energy gives J = 4 Iy Iz/(Iy + Iz): a⁴/6 of a square, 19 % too much.
  brick
};

/// Data that the model's own file lacks.
struct FeCompanions {
  std::string mass, nodes, dofs;  ///< files beside a stiffness matrix; `nodes` also of DMIG cards
  /// Of the element groups without a material, by the group's name; "": of all that are left.
  std::vector<NamedMaterial> materials;
  /// kg/m³, of the materials without a density, by name; "": of all that are left.
  std::vector<NamedNumber> densities;
  /// m, of the shells without a thickness, by the name of their group; "": of all that are left.
  std::vector<NamedNumber> thicknesses;
  BeamTorsion beam_torsion = BeamTorsion::section;
};

/// A model by its file's ending: those of read_mesh are meshes, assembled here (with matrices of the same
/// name beside an .inp those are taken), .mtx and .npz stiffness matrices, .bdf, .dat, .nas, .pch and .dmig
/// Nastran bulk data: elements or, without these, DMIG cards. Throws std::invalid_argument for an ending that
/// is not known, companions that are missing or groups that are not there, InputError for what is wrong with
/// the files.
FeModel read_model(const std::string& path, const FeCompanions& companions = {}, const FileUnits& units = {});

/// What read_model() reads beside a file: the includes of a CalculiX, Abaqus or Nastran input, and the
/// matrices of the same name as an .inp (if they exist). Throws InputError when an include is missing.
std::vector<std::string> files_beside(const std::string& inp_path);

/// Nodes that a text selects: `group:NAME` or `set:NAME` (a node set of the mesh), `nodes:FILE` (labels, one
/// per line or separated by commas or blanks), `box(x0,y0,z0, x1,y1,z1)` (inside, with a margin of 1e-6 of
/// the model), `cylinder(px,py,pz, ax,ay,az, r)` (on that surface, to 1 % of r). Coordinates in the file's
/// unit of length. Places select among nodes with dofs: others cannot carry
/// anything. Throws
/// std::invalid_argument with the mistake and the valid names.
std::vector<int> select_nodes(const std::string& text, const SolidMesh& mesh, const std::vector<Dof>& dofs,
                              double length_unit);

/// Stress by displacements from SciPy's save_npz (CSR, CSC or COO; entries of the same place are summed).
/// Rows: xx yy zz xy yz zx of each node in turn, nodes in the order of the mesh or, with `nodes_path`, of a
/// table whose first column has their labels. Columns: the dofs `columns` or, where that is empty, those of
/// `matrices`, in this order. `units` are those of the file: stress in mass/(length time²), by displacements
/// in lengths and rotations in rad. Throws InputError.
StressMatrix read_stress_matrix(const std::string& path, const std::string& nodes_path, const SolidMesh& mesh,
                                const FeMatrices& matrices, const std::vector<Dof>& columns,
                                const FileUnits& units = {});

/// Mode shapes from a table. CSV (comma, semicolon, tab or blanks): node label, direction (1–6, or x y z rx
/// ry rz), then a column per mode, with or without a heading. NumPy's savez (.npz): the arrays `label` and
/// `direction` (1–6) of whole numbers, `shapes` (rows × modes). Throws InputError.
UserModes read_user_modes(const std::string& path, const SolidMesh& mesh, const FileUnits& units = {});

/// A body reduced elsewhere, with warnings of what its file lacks.
struct ImportedBody {
  ReducedBody body;
  std::vector<Diagnostic> warnings;
};

/// MBDyn's .fem of the modal joint. Its nodes become frames `node LABEL`. Mass, first and second moments come
/// from record group 12 or, without it, from the lumped masses of group 11; the modal integrals from groups
/// 13 to 17 or else from lumped masses and mode shapes.
/// Record group 19 holds the geometric stiffness, as stiffness per unit of two kinds of loads: accelerations
/// of the body with its frame held, and forces at the nodes. GeometricStiffness::boundary_loads, elastic
/// forces on the boundary, are linear functions of the amplitudes instead; .fem has no place for those.
/// Writing takes the nodal forces that would deform the body, at rest, by the same amplitudes; reading takes
/// the boundary loads that hold the nodes at the amplitudes which the nodal forces cause. Where all modes are
/// static modes of the nodes the two are each other's inverse, and a body comes back as it was. Not in the
/// format, and lost by writing: axes of frames (positions and modes are in body axes), mode names, stress,
/// drawing lines and points, modes in the user's view, second order. Blanks in the names of frames become
/// '_'. Writing throws std::invalid_argument for a body without frames, a beam by absolute nodal
/// coordinates, and boundary loads with a stiffness that is not positive definite.
ImportedBody read_mbdyn_fem(const std::string& path);
void write_mbdyn_fem(const ReducedBody& body, const std::string& path);

/// SID, standard input data (O. Wallrapp, Mech. Struct. Mach. 22(4), 1994). Nodes become frames `node LABEL`;
/// the linear terms m1 are accepted with the indices (row, mode, column) and (row, column, mode). Geometric
/// stiffness, by the loads of write_mbdyn_fem, is in the linear terms of Oe, Ct and Cr and, minus that by
/// forces and torques at a node, of its phi and psi, so that phiᵀ F is the force on the modes. Initial stress
/// changes the stiffness (linear terms of ksigma), its forces are left out.
/// Stress of the modes is sigma of the nodes (xx yy zz xy yz zx). The body's points with stress become nodes
/// behind the frames, without psi and so, when read, no frames; a point that is where a frame is, and moves
/// as it does, is one node with it. Points keep their labels, unless these are there twice or are frames'
/// too: then they are numbered. Frames are numbered, above those labels, unless all are called `node NUMBER`.
/// Without a place there: strain, triangles, drawing lines, modes in the user's view, second order. Throws
/// std::invalid_argument for a beam by absolute nodal coordinates, and for boundary loads with a stiffness
/// that is not positive definite.
ImportedBody read_sid(const std::string& path);
void write_sid(const ReducedBody& body, const std::string& path);

/// The formats of reduced bodies: mimbre's own (docs/reduced-body-format.md), MBDyn's, SID.
enum class BodyFormat { h5, fem, sid };
/// By the file's ending: .h5 and .hdf5, .fem, .sid and .sid_fem. Throws std::invalid_argument for another.
BodyFormat body_format(const std::string& path);
/// A body in any of them. Throws as body_format() and the format's own function do.
ImportedBody read_body(const std::string& path);
void write_body(const ReducedBody& body, const std::string& path, BodyFormat format);

}  // namespace mimbre::fe
