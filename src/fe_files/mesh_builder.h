#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "fe_files/text_file.h"
#include "mimbre/fe_mesh.h"

namespace mimbre::fe {

/// Nodes by their labels while a file is read.
class NodeTable {
 public:
  /// Throws at a label that is taken and at a position that is not finite.
  int add(std::int64_t label, const Eigen::Vector3d& position, const TextFile& file);
  /// Index of a label, -1 when there is none.
  int find(std::int64_t label) const;
  /// Index of a label; throws, naming `user` ("element 7"), when there is none.
  int at(std::int64_t label, const TextFile& file, const char* user, std::int64_t user_label) const;
  int size() const { return static_cast<int>(labels_.size()); }
  const Eigen::Vector3d& position(int index) const { return positions_[static_cast<std::size_t>(index)]; }
  std::int64_t label(int index) const { return labels_[static_cast<std::size_t>(index)]; }

  /// Moves nodes and labels into the mesh.
  void move_into(SolidMesh& mesh);

 private:
  std::vector<Eigen::Vector3d> positions_;
  std::vector<std::int64_t> labels_;
  std::unordered_map<std::int64_t, int> by_label_;
};

/// Named lists of nodes in the order of their first mention; names differ in more than letter case.
class NodeSets {
 public:
  std::vector<int>& operator[](const std::string& name);
  const std::vector<int>* find(const std::string& name) const;
  void move_into(SolidMesh& mesh);

 private:
  std::vector<NodeSet> sets_;
  std::unordered_map<std::string, int> by_name_;
};

/// To SI units.
void scale(SolidMesh& mesh, double length, double mass, double time);

}  // namespace mimbre::fe
