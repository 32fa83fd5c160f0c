#pragma once
#include <Eigen/Core>
#include <array>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "fe/elements/shear_coefficient.h"
#include "mimbre/beam_reduction.h"
#include "mimbre/spec.h"
#include "model_file/text/expression.h"
#include "model_file/text/placement.h"
#include "model_file/text/value.h"

namespace mimbre::model_file {

/// A section as it is named: where its shear areas are not given they follow from shape and material.
struct NamedSection {
  fe::Section section;
  fe::ShearCoefficient shear;
};

struct Part;

/// Something to be placed several times.
struct Template {
  std::shared_ptr<const Tree> tree;  ///< null where it cannot be read
  const Part* home = nullptr;        ///< in which it is written: it sees that part's parameters and materials
  Mark mark;
};

/// The model itself or one instance of a template: its sections, parameters, names and place.
struct Part {
  std::string instance;                 ///< empty for the model itself; car.left for one within another
  const Part* outer = nullptr;          ///< in which it stands; null for the model itself
  const Part* home = nullptr;           ///< in which its template is written
  std::shared_ptr<const Tree> written;  ///< as it is in the file
  std::shared_ptr<const Tree> tree;     ///< with repeated items written out
  std::map<std::string, Template> templates;
  Scope scope;
  Placement place;
  Reading reading;
  std::map<std::string, fe::Material> materials;
  std::map<std::string, NamedSection> sections;

  std::string full_name(const std::string& name) const {
    return instance.empty() ? name : instance + "." + name;
  }
  /// What `name` may mean: an item of this part first, then of those in which it stands, of the model last.
  std::vector<std::string> meanings(const std::string& name) const;
  /// Section `key` of this part; nothing when absent.
  std::optional<Value> section(const std::string& key) const;
};

/// A frame of bars that is cut into bodies joined by brackets.
struct Substructures {
  Mark mark;
  int count = 1;
  int dynamic_modes = 0;  ///< of every piece but those with a free end, which take those of the options
};

/// What becomes of a body of bars.
enum class BeamKind {
  reduced,              ///< modes in one floating frame, or in that of each substructure
  corotational,         ///< a floating frame for every element, which deforms with the ends of the element
  ancf,                 ///< absolute nodal coordinates, in a plane
  segments,             ///< rigid bodies with springs against turning between them
  stretching_segments,  ///< likewise, with springs along and across, too
  ancf_cable,           ///< absolute nodal coordinates in space: stretch and bending
  ancf_thick            ///< likewise, with shear and twist
};

/// A beam frame ready to be reduced, in body axes.
struct FlexibleDescription {
  Mark mark;
  BeamKind kind = BeamKind::reduced;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of the plane to which it is bound; zero: none
  std::string what;
  fe::Mesh mesh;
  fe::ReductionOptions options;
  std::vector<fe::NodeFrame> frames;  ///< the named nodes
  double line_radius = 0.01;
  Substructures substructures;

  bool in_segments() const { return kind == BeamKind::segments || kind == BeamKind::stretching_segments; }
  bool by_ancf() const {
    return kind == BeamKind::ancf || kind == BeamKind::ancf_cable || kind == BeamKind::ancf_thick;
  }
  bool in_pieces() const { return substructures.count > 1 || kind == BeamKind::corotational; }
};
/// Amplitudes that the description has: of all pieces, one after the other.
int mode_count(const FlexibleDescription& description);

/// What the later sections need to know of a body besides the spec.
struct BodyInfo {
  bool failed = false;  ///< its description has errors: nothing that follows from it is reported
  bool flexible = false;
  std::vector<std::string> node_names;
  std::vector<Eigen::Vector3d> node_positions;  ///< body axes
  std::optional<FlexibleDescription> description;
  std::optional<Value> inertia;  ///< of a rigid body with a sound mass, to be checked with the joints
};

/// Names of one kind of items: index by full name.
struct Names {
  std::string kind;
  std::unordered_map<std::string, int> index;
  std::vector<std::string> list() const;
};

class FileReader;

/// The model while it is being read.
struct Builder {
  Builder(Limits bounds, const FileReader& files_by) : limits(bounds), reader(&files_by), errors(limits) {}

  Limits limits;
  const FileReader* reader;  ///< of the files that it names
  Errors errors;
  std::vector<Diagnostic> warnings;
  std::string directory;
  std::vector<std::string> other_files;  ///< that were read
  std::deque<Part> parts;  ///< the model first, then the instances in file order, each before those within it
  std::set<const Tree*> placed_templates;
  /// Trees of further files, with what these include in place, by path; null where one cannot be read.
  std::map<std::string, std::shared_ptr<const Tree>> files;
  spec::Model model;
  std::vector<BodyInfo> bodies;
  Names body_names{"body", {}}, frame_names{"frame", {}}, joint_names{"joint", {}},
      spring_names{"spring", {}}, load_names{"load", {}}, road_names{"road", {}}, tyre_names{"tyre", {}},
      surface_names{"surface", {}}, contact_names{"contact", {}}, output_names{"output", {}},
      input_names{"input", {}}, signal_names{"signal", {}}, event_names{"event", {}},
      constraint_names{"constraint", {}};
  std::map<std::string, Names> element_names;   ///< by section
  std::set<std::string> outputs_ahead;          ///< names of outputs, before they are read
  std::map<std::string, int> sensor_of_output;  ///< those that laws and signals use
  std::set<std::string> clashing_ends;          ///< joints and constraints for which that has been reported
  std::unordered_map<std::string, int> node_frames;  ///< frames of named nodes, made when first used
  /// Bodies of files, by path and by which axes are mirrored.
  std::map<std::string, std::map<std::array<bool, 3>, std::shared_ptr<const ReducedBody>>> reduced_files;
  std::map<std::string, std::shared_ptr<const SurfaceMesh>> surfaces;  ///< of files, by path

