#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace mimbre {

/// A frame on a flexible body to which joints, forces and outputs attach. Undeformed pose in body axes; moves
/// by `X y` and turns by the rotation vector `X_theta y`, both in body axes, y the modal amplitudes.
struct BodyFrame {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< frame axes to body axes
  Eigen::Matrix3Xd X;                                      ///< 3 × modes
  Eigen::Matrix3Xd X_theta;                                ///< 3 × modes
};

/// The finite-element mesh behind the modes, for inertia by projection (Lugrís 2008, 2.76–2.90). Undeformed
/// positions are ReducedBody::nodes. Not needed for inertia by shape integrals.
struct MeshInertia {
  int dofs_per_node = 6;  ///< 6: translations, then rotations, of each node in turn; 3: translations
  Eigen::SparseMatrix<double> mass;  ///< M*, dofs × dofs, symmetric, full storage, body axes
  Eigen::MatrixXd shapes;            ///< Φ, dofs × modes
  /// Nodes × nodes: consistent mass of the translations alone, interpolated as in isoparametric elements
  /// (Lugrís 2008, 2.4.1). Empty: what M* has for the translations.
  Eigen::SparseMatrix<double> nodal_mass;
};

/// Large deflections: products of amplitudes that count as further amplitudes, so that displacements (and the
/// strain energy) are quadratic (of degree four) in the modes' amplitudes while all integrals stay constant.
/// "Extended" blocks have `modes` columns for the amplitudes y, then one for each product y_a y_b.
struct SecondOrder {
  std::vector<std::array<int, 2>> products;  ///< (a, b), a ≤ b
  Eigen::Matrix3Xd S;                        ///< ∫ X dm, extended
  std::array<Eigen::Matrix3Xd, 3> S_position;
  std::array<std::array<Eigen::MatrixXd, 3>, 3> S_modes;
  Eigen::MatrixXd mass_matrix;
  /// Elastic force on the extended amplitudes η: stiffnessᵀ η. Symmetric where it derives from an energy
  /// ½ ηᵀ K η; published nonlinear-stiffness forces do not.
  Eigen::MatrixXd stiffness;
  std::vector<Eigen::Matrix3Xd> frame_shapes;  ///< X of each of the body's frames, extended
  Eigen::MatrixXd node_shapes;                 ///< 3·nodes × extended
  Eigen::MatrixXd mesh_shapes;                 ///< of MeshInertia, dofs × extended; empty without a mesh
};

/// Geometric stiffness of the prestressed body by the loads that prestress it, each in proportion: a force
/// −(Σ s_l K_l) y on the amplitudes, s_l the load's present value. Stress that the body's motion causes needs
/// no mode that stretches (Wallrapp, Schwertassek 1991, SID's Ge and ksigma). The body's energy has no such
/// term, and the motion of the body frame does not feel it.
struct GeometricStiffness {
  /// Numbers of the loads of inertia and gravity, body axes: products ωx², ωy², ωz², ωxωy, ωyωz, ωxωz of the
  /// body frame's angular velocity (a mixed product stands once for both orders, s = ωx ωy), components of
  /// the acceleration at its origin minus gravity, of the angular acceleration. Both are those of the body's
  /// mean motion: to the frame's comes the rigid motion that is nearest, by mass, to what the modes do.
  static constexpr int angular_velocity = 0, acceleration = 6, angular_acceleration = 9;
  /// Number of the first boundary load: load boundary + r is row r of `boundary_loads` times y.
  static constexpr int boundary = 12;

  std::vector<int> loads;                  ///< ascending; those that are missing stiffen nothing
  std::vector<Eigen::MatrixXd> stiffness;  ///< one for each of `loads`: modes × modes, symmetric
  Eigen::MatrixXd boundary_loads;          ///< elastic forces (N, N m) by amplitudes: count × modes
};

/// What bending does to lengths and areas in the second order, for judging what linear modes neglect: where
/// ends or edges are held it costs energy. States of stress σ_s, in equilibrium with forces at places that
/// frames are at and no others, scaled so that ∫ σ_s C⁻¹ σ_t dV = δ_st. With z the amplitudes y, then a
/// rotation of the whole body (3, rad), and d the further motion of the places (6 each: displacement, m, and
/// rotation, rad; body axes) the energy is
///   ½ |e|² + eᵀ places d + ½ dᵀ stiffness d,   e_s = ½ zᵀ forms[s] z
/// beside the linear one. The dynamics has no such term.
struct Stretching {
  std::vector<Eigen::MatrixXd> forms;  ///< modes + 3 square each, symmetric, √J
  Eigen::MatrixXd places;              ///< states × 6·places, √J by m and rad
  Eigen::MatrixXd stiffness;           ///< of the places, nothing else held: 6·places square
  std::vector<int> place_of_frame;     ///< of each of the body's frames
};

