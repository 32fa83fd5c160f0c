#pragma once
#include <memory>
#include <string>
#include <vector>

#include "mimbre/spec.h"

namespace mimbre {

struct Compiled;
class Image;

/// A compiled model: immutable, shareable between threads and simulations.
class Model {
 public:
  /// Chooses tree and cuts, lays everything out for the step. Throws InputError when the model cannot be
  /// simulated.
  static std::shared_ptr<const Model> compile(spec::Model model);
  ~Model();
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  const spec::Model& spec() const { return spec_; }
  int bodies() const;
  int coordinates() const;  ///< velocity coordinates: joints' and modal amplitudes
  int elastic_coordinates() const;
  int constraints() const;  ///< equations: of cut joints, drives, constraints

  /// One line per tree joint and cut joint, for people.
  struct JointLine {
    std::string name, type, parent, child;
    bool cut;
    int coordinates;
    int equations;
  };
  std::vector<JointLine> joint_lines() const;

  /// The same of constraints.
  struct ConstraintLine {
    std::string name, type;
    std::vector<std::string> between;  ///< the two bodies, or the joints that are coupled
    int equations;
  };
  std::vector<ConstraintLine> constraint_lines() const;

  const Compiled& compiled() const;
  /// What the step needs, as one block (compile/image.h): for the library itself, its type's header is not
  /// installed.
  const Image& image() const { return *image_; }

 private:
  explicit Model(spec::Model model);
  spec::Model spec_;
  std::unique_ptr<const Image> image_;
};

}  // namespace mimbre
