#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "mimbre/spec.h"

/// The data of a run: numbers by name, and what a picture needs.
namespace mimbre {

struct ChannelInfo {
  std::string name;
  std::string unit;     ///< "m", "rad", "N", "J", "1", …
  std::string meaning;  ///< one line for people
  /// Whether rigid-body mechanics determines it: reactions of redundant constraints it does not.
  bool determined = true;
  /// Which other values mean the same: none, whole turns more or less (an angle of a cut joint), or its
  /// negative (a quaternion).
  enum class Alike { value, turns, sign } alike = Alike::value;
};

/// How a body is drawn: points (body axes), mode shapes of the points, lines between points, solid shapes.
struct BodyDrawing {
  std::string name;
  Eigen::Matrix3Xd points;
  Eigen::MatrixXd point_shapes;  ///< 3·points × modes; no columns for a rigid body
  std::vector<std::array<int, 2>> lines;
  std::vector<std::array<int, 3>> triangles;  ///< of points: the surface, counterclockwise from outside
  std::vector<std::int64_t> labels;           ///< of the points in the file of their mesh; none: unknown
  Eigen::MatrixXd stress;                     ///< 6·points × modes, see ReducedBody::stress; empty: unknown
  /// Of bodies made of bars, see BarStress: 8·lines × modes, and which of the lines are round; empty:
  /// unknown.
  Eigen::MatrixXd bar_stress;
  std::vector<bool> round_lines;
  double line_radius = 0.01;
  std::vector<spec::Shape> shapes;
  int modes = 0;
};

struct RoadDrawing {
  std::string name;
  Eigen::Matrix2Xd profile;  ///< x, z
};

/// A point with axes on a body, or on the ground, at which a joint or a force acts.
struct FrameDrawing {
  std::string name;
  int body = spec::ground;  ///< index into ResultsHeader::bodies
  spec::Pose pose;          ///< undeformed, in body axes; of the ground: global
  Eigen::MatrixXd
      motion;  ///< 6 × the body's modes: displacement and small turn, body axes, per unit amplitude
};

/// What holds bodies together or acts on them.
struct ElementDrawing {
  std::string name;
  std::string kind;  ///< a joint's type; "spring", "damper", "spring damper", "actuator"; of a joint's own
                     ///< springs "torsional …" with "about z" behind, or "sliding …" with "along z" (or x, y:
                     ///< its axis); "load"; "tyre", or, where its road is a function of time, "tyre on rig";
                     ///< of a constraint between two frames "distance", "on_line", "on_plane", "on_curve",
                     ///< "parallel", "perpendicular", "constant_velocity" or "screw"; "coupling" or "coupling
                     ///< spring" between the joints of which it couples coordinates; "motor", "friction" or
                     ///< "stop" with "about z" or "along z" behind on a joint; "bushing"; "drag"
  int frame_a = -1,
      frame_b = -1;        ///< indices into ResultsHeader::frames; loads and tyres have the first only
  double size = 0;         ///< a tyre's radius, m
  Eigen::Matrix3Xd curve;  ///< of "on_curve": points along it in the axes of frame_a, m
};

/// A section of a body's bars of which a run records something.
struct RecordedSection {
  int body = 0;     ///< index into ResultsHeader::bodies
  std::string bar;  ///< its name
  int element = 1;  ///< of the bar's elements, from 1: this one's start or end
  bool end = false;
  double along = 0;  ///< m from the bar's start
  /// N, Vy, Vz, T, My, Mz, largest von Mises stress: indices into ResultsHeader::channels; -1: not recorded.
  std::array<int, 7> channels{-1, -1, -1, -1, -1, -1, -1};
};

/// What describes a run, written before the first step.
struct ResultsHeader {
  std::string title;
  std::string model_text;
  std::string options_json;  ///< parameters and command-line overrides
  double step = 0;
  std::vector<ChannelInfo> channels;
  std::vector<BodyDrawing> bodies;
  std::vector<RoadDrawing> roads;
  std::vector<FrameDrawing> frames;
  std::vector<ElementDrawing> elements;
  std::vector<RecordedSection> sections;  ///< body by body, along their bars
};

/// One output instant. Poses: 7 × bodies (position, quaternion w x y z); modes: all bodies' amplitudes one
/// after another.
struct ResultsRow {
  double time = 0;
  Eigen::VectorXd channels;
  Eigen::Matrix<double, 7, Eigen::Dynamic> poses;
  Eigen::VectorXd modes;
};

}  // namespace mimbre
