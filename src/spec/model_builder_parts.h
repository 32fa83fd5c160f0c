#pragma once
#include <fmt/format.h>

#include <map>
#include <span>
#include <unordered_map>

#include "mimbre/model_builder.h"
#include "spec/number_key.h"

/// What the parts of the builder share.
namespace mimbre {

/// Items of one kind: their numbers by name.
struct NamedItems {
  const char* kind;
  std::map<std::string, int> index;
};

struct ModelBuilder::Impl {
  spec::Model model;
  NamedItems bodies{"body", {}}, frames{"frame", {}}, joints{"joint", {}}, springs{"spring", {}},
      loads{"load", {}}, roads{"road", {}}, tyres{"tyre", {}}, outputs{"output", {}}, inputs{"input", {}},
      signals{"signal", {}}, events{"event", {}}, elements{"element", {}}, surfaces{"surface", {}},
      contacts{"contact", {}}, constraints{"constraint", {}};
  std::map<std::string, int> sensors;                ///< of outputs that signals see
  std::unordered_map<std::string, int> node_frames;  ///< frames of nodes, made when first used
};

/// A name where something can attach: a body (or the ground), or a frame.
struct Attachment {
  int body = spec::ground;
  int frame = -1;  ///< -1: a body was named
};

/// One call of the builder: how messages call what it adds, where its coordinates are from, and the frames
/// that it makes, which are kept apart until nothing can go wrong any more.
class Addition {
 public:
  /// Refuses names that are none or taken among the items of the kind.
  Addition(ModelBuilder::Impl& builder, const NamedItems& kind, const std::string& name);

  [[noreturn]] void refuse(const std::string& message) const;

  /// From here on points and directions are those of the body or frame of this name; empty: global.
  void coordinates_of(const std::string& in);
  Eigen::Vector3d point(const char* what, const Eigen::Vector3d& given) const;
  Eigen::Vector3d vector(const Eigen::Vector3d& given) const { return base_.rotation * given; }
  /// Of length 1.
  Eigen::Vector3d direction(const char* what, const Eigen::Vector3d& given) const;
  spec::Pose pose(const Eigen::Vector3d& at, const build::Axes& axes) const;

  /// The number of an item of the kind; refuses, with names that could be meant, when there is none.
  int find(const NamedItems& items, const char* what, const std::string& name) const;
  /// Formulas of the time, inputs, signals and outputs of these names; outputs become sensors. Refuses what
  /// is none.
  std::vector<spec::Law> formulas(const char* what, const std::vector<std::string>& texts,
                                  const std::vector<std::string>& of);
  Attachment attachment(const char* what, const std::string& name);
  /// The frame that is named; of a body its own frame, or a new one at the point.
  int attach(const char* what, const std::string& name, const std::optional<Eigen::Vector3d>& at,
             const std::string& new_name);
  /// A new frame with global place and axes. On a flexible body a node must be there.
  int new_frame(const std::string& name, int body, const spec::Pose& global);
  /// The frame of a body that is about to be added.
  void new_body_frame(const std::string& name, int body);

  const spec::Frame& frame(int number) const;
  spec::Pose body_pose(int body) const;
  spec::Pose frame_pose(int frame) const;
  int own_frame(int body) const;

  /// Keeps the frames that were made, and the name as that of the item of this number.
  void commit(NamedItems& kind, std::size_t number);

 private:
  int add(spec::Frame frame);
  void check_name(const std::string& name, const char* kind) const;

  ModelBuilder::Impl& builder_;
  std::string name_;
  std::string called_;
  spec::Pose base_;
  std::vector<spec::Frame> made_;
  std::vector<std::pair<std::string, int>> made_names_, made_nodes_;
};

/// The numbers of a kind by their keys; NaN where one is neither given nor has a default. Refuses keys that
/// it has not.
std::vector<double> numbers_by_key(const Addition& addition, std::string_view kind,
                                   std::span<const LawNumber> numbers,
                                   const std::map<std::string, double>& given);
/// Refuses where one is NaN that is not given.
void require_numbers(const Addition& addition, std::span<const LawNumber> numbers,
                     const std::vector<double>& values, const std::map<std::string, double>& given = {});
/// Refuses a name of `what` that a kind has not.
void require_known(const Addition& addition, const char* what, std::string_view kind, const std::string& name,
                   const std::vector<std::string>& known);

/// "a, b, c", not too many.
std::string listed(const std::vector<std::string>& names);

}  // namespace mimbre