  /// Records an error for a name that is taken or no name; false then.
  bool claim(Names& names, const Part& part, const std::string& full_name, const Mark& mark, int index);
  /// Likewise for the frame THING.a or THING.b (`end`) of a joint or constraint, at its first or second body.
  void claim_end(const Names& items, const Part& part, const std::string& item, char end, const Mark& mark,
                 int frame);
  /// The item called `name` in `part` (Part::meanings). -1, and an error at `value`, when there is none.
  int resolve(const Names& names, const Part& part, const std::string& name, const Value& value);
  /// The same without an error.
  int known(const Names& names, const Part& part, const std::string& name) const;

  int add_frame(spec::Frame frame);
  /// A new frame at a global place with global axes. On a flexible body a node must be there.
  int add_frame_at(const std::string& name, int body, const Eigen::Vector3d& position,
                   const Eigen::Matrix3d& axes, const Value& value);
  spec::Pose global_pose(int frame) const;
  spec::Pose body_pose(int body) const;
};

/// A name where something can attach: a body (or the ground), or a frame.
struct Attachment {
  int body = spec::ground;
  int frame = -1;  ///< -1: a body was named
};
std::optional<Attachment> resolve_attachment(Builder& builder, const Part& part, const Value& value);

/// The frame that `value` names; for a body without `at` the body's own frame, with `at` a new one of that
/// name.
int attach(Builder& builder, const Part& part, const Value& value, const std::optional<Value>& at,
           const std::string& new_name);

/// Reading of the sections, in the order in which they need one another.
void read_materials_and_sections(Builder& builder, Part& part);
void read_bodies(Builder& builder, Part& part);
/// What no matter can have is refused before it makes the motion explode, or warned of where joints make it
/// harmless.
void check_inertias(Builder& builder);
void read_frames(Builder& builder, Part& part);
void read_joints(Builder& builder, Part& part);
void read_springs(Builder& builder, Part& part);
void read_loads(Builder& builder, Part& part);
void read_roads(Builder& builder, Part& part);
void read_tyres(Builder& builder, Part& part);
/// Warns of forces on nodes of flexible bodies that have no static mode.
void warn_of_loaded_nodes(Builder& builder);
void read_constraints(Builder& builder, Part& part);
void read_outputs(Builder& builder);
void read_simulation(Builder& builder, Part& part);
void read_instances(Builder& builder);
void add_floating_joints(Builder& builder);
/// Cuts the bodies with substructures into pieces and moves frames and outputs to the piece that carries
/// them.
void split_bodies(Builder& builder);
/// Makes bars of segments into rigid bodies, joints and springs, and moves frames and outputs likewise.
void segment_bodies(Builder& builder);
void read_neglected_inertia(Builder& builder, Part& model);
/// Reduces every flexible body; equal ones once.
void reduce_bodies(Builder& builder);

/// The beam frame under `flexible:`, for a body whose frame is `pose`. Fills the named nodes in any case.
std::optional<FlexibleDescription> read_flexible(Builder& builder, const Part& part, const Value& value,
                                                 const spec::Pose& pose, BodyInfo& info);

/// {at, x, y, z}: axes from one or two of the vectors, global, placed.
spec::Pose read_pose(const Part& part, const Fields& fields, const Eigen::Vector3d& default_position);

/// Whether a text is a number, or an expression of numbers and parameters alone.
bool is_plain_number(const Value& value);

/// A law (docs/model-file.md) of `law`, whose numbers may have the units.
std::optional<Function> read_law(const Value& value, LawOf law, const LawUnits& units);
/// The same for springs, where a plain number could mean a stiffness or a force and is refused.
std::optional<Function> read_elastic_law(const Value& value, const LawUnits& units);
/// The same for dampers, where a plain number is the coefficient.
std::optional<Function> read_damping_law(const Value& value, const LawUnits& units);
/// [[x, y], ..] with ascending x; with `jumps` an x may come twice.
std::optional<std::pair<std::vector<double>, std::vector<double>>> read_points(const Value& value, bool jumps,
                                                                               const Quantity& x,
                                                                               const Quantity& y);

/// The path of a file that is named at `mark`, from the folder of the file that names it.
std::string path_of(const Builder& builder, const Mark& mark, const std::string& name);
/// False, and an error at `value`, for a model that was no file: it has no folder in which others could be
/// found.
bool has_folder(const Builder& builder, const Value& value);
/// Text of the file at `path`; nothing, and an error at `value`, when it cannot be read.
std::optional<std::string> read_file(Builder& builder, const Value& value, const std::string& path);

}  // namespace mimbre::model_file