/// How a frame turns by its small rotations θ = X_theta y (Lugrís 2008, 2.11, 4.2). All but the first are
/// there for comparison: `successive` is singular at a quarter turn, `infinitesimal` is no rotation.
enum class BoundaryRotation {
  exponential,   ///< exp(θ~)
  successive,    ///< about x, then the turned y, then the turned z
  infinitesimal  ///< I + θ~
};

/// Beams by absolute nodal coordinates.
enum class AncfKind {
  planar,  ///< in a plane: stretch and bending (Shabana 1997; Gerstmayr, Irschik 2008)
  cable,   ///< in space: stretch and bending, alike in all directions; no twist (Gerstmayr, Shabana 2006)
  thick    ///< in space: shear, twist and sections that deform, too (Nachbagauer, Gruber, Gerstmayr 2013)
};

/// A beam by absolute nodal coordinates: the amplitudes are displacements at nodes and changes there of slope
/// (planar, cable) or of the directions y and z of the cross-section (thick), in the axes of the first node,
/// so that the inertia is linear in them and all of its integrals are exact; the elastic forces are those of
/// any deflection. Where there are slopes a frame's X_theta gives the change of slope, and its axes turn with
/// the slope: in space by the shortest way, since a cable knows no twist. Those of a thick beam turn with its
/// section (`sections`), and X_theta is what they do at y = 0.
struct AncfBeam {
  AncfKind kind = AncfKind::planar;
  Eigen::Vector3d along = Eigen::Vector3d::UnitX();  ///< the straight undeformed axis, body axes
  /// Of the plane, or the sections' z; across, or the sections' y, is normal × along.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  struct Element {
    /// Amplitude of: displacement along and across, change of slope along and across, of the first node, then
    /// of the second; -1: zero.
    std::array<int, 8> amplitudes{};
    double length = 0;   ///< m
    double axial = 0;    ///< EA, N
    double bending = 0;  ///< EI, N m²
  };
  std::vector<Element> elements;  ///< of a planar beam
  struct SpatialElement {
    /// Amplitudes of vectors, in the axes along, across, normal; -1: zero. Cable: displacement and change of
    /// slope of both nodes. Thick: displacement, changes of y and z, of the first node, the middle and the
    /// second node.
    std::array<int, 27> amplitudes{};
    double length = 0;  ///< m
    double axial = 0;   ///< EA, N
    /// N m²: about y and z of the section; a cable has both alike.
    double bending_y = 0, bending_z = 0;
    // Of a thick beam.
    double torsion = 0;               ///< GJ, N m²
    double shear_y = 0, shear_z = 0;  ///< kGA, N
    double section_shear = 0;         ///< GA, N: of the section in its own plane
  };
  std::vector<SpatialElement> spatial;  ///< of a cable or a thick beam
  /// Of a thick beam: of each of the body's frames the amplitudes of the changes of y and z, axes as above.
  std::vector<std::array<int, 6>> sections;
  double stiffness_damping = 0;  ///< s: strain rates act like this many seconds of strain
};

/// What there is of a section: forces and moments, and the largest von Mises stress.
inline constexpr std::array section_components{"N", "Vy", "Vz", "T", "My", "Mz", "von_mises"};
constexpr int von_mises_of_section = 6;

/// Section forces of a body made of bars, linear in the loads that act on it: by equilibrium with the forces
/// on its frames and the inertia of its distributed mass, in the undeformed shape (mode acceleration), so
/// that they do not depend on how well the modes show its stress. The loads are, in this order: the twelve of
/// inertia and gravity that GeometricStiffness numbers, of the body frame's own motion; the modes' second
/// derivatives; ω_x ẏ, ω_y ẏ, ω_z ẏ (modes each); of each frame the force on it and the moment, body axes.
struct BarSections {
  struct Section {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< m, body axes
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: its normal x, y, z
    double area = 0, Iy = 0, Iz = 0;                     ///< m², m⁴
    // As in fe::Section; 0: unknown.
    double reach_y = 0, reach_z = 0, torsion_modulus = 0;
    bool round = false;
    std::string bar;   ///< of which it is a section
    int element = 1;   ///< of the bar's elements, from 1
    double along = 0;  ///< m from the bar's start
  };
  std::vector<Section> sections;  ///< start and end of each element of the mesh in turn
  /// 6·sections × loads: N, Vy, Vz, T, My, Mz of each section in turn, acting on the part before it: N > 0 is
  /// tension.
  Eigen::MatrixXd influence;
};

