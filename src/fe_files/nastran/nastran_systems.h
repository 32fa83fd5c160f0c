#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "fe_files/nastran/nastran_cards.h"

namespace mimbre::fe {

/// Where a coordinate system stands in the basic one.
struct NastranSystem {
  enum class Kind { rectangular, cylindrical, spherical } kind = Kind::rectangular;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: x, y, z of the system in basic axes

  /// Coordinates (angles in degrees) as a place in the basic system.
  Eigen::Vector3d place(const Eigen::Vector3d& coordinates) const;
  /// Columns: directions 1, 2, 3 of the system at a place. On the axis of a cylindrical or spherical system
  /// they are those of the plane θ = 0.
  Eigen::Matrix3d directions(const Eigen::Vector3d& at) const;
  bool is_basic() const;
};

/// The CORD1x and CORD2x cards of a file or several.
class NastranSystems {
 public:
  /// Coordinates of a GRID card and the system that they are in; false: there is none.
  struct GridPlace {
    std::int64_t system = 0;
    Eigen::Vector3d coordinates;
  };
  using FindGrid = std::function<bool(std::int64_t label, GridPlace& place)>;

  /// True when the card was one of them. Throws at one that is there already.
  bool read(const NastranCard& card);
  /// Once all cards are read; systems of three GRIDs need `find`. Throws InputError with all that is wrong.
  void resolve(const FindGrid& find);
  /// After resolve(); throws, at `mark`, when there is none.
  const NastranSystem& at(std::int64_t label, const Mark& mark) const;

 private:
  struct Card {
    NastranSystem::Kind kind{};
    std::int64_t reference = 0;
    std::array<Eigen::Vector3d, 3> points;       ///< CORD2: origin, on z, in the x–z plane
    std::array<std::int64_t, 3> grids{0, 0, 0};  ///< CORD1
    Mark mark;
    bool within = false;  ///< its points are being found
  };
  void add(const NastranCard& card, std::size_t label_field, Card system);
  std::array<Eigen::Vector3d, 3> points_of(std::int64_t label, const Card& card, const FindGrid& find,
                                           int depth);
  const NastranSystem& resolved(std::int64_t label, const Mark& mark, const FindGrid& find, int depth);

  std::map<std::int64_t, Card> cards_;
  std::map<std::int64_t, NastranSystem> systems_{{0, {}}};
};

}  // namespace mimbre::fe