/// Stress in the bars by their deflection alone, for drawing: at the start and the end of each of the body's
/// lines in turn the largest normal stress by N, by My and by Mz, and √3 times the largest shear stress by T.
struct BarStress {
  std::vector<bool> round;  ///< of each line: its outermost fibres are a circle; else a rectangle's corners
  Eigen::MatrixXd shapes;   ///< 8·lines × modes, Pa by amplitude
};

/// One line of the validation report of a reduction.
struct Check {
  std::string name;
  bool passed = false;
  std::string detail;
};

/// All that dynamics knows of a flexible body, wherever it comes from. SI units, body axes throughout.
/// Modes are mass- and stiffness-orthogonal when `make_orthogonal` was applied (built-in bodies always are).
struct ReducedBody {
  std::string name;
  int modes = 0;
  std::vector<std::string> mode_names;  ///< the user's view: "static ball.n", "dynamic 1", …

  /// Inertia shape integrals (Lugrís 2008, 3.6–3.11).
  double mass = 0;
  Eigen::Vector3d first_moment = Eigen::Vector3d::Zero();   ///< m̄u = ∫ r̄u dm
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero();  ///< P̄u = ∫ r̄u r̄uᵀ dm
  Eigen::Matrix3Xd S;                                       ///< ∫ X dm, 3 × modes
  std::array<Eigen::Matrix3Xd, 3> S_position;               ///< S̄^i = ∫ r̄u,i X dm, 3 × modes each
  std::array<std::array<Eigen::MatrixXd, 3>, 3> S_modes;    ///< S^ij = ∫ Xiᵀ Xj dm, modes × modes each
  Eigen::MatrixXd mass_matrix;  ///< Mff (with rotary terms of the mesh), modes × modes
  Eigen::MatrixXd stiffness;    ///< modes × modes
  Eigen::MatrixXd damping;      ///< modes × modes

  std::vector<BodyFrame> frames;
  BoundaryRotation boundary_rotation = BoundaryRotation::exponential;

  /// user amplitudes = user_from_modal * y; identity until make_orthogonal is applied.
  Eigen::MatrixXd user_from_modal;
  Eigen::VectorXd eigenfrequencies;  ///< of the reduced matrices, rad/s, ascending, when orthogonal

  /// For drawing and output: mesh nodes (3 × nodes), mode shapes (3·nodes × modes), lines between nodes.
  Eigen::Matrix3Xd nodes;
  Eigen::MatrixXd node_shapes;
  std::vector<std::array<int, 2>> lines;
  std::vector<std::array<int, 3>> triangles;  ///< the surface, counterclockwise from outside; none: unknown
  double line_radius = 0.01;                  ///< m, for drawing
  std::vector<std::int64_t> node_labels;      ///< of the nodes in the file of their mesh; none: unknown
  /// Stress (Pa) and strain at the nodes, linear in the amplitudes: rows xx yy zz xy yz zx of each node in
  /// turn, body axes, shear strains twice the tensor's entries. 6·nodes × modes; empty: unknown.
  Eigen::MatrixXd stress, strain;

  std::vector<Check> checks;  ///< of the reduction that made it; none: it was not certified

  std::optional<SecondOrder> second_order;      ///< absent: linear in the amplitudes
  std::optional<GeometricStiffness> geometric;  ///< absent: stress does not stiffen
  std::optional<Stretching> stretching;         ///< absent: not known, or nothing can be held
  std::optional<AncfBeam> ancf;         ///< present: elastic forces are its own; `stiffness` is that at y = 0
  std::optional<BarSections> sections;  ///< absent: not of bars, not asked for, or from a file
  std::optional<BarStress> bar_stress;  ///< absent: not of bars, of sections of unknown shape, or from a file
  std::optional<MeshInertia> mesh_inertia;  ///< absent: inertia by shape integrals only

  /// Index of a frame by name, -1 when there is none.
  int find_frame(const std::string& frame_name) const;
};

/// Makes Mff = I and K = diag(ω²) by the eigenproblem of the reduced matrices; every mode block rotates
/// along. Same space, so nothing physical changes. Throws std::invalid_argument when Mff is not positive
/// definite.
void make_orthogonal(ReducedBody& body);

/// Checks sizes, finite numbers, symmetry, positive definiteness of mass and triangle inequality of the
/// inertia. Returns one message per violation; empty when sound.
std::vector<std::string> check(const ReducedBody& body);

/// One HDF5 file (layout in docs/reduced-body-format.md). Throw InputError naming the file and what is wrong
/// with it; save throws std::runtime_error where the file cannot be written.
void save(const ReducedBody& body, const std::string& path);
ReducedBody load_reduced_body(const std::string& path);
/// Whether there is such a file, judged by its first attribute.
bool is_reduced_body(const std::string& path);

}  // namespace mimbre
